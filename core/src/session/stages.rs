//! The results of the stages of a scan, for people who follow the cycle (TDK 2016 §6.3).

use crate::geom::PoseEstimate;
use crate::pilot::StageReport;
use crate::points::Points;
use crate::slam::Slam;

/// Reports of scan, lines, localise and map, once `slam` has taken in a scan; `before` is what it
/// estimated just before.
pub(super) fn of_scan(slam: &Slam, before: &PoseEstimate) -> [StageReport; 4] {
    let view = slam.view();
    let (lines, walls) = (view.features, view.landmarks);
    let [matched, added, rejected] = view.update.map_or([0; 3], |report| {
        [report.matches.len(), report.added.len(), report.rejected()]
    });
    [
        StageReport::Scan {
            readings: slam.points().map_or(0, |points| points.beams.len()),
            hits: slam.points().into_iter().flat_map(Points::hits).count(),
        },
        StageReport::Lines {
            lines: lines.len(),
            points: lines.iter().map(|line| line.n_points).sum(),
        },
        StageReport::Localise {
            matched,
            added,
            rejected,
            estimate: slam.estimate(),
            before: *before,
        },
        StageReport::Map {
            confirmed: view.confirmed(),
            walls: walls.len(),
        },
    ]
}

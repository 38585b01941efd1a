//! What a person sees of a map, flattened for the page.

use nalgebra::Point2;
use slamlab_core::geom::{Pose2, Segment};
use slamlab_core::map::CellState;
use slamlab_core::pilot::Stage;
use slamlab_core::points::{Beam, Points};
use slamlab_core::robot::{BodyShape, RobotModel};
use slamlab_core::session::Session;
use slamlab_core::slam::Slam;
use wasm_bindgen::prelude::wasm_bindgen;

/// What a person sees of [`Slam`], whatever feeds it: map frame, m and rad.
#[wasm_bindgen(getter_with_clone)]
#[derive(Clone, Debug, PartialEq)]
pub struct SlamView {
    /// Changes when the grid was drawn anew and old blocks are worth nothing.
    pub generation: u32,
    /// With `generation`, hand it in next time to get what changed since.
    pub revision: f64,
    /// Side of a cell, m.
    pub resolution: f64,
    /// Column and row of each block that changed, in blocks.
    pub blocks: Vec<i32>,
    /// 64 x 64 cells of each such block in rows from the lower left: 0 unknown, else 1 + 254 p, p the probability of an
    /// obstacle.
    pub cells: Vec<u8>,
    /// x y of what the last scan hit.
    pub scan: Vec<f32>,
    /// Range and σ (m) and quality of each of these hits, in the same order; NaN where the sensor tells no quality.
    pub beams: Vec<f32>,
    /// x1 y1 x2 y2 of the lines found in the last scan.
    pub found: Vec<f32>,
    /// The walls of the line map, see `LINE_STRIDE` of www/src/protocol/frame.ts; none while they are those that were shown.
    pub lines: Option<Vec<f64>>,
}

impl SlamView {
    /// The view of someone who knows the grid up to `revision` of `generation`. Somebody who follows the cycle stage by stage
    /// sees what each stage changed when that stage is shown.
    pub(crate) fn since(session: &Session, generation: u32, revision: f64) -> Self {
        let slam = session.slam();
        let (layers, now) = (slam.layers(), slam.shown_version() as u32);
        let known = if now == generation {
            revision as u64
        } else {
            0
        };
        let mut view = Self {
            generation: now,
            revision: layers.revision() as f64,
            resolution: slam.grid().resolution(),
            blocks: vec![],
            cells: vec![],
            scan: hits(session),
            beams: beams(slam),
            found: found(session),
            lines: (!session.stages().awaits(Stage::Localise)).then(|| lines(slam)),
        };
        if session.stages().awaits(Stage::Map) {
            (view.generation, view.revision) = (generation, revision);
            return view;
        }
        for (block, log_odds) in layers.blocks_since(known) {
            view.blocks.extend([block.col, block.row]);
            view.cells.extend(log_odds.iter().map(|&l| tone(l)));
        }
        view
    }
}

/// A probability as one byte that keeps "nothing known" apart from "as likely as not".
fn tone(log_odds: f32) -> u8 {
    if log_odds == 0.0 {
        return 0;
    }
    let p = 1.0 / (1.0 + (-log_odds).exp());
    1 + (254.0 * p).round() as u8
}

/// Area known to be free, m².
pub(crate) fn free_area(slam: &Slam) -> f64 {
    let grid = slam.grid();
    let free = grid
        .blocks_since(0)
        .flat_map(|(_, cells)| cells)
        .filter(|&&l| grid.state_of(l) == CellState::Free)
        .count();
    free as f64 * grid.resolution() * grid.resolution()
}

fn hits(session: &Session) -> Vec<f32> {
    let map_from_robot = map_from_robot_at_scan(session);
    let ends = hits_of(session.slam()).map(|beam| flat(map_from_robot * beam.end_in_robot));
    ends.flatten().collect()
}

fn beams(slam: &Slam) -> Vec<f32> {
    hits_of(slam)
        .flat_map(|beam| {
            let quality = beam.quality.map_or(f32::NAN, f32::from);
            [beam.range as f32, beam.sigma as f32, quality]
        })
        .collect()
}

fn hits_of(slam: &Slam) -> impl Iterator<Item = &Beam> {
    slam.points().into_iter().flat_map(Points::hits)
}

pub(crate) fn map_from_robot_at_scan(session: &Session) -> Pose2 {
    session.shown_estimate().pose * session.slam().motion_since_scan().inverse()
}

fn found(session: &Session) -> Vec<f32> {
    if session.stages().awaits(Stage::Lines) {
        return vec![];
    }
    let map_from_robot = map_from_robot_at_scan(session);
    let ends = session
        .slam()
        .view()
        .features
        .iter()
        .flat_map(|line| line.ends);
    ends.flat_map(|end| flat(map_from_robot * end)).collect()
}

/// Names of the walls that the last scan merged, the one that stays before the one that goes.
pub(crate) fn merged(slam: &Slam) -> Vec<u32> {
    let merged = slam
        .view()
        .update
        .into_iter()
        .flat_map(|report| &report.merged);
    merged.flat_map(|m| [m.kept.0, m.gone.0]).collect()
}

/// For each wall: alpha, r, var alpha, cov alpha r, var r, x1, y1, x2, y2, matched in the last scan, confirmed, name.
fn lines(slam: &Slam) -> Vec<f64> {
    let is_matched = |id| slam.view().matches().iter().any(|m| m.landmark == id);
    let mut numbers = vec![];
    for wall in slam.view().landmarks {
        let [a, b] = wall.ends;
        numbers.extend([
            wall.line.alpha(),
            wall.line.r(),
            wall.cov[(0, 0)],
            wall.cov[(0, 1)],
            wall.cov[(1, 1)],
        ]);
        numbers.extend([a.x, a.y, b.x, b.y]);
        numbers
            .extend([is_matched(wall.id), wall.is_confirmed].map(|yes| f64::from(u8::from(yes))));
        numbers.push(f64::from(wall.id.0));
    }
    numbers
}

/// x1 y1 x2 y2 of each segment, moved into the map frame.
pub(crate) fn segments<'a>(
    segments: impl Iterator<Item = &'a Segment>,
    map_from: &Pose2,
) -> Vec<f32> {
    segments
        .flat_map(|s| [flat(*map_from * s.a), flat(*map_from * s.b)])
        .flatten()
        .collect()
}

/// x1 y1 x2 y2 of the walls of the known map; empty for methods without.
pub(crate) fn known_walls(slam: &Slam) -> Vec<f32> {
    let lines = match slam.view().prior_map_fit {
        Some(_) => slam.config().prior_map.lines.as_slice(),
        None => &[],
    };
    lines
        .iter()
        .flat_map(|line| line.ends)
        .flat_map(flat)
        .collect()
}

/// x y of each point.
pub(crate) fn polyline(points: &[Point2<f64>]) -> Vec<f32> {
    points.iter().copied().flat_map(flat).collect()
}

fn flat(point: Point2<f64>) -> [f32; 2] {
    [point.x as f32, point.y as f32]
}

/// Half length and half width of a robot, m; 1 where walls are touched by that rectangle, 0 where by the disc around it.
pub(crate) fn body(robot: &RobotModel) -> Vec<f64> {
    let is_rectangle = robot.shape == BodyShape::Rectangle;
    vec![
        0.5 * robot.length,
        0.5 * robot.width,
        f64::from(u8::from(is_rectangle)),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_known_is_not_as_likely_as_not() {
        assert_eq!(tone(0.0), 0);
        assert_eq!(tone(1e-6), 128);
        assert_eq!(tone(-30.0), 1);
        assert_eq!(tone(30.0), 255);
    }
}

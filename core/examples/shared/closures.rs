//! Loop closures of scan matching, compared with the truth.
//!
//! A closure joins two submaps that are not consecutive. It is false if the relative pose that it
//! claims differs from the true one by more than [`MOST_SHIFT`] or [`MOST_TURN`]. The true pose of
//! a submap is the mean over its scans, each from the robot's true pose and the scan's pose in the
//! submap. Its first scan alone is not enough: taken in a quick turn, it is a tenth of a radian off
//! relative to the others.

use std::collections::BTreeMap;
use std::fmt;

use anyhow::{Context, Result};
use slamlab_core::estimation::{Edge, ScanMatcher};
use slamlab_core::geom::{Length, Pose2};
use slamlab_core::robot::Stamp;

/// A closure with a larger error is false, m and rad.
const MOST_SHIFT: f64 = 0.5;
const MOST_TURN: f64 = 0.1;

/// A closure of a loop, and its error.
pub(crate) struct Closure {
    /// The submaps that it joins, and when they began.
    submaps: [usize; 2],
    began: [Stamp; 2],
    /// How far the graph overruled it in the end, m.
    overruled: f64,
    pub(crate) shift: f64,
    pub(crate) turn: f64,
}

impl Closure {
    pub(crate) fn is_wrong(&self) -> bool {
        self.shift > MOST_SHIFT || self.turn > MOST_TURN
    }
}

impl fmt::Display for Closure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ([old, new], [then, now]) = (self.submaps, self.began);
        write!(
            f,
            "submap {new} of {:.1} s is put {:.2} m and {:.2} rad from where it is in submap {old} of {:.1} s; in the end overruled by {:.2} m",
            now.seconds(),
            self.shift,
            self.turn,
            then.seconds(),
            self.overruled,
        )
    }
}

/// The closures of a run, given its true poses at each scan, map frame.
///
/// # Errors    A scan without a true pose.
pub(crate) fn closures_of(
    matcher: &ScanMatcher,
    truth: &BTreeMap<Stamp, Pose2>,
) -> Result<Vec<Closure>> {
    let begun = submaps_of(matcher, truth)?;
    let edges = matcher.graph().edges().iter();
    let poses = matcher.graph().poses();
    let overruled = |edge: &Edge| {
        let ends = poses.get(edge.from).zip(poses.get(edge.to));
        let off = ends.map(|(from, to)| edge.motion.delta_to(&from.delta_to(to)));
        off.map_or(f64::NAN, |off| off.position().coords.length())
    };
    let closures = edges.filter(|edge| edge.from.abs_diff(edge.to) > 1);
    closures
        .map(|edge| {
            let end = |submap: usize| begun.get(&submap).context("no scan is in a joined submap");
            let ((then, from), (now, to)) = (end(edge.from)?, end(edge.to)?);
            let off = from.delta_to(to).delta_to(&edge.motion);
            Ok(Closure {
                submaps: [edge.from, edge.to],
                began: [*then, *now],
                overruled: overruled(edge),
                shift: off.position().coords.length(),
                turn: off.heading().abs(),
            })
        })
        .collect()
}

/// For each submap when it began, and its true pose.
fn submaps_of(
    matcher: &ScanMatcher,
    truth: &BTreeMap<Stamp, Pose2>,
) -> Result<BTreeMap<usize, (Stamp, Pose2)>> {
    let mut placed: BTreeMap<usize, Vec<(Stamp, Pose2)>> = BTreeMap::new();
    for (stamp, submap, submap_from_robot) in matcher.scans_in_submaps() {
        let map_from_robot = truth
            .get(&stamp)
            .context("the truth of a scan is not known")?;
        let map_from_submap = *map_from_robot * submap_from_robot.inverse();
        let scans = placed.entry(submap).or_default();
        scans.push((stamp, map_from_submap));
    }
    let mean = |(submap, scans): (usize, Vec<(Stamp, Pose2)>)| {
        let &(began, first) = scans.first()?;
        // Headings are averaged about one of them, because they wrap.
        let off = scans.iter().map(|(_, pose)| first.delta_to(pose));
        let sum = off.fold([0.0; 3], |[x, y, turn], off| {
            [x + off.x(), y + off.y(), turn + off.heading()]
        });
        let [x, y, turn] = sum.map(|sum| sum / scans.len() as f64);
        Some((submap, (began, first * Pose2::new(x, y, turn))))
    };
    Ok(placed.into_iter().filter_map(mean).collect())
}

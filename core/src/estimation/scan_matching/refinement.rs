//! Refines the keyframes within their submap, by other submaps that show the same place.
//!
//! In: a closed submap, and the loop closures that join it to others. Out: the poses of its
//! keyframes in it, and of the scans between them.
//!
//! A closure moves a submap as a whole. Along a curved wall, or while people walk around the robot,
//! matching drifts by degrees within one submap, and no pose graph of submaps corrects that.
//!
//! 1. What the keyframes saw is kept for a while, until most loops past their submap are closed.
//! 2. Each keyframe is then matched by itself to each submap that closures join to its own, one
//!    keyframe at each scan.
//! 3. The keyframes of the submap form a chain: each is tied to the previous one as tracking had
//!    it, and to where the reliable matches have it. The chain is optimised like any pose graph.
//! 4. Scans between two keyframes move with them.
//!
//! The shape that the submap itself had gets almost no weight: it drifted. Weighting it like one
//! match loses half of the gain (Intel, Killian).
//!
//! The grid and the trajectory are drawn by these poses. What scans and submaps are matched to
//! stays unchanged, and so do the closures: what they proved is not proved by itself again. A pass
//! whose loop is closed more than [`WAITS`] submaps later stays unchanged: the next pass is laid on
//! it. The join to the next submap is not changed either, so the trajectory may jump there by as
//! much as the last keyframe was moved.

use nalgebra::Matrix3;

use super::super::agreement::Agreement;
use super::super::pose_graph::{Edge, PoseGraph, information_at_end};
use super::super::submap::Indexed;
use super::tracking::is_sure;
use super::{ScanMatcher, TrackPoint};
use crate::geom::{Length, Pose2, pose_cov};
use crate::points::{OrientedPoint, thinned};
use crate::registration::{Prior, Registration, Verdict, register};
use crate::snapshot::snapshot;

/// A submap is refined only after this many more were begun: until then, more closures are found.
const WAITS: usize = 20;
/// The most submaps that a keyframe is matched to, those with the largest overlap. More bring
/// little, and each costs an index.
const MOST_OTHERS: usize = 3;
/// About this many surfaces of a keyframe are matched, evenly spread.
const SURFACES: usize = 100;
/// How far a keyframe may have drifted when its matching starts, m and rad.
const DRIFT: [f64; 2] = [0.1, 0.06];
/// Uncertainty of a keyframe relative to the previous one by tracking, m and rad.
const STEP: [f64; 2] = [0.01, 0.006];
/// A match is never believed to be more accurate than this, m and rad: the submap that it is
/// matched to drifted as well.
const MATCH: [f64; 2] = [0.015, 0.004];
/// The least information of a match, 1/m² and 1/rad².
const MIN_INFORMATION: f64 = 0.01;
/// Scale of the Cauchy kernel of matches, in standard deviations.
const KERNEL: f64 = 2.0;
const MOST_ITERATIONS: usize = 20;

/// A closed submap whose keyframes may be refined.
#[derive(Clone, Debug)]
pub(super) struct Unrefined {
    pub(super) submap: usize,
    /// Some of what its last keyframes saw, in their order.
    surfaces: Vec<Vec<OrientedPoint>>,
    /// Submaps that show the same place, and where this one lay in them when its refinement began
    /// (`other_from_submap`); empty until then.
    others: Vec<(usize, Pose2)>,
    /// How many of `surfaces` were matched.
    matched: usize,
    places: Vec<Place>,
}

/// The pose of a keyframe by a match.
#[derive(Clone, Debug)]
struct Place {
    /// Its index among the kept keyframes.
    keyframe: usize,
    submap_from_robot: Pose2,
    /// As an edge of a pose graph takes it.
    information: Matrix3<f64>,
}

snapshot!(Unrefined {
    submap,
    surfaces,
    others,
    matched,
    places,
});
snapshot!(Place {
    keyframe,
    submap_from_robot,
    information,
});

impl Unrefined {
    /// Whether everything that it names exists, in a map in which its submap has this many
    /// keyframes.
    pub(super) fn is_sound(&self, submaps: usize, keyframes: usize) -> bool {
        let count = self.surfaces.len();
        count <= keyframes
            && self.matched <= count
            && self.others.iter().all(|(other, _)| *other < submaps)
            && self.places.iter().all(|place| place.keyframe < count)
    }
}

impl ScanMatcher {
    /// Keeps what the keyframes of the last submap, which is being closed, saw.
    pub(super) fn keep_for_refinement(&mut self) {
        let submap = self.submaps.len() - 1;
        let [first, behind] = self.keyframes_of(submap);
        let own = (behind - first).min(self.recent.len());
        if own == 0 || !self.config.close_loops {
            return;
        }
        let recent = self.recent.iter().skip(self.recent.len() - own);
        let seen = recent.map(|recent| recent.surfaces.as_slice());
        self.unrefined.push_back(Unrefined {
            submap,
            surfaces: seen
                .enumerate()
                .map(|(at, seen)| thinned(seen, SURFACES, at))
                .collect(),
            others: vec![],
            matched: 0,
            places: vec![],
        });
    }

    /// Matches up to `count` keyframes of submaps that have waited long enough, or of `all`
    /// submaps, and refines a submap when all of its keyframes are matched.
    pub(super) fn refine(&mut self, count: usize, all: bool) {
        let waits = if all { 0 } else { WAITS };
        for _ in 0..count {
            if self.unrefined.len() <= waits {
                return;
            }
            let Some(mut first) = self.unrefined.pop_front() else {
                return;
            };
            if first.matched == 0 {
                first.others = self.joined_by_closures(first.submap);
            }
            if first.others.is_empty() {
                continue;
            }
            self.match_next(&mut first);
            if first.matched < first.surfaces.len() {
                self.unrefined.push_front(first);
            } else {
                self.lay_anew(&first);
            }
        }
    }

    /// The submaps that closures join to this one, those with the largest overlap first, and where
    /// it lies in them.
    fn joined_by_closures(&self, submap: usize) -> Vec<(usize, Pose2)> {
        let accepted = self.records.accepted().map(|(_, _, record)| record);
        let mut closures: Vec<(f64, usize)> = accepted
            .filter_map(|record| match (record.old, record.new) {
                (old, new) if new == submap => Some((record.overlap, old)),
                (old, new) if old == submap => Some((record.overlap, new)),
                _ => None,
            })
            .collect();
        closures.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let mut others: Vec<usize> = vec![];
        for (_, other) in closures {
            if others.len() < MOST_OTHERS && !others.contains(&other) {
                others.push(other);
            }
        }
        let pose = |submap: usize| self.submaps[submap].map_from_submap;
        let with_place = |other| (other, pose(other).delta_to(&pose(submap)));
        others.into_iter().map(with_place).collect()
    }

    /// The index of a submap's first keyframe, and that after its last.
    pub(super) fn keyframes_of(&self, submap: usize) -> [usize; 2] {
        let first = self.keyframes.partition_point(|k| k.submap < submap);
        let behind = self.keyframes.partition_point(|k| k.submap <= submap);
        [first, behind]
    }

    /// The index of the first scan that was placed in a submap, and that after its last.
    fn scans_of(&self, submap: usize) -> [usize; 2] {
        let first = self.trajectory.partition_point(|t| t.submap < submap);
        let behind = self.trajectory.partition_point(|t| t.submap <= submap);
        [first, behind]
    }

    /// The scans from which the keyframes of a submap were made: their poses are equal to the bit.
    fn scans_of_keyframes(&self, submap: usize) -> Vec<Option<usize>> {
        let [mut from, end] = self.scans_of(submap);
        let [first, behind] = self.keyframes_of(submap);
        let keyframes = self.keyframes[first..behind].iter();
        keyframes
            .map(|keyframe| {
                let lies_there =
                    |scan: &TrackPoint| scan.submap_from_robot == keyframe.submap_from_robot;
                let ahead = self.trajectory[from..end].iter().position(lies_there)?;
                from += ahead;
                Some(from)
            })
            .collect()
    }

    /// The indices of the scans that were drawn; the others are in no grid.
    pub fn drawn_scans(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.submaps.len())
            .flat_map(|submap| self.scans_of_keyframes(submap).into_iter().flatten())
    }

    /// Matches the next keyframe to each of the others.
    fn match_next(&mut self, planned: &mut Unrefined) {
        let at = planned.matched;
        planned.matched += 1;
        let Some(surfaces) = planned.surfaces.get(at) else {
            return;
        };
        let [_, behind] = self.keyframes_of(planned.submap);
        let keyframe = &self.keyframes[behind - planned.surfaces.len() + at];
        // Ask for the submap that loop closing compares now, so that its indexes are kept.
        let newest = self.submaps.len().saturating_sub(2);
        for (other, other_from_submap) in &planned.others {
            let index = self.indexes.of(*other, newest);
            let closed = &self.submaps[*other].closed;
            let target = Indexed::new(closed, &index, &self.config.surfels);
            let start = *other_from_submap * keyframe.submap_from_robot;
            let prior = Prior {
                pose: start,
                information: information(DRIFT),
            };
            let found = register(surfaces, &target, &start, &prior, &self.config.matching);
            let pose = &found.estimate.pose;
            let agreement = Agreement::of(surfaces, pose, &target, closed.free());
            if is_sure(&agreement) && is_settled(&found) {
                planned.places.push(Place {
                    keyframe: at,
                    submap_from_robot: other_from_submap.inverse() * *pose,
                    information: information_at_end(pose, &believed(&found)),
                });
            }
        }
    }

    /// Moves the keyframes of a submap, and the scans between them, to where the chain has them.
    fn lay_anew(&mut self, refined: &Unrefined) {
        if refined.places.is_empty() {
            return;
        }
        let [first, behind] = self.keyframes_of(refined.submap);
        let matched_from = behind - first - refined.surfaces.len();
        let before: Vec<Pose2> = (self.keyframes[first..behind].iter())
            .map(|keyframe| keyframe.submap_from_robot)
            .collect();
        let after = chain(&before, &refined.places, matched_from);
        self.carry_scans(refined.submap, &after);
        let turn = self.config.redraw_turn;
        for (keyframe, pose) in self.keyframes[first..behind].iter_mut().zip(&after) {
            let moved = keyframe.submap_from_robot.delta_to(pose);
            let off = moved
                .position()
                .coords
                .length()
                .max(moved.heading().abs() / turn);
            self.moved_within = self.moved_within.max(off);
            keyframe.submap_from_robot = *pose;
        }
        self.moves += 1;
    }

    /// Moves the scans of a submap with its keyframes: each by interpolation between the motions of
    /// the keyframes before and after it. Stamps do not tell how far along a scan is: in
    /// recordings, several scans often have the same stamp.
    fn carry_scans(&mut self, submap: usize, after: &[Pose2]) {
        let of_keyframes = self.scans_of_keyframes(submap).into_iter().zip(after);
        let placed: Vec<(usize, Pose2)> = of_keyframes
            .filter_map(|(scan, after)| Some((scan?, *after)))
            .collect();
        let moved: Vec<(usize, Pose2)> = (placed.iter())
            .map(|(scan, after)| {
                let before = self.trajectory[*scan].submap_from_robot;
                (*scan, before.delta_to(after))
            })
            .collect();
        let (Some(first), Some(last)) = (moved.first(), moved.last()) else {
            return;
        };
        let [begin, end] = self.scans_of(submap);
        let (begin, end) = ((begin, first.1), (end, last.1));
        let ends: Vec<_> = [begin].into_iter().chain(moved).chain([end]).collect();
        for pair in ends.windows(2) {
            let [(from, a), (to, b)] = [pair[0], pair[1]];
            for at in from..to {
                let part = (at - from) as f64 / (to - from) as f64;
                let scan = &mut self.trajectory[at].submap_from_robot;
                *scan = *scan * between(&a, &b, part);
            }
        }
        // Equal to the bit, because that is how a keyframe finds its scan.
        for (scan, after) in placed {
            self.trajectory[scan].submap_from_robot = after;
        }
    }
}

/// The poses of consecutive keyframes, where `places` give those from index `matched_from` on.
fn chain(poses: &[Pose2], places: &[Place], matched_from: usize) -> Vec<Pose2> {
    let mut graph = PoseGraph::default();
    let origin = graph.add_pose(Pose2::identity());
    let mut last: Option<(usize, Pose2)> = None;
    for pose in poses {
        let number = graph.add_pose(*pose);
        graph.add_edge(Edge {
            from: origin,
            to: number,
            motion: *pose,
            information: information(DRIFT),
            cauchy: None,
        });
        if let Some((last, last_pose)) = last {
            let motion = last_pose.delta_to(pose);
            graph.add_edge(Edge {
                from: last,
                to: number,
                motion,
                information: information(STEP),
                cauchy: None,
            });
        }
        last = Some((number, *pose));
    }
    for place in places {
        graph.add_edge(Edge {
            from: origin,
            to: origin + 1 + matched_from + place.keyframe,
            motion: place.submap_from_robot,
            information: place.information,
            cauchy: Some(KERNEL),
        });
    }
    graph.optimize(MOST_ITERATIONS);
    graph.poses()[origin + 1..].to_vec()
}

fn information([shift, turn]: [f64; 2]) -> Matrix3<f64> {
    let cov = pose_cov(shift, turn);
    Matrix3::from_diagonal(&cov.diagonal().map(|variance| 1.0 / variance))
}

fn is_settled(found: &Registration) -> bool {
    !matches!(
        found.verdict,
        Verdict::TooFewPoints { .. } | Verdict::NotConverged
    )
}

/// The information of a match in another submap about the pose there: the inverse of its
/// covariance.
fn believed(found: &Registration) -> Matrix3<f64> {
    let least = Matrix3::identity() * MIN_INFORMATION;
    let cov = (found.information + least).try_inverse();
    let cov = cov.map(|cov| cov + pose_cov(MATCH[0], MATCH[1]));
    cov.and_then(Matrix3::try_inverse)
        .unwrap_or_else(Matrix3::zeros)
}

/// Interpolates between two small motions.
fn between(a: &Pose2, b: &Pose2, part: f64) -> Pose2 {
    let on_the_way = |a: f64, b: f64| a + part * (b - a);
    Pose2::new(
        on_the_way(a.x(), b.x()),
        on_the_way(a.y(), b.y()),
        on_the_way(a.heading(), b.heading()),
    )
}

#[cfg(test)]
mod tests;

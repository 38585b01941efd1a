//! Keyframes laid anew within their submap, as other submaps have them that show the same place.
//!
//! In: a closed submap, and the loop closures that join it to others. Out: the poses of its
//! keyframes in it, and of the scans between them.
//!
//! A closure moves a submap as a whole. Along a curved wall, or while people walk around the robot,
//! matching drifts by degrees within one, and no pose graph of submaps takes that out.
//!
//! 1. What the keyframes saw is kept for a while, until most loops past their submap are closed.
//! 2. Each keyframe is then matched by itself to each of the submaps that closures join to its own,
//!    one keyframe at each scan.
//! 3. The keyframes of the submap are a chain: each is held to the one before as tracking had it,
//!    and to where the matches that are sure have it. It is optimised like any pose graph.
//! 4. Scans between two keyframes go with them.
//!
//! The shape that the submap had itself has next to no vote: it drifted. With a vote as heavy as
//! one match, half of the gain is gone (Intel, Killian).
//!
//! The grid and the way are drawn by these poses. What scans and submaps are matched to stays as it
//! was made, and so do the closures: what was proved by them is not proved by itself again. A pass
//! of which the loop is closed only [`WAITS`] submaps later stays as it is: the next one is laid on
//! it. Nor is the join to the next submap changed, so that the way may jump there by as much as the
//! last keyframe was moved.

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

/// So many submaps are begun before one is refined: until then, more closures are found.
const WAITS: usize = 20;
/// Most submaps that a keyframe is matched to, those that overlap most. More give little, and each
/// costs an index.
const MOST_OTHERS: usize = 3;
/// About so many surfaces of a keyframe are matched, evenly spread.
const SURFACES: usize = 100;
/// How far a keyframe may have drifted, m and rad, where it begins to be matched.
const DRIFT: [f64; 2] = [0.1, 0.06];
/// How well tracking knows a keyframe relative to the one before, m and rad.
const STEP: [f64; 2] = [0.01, 0.006];
/// A match is never believed better than this, m and rad: the submap that it is matched to drifted
/// as well.
const MATCH: [f64; 2] = [0.015, 0.004];
/// What a match says at least, 1/m² and 1/rad².
const MIN_INFORMATION: f64 = 0.01;
/// Scale of the Cauchy kernel of matches, in standard deviations.
const KERNEL: f64 = 2.0;
const MOST_ITERATIONS: usize = 20;

/// A closed submap whose keyframes may be laid anew.
#[derive(Clone, Debug)]
pub(super) struct Unrefined {
    pub(super) submap: usize,
    /// Of what its last keyframes saw, some, in their order.
    surfaces: Vec<Vec<OrientedPoint>>,
    /// Submaps that show the same place, and where it lay in them when it was begun with
    /// (`other_from_submap`); empty until then.
    others: Vec<(usize, Pose2)>,
    /// Of `surfaces`, those that were matched.
    matched: usize,
    places: Vec<Place>,
}

/// Where a match has a keyframe.
#[derive(Clone, Debug)]
struct Place {
    /// Its number among those that were kept.
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
    /// Whether all that it names is there, in a map in which its submap has so many keyframes.
    pub(super) fn is_sound(&self, submaps: usize, keyframes: usize) -> bool {
        let count = self.surfaces.len();
        count <= keyframes
            && self.matched <= count
            && self.others.iter().all(|(other, _)| *other < submaps)
            && self.places.iter().all(|place| place.keyframe < count)
    }
}

impl ScanMatcher {
    /// Keeps what the keyframes of the last submap saw, which is being closed.
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

    /// Matches up to `count` keyframes of submaps that have waited long enough, or `all`, and lays
    /// those of a submap anew when all of them are matched.
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

    /// The submaps that closures join to this one, those first that overlap it most, and where it
    /// lies in them.
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

    /// Of the keyframes of a submap, the first and the one behind the last.
    pub(super) fn keyframes_of(&self, submap: usize) -> [usize; 2] {
        let first = self.keyframes.partition_point(|k| k.submap < submap);
        let behind = self.keyframes.partition_point(|k| k.submap <= submap);
        [first, behind]
    }

    /// Of the scans that were placed in a submap, the first and the one behind the last.
    fn scans_of(&self, submap: usize) -> [usize; 2] {
        let first = self.trajectory.partition_point(|t| t.submap < submap);
        let behind = self.trajectory.partition_point(|t| t.submap <= submap);
        [first, behind]
    }

    /// The scans of which the keyframes of a submap were made: they lie where those do, to the bit.
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

    /// The numbers of the scans that were drawn: the others are in no grid.
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
        // The submap that others are compared with, too: what they keep is kept.
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

    /// Lays the keyframes of a submap, and the scans between them, where the chain has them.
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

    /// Moves the scans of a submap with its keyframes: each by what lies between the motions of the
    /// keyframes before and behind it. Stamps do not tell how far it is on the way: in recordings,
    /// several scans often have one.
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
        // To the bit, by which a keyframe knows its scan.
        for (scan, after) in placed {
            self.trajectory[scan].submap_from_robot = after;
        }
    }
}

/// The poses of keyframes that lie one after the other, where `places` have those from number
/// `matched_from` on.
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

/// What a match in another submap says of the pose there: the inverse of its covariance.
fn believed(found: &Registration) -> Matrix3<f64> {
    let least = Matrix3::identity() * MIN_INFORMATION;
    let cov = (found.information + least).try_inverse();
    let cov = cov.map(|cov| cov + pose_cov(MATCH[0], MATCH[1]));
    cov.and_then(Matrix3::try_inverse)
        .unwrap_or_else(Matrix3::zeros)
}

/// This part of the way from one small motion to another.
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

//! Removes submaps that newer ones cover, so that the map grows with the building, not with the
//! distance driven.
//!
//! In: a map. Out: the map without submaps whose contents newer ones hold completely.
//!
//! 1. Starting with the oldest, a submap is covered if nearly all of its surfaces stand in several
//!    newer ones, in the same place and facing the same way, and if nearly all space that it saw as
//!    free was seen as free by newer ones. Several are required because neighbours on a path share
//!    half of what they hold, and what was seen once may have been seen badly.
//! 2. Its pose is removed from the graph. Everything joined to it is joined through it to one of
//!    its neighbours on the trajectory, unless joined to that already: motions are composed, and
//!    their covariances add up. The edge to that neighbour is then used several times, so its
//!    covariance is counted as often: the result never claims to be known better than before.
//! 3. Its keyframes and trajectory poses go with it, and the grid is redrawn.
//!
//! Marginalising would join all neighbours to one another, with information that is exact, and
//! the graph would fill in run by run. A tree through one neighbour keeps it sparse (Kretzschmar &
//! Stachniss 2012, "Information-theoretic compression of pose graphs for laser-based SLAM", who
//! choose the tree by mutual information).

use std::collections::BTreeMap;

use nalgebra::Matrix3;

use super::super::free_space::FreeSpace;
use super::super::pose_graph::{Edge, EdgeId};
use super::{ScanMatcher, Submap};
use crate::geom::{Length, Pose2, symmetrize};

/// What was removed from a map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Pruned {
    /// Submaps.
    pub submaps: usize,
    /// Keyframes.
    pub keyframes: usize,
}

/// This many newer submaps have to hold a surface.
const COVERED_BY: u32 = 3;
/// This part of the surfaces of a submap has to be held.
const COVERED_SURFACES: f64 = 0.97;
/// This part of the free space that it saw has to be held.
const COVERED_FREE: f64 = 0.97;
/// Surfaces are the same if they fall into one cell of this side, m, or into neighbouring ones ...
const CELL: f64 = 0.2;
/// ... and face into the same one of this many directions, or into neighbouring ones.
const DIRECTIONS: i32 = 8;
/// A closure with less kernel weight than this is not followed by the graph, and says nothing.
const LEAST_WEIGHT: f64 = 0.1;

/// A surface, coarsely: column, row, direction.
type Key = (i32, i32, i32);

impl ScanMatcher {
    /// Removes submaps that newer ones cover. The map must be finished ([`Self::finish`]).
    pub fn prune(&mut self) -> Pruned {
        let count = self.submaps.len();
        let keyframes = self.keyframes.len();
        let held: Vec<Vec<Key>> = self.submaps.iter().map(keys).collect();
        // For each surface, the number of submaps that hold it, among those that are kept or newer
        // than the one in question.
        let mut holders: BTreeMap<Key, u32> = BTreeMap::new();
        for key in held.iter().flatten() {
            *holders.entry(*key).or_default() += 1;
        }
        let last = self.unplaced.as_ref().map_or(count, |piece| piece.first);
        let mut kept = vec![true; count];
        for submap in 0..last.saturating_sub(1) {
            for key in &held[submap] {
                if let Some(holders) = holders.get_mut(key) {
                    *holders -= 1;
                }
            }
            let is_covered = surfaces_are_held(&held[submap], &holders)
                && self.free_is_held(submap, &kept)
                && self.join_past(submap).is_some();
            kept[submap] = !is_covered;
        }
        let pruned = kept.iter().filter(|kept| !**kept).count();
        if pruned > 0 {
            self.keep_submaps(&kept);
            self.redraw_at_once();
        }
        Pruned {
            submaps: pruned,
            keyframes: keyframes - self.keyframes.len(),
        }
    }

    /// Whether newer submaps saw as free what this one did.
    fn free_is_held(&self, submap: usize, kept: &[bool]) -> bool {
        let this = &self.submaps[submap];
        let middle = this.map_from_submap * this.closed.centre;
        let newer = self.submaps.iter().zip(kept).skip(submap + 1);
        let near: Vec<(Pose2, &FreeSpace)> = newer
            .filter(|(other, kept)| {
                let far = (other.map_from_submap * other.closed.centre - middle).length();
                let reach = 2.0 * (other.closed.radius + this.closed.radius);
                **kept && far < reach
            })
            .map(|(other, _)| (other.map_from_submap.inverse(), other.closed.free()))
            .collect();
        let (mut free, mut held) = (0_usize, 0_usize);
        for place in this.closed.free().places() {
            let place = this.map_from_submap * place;
            free += 1;
            held += usize::from(
                near.iter()
                    .any(|(pose, other)| other.contains(*pose * place)),
            );
        }
        held as f64 >= COVERED_FREE * free as f64
    }

    /// Joins the neighbours of submap `submap` in the graph directly: removes its own edges and
    /// returns the new ones; `None` if it has no edges.
    pub(super) fn join_past(&mut self, submap: usize) -> Option<Vec<EdgeId>> {
        let ids = self.graph.edge_ids().iter().zip(self.graph.edges());
        let own: Vec<_> = ids
            .filter(|(_, edge)| edge.from == submap || edge.to == submap)
            .map(|(id, edge)| (*id, *edge))
            .collect();
        let arms: Vec<Arm> = (own.iter())
            .filter(|(_, edge)| self.is_followed(edge))
            .filter_map(|(_, edge)| Arm::of(edge, submap))
            .collect();
        // Prefer an edge of the trajectory, so that it stays one of motions that are believed.
        let best = arms.iter().min_by(|a, b| {
            let is_closure = |arm: &Arm| arm.cauchy.is_some();
            let spread = |arm: &Arm| arm.cov.trace();
            (is_closure(a).cmp(&is_closure(b))).then(spread(a).total_cmp(&spread(b)))
        })?;
        for (id, _) in &own {
            self.graph.remove_edge(*id);
        }
        let others: Vec<&Arm> = (arms.iter())
            .filter(|arm| arm.end != best.end)
            .filter(|arm| arm.cauchy.is_none() || !self.has_edge(arm.end, best.end))
            .collect();
        let joined: Vec<Edge> = (others.iter())
            .filter_map(|arm| best.joined_to(arm, others.len()))
            .collect();
        let joined = joined.into_iter();
        let added = joined
            .filter_map(|edge| self.graph.add_edge(edge))
            .collect();
        if self.submaps[submap].is_loose
            && let Some(next) = self.submaps.get_mut(submap + 1)
        {
            next.is_loose = true;
        }
        Some(added)
    }

    fn has_edge(&self, a: usize, b: usize) -> bool {
        let ends = [a.min(b), a.max(b)];
        let edges = self.graph.edges().iter();
        let mut all = edges.map(|edge| [edge.from.min(edge.to), edge.from.max(edge.to)]);
        all.any(|other| other == ends)
    }

    fn is_followed(&self, edge: &Edge) -> bool {
        let chi2 = self.graph.chi2_of(edge);
        edge.cauchy
            .is_none_or(|scale| 1.0 / (1.0 + chi2 / (scale * scale)) >= LEAST_WEIGHT)
    }
}

/// An edge, seen from one of its ends, the `hub`.
struct Arm {
    end: usize,
    hub_from_end: Pose2,
    /// Covariance of (x, y, θ) of `hub_from_end`, in the frame of the end.
    cov: Matrix3<f64>,
    cauchy: Option<f64>,
}

impl Arm {
    fn of(edge: &Edge, hub: usize) -> Option<Self> {
        let cov = edge.information.try_inverse()?;
        let cauchy = edge.cauchy;
        if edge.from == hub {
            return Some(Self {
                end: edge.to,
                hub_from_end: edge.motion,
                cov,
                cauchy,
            });
        }
        // An error e at the end of a motion z is one of -Ad(z) e at the end of its inverse.
        let carry = edge.motion.adjoint();
        Some(Self {
            end: edge.from,
            hub_from_end: edge.motion.inverse(),
            cov: carry * cov * carry.transpose(),
            cauchy,
        })
    }

    /// The edge from the end of this arm to that of another, bypassing the hub. This arm is used
    /// `times` times.
    fn joined_to(&self, other: &Self, times: usize) -> Option<Edge> {
        let motion = self.hub_from_end.inverse() * other.hub_from_end;
        // The error at the end of this arm, carried to the end of the motion.
        let carry = motion.inverse().adjoint();
        let own = carry * self.cov * carry.transpose() * times as f64;
        let mut information = (own + other.cov).try_inverse()?;
        symmetrize(&mut information);
        Some(Edge {
            from: self.end.min(other.end),
            to: self.end.max(other.end),
            motion: if self.end < other.end {
                motion
            } else {
                motion.inverse()
            },
            information: if self.end < other.end {
                information
            } else {
                // As above, in the other direction.
                let carry = motion.inverse().adjoint();
                let mut turned = carry.transpose() * information * carry;
                symmetrize(&mut turned);
                turned
            },
            cauchy: self.cauchy.or(other.cauchy),
        })
    }
}

/// The surfaces of a submap in the map, each cell once.
fn keys(submap: &Submap) -> Vec<Key> {
    let surfels = submap.closed.oriented();
    let mut keys: Vec<Key> = surfels
        .map(|point| {
            let place = submap.map_from_submap * point.position;
            let normal = submap.map_from_submap.rotate(point.normal);
            let turns = libm::atan2(normal.y, normal.x) / std::f64::consts::TAU;
            let direction = (turns * f64::from(DIRECTIONS)).floor() as i32;
            let cell = |v: f64| (v / CELL).floor() as i32;
            (
                cell(place.x),
                cell(place.y),
                direction.rem_euclid(DIRECTIONS),
            )
        })
        .collect();
    keys.sort_unstable();
    keys.dedup();
    keys
}

/// Whether enough submaps hold nearly all of these surfaces.
fn surfaces_are_held(keys: &[Key], holders: &BTreeMap<Key, u32>) -> bool {
    let around = |(col, row, direction): Key| {
        let steps = [-1, 0, 1];
        let cells = steps.into_iter().flat_map(move |c| steps.map(|r| (c, r)));
        let facing = move |(c, r): (i32, i32)| {
            steps.map(|turn| (col + c, row + r, (direction + turn).rem_euclid(DIRECTIONS)))
        };
        cells.flat_map(facing)
    };
    let is_held = |key: &&Key| {
        // The maximum over the neighbours: a sum would count a submap several times.
        let most = around(**key).filter_map(|key| holders.get(&key)).max();
        most.is_some_and(|most| *most >= COVERED_BY)
    };
    keys.iter().filter(is_held).count() as f64 >= COVERED_SURFACES * keys.len() as f64
}

#[cfg(test)]
mod tests;

//! Points found again by the distances among them, whatever the motion.
//!
//! 1. Cross distances: two points before and two now, of the same kinds, whose distances agree
//!    within n σ, give a placement: the motion that lays one pair on the other.
//! 2. Its support is the number of points that it puts on one of their kind, one to one, within the
//!    gate. Such a placement errs by the noise of its two points, less the farther they are apart.
//!    So of all pairs that belong together, the best is supported by every true match.
//! 3. The placement with the most support wins (of equal ones, the one with the smaller sum of d²).
//!    It is fitted to all points that support it, and its support is found anew.
//! 4. If another placement that puts the points elsewhere has as much support, nothing is found
//!    again: in a row of equal pillars, any shift by one is as good.
//!
//! Source: Pilch 2016 §1.2.3 (relations among the points); the search is that of Grimson &
//! Lozano-Pérez (1987), "Localizing overlapping parts by searching the interpretation tree", cut
//! off at pairs.

use nalgebra::{Matrix2, Point2, Vector2};

use super::{PointMatch, PointMatchConfig, are_alike, distance2, one_to_one, place};
use crate::features::PointFeature;
use crate::geom::{Length, Pose2};

/// Points nearer to each other than this make no placement, m: their direction is too uncertain.
const LEAST_DISTANCE: f64 = 0.3;
/// A placement is the same as the best one if it puts the middle of the points within this distance
/// of where the best one puts it (m), and is turned by no more than this (rad).
const SAME_SHIFT: f64 = 0.3;
const SAME_TURN: f64 = 0.1;

/// A placement and the matches that support it.
struct Placement {
    now_from_before: Pose2,
    matches: Vec<PointMatch>,
    sum: f64,
}

pub(super) fn by_relations(
    before: &[PointFeature],
    now: &[PointFeature],
    config: &PointMatchConfig,
) -> Vec<PointMatch> {
    let mut best: Option<Placement> = None;
    let mut rivals: Vec<(usize, Pose2)> = vec![];
    for pose in placements(before, now, config) {
        let placement = supported(before, now, pose, config.gate);
        let support = placement.matches.len();
        if support >= config.min_support {
            rivals.push((support, pose));
            if best.as_ref().is_none_or(|best| placement.is_better(best)) {
                best = Some(placement);
            }
        }
    }
    let Some(best) = best else { return vec![] };
    let support = best.matches.len();
    let middle = middle(before);
    let is_elsewhere = |pose: &Pose2| {
        let shift = (*pose * middle - best.now_from_before * middle).length();
        let turn = best.now_from_before.delta_to(pose).heading().abs();
        shift > SAME_SHIFT || turn > SAME_TURN
    };
    if rivals
        .iter()
        .any(|(own, pose)| *own >= support && is_elsewhere(pose))
    {
        return vec![];
    }
    let pairs = best
        .matches
        .iter()
        .filter_map(|pair| Some((place(before, pair.before)?, place(now, pair.now)?)));
    match fitted(&pairs.collect::<Vec<_>>()) {
        Some(pose) => {
            let again = supported(before, now, pose, config.gate);
            if again.is_better(&best) {
                again.matches
            } else {
                best.matches
            }
        }
        None => best.matches,
    }
}

impl Placement {
    fn is_better(&self, other: &Self) -> bool {
        let (own, others) = (self.matches.len(), other.matches.len());
        own > others || own == others && self.sum < other.sum
    }
}

/// Step 1.
fn placements(
    before: &[PointFeature],
    now: &[PointFeature],
    config: &PointMatchConfig,
) -> Vec<Pose2> {
    let (of_before, of_now) = (distances(before), distances(now));
    let mut found = vec![];
    for a in &of_before {
        // Distances now that may be the same.
        let most = config.relation_sigmas
            * (a.var + of_now.iter().map(|b| b.var).fold(0.0, f64::max)).sqrt();
        let from = of_now.partition_point(|b| b.length < a.length - most);
        let near = of_now
            .iter()
            .skip(from)
            .take_while(|b| b.length <= a.length + most);
        for b in near {
            let off = b.length - a.length;
            let limit = config.relation_sigmas * config.relation_sigmas;
            if off * off > limit * (a.var + b.var) {
                continue;
            }
            for ends in [b.ends, [b.ends[1], b.ends[0]]] {
                found.extend(placement(before, now, a.ends, ends));
            }
        }
    }
    found
}

/// The distance of two points, and its variance.
struct Distance {
    ends: [usize; 2],
    length: f64,
    var: f64,
}

/// All distances that are long enough, by length.
fn distances(points: &[PointFeature]) -> Vec<Distance> {
    let pairs = points.iter().enumerate().flat_map(|(i, a)| {
        points
            .iter()
            .enumerate()
            .skip(i + 1)
            .map(move |(j, b)| ([i, j], a, b))
    });
    let mut all: Vec<Distance> = pairs
        .filter_map(|(ends, a, b)| {
            let off = b.position - a.position;
            let length = off.length();
            let along = off / length;
            let var = along.dot(&((a.cov + b.cov) * along));
            (length >= LEAST_DISTANCE && var.is_finite()).then_some(Distance { ends, length, var })
        })
        .collect();
    all.sort_by(|a, b| a.length.total_cmp(&b.length));
    all
}

/// The motion that lays two points on two others of their kinds, as well as their distances allow.
fn placement(
    before: &[PointFeature],
    now: &[PointFeature],
    [i, j]: [usize; 2],
    [k, l]: [usize; 2],
) -> Option<Pose2> {
    let (a, b, c, d) = (before.get(i)?, before.get(j)?, now.get(k)?, now.get(l)?);
    if !(are_alike(&a.kind, &c.kind) && are_alike(&b.kind, &d.kind)) {
        return None;
    }
    fitted(&[(a.position, c.position), (b.position, d.position)])
}

/// Step 2.
fn supported(before: &[PointFeature], now: &[PointFeature], pose: Pose2, gate: f64) -> Placement {
    let turn = Matrix2::from_columns(&[Vector2::x(), Vector2::y()].map(|axis| pose.rotate(axis)));
    let mut pairs = vec![];
    for (index, point) in before.iter().enumerate() {
        let moved = PointFeature {
            position: pose * point.position,
            cov: turn * point.cov * turn.transpose(),
            ..*point
        };
        pairs.extend(now.iter().enumerate().filter_map(|(now, other)| {
            let d2 = distance2(&moved, other)?;
            (d2 <= gate).then_some(PointMatch {
                before: index,
                now,
                d2,
            })
        }));
    }
    let matches = one_to_one(pairs);
    Placement {
        now_from_before: pose,
        sum: matches.iter().map(|pair| pair.d2).sum(),
        matches,
    }
}

/// A place before, and the same place now.
type PlacePair = (Point2<f64>, Point2<f64>);

/// The motion with the least sum of squared distances, in closed form (Arun et al. 1987, in the
/// plane); `None` if all points coincide.
fn fitted(pairs: &[PlacePair]) -> Option<Pose2> {
    let n = pairs.len() as f64;
    let sum =
        |side: fn(&PlacePair) -> Vector2<f64>| pairs.iter().map(side).sum::<Vector2<f64>>() / n;
    let (from, to) = (sum(|pair| pair.0.coords), sum(|pair| pair.1.coords));
    let (mut cos, mut sin) = (0.0, 0.0);
    for (a, b) in pairs {
        let (a, b) = (a.coords - from, b.coords - to);
        cos += a.dot(&b);
        sin += a.perp(&b);
    }
    let length = Vector2::new(cos, sin).length();
    (length > 0.0 && length.is_finite()).then(|| {
        let turn = libm::atan2(sin, cos);
        let shift = to - Pose2::new(0.0, 0.0, turn).rotate(from);
        Pose2::new(shift.x, shift.y, turn)
    })
}

fn middle(points: &[PointFeature]) -> Point2<f64> {
    let n = points.len().max(1) as f64;
    let sum = points
        .iter()
        .map(|p| p.position.coords)
        .sum::<Vector2<f64>>();
    Point2::from(sum / n)
}

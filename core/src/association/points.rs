//! In: points of two scans. Out: which points are the same.
//!
//! | way | needs | cost for n points |
//! |---|---|---|
//! | [`PointMatching::Exhaustive`] | the robot's motion to a few σ | n² |
//! | [`PointMatching::Nearest`] | the same | n, by a hash grid ([`grid`]) |
//! | [`PointMatching::Relations`] | nothing: works for any motion | n⁴ at worst ([`relations`]) |
//!
//! Points of different kinds, and circles of different sizes, are never the same. The distance of a
//! pair is the squared Mahalanobis distance d², with the covariances of both points and of the
//! motion; a pair must be within the gate.
//!
//! Source: Pilch 2016 §1.2.3, who names exhaustive search, nearest neighbours by an index, and
//! cross-correlation of the relations among the points for large moves.

mod grid;
mod relations;

use nalgebra::{Matrix2, Matrix2x3, Point2, Vector2};

use crate::bounds::{Bounds, NOT_NEGATIVE, OutOfBounds, check, config, or_no_limit};
use crate::features::{PointFeature, PointKind};
use crate::geom::{CHI2_2DOF_99, PoseEstimate};
use grid::PointGrid;

/// How the points of one scan are found again in the next.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PointMatching {
    /// All pairs are compared; the nearest pair is matched, then the nearest of the rest.
    Exhaustive,
    /// Pairs of points that are each other's nearest. If the gates of two pairs overlap, this
    /// leaves out what [`Self::Exhaustive`] would give to the second best.
    #[default]
    Nearest,
    /// The placement on which most distances among the points agree.
    Relations,
}

impl PointMatching {
    /// All of them, with their names.
    pub const ALL: [(&'static str, Self); 3] = [
        ("exhaustive", Self::Exhaustive),
        ("nearest", Self::Nearest),
        ("relations", Self::Relations),
    ];
}

config! {
    /// When two points of different scans are the same.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct PointMatchConfig {
        /// How pairs are found. Default [`PointMatching::Nearest`].
        pub method: PointMatching = PointMatching::Nearest,
        /// Largest d² of a pair. Default 9.21, 99 % of χ² with 2 degrees of freedom. Larger: more
        /// pairs, more wrong ones.
        pub gate: f64 = CHI2_2DOF_99,
        /// Of relations: two distances agree within so many standard deviations. Default 3. Larger:
        /// slower, more chance agreement.
        pub relation_sigmas: f64 = 3.0,
        /// Of relations: fewest points that must agree in one placement. Default 4: two make any
        /// placement, and a third may fit by chance.
        pub min_support: usize = 4,
    }
}

impl PointMatchConfig {
    /// What [`Self::relation_sigmas`] may be.
    pub const RELATION_SIGMAS: Bounds = [0.1, 20.0];
    /// What [`Self::min_support`] may be.
    pub const MIN_SUPPORT: Bounds = [2.0, 100.0];

    /// Checks all settings. The gate may be infinite: then it lets everything pass.
    ///
    /// # Errors    [`OutOfBounds`] with the first one out of range.
    pub fn validate(&self) -> Result<(), OutOfBounds> {
        let gate = or_no_limit(self.gate, NOT_NEGATIVE);
        check(&[
            ("gate", gate, NOT_NEGATIVE),
            (
                "relation_sigmas",
                self.relation_sigmas,
                Self::RELATION_SIGMAS,
            ),
            ("min_support", self.min_support as f64, Self::MIN_SUPPORT),
        ])
    }
}

/// A point that was found again.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointMatch {
    /// Its index among the points before.
    pub before: usize,
    /// Its index among the points now.
    pub now: usize,
    /// Squared Mahalanobis distance of the two.
    pub d2: f64,
}

/// Finds the points of one scan again in another, each at most once, in the order of the points
/// now.
///
/// # Units    Each scan in its own robot frame, m. `now_from_before`: the motion, with its
/// covariance (the pose of the earlier frame in the present one); [`PointMatching::Relations`]
/// ignores it.
/// # Source   Pilch 2016 §1.2.3.
#[must_use]
pub fn match_points(
    before: &[PointFeature],
    now: &[PointFeature],
    now_from_before: &PoseEstimate,
    config: &PointMatchConfig,
) -> Vec<PointMatch> {
    let mut matches = match config.method {
        PointMatching::Exhaustive => exhaustive(&moved(before, now_from_before), now, config.gate),
        PointMatching::Nearest => nearest(&moved(before, now_from_before), now, config.gate),
        PointMatching::Relations => relations::by_relations(before, now, config),
    };
    matches.sort_by_key(|pair| pair.now);
    matches
}

/// The earlier points where they are expected now: Σ = R C Rᵀ + J P Jᵀ with J = (I, R' p).
fn moved(before: &[PointFeature], now_from_before: &PoseEstimate) -> Vec<PointFeature> {
    let pose = &now_from_before.pose;
    let turn = Matrix2::from_columns(&[Vector2::x(), Vector2::y()].map(|axis| pose.rotate(axis)));
    before
        .iter()
        .map(|point| {
            let arm = pose.rotate(point.position.coords);
            let by_pose = Matrix2x3::new(1.0, 0.0, -arm.y, 0.0, 1.0, arm.x);
            PointFeature {
                position: *pose * point.position,
                cov: turn * point.cov * turn.transpose()
                    + by_pose * now_from_before.cov * by_pose.transpose(),
                ..*point
            }
        })
        .collect()
}

/// d² of two points of one kind; `None` if they cannot be the same.
fn distance2(a: &PointFeature, b: &PointFeature) -> Option<f64> {
    if !are_alike(&a.kind, &b.kind) {
        return None;
    }
    let off = b.position - a.position;
    let d2 = off.dot(&(a.cov + b.cov).cholesky()?.solve(&off));
    d2.is_finite().then_some(d2)
}

/// Whether both are of one kind; circles also need equal size within 3 σ.
#[must_use]
pub fn are_alike(a: &PointKind, b: &PointKind) -> bool {
    match (a, b) {
        (
            PointKind::Circle { radius, var_radius },
            PointKind::Circle {
                radius: other,
                var_radius: other_var,
            },
        ) => (radius - other) * (radius - other) <= 9.0 * (var_radius + other_var),
        (a, b) => a.is_like(b),
    }
}

fn exhaustive(expected: &[PointFeature], now: &[PointFeature], gate: f64) -> Vec<PointMatch> {
    let pairs = expected.iter().enumerate().flat_map(|(before, a)| {
        let pair = move |(now, b)| {
            let d2 = distance2(a, b)?;
            (d2 <= gate).then_some(PointMatch { before, now, d2 })
        };
        now.iter().enumerate().filter_map(pair)
    });
    one_to_one(pairs.collect())
}

/// The nearest pairs first, each point once.
fn one_to_one(mut pairs: Vec<PointMatch>) -> Vec<PointMatch> {
    pairs.sort_by(|a, b| a.d2.total_cmp(&b.d2));
    let mut kept: Vec<PointMatch> = vec![];
    for pair in pairs {
        if !kept
            .iter()
            .any(|k| k.before == pair.before || k.now == pair.now)
        {
            kept.push(pair);
        }
    }
    kept
}

fn nearest(expected: &[PointFeature], now: &[PointFeature], gate: f64) -> Vec<PointMatch> {
    // Beyond this no pair can be within the gate: d² ≥ distance² / (sum of the largest variances).
    let widest = |points: &[PointFeature]| {
        let traces = points.iter().map(|point| point.cov.trace());
        traces.fold(0.0, f64::max)
    };
    let reach = (gate * (widest(expected) + widest(now))).sqrt();
    let best_of = |own: &[PointFeature], others: &[PointFeature]| -> Vec<Option<(usize, f64)>> {
        let grid = PointGrid::new(others.iter().map(|point| point.position), reach);
        let nearest = |point: &PointFeature| {
            let near = grid.near(point.position).filter_map(|index| {
                let d2 = distance2(point, others.get(index)?)?;
                (d2 <= gate).then_some((index, d2))
            });
            near.min_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)))
        };
        own.iter().map(nearest).collect()
    };
    let (of_before, of_now) = (best_of(expected, now), best_of(now, expected));
    let is_mutual = |(now, best): (usize, &Option<(usize, f64)>)| {
        let (before, d2) = (*best)?;
        let back = of_before.get(before).copied().flatten();
        back.is_some_and(|(back, _)| back == now)
            .then_some(PointMatch { before, now, d2 })
    };
    of_now.iter().enumerate().filter_map(is_mutual).collect()
}

/// The position of a point.
fn place(points: &[PointFeature], index: usize) -> Option<Point2<f64>> {
    points.get(index).map(|point| point.position)
}

#[cfg(test)]
mod tests;

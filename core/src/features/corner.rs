//! In: runs of neighbours. Out: corners, by a sliding window.
//!
//! Source: Pilch 2016 §1.2.1, eq. (1.1), and §3.5.1.
//!
//! 1. Of 11, 13 or 15 neighbours, the middle one is a vertex if the vectors u and v to the first
//!    and the last make an angle θ = acos(u·v / |u||v|) from 40° to 143°.
//! 2. Both are no longer than a number of k per point (the paper: 1.5), k being the spacing of
//!    beams at that range ([`SpacingModel`]): otherwise something is missing between them.
//! 3. Checked backwards: the angles to the 1st to 4th neighbours on both sides are within the same
//!    limits. If ranges are as uncertain as the distance between points, those angles can be
//!    anything; so the limits are widened by n σ of each angle. With n = 0 it is the paper's check.
//! 4. Of the vertices in one window, the one with the smallest angle is kept: beside the true
//!    vertex, one of the vectors crosses the corner, which widens the angle.
//! 5. The paper's corner is the measured point. Here it is where the legs cross: each leg is the
//!    weighted line through the neighbours on its side ([`super::consensus`]), the border between
//!    them is where their sum of squares is least, and the covariance is that of the crossing
//!    ([`super::crossing`]). So the corner does not depend on where a beam happened to hit, and its
//!    uncertainty is known.

use std::ops::Range;

use nalgebra::{Point2, Vector2};

use super::columns::Columns;
use super::consensus::{refined, settle_borders};
use super::crossing::crossing;
use super::fit::{Fit, fit_columns};
use super::piece::Piece;
use super::point::{PointFeature, PointKind, probability_within};
use crate::bounds::config;
use crate::geom::{Length, wrap};
use crate::points::{Points, SpacingModel};

config! {
    /// Where a row of neighbours has a corner.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct CornerConfig {
        /// Whether they are looked for. Default yes.
        pub is_on: bool = true,
        /// Neighbours on either side of the vertex. Default 5, which is a window of 11; 6 and 7 are
        /// windows of 13 and 15. Larger: less noise, larger corners.
        pub half_window: usize = 5,
        /// Smallest angle of a corner, rad. Default 40°.
        pub min_angle: f64 = 0.698,
        /// Largest angle of a corner, rad. Default 143°. Larger: walls become corners by noise.
        pub max_angle: f64 = 2.496,
        /// Neighbours for which the angle is checked again. Default 4.
        pub back_checks: usize = 4,
        /// By how many standard deviations of its own an angle may miss the limits there. Default
        /// 2. Larger: more corners, more wrong ones. 0 is the paper's.
        pub back_check_sigmas: f64 = 2.0,
        /// Longest vector per point, in spacings of the beams. Default 3, legs seen at up to 70°.
        /// The paper's 1.5 is 48°, and the legs of a right angle are seen at i and 90° - i: it
        /// loses two of three corners of a room. Larger: corners across gaps.
        pub max_stretch: f64 = 3.0,
        /// Neighbours of a leg at most. Default 20. Larger: better placed, in straight walls.
        pub leg_points: usize = 20,
        /// Largest standard deviation of a leg's direction, rad. Default 0.1: what is linear there
        /// is not at 0.2.
        pub max_alpha_sigma: f64 = 0.1,
    }
}

/// A point is on a leg within so many standard deviations.
const LEG_SIGMAS: f64 = 3.0;
/// Fewest points of a leg.
const FEW: usize = 4;

/// Neighbours in the columns.
#[derive(Clone, Debug)]
pub(super) struct Row {
    /// Their range in the columns.
    pub(super) range: Range<usize>,
    /// How many of the first are repeated at the end if the row is a ring: without this, no window
    /// would have its first and last points in the middle, and a ring begins at a corner.
    pub(super) n_repeated: usize,
}

impl CornerConfig {
    /// How many points of a ring must be repeated at its end.
    pub(super) fn overlap(&self) -> usize {
        2 * self.half_window + self.leg_points
    }
}

/// The corners of the rows; added to `found`.
pub(super) fn corners(
    columns: &Columns,
    points: &Points,
    rows: &[Row],
    config: &CornerConfig,
    found: &mut Vec<PointFeature>,
) {
    let finder = Finder {
        columns,
        points,
        config,
        spacing: SpacingModel::of(points),
    };
    for row in rows {
        for vertex in finder.vertices(row) {
            found.extend(finder.corner(&row.range, vertex));
        }
    }
}

struct Finder<'a> {
    columns: &'a Columns,
    points: &'a Points,
    config: &'a CornerConfig,
    spacing: SpacingModel,
}

impl Finder<'_> {
    /// Steps 1 to 4, in order.
    fn vertices(&self, row: &Row) -> Vec<usize> {
        let (half, range) = (self.config.half_window, &row.range);
        let first = range.start + half;
        let n_points = range.len() - row.n_repeated;
        let end = match row.n_repeated {
            0 => range.end.saturating_sub(half),
            // Each point of a ring is visited once.
            _ => first + n_points,
        };
        let candidates =
            (first..end).filter_map(|vertex| Some((vertex, self.angle_of_vertex(vertex)?)));
        let mut best: Vec<(usize, f64)> = vec![];
        for (vertex, angle) in candidates {
            match best.last_mut() {
                Some(last) if vertex - last.0 <= half => {
                    if angle < last.1 {
                        *last = (vertex, angle);
                    }
                }
                _ => best.push((vertex, angle)),
            }
        }
        // A ring ends where it began.
        if let (true, [first, .., last]) = (row.n_repeated > 0, best.as_slice())
            && first.0 + n_points - last.0 <= half
        {
            if last.1 < first.1 {
                best.remove(0);
            } else {
                best.pop();
            }
        }
        best.into_iter().map(|(vertex, _)| vertex).collect()
    }

    /// The angle at a point if it is a vertex, rad.
    fn angle_of_vertex(&self, vertex: usize) -> Option<f64> {
        let half = self.config.half_window;
        let limits = [self.config.min_angle, self.config.max_angle];
        let angle = self.angle(vertex, half)?;
        let is_inside =
            |angle: f64, slack: f64| (limits[0] - slack..=limits[1] + slack).contains(&angle);
        let longest = self.config.max_stretch * half as f64 * self.expected_spacing(vertex);
        let at = self.columns.point(vertex);
        let is_long = |end: usize| (self.columns.point(end) - at).length() > longest;
        if !is_inside(angle, 0.0) || is_long(vertex - half) || is_long(vertex + half) {
            return None;
        }
        let holds = |step: usize| {
            let slack = self.config.back_check_sigmas * self.angle_sigma(vertex, step);
            (self.angle(vertex, step)).is_some_and(|angle| is_inside(angle, slack))
        };
        let steps = 1..=self.config.back_checks.min(half - 1);
        steps.into_iter().all(holds).then_some(angle)
    }

    /// k at a point.
    fn expected_spacing(&self, index: usize) -> f64 {
        let beam = self.points.beams.get(self.columns.source(index));
        beam.map_or(0.0, |beam| self.spacing.at(beam.range))
    }

    /// The vectors from a point to its neighbours `step` before and after it.
    fn arms(&self, vertex: usize, step: usize) -> [Vector2<f64>; 2] {
        let at = self.columns.point(vertex);
        [vertex - step, vertex + step].map(|end| self.columns.point(end) - at)
    }

    /// Eq. (1.1).
    fn angle(&self, vertex: usize, step: usize) -> Option<f64> {
        let [u, v] = self.arms(vertex, step);
        // From both products: the cosine alone has no precision near 0 and π.
        let angle = libm::atan2(u.perp(&v).abs(), u.dot(&v));
        (u.length() > 0.0 && v.length() > 0.0).then_some(angle)
    }

    /// Standard deviation of that angle from the noise of the three points, rad: an arm u turns by
    /// (u ⟂ du) / |u|², and the vertex moves both.
    fn angle_sigma(&self, vertex: usize, step: usize) -> f64 {
        let [by_u, by_v] = self.arms(vertex, step).map(|arm| {
            let across = Vector2::new(-arm.y, arm.x);
            across / arm.norm_squared()
        });
        let var = self.columns.spread(vertex - step, &by_u)
            + self.columns.spread(vertex + step, &by_v)
            + self.columns.spread(vertex, &(by_u - by_v));
        var.sqrt()
    }

    /// Step 5.
    fn corner(&self, run: &Range<usize>, vertex: usize) -> Option<PointFeature> {
        let (half, reach) = (
            self.config.half_window,
            self.config.leg_points.max(self.config.half_window),
        );
        let before = run.start.max(vertex.saturating_sub(reach))..vertex;
        let after = vertex..run.end.min(vertex + reach + 1);
        let leg = |range: &Range<usize>| {
            let near = |index: usize| index != vertex && index.abs_diff(vertex) <= half;
            let found = refined(self.columns, range, (LEG_SIGMAS, FEW), |_| true, near)?;
            let touches = (found.stretch.range.start <= vertex + 2)
                && (found.stretch.range.end + 2 >= vertex);
            touches.then_some(found)
        };
        let (before, after) = (leg(&before)?, leg(&after)?);
        let mut columns = self.columns.clone();
        let mut legs = [before, after].map(|leg| leg.take(&mut columns, LEG_SIGMAS));
        settle_borders(&mut columns, &mut legs, FEW);
        let [a, b] = legs.map(|leg| inner(&columns, &leg, vertex));
        let (a, b) = (fit_columns(&columns, &a?)?, fit_columns(&columns, &b?)?);
        self.where_legs_cross(&a, &b, vertex)
    }

    fn where_legs_cross(&self, a: &Fit, b: &Fit, vertex: usize) -> Option<PointFeature> {
        let largest = self.config.max_alpha_sigma;
        if a.cov[(0, 0)].max(b.cov[(0, 0)]) > largest * largest {
            return None;
        }
        let (position, cov) = crossing([(a.line, a.cov), (b.line, b.cov)])?;
        // At most as far from the measured vertex as the step between points plus noise: otherwise
        // something smaller stands between the legs, such as the end of a thin wall.
        let near = self.config.max_stretch * self.expected_spacing(vertex)
            + LEG_SIGMAS * self.columns.variance_along(vertex).sqrt();
        if (position - self.columns.point(vertex)).length() > near {
            return None;
        }
        let (angle, limits) = (
            angle_between(a, b, position),
            [self.config.min_angle, self.config.max_angle],
        );
        let sigma = (a.cov[(0, 0)] + b.cov[(0, 0)]).sqrt();
        (limits[0]..=limits[1])
            .contains(&angle)
            .then(|| PointFeature {
                position,
                cov,
                kind: PointKind::Corner,
                confidence: probability_within(angle, sigma, limits),
                beams: [self.columns.number(a.first), self.columns.number(b.last)],
            })
    }
}

/// A leg without the point next to the vertex, because which leg that belongs to is a guess.
fn inner(columns: &Columns, leg: &Piece, vertex: usize) -> Option<Piece> {
    let (first, last) = (leg.first(columns)?, leg.last(columns)?);
    let range = if first.abs_diff(vertex) < last.abs_diff(vertex) {
        first + 1..last + 1
    } else {
        first..last
    };
    (range.len() >= FEW - 1).then(|| Piece::kept_of(columns, range))
}

/// The angle at the corner between two legs, rad.
fn angle_between(a: &Fit, b: &Fit, corner: Point2<f64>) -> f64 {
    let towards = |fit: &Fit| {
        let middle = nalgebra::center(&fit.ends[0], &fit.ends[1]);
        let along = middle - corner;
        libm::atan2(along.y, along.x)
    };
    wrap(towards(b) - towards(a)).abs()
}

#[cfg(test)]
mod tests;

//! Infinite lines in Hessian normal form.

use nalgebra::{Matrix2, Point2, Vector2};

use super::{Pose2, sin_cos, wrap};
use crate::geom::Length;

/// The line x cos α + y sin α = r with r ≥ 0 and α in (-π, π].
///
/// Source: TDK 2016 §3.2. The invariant is kept by the constructor; flipping the sign of r turns α
/// by π.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    alpha: f64,
    r: f64,
}

impl Line {
    /// The line with normal direction `alpha` (rad) at signed distance `r` (m); brought to r ≥ 0.
    #[must_use]
    pub fn new(alpha: f64, r: f64) -> Self {
        if r < 0.0 {
            Self {
                alpha: wrap(alpha + std::f64::consts::PI),
                r: -r,
            }
        } else {
            Self {
                alpha: wrap(alpha),
                r,
            }
        }
    }

    /// The line through two points; `None` if they coincide.
    #[must_use]
    pub fn through(a: Point2<f64>, b: Point2<f64>) -> Option<Self> {
        let along = b - a;
        let length = along.length();
        if !(length > 0.0 && length.is_finite()) {
            return None;
        }
        let normal = Vector2::new(-along.y, along.x) / length;
        Some(Self::new(
            libm::atan2(normal.y, normal.x),
            normal.dot(&a.coords),
        ))
    }

    /// Direction of the normal, from the origin towards the line, rad.
    #[must_use]
    pub fn alpha(&self) -> f64 {
        self.alpha
    }

    /// Distance from the origin, m.
    #[must_use]
    pub fn r(&self) -> f64 {
        self.r
    }

    /// Unit normal, from the origin towards the line.
    #[must_use]
    pub fn normal(&self) -> Vector2<f64> {
        let (sin, cos) = sin_cos(self.alpha);
        Vector2::new(cos, sin)
    }

    /// Signed distance of a point, m: positive beyond the line as seen from the origin.
    #[must_use]
    pub fn signed_distance(&self, point: Point2<f64>) -> f64 {
        self.normal().dot(&point.coords) - self.r
    }

    /// Foot of the perpendicular from `point`.
    #[must_use]
    pub fn project(&self, point: Point2<f64>) -> Point2<f64> {
        point - self.normal() * self.signed_distance(point)
    }

    /// This line seen from frame a, for a line in frame b and a given `a_from_b`, with the Jacobian
    /// of (α, r) in a by (α, r) in b. The row of r flips its sign together with r.
    ///
    /// Source: TDK 2016 eq. (3.27), with the erratum of the specification: the global α in cos and
    /// sin.
    #[must_use]
    pub fn transformed(&self, a_from_b: &Pose2) -> (Self, Matrix2<f64>) {
        let alpha = self.alpha + a_from_b.heading();
        let (sin, cos) = sin_cos(alpha);
        let (x, y) = (a_from_b.x(), a_from_b.y());
        let r = self.r + x * cos + y * sin;
        let sign = if r < 0.0 { -1.0 } else { 1.0 };
        let jacobian = Matrix2::new(1.0, 0.0, sign * (-x * sin + y * cos), sign);
        (Self::new(alpha, r), jacobian)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, PI};

    use super::*;
    use proptest::prelude::*;

    #[test]
    fn wall_two_metres_ahead() {
        let wall = Line::through(Point2::new(2.0, -1.0), Point2::new(2.0, 1.0)).unwrap();
        assert!(wall.alpha().abs() < 1e-12 && (wall.r() - 2.0).abs() < 1e-12);
        assert!(Line::through(Point2::origin(), Point2::origin()).is_none());
    }

    #[test]
    fn negative_distance_turns_the_normal() {
        let line = Line::new(FRAC_PI_2, -1.0);
        assert!((line.alpha() + FRAC_PI_2).abs() < 1e-12 && line.r() > 0.0);
    }

    proptest! {
        #[test]
        fn moving_the_line_is_moving_its_points(
            alpha in -PI..PI, r in 0.0..20.0_f64, x in -20.0..20.0_f64, y in -20.0..20.0_f64, turn in -PI..PI, s in -9.0..9.0_f64,
        ) {
            let line = Line::new(alpha, r);
            let (sin, cos) = sin_cos(alpha);
            let on_it = Point2::new(r * cos - s * sin, r * sin + s * cos);
            let a_from_b = Pose2::new(x, y, turn);
            let (moved, _) = line.transformed(&a_from_b);
            prop_assert!(moved.r() >= 0.0);
            prop_assert!(moved.signed_distance(a_from_b * on_it).abs() < 1e-9);
        }

        #[test]
        fn jacobian_matches_central_differences(
            alpha in -PI..PI, r in 0.1..20.0_f64, x in -20.0..20.0_f64, y in -20.0..20.0_f64, turn in -PI..PI,
        ) {
            let a_from_b = Pose2::new(x, y, turn);
            let (moved, jacobian) = Line::new(alpha, r).transformed(&a_from_b);
            prop_assume!(moved.r() > 1e-3);
            let h = 1e-6;
            for (column, (da, dr)) in [(h, 0.0), (0.0, h)].into_iter().enumerate() {
                let (plus, _) = Line::new(alpha + da, r + dr).transformed(&a_from_b);
                let (minus, _) = Line::new(alpha - da, r - dr).transformed(&a_from_b);
                let numeric = [wrap(plus.alpha() - minus.alpha()) / (2.0 * h), (plus.r() - minus.r()) / (2.0 * h)];
                for (row, n) in numeric.iter().enumerate() {
                    prop_assert!((n - jacobian[(row, column)]).abs() < 1e-5, "{n} against {}", jacobian[(row, column)]);
                }
            }
        }
    }
}

//! Poses and rigid motions of the plane, SE(2).

use std::ops::Mul;

use nalgebra::{Isometry2, Matrix3, Point2, Translation2, UnitComplex, Vector2, Vector3};

use super::{sin_cos, wrap};

/// A pose, or a rigid motion: `map_from_robot * p_in_robot = p_in_map`.
///
/// Name a value after what it does, and let the names meet: `map_from_scan = map_from_robot *
/// robot_from_scan`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose2(Isometry2<f64>);

impl Pose2 {
    /// The pose at (`x`, `y`), metres, turned by `heading`, radians.
    #[must_use]
    pub fn new(x: f64, y: f64, heading: f64) -> Self {
        let (sin, cos) = sin_cos(heading);
        Self(Isometry2::from_parts(
            Translation2::new(x, y),
            UnitComplex::from_cos_sin_unchecked(cos, sin),
        ))
    }

    /// The pose at (`x`, `y`), metres, turned by the angle of this cosine and sine, which are used
    /// unchanged: their squares must sum to 1.
    #[must_use]
    pub fn from_cos_sin(x: f64, y: f64, cos: f64, sin: f64) -> Self {
        Self(Isometry2::from_parts(
            Translation2::new(x, y),
            UnitComplex::from_cos_sin_unchecked(cos, sin),
        ))
    }

    /// No motion.
    #[must_use]
    pub fn identity() -> Self {
        Self(Isometry2::identity())
    }

    /// x, m.
    #[inline]
    #[must_use]
    pub fn x(&self) -> f64 {
        self.0.translation.x
    }

    /// y, m.
    #[inline]
    #[must_use]
    pub fn y(&self) -> f64 {
        self.0.translation.y
    }

    /// Heading in (-π, π], rad.
    #[inline]
    #[must_use]
    pub fn heading(&self) -> f64 {
        wrap(libm::atan2(self.0.rotation.im, self.0.rotation.re))
    }

    /// Cosine and sine of the heading, without a transcendental call.
    #[inline]
    #[must_use]
    pub fn cos_sin(&self) -> (f64, f64) {
        (self.0.rotation.re, self.0.rotation.im)
    }

    /// The position as a point.
    #[inline]
    #[must_use]
    pub fn position(&self) -> Point2<f64> {
        Point2::from(self.0.translation.vector)
    }

    /// The motion that undoes this one.
    #[inline]
    #[must_use]
    pub fn inverse(&self) -> Self {
        Self(self.0.inverse())
    }

    /// Turns a direction without moving it.
    #[inline]
    #[must_use]
    pub fn rotate(&self, direction: Vector2<f64>) -> Vector2<f64> {
        self.0.rotation * direction
    }

    /// The motion that takes this pose to `to`, in this pose's own frame:
    /// `self * self.delta_to(to) == to`.
    #[must_use]
    pub fn delta_to(&self, to: &Self) -> Self {
        self.inverse() * *to
    }

    /// This pose with `by` added to (x, y, θ).
    #[must_use]
    pub fn plus(&self, by: &Vector3<f64>) -> Self {
        Self::new(self.x() + by.x, self.y() + by.y, self.heading() + by.z)
    }

    /// (x, y, θ) minus that of `other`; the turn is wrapped.
    #[must_use]
    pub fn minus(&self, other: &Self) -> Vector3<f64> {
        let turn = wrap(self.heading() - other.heading());
        (self.position() - other.position()).push(turn)
    }

    /// A part of this motion: `fraction` 0 is none, 1 is all, along the arc of constant speed and
    /// turn rate.
    ///
    /// Source: exponential map of SE(2), as used by scan de-skewing under constant velocity.
    #[must_use]
    pub fn fraction(&self, fraction: f64) -> Self {
        let turn = self.heading();
        // V(turn) maps the body velocity to the translation; v = V(turn)⁻¹ t, then t' = V(f·turn) f
        // v.
        let (a, b) = arc_coefficients(turn);
        let scale = 1.0 / (a * a + b * b);
        let vx = scale * (a * self.x() + b * self.y());
        let vy = scale * (-b * self.x() + a * self.y());
        let (a, b) = arc_coefficients(fraction * turn);
        Self::new(
            fraction * (a * vx - b * vy),
            fraction * (b * vx + a * vy),
            fraction * turn,
        )
    }

    /// The adjoint: maps a small motion in the frame on the right of `self` to the frame on its
    /// left, ordered (x, y, θ).
    #[must_use]
    pub fn adjoint(&self) -> Matrix3<f64> {
        let (cos, sin) = self.cos_sin();
        Matrix3::new(cos, -sin, self.y(), sin, cos, -self.x(), 0.0, 0.0, 1.0)
    }

    /// The rotation of (x, y, θ) from the frame of this pose into the frame in which the pose is
    /// given; θ does not change.
    #[must_use]
    pub fn rotation(&self) -> Matrix3<f64> {
        let (cos, sin) = self.cos_sin();
        Matrix3::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0)
    }

    /// Whether every component is a finite number.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        let (cos, sin) = self.cos_sin();
        self.x().is_finite() && self.y().is_finite() && cos.is_finite() && sin.is_finite()
    }
}

/// sin(t)/t and (1 - cos(t))/t, by series near zero, where the quotients lose all digits.
fn arc_coefficients(turn: f64) -> (f64, f64) {
    if turn.abs() < 1e-4 {
        (
            1.0 - turn * turn / 6.0,
            turn / 2.0 - turn * turn * turn / 24.0,
        )
    } else {
        let (sin, cos) = sin_cos(turn);
        (sin / turn, (1.0 - cos) / turn)
    }
}

impl Mul for Pose2 {
    type Output = Self;
    #[inline]
    fn mul(self, right: Self) -> Self {
        let mut product = self.0 * right.0;
        // Thousands of products in a row must stay rotations.
        product.rotation.renormalize_fast();
        Self(product)
    }
}

impl Mul<Point2<f64>> for Pose2 {
    type Output = Point2<f64>;
    #[inline]
    fn mul(self, point: Point2<f64>) -> Point2<f64> {
        self.0 * point
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, PI};

    use super::*;
    use crate::geom::Length;
    use proptest::prelude::*;

    fn close(a: Pose2, b: Pose2) -> bool {
        (a.position() - b.position()).length() < 1e-9
            && wrap(a.heading() - b.heading()).abs() < 1e-9
    }

    #[test]
    fn quarter_turn_takes_x_axis_to_y_axis() {
        let p = Pose2::new(1.0, 2.0, FRAC_PI_2) * Point2::new(1.0, 0.0);
        assert!((p - Point2::new(1.0, 3.0)).length() < 1e-12);
    }

    #[test]
    fn half_of_a_half_circle_is_a_quarter_circle() {
        // Half a circle of radius 1 to the left ends at (0, 2) turned by π; half of that ends at
        // (1, 1) turned by π/2.
        for side in [1.0, -1.0] {
            let half = Pose2::new(0.0, 2.0 * side, side * PI * (1.0 - 1e-12)).fraction(0.5);
            assert!(
                close(half, Pose2::new(1.0, side, side * FRAC_PI_2)),
                "{half:?}"
            );
        }
    }

    fn pose() -> impl Strategy<Value = Pose2> {
        (-50.0..50.0_f64, -50.0..50.0_f64, -PI..PI).prop_map(|(x, y, t)| Pose2::new(x, y, t))
    }

    proptest! {
        #[test]
        fn group_laws(a in pose(), b in pose(), c in pose()) {
            prop_assert!(close((a * b) * c, a * (b * c)));
            prop_assert!(close(a * a.inverse(), Pose2::identity()));
            prop_assert!(close(a * a.delta_to(&b), b));
        }

        #[test]
        fn fractions_add_up(m in pose(), f in 0.0..1.0_f64) {
            // Along one arc, the first part followed by the rest gives the whole.
            prop_assert!(close(m.fraction(f) * m.fraction(1.0 - f), m));
        }

        #[test]
        fn adjoint_matches_central_differences(a in pose()) {
            let h = 1e-6;
            for column in 0..3 {
                let step = |h: f64| {
                    let mut d = [0.0; 3];
                    d[column] = h;
                    a * Pose2::new(d[0], d[1], d[2]) * a.inverse()
                };
                let (plus, minus) = (step(h), step(-h));
                let numeric = [
                    (plus.x() - minus.x()) / (2.0 * h),
                    (plus.y() - minus.y()) / (2.0 * h),
                    wrap(plus.heading() - minus.heading()) / (2.0 * h),
                ];
                for (row, n) in numeric.iter().enumerate() {
                    prop_assert!((n - a.adjoint()[(row, column)]).abs() < 1e-6);
                }
            }
        }
    }
}

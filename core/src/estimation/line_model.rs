//! Observation model of a line: how it appears to the robot, and back, with Jacobians.
//!
//! Lines are oriented (see `association::gate`): r is signed, so neither function has a jump and
//! the sign never flips.
//!
//! # Source    TDK 2016 §3.2 and §3.4, eq. (3.27) and (3.29) with the erratum of the specification
//! (the global α).

use nalgebra::{Matrix2, Matrix2x3, Point2, Vector2};

use crate::geom::{Pose2, sin_cos, wrap};

/// Where the derivatives are taken: position of the robot and direction of the line, in the map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Linearisation {
    /// Position of the robot.
    pub(super) robot: Point2<f64>,
    /// α of the line.
    pub(super) alpha: f64,
}

/// ẑ = (α - θ, r - x cos α - y sin α), and H by (x, y, θ) and by (α, r).
pub(super) fn observe(
    map_from_robot: &Pose2,
    line: [f64; 2],
    at: &Linearisation,
) -> (Vector2<f64>, Matrix2x3<f64>, Matrix2<f64>) {
    let [alpha, r] = line;
    let (sin, cos) = sin_cos(alpha);
    let expected = Vector2::new(
        wrap(alpha - map_from_robot.heading()),
        r - map_from_robot.x() * cos - map_from_robot.y() * sin,
    );
    let (sin, cos) = sin_cos(at.alpha);
    let by_pose = Matrix2x3::new(0.0, 0.0, -1.0, -cos, -sin, 0.0);
    let by_line = Matrix2::new(1.0, 0.0, at.robot.x * sin - at.robot.y * cos, 1.0);
    (expected, by_pose, by_line)
}

/// (α_i + θ, r_i + x cos α + y sin α), and G by (x, y, θ) and by the sighting.
pub(super) fn place(
    map_from_robot: &Pose2,
    seen: [f64; 2],
    linearise_at: Point2<f64>,
) -> ([f64; 2], Matrix2x3<f64>, Matrix2<f64>) {
    let alpha = wrap(seen[0] + map_from_robot.heading());
    let (sin, cos) = sin_cos(alpha);
    let r = seen[1] + map_from_robot.x() * cos + map_from_robot.y() * sin;
    let lever = -linearise_at.x * sin + linearise_at.y * cos;
    let by_pose = Matrix2x3::new(0.0, 0.0, 1.0, cos, sin, lever);
    let by_seen = Matrix2::new(1.0, 0.0, lever, 1.0);
    ([alpha, r], by_pose, by_seen)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use proptest::prelude::*;

    use super::*;

    /// Column `axis` of a Jacobian by central differences; the first row is an angle.
    fn central(f: impl Fn(f64) -> [f64; 2]) -> [f64; 2] {
        let h = 1e-6;
        let (plus, minus) = (f(h), f(-h));
        [
            wrap(plus[0] - minus[0]) / (2.0 * h),
            (plus[1] - minus[1]) / (2.0 * h),
        ]
    }

    fn nudged(pose: [f64; 3], axis: usize, h: f64) -> Pose2 {
        let mut p = pose;
        p[axis] += h;
        Pose2::new(p[0], p[1], p[2])
    }

    proptest! {
        #[test]
        fn observation_jacobians_match_central_differences(
            x in -20.0..20.0_f64, y in -20.0..20.0_f64, turn in -PI..PI, alpha in -PI..PI, r in -20.0..20.0_f64,
        ) {
            let pose = [x, y, turn];
            let at = |alpha| Linearisation { robot: Point2::new(x, y), alpha };
            let z = |p: &Pose2, line: [f64; 2]| { let v = observe(p, line, &at(line[0])).0; [v.x, v.y] };
            let (_, by_pose, by_line) = observe(&nudged(pose, 0, 0.0), [alpha, r], &at(alpha));
            for axis in 0..3 {
                let n = central(|h| z(&nudged(pose, axis, h), [alpha, r]));
                for row in 0..2 { prop_assert!((n[row] - by_pose[(row, axis)]).abs() < 1e-5); }
            }
            for axis in 0..2 {
                let n = central(|h| { let mut l = [alpha, r]; l[axis] += h; z(&nudged(pose, 0, 0.0), l) });
                for row in 0..2 { prop_assert!((n[row] - by_line[(row, axis)]).abs() < 1e-5); }
            }
        }

        #[test]
        fn placement_jacobians_match_central_differences(
            x in -20.0..20.0_f64, y in -20.0..20.0_f64, turn in -PI..PI, alpha in -PI..PI, r in -20.0..20.0_f64,
        ) {
            let pose = [x, y, turn];
            let l = |p: &Pose2, seen: [f64; 2]| place(p, seen, p.position()).0;
            let (_, by_pose, by_seen) = place(&nudged(pose, 0, 0.0), [alpha, r], Point2::new(x, y));
            for axis in 0..3 {
                let n = central(|h| l(&nudged(pose, axis, h), [alpha, r]));
                for row in 0..2 { prop_assert!((n[row] - by_pose[(row, axis)]).abs() < 1e-5); }
            }
            for axis in 0..2 {
                let n = central(|h| { let mut s = [alpha, r]; s[axis] += h; l(&nudged(pose, 0, 0.0), s) });
                for row in 0..2 { prop_assert!((n[row] - by_seen[(row, axis)]).abs() < 1e-5); }
            }
        }

        #[test]
        fn placed_line_is_observed_where_it_was_seen(
            x in -20.0..20.0_f64, y in -20.0..20.0_f64, turn in -PI..PI, alpha in -PI..PI, r in 0.0..20.0_f64,
        ) {
            let pose = Pose2::new(x, y, turn);
            let (line, _, _) = place(&pose, [alpha, r], pose.position());
            let (z, _, _) = observe(&pose, line, &Linearisation { robot: pose.position(), alpha: line[0] });
            prop_assert!(wrap(z.x - alpha).abs() < 1e-9 && (z.y - r).abs() < 1e-9);
        }
    }
}

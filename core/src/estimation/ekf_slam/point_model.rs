//! Observation model of a point: how it appears to the robot, and back, with Jacobians.
//!
//! A point is seen as (x, y) in the robot frame, in which its covariance is given: this avoids the
//! unstable bearing of a post that is very near.

use nalgebra::{Matrix2, Matrix2x3, Point2, Vector2};

use crate::geom::Pose2;

/// Where the derivatives are taken: positions of the robot and of the point, in the map.
///
/// The heading is not among them: it only rotates the rows of H by the newest estimate, and a
/// direction that no row of H observes is not observed by any rotated row either.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Places {
    pub(super) robot: Point2<f64>,
    pub(super) point: Point2<f64>,
}

/// ẑ = Rᵀ (p - t), and H by (x, y, θ) and by p.
pub(super) fn observe(
    map_from_robot: &Pose2,
    point: Point2<f64>,
    at: &Places,
) -> (Point2<f64>, Matrix2x3<f64>, Matrix2<f64>) {
    let back = rotation(map_from_robot).transpose();
    let by_pose = back * moved_with(at.point - at.robot);
    (map_from_robot.inverse() * point, -by_pose, back)
}

/// p = t + R z, and G by (x, y, θ) and by z.
pub(super) fn place(
    map_from_robot: &Pose2,
    seen: Point2<f64>,
    linearise_at: Point2<f64>,
) -> (Point2<f64>, Matrix2x3<f64>, Matrix2<f64>) {
    let point = *map_from_robot * seen;
    let by_pose = moved_with(point - linearise_at);
    (point, by_pose, rotation(map_from_robot))
}

/// The derivative of the tip of an arm with respect to the pose at its base, by (x, y, θ).
pub(super) fn moved_with(arm: Vector2<f64>) -> Matrix2x3<f64> {
    Matrix2x3::new(1.0, 0.0, -arm.y, 0.0, 1.0, arm.x)
}

/// R of a pose.
pub(super) fn rotation(pose: &Pose2) -> Matrix2<f64> {
    let (cos, sin) = pose.cos_sin();
    Matrix2::new(cos, -sin, sin, cos)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use proptest::prelude::*;

    use super::*;
    use crate::geom::Length;

    fn nudged(numbers: [f64; 3], axis: usize, h: f64) -> Pose2 {
        let mut n = numbers;
        n[axis] += h;
        Pose2::new(n[0], n[1], n[2])
    }

    proptest! {
        #[test]
        fn jacobians_match_central_differences(
            x in -20.0..20.0_f64, y in -20.0..20.0_f64, turn in -PI..PI, px in -20.0..20.0_f64, py in -20.0..20.0_f64,
        ) {
            let (numbers, p, h) = ([x, y, turn], Point2::new(px, py), 1e-6);
            let pose = nudged(numbers, 0, 0.0);
            let at = Places { robot: pose.position(), point: p };
            let (_, by_pose, by_point) = observe(&pose, p, &at);
            let (_, placed_by_pose, placed_by_seen) = place(&pose, p, pose.position());
            let central = |plus: Point2<f64>, minus: Point2<f64>| (plus - minus) / (2.0 * h);
            for axis in 0..3 {
                let [plus, minus] = [h, -h].map(|h| nudged(numbers, axis, h));
                let seen = central(observe(&plus, p, &at).0, observe(&minus, p, &at).0);
                let placed = central(place(&plus, p, at.robot).0, place(&minus, p, at.robot).0);
                prop_assert!((seen - by_pose.column(axis)).length() < 1e-5);
                prop_assert!((placed - placed_by_pose.column(axis)).length() < 1e-5);
            }
            for axis in 0..2 {
                let mut step = Vector2::zeros();
                step[axis] = h;
                let seen = central(observe(&pose, p + step, &at).0, observe(&pose, p - step, &at).0);
                let placed = central(place(&pose, p + step, at.robot).0, place(&pose, p - step, at.robot).0);
                prop_assert!((seen - by_point.column(axis)).length() < 1e-5);
                prop_assert!((placed - placed_by_seen.column(axis)).length() < 1e-5);
            }
        }

        #[test]
        fn placed_point_is_observed_where_it_was_seen(
            x in -20.0..20.0_f64, y in -20.0..20.0_f64, turn in -PI..PI, px in -9.0..9.0_f64, py in -9.0..9.0_f64,
        ) {
            let (pose, seen) = (Pose2::new(x, y, turn), Point2::new(px, py));
            let (point, _, _) = place(&pose, seen, pose.position());
            let at = Places { robot: pose.position(), point };
            prop_assert!((observe(&pose, point, &at).0 - seen).length() < 1e-9);
        }

        /// A rotation of robot and points together about the map's origin is seen by no row,
        /// whatever the newest heading: so a filter that keeps its first places never believes that
        /// it learns it.
        #[test]
        fn turn_of_the_whole_map_is_not_observed(
            x in -20.0..20.0_f64, y in -20.0..20.0_f64, turn in -PI..PI, px in -20.0..20.0_f64, py in -20.0..20.0_f64,
            rx in -20.0..20.0_f64, ry in -20.0..20.0_f64,
        ) {
            let at = Places { robot: Point2::new(rx, ry), point: Point2::new(px, py) };
            let (_, by_pose, by_point) = observe(&Pose2::new(x, y, turn), at.point, &at);
            let of_pose = nalgebra::Vector3::new(-ry, rx, 1.0);
            let of_point = Vector2::new(-py, px);
            prop_assert!((by_pose * of_pose + by_point * of_point).length() < 1e-9);
        }
    }
}

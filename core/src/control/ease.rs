//! Easing a robot that turns on the spot away from what it has come too near to.
//!
//! In: the points of the last scan, the motion since. Out: a slow forward speed, negative for back,
//! that makes room; 0 if there is room enough, or if no motion makes any.
//!
//! 1. Points within a margin around the robot's disc push it away from themselves, each by how deep
//!    it lies in that margin.
//! 2. The robot can only follow the component of that push along its heading. Points abeam, or on
//!    both sides, do not move it; as the robot turns on, its heading comes to where they do.
//!
//! Ours: a spring over a dead zone.

use super::strip::TIGHT;
use crate::geom::{Length, Pose2};
use crate::points::Points;

/// Fraction of the missing room that is made up for in a second, 1/s.
const GAIN: f64 = 2.0;
/// Least part of the push that has to be along the heading: the cosine of 70°.
const ALONG: f64 = 0.35;

/// The forward speed (m/s, at most `most`) that takes a disc of `radius` away from points nearer to
/// it than [`TIGHT`].
pub(super) fn ease_off(
    points: &Points,
    robot_at_scan_from_robot: &Pose2,
    radius: f64,
    most: f64,
) -> f64 {
    let robot_from_scan = robot_at_scan_from_robot.inverse();
    let (mut along, mut all, mut deepest) = (0.0, 0.0, 0.0_f64);
    for beam in points.hits() {
        let point = robot_from_scan * beam.end_in_robot;
        let distance = point.coords.length();
        let depth = radius + TIGHT - distance;
        if depth > 0.0 {
            along -= depth * point.x / distance.max(1e-9);
            all += depth;
            deepest = deepest.max(depth);
        }
    }
    if along.abs() <= ALONG * all {
        return 0.0;
    }
    (GAIN * deepest).min(most).copysign(along)
}

#[cfg(test)]
mod tests {
    use nalgebra::Point2;

    use super::*;
    use crate::points::fixture::scan_of_hits;

    const RADIUS: f64 = 0.3;

    /// The speed caused by points at angles (degrees) and distances from the disc, m.
    fn eased(at: &[(f64, f64)], moved: Pose2) -> f64 {
        let points = scan_of_hits(at.iter().map(|(degrees, room)| {
            let (sin, cos) = crate::geom::sin_cos(degrees.to_radians());
            Point2::new(cos, sin) * (RADIUS + room)
        }));
        ease_off(&points, &moved, RADIUS, 0.05)
    }

    #[test]
    fn it_goes_away_from_what_is_too_near_and_only_then() {
        let here = Pose2::identity();
        for (at, expect) in [
            (&[(0.0, 0.015)][..], -0.01),
            (&[(180.0, 0.015)], 0.01),
            (&[(50.0, 0.01)], -0.02),
            (&[(-50.0, -0.02)], -0.05),
            (&[(80.0, 0.01)], 0.0),
            (&[(10.0, 0.03)], 0.0),
            (&[(0.0, 0.01), (180.0, 0.01)], 0.0),
            (&[(60.0, 0.01), (-120.0, 0.01)], 0.0),
            (&[], 0.0),
        ] {
            let speed = eased(at, here);
            assert!((speed - expect).abs() < 1e-9, "{at:?}: {speed}");
        }
    }

    #[test]
    fn what_the_robot_turned_since_the_scan_counts() {
        let half_round = Pose2::new(0.0, 0.0, std::f64::consts::PI);
        assert!(eased(&[(0.0, 0.01)], half_round) > 0.0);
        let back = Pose2::new(-0.02, 0.0, 0.0);
        assert_eq!(eased(&[(0.0, 0.01)], back), 0.0);
    }
}

//! Tracks compared with the arc of constant speeds, covariances with numeric propagation.

use nalgebra::Vector3;

use super::*;
use crate::geom::Length;

#[test]
fn opposite_tracks_turn_on_the_spot_and_equal_ones_go_straight() {
    let turn = Tracks {
        left: -0.1,
        right: 0.1,
    }
    .motion(0.2);
    assert!(turn.position().coords.length() < 1e-12 && (turn.heading() - 1.0).abs() < 1e-12);
    let straight = Tracks {
        left: 0.5,
        right: 0.5,
    }
    .motion(0.2);
    assert!((straight.x() - 0.5).abs() < 1e-12 && straight.heading().abs() < 1e-12);
}

#[test]
fn midpoint_rule_follows_the_arc_of_constant_speeds_to_third_order() {
    let b = 0.2;
    let difference = |scale: f64| {
        let (left, right) = (0.06 * scale, 0.1 * scale);
        // The arc, integrated in a hundred thousand pieces: their error is 1e-10 of one.
        let n = 100_000;
        let (advance, turn) = (
            0.5 * (left + right) / f64::from(n),
            (right - left) / b / f64::from(n),
        );
        let (mut x, mut y) = (0.0, 0.0);
        for i in 0..n {
            let (sin, cos) = sin_cos((f64::from(i) + 0.5) * turn);
            (x, y) = (x + advance * cos, y + advance * sin);
        }
        let midpoint = Tracks { left, right }.motion(b);
        libm::hypot(midpoint.x() - x, midpoint.y() - y)
    };
    // Half the step, an eighth of the difference; its size is Δs Δθ²/24.
    for scale in [1.0, 0.5] {
        let ratio = difference(scale) / difference(0.5 * scale);
        assert!((ratio - 8.0).abs() < 0.05, "{ratio}");
    }
    let (advance, turn) = (0.08, 0.2);
    assert!((difference(1.0) / (advance * turn * turn / 24.0) - 1.0).abs() < 0.01);
}

#[test]
fn covariance_matches_numeric_propagation() {
    let (b, noise) = (
        0.2,
        OdometryNoise {
            per_metre: 1e-3,
            lateral_per_metre: 0.0,
            heading_per_radian: 0.0,
        },
    );
    for (left, right) in [(0.4, 0.5), (0.5, 0.4), (-0.3, -0.2), (0.2, -0.2)] {
        let h = 1e-6;
        let column = |dl: f64, dr: f64| {
            let plus = Tracks {
                left: left + dl,
                right: right + dr,
            }
            .motion(b);
            let minus = Tracks {
                left: left - dl,
                right: right - dr,
            }
            .motion(b);
            Vector3::new(
                plus.x() - minus.x(),
                plus.y() - minus.y(),
                plus.heading() - minus.heading(),
            ) / (2.0 * h)
        };
        let (jl, jr) = (column(h, 0.0), column(0.0, h));
        let numeric =
            jl * jl.transpose() * (1e-3 * left.abs()) + jr * jr.transpose() * (1e-3 * right.abs());
        let analytic = Tracks { left, right }.covariance(b, &noise);
        assert!((numeric - analytic).length() < 1e-8, "{numeric} {analytic}");
    }
}

#[test]
fn constant_noise_does_not_ask_how_far_the_tracks_ran() {
    let (b, q) = (0.2, 1e-6);
    let noise = TrackNoise::Constant(q);
    let standing = noise.covariance(&Tracks::default(), b);
    // Δs = (R + L)/2 and Δθ = (R - L)/b from two independent errors.
    assert!((standing[(0, 0)] - 0.5 * q).abs() < 1e-18);
    assert!((standing[(2, 2)] - 2.0 * q / (b * b)).abs() < 1e-15);
    let straight = Tracks {
        left: 1.0,
        right: 1.0,
    };
    assert!((noise.covariance(&straight, b)[(2, 2)] - standing[(2, 2)]).abs() < 1e-18);
    let model = RobotModel::rp6();
    let proportional = TrackNoise::Proportional(model.odometry_noise);
    assert_eq!(
        proportional.covariance(&straight, b),
        straight.covariance(b, &model.odometry_noise)
    );
}

#[test]
fn composed_covariance_matches_numeric_propagation() {
    let step = |x, y, t, s: f64| Odometry {
        from: Stamp(0),
        to: Stamp(1),
        motion: Pose2::new(x, y, t),
        cov: Matrix3::from_diagonal(&Vector3::new(s, 2.0 * s, 3.0 * s)),
    };
    let (a, b) = (step(1.0, 0.2, 0.7, 1e-4), step(0.5, -0.3, -0.4, 2e-4));
    let h = 1e-6;
    let mut numeric = Matrix3::zeros();
    for (first, cov) in [(true, a.cov), (false, b.cov)] {
        let mut jacobian = Matrix3::zeros();
        for axis in 0..3 {
            let nudged = |h: f64| {
                let mut d = Vector3::zeros();
                d[axis] = h;
                let nudge = |o: &Odometry| {
                    Pose2::new(
                        o.motion.x() + d[0],
                        o.motion.y() + d[1],
                        o.motion.heading() + d[2],
                    )
                };
                if first {
                    nudge(&a) * b.motion
                } else {
                    a.motion * nudge(&b)
                }
            };
            let (plus, minus) = (nudged(h), nudged(-h));
            jacobian.set_column(
                axis,
                &(Vector3::new(
                    plus.x() - minus.x(),
                    plus.y() - minus.y(),
                    plus.heading() - minus.heading(),
                ) / (2.0 * h)),
            );
        }
        numeric += jacobian * cov * jacobian.transpose();
    }
    assert!((a.then(&b).cov - numeric).length() < 1e-9);
}

#[test]
fn what_is_no_motion_is_named() {
    let good = Odometry::standing(Stamp(2_000_000));
    assert_eq!(good.validate(), Ok(()));
    let spoilt = |spoil: fn(&mut Odometry)| {
        let mut odometry = good;
        spoil(&mut odometry);
        odometry.validate().unwrap_err().to_string()
    };
    let motion = spoilt(|o| o.motion = Pose2::new(0.0, f64::NAN, 0.0));
    assert!(
        motion.starts_with("odometry from 2.000 s to 2.000 s: the motion is not finite"),
        "{motion}"
    );
    assert!(spoilt(|o| o.motion = Pose2::new(0.0, 0.0, f64::INFINITY)).contains("motion"));
    assert!(spoilt(|o| o.cov[(0, 1)] = f64::INFINITY).contains("covariance"));
    assert!(spoilt(|o| o.cov[(2, 2)] = -1e-9).contains("variance is negative"));
}

#[test]
fn ticks_become_metres() {
    let model = RobotModel::rp6();
    let mut odometry = TrackOdometry::new(&model);
    assert_eq!(
        odometry.update(Stamp(0), [10, 10]).motion,
        Pose2::identity()
    );
    let moved = odometry.update(Stamp(100), [1010, 1010]);
    assert!((moved.motion.x() - 1000.0 * model.metres_per_tick).abs() < 1e-12);
    assert!(moved.cov[(0, 0)] > 0.0);
}

//! The chassis against closed forms, against points of a rigid body, and against itself without one wheel.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

use nalgebra::Vector2;
use proptest::prelude::*;

use super::*;
use crate::robot::Tracks;

const RADIUS: f64 = 0.03;

/// A wheel whose rolling direction is `heading` in the robot frame, at (x, y): α + β = heading + π/2.
fn wheel_at(x: f64, y: f64, heading: f64, kind: WheelKind) -> Wheel {
    let bearing = libm::atan2(y, x);
    Wheel {
        distance: libm::hypot(x, y),
        bearing,
        orientation: heading + FRAC_PI_2 - bearing,
        radius: RADIUS,
        kind,
    }
}

fn twist(forward: f64, left: f64, turn: f64) -> Twist {
    Twist {
        forward,
        left,
        turn,
    }
}

fn assert_near(found: &Twist, expect: &Twist) {
    let error = (found.to_vector() - expect.to_vector()).norm();
    assert!(error < 1e-9, "{found:?}, expected {expect:?}");
}

fn skid_steered() -> Chassis {
    let corners = [(0.1, 0.1), (0.1, -0.1), (-0.1, 0.1), (-0.1, -0.1)];
    Chassis::new(
        corners
            .map(|(x, y)| wheel_at(x, y, 0.0, WheelKind::Fixed))
            .to_vec(),
    )
    .unwrap()
}

fn mecanum() -> Chassis {
    let corners = [
        (0.2, 0.15, -FRAC_PI_4),
        (0.2, -0.15, FRAC_PI_4),
        (-0.2, 0.15, FRAC_PI_4),
        (-0.2, -0.15, -FRAC_PI_4),
    ];
    let wheels = corners.map(|(x, y, rollers)| wheel_at(x, y, 0.0, WheelKind::Swedish { rollers }));
    Chassis::new(wheels.to_vec()).unwrap()
}

proptest! {
    #[test]
    fn differential_drive_has_the_closed_form(left in -9.0..9.0_f64, right in -9.0..9.0_f64, width in 0.05..1.0_f64) {
        let chassis = Chassis::differential(width, RADIUS).unwrap();
        let motion = chassis.motion(&[left, right]).unwrap();
        assert_near(&motion.twist, &twist(0.5 * RADIUS * (left + right), 0.0, RADIUS * (right - left) / width));
        prop_assert!(motion.residual < 1e-12);
        let back = chassis.wheel_motions(&motion.twist);
        prop_assert!((back[0].speed - left).abs() < 1e-9 && (back[1].speed - right).abs() < 1e-9);
        prop_assert!(back.iter().all(|wheel| wheel.skid.abs() < 1e-12));
    }

    #[test]
    fn every_wheel_moves_as_its_point_of_the_body_does(
        x in -1.0..1.0_f64, y in -1.0..1.0_f64, heading in -3.0..3.0_f64, v in -1.0..1.0_f64, u in -1.0..1.0_f64, w in -2.0..2.0_f64,
    ) {
        let chassis = Chassis::new(vec![wheel_at(x, y, heading, WheelKind::Steered)]).unwrap();
        let found = chassis.wheel_motions(&twist(v, u, w))[0];
        // The point's velocity v + ω × p, along the wheel and across it.
        let velocity = Vector2::new(v - w * y, u + w * x);
        let along = Vector2::new(libm::cos(heading), libm::sin(heading));
        prop_assert!((found.speed * RADIUS - velocity.dot(&along)).abs() < 1e-9);
prop_assert!((found.skid - along.perp(&velocity)).abs() < 1e-9);
    }

    #[test]
    fn least_squares_without_a_wheel_is_what_its_contradiction_says(noise in proptest::collection::vec(-1.0..1.0_f64, 4)) {
        // Three omni wheels and a fourth one: any three tell the motion.
        let wheels: Vec<Wheel> = (0..4)
            .map(|i| {
                let bearing = 0.3 + 1.7 * f64::from(i);
                Wheel { distance: 0.2, bearing, orientation: 0.1 * f64::from(i), radius: RADIUS, kind: WheelKind::Swedish { rollers: 0.0 } }
            })
            .collect();
        let motion = Chassis::new(wheels.clone()).unwrap().motion(&noise).unwrap();
        for contradiction in &motion.contradictions {
            let keep = |i: &usize| *i != contradiction.wheel;
            let others: Vec<Wheel> = (0..4).filter(keep).map(|i| wheels[i]).collect();
            let speeds: Vec<f64> = (0..4).filter(keep).map(|i| noise[i]).collect();
            let without = Chassis::new(others).unwrap().motion(&speeds).unwrap();
            let said = RADIUS * noise[contradiction.wheel];
            let by_others = (wheels[contradiction.wheel].rolling() * without.twist.to_vector()).x;
            prop_assert!((contradiction.by - (said - by_others)).abs() < 1e-9);
        }
        prop_assert_eq!(motion.contradictions.len(), 4);
    }

    #[test]
    fn mecanum_goes_any_way(v in -1.0..1.0_f64, u in -1.0..1.0_f64, w in -2.0..2.0_f64) {
        let chassis = mecanum();
        let speeds: Vec<f64> = chassis.wheel_motions(&twist(v, u, w)).iter().map(|wheel| wheel.speed).collect();
        let motion = chassis.motion(&speeds).unwrap();
        assert_near(&motion.twist, &twist(v, u, w));
        prop_assert!(motion.residual < 1e-9);
        // The textbook's form: (v ∓ u ∓ (a + b) w) / r.
        let arm = 0.35 * w;
        for (found, expect) in speeds.iter().zip([v - u - arm, v + u + arm, v + u - arm, v - u + arm]) {
            prop_assert!((found * RADIUS - expect).abs() < 1e-9, "{speeds:?}");
        }
    }
}

#[test]
fn mobility_and_rank_are_those_of_the_textbook() {
    let check = |chassis: &Chassis, rank: usize, mobility: usize| {
        assert_eq!((chassis.rank(), chassis.mobility()), (rank, mobility));
    };
    check(&Chassis::differential(0.2, RADIUS).unwrap(), 3, 2);
    check(&mecanum(), 3, 3);
    // Four wheels that cannot slide do not let a body turn: skid steering lives by slip.
    check(&skid_steered(), 3, 1);
    // A bicycle with its wheel turned: only about the point where the axles meet.
    let bicycle = |steered: f64| {
        let rear = wheel_at(0.0, 0.0, 0.0, WheelKind::Fixed);
        Chassis::new(vec![rear, wheel_at(1.0, 0.0, steered, WheelKind::Steered)]).unwrap()
    };
    check(&bicycle(0.5), 3, 1);
    // A caster holds nobody back.
    let mut wheels = Chassis::differential(0.2, RADIUS)
        .unwrap()
        .wheels()
        .to_vec();
    wheels.push(wheel_at(-0.1, 0.0, 0.4, WheelKind::Caster { offset: 0.03 }));
    check(&Chassis::new(wheels).unwrap(), 3, 2);
}

#[test]
fn bicycle_turns_about_the_point_where_its_axles_meet() {
    let steered = 0.5;
    let rear = wheel_at(0.0, 0.0, 0.0, WheelKind::Fixed);
    let front = wheel_at(1.0, 0.0, steered, WheelKind::Steered);
    let chassis = Chassis::new(vec![rear, front]).unwrap();
    // Rear wheel at v: ω = v tan δ / L, front wheel at v / cos δ.
    let v = 0.4;
    let speeds = [v / RADIUS, v / (RADIUS * libm::cos(steered))];
    let motion = chassis.motion(&speeds).unwrap();
    assert_near(&motion.twist, &twist(v, 0.0, v * libm::tan(steered)));
    assert!(motion.residual < 1e-12);
}

#[test]
fn the_wheel_that_contradicts_is_named_with_what_it_is_off_by() {
    let chassis = mecanum();
    let mut speeds: Vec<f64> = chassis
        .wheel_motions(&twist(0.3, 0.0, 0.2))
        .iter()
        .map(|w| w.speed)
        .collect();
    // One wheel of four alone cannot be told: all four share the one redundancy alike.
    speeds[2] += 1.0;
    let motion = chassis.motion(&speeds).unwrap();
    assert_eq!(motion.contradictions.len(), 4);
    // A fifth and a sixth wheel make it clear.
    let mut wheels = chassis.wheels().to_vec();
    wheels.push(wheel_at(
        0.25,
        0.0,
        0.0,
        WheelKind::Swedish { rollers: 0.0 },
    ));
    wheels.push(wheel_at(
        0.0,
        0.25,
        FRAC_PI_2,
        WheelKind::Swedish { rollers: 0.0 },
    ));
    let six = Chassis::new(wheels).unwrap();
    let mut speeds: Vec<f64> = six
        .wheel_motions(&twist(0.3, 0.1, 0.2))
        .iter()
        .map(|w| w.speed)
        .collect();
    speeds[2] += 1.0;
    let worst = six.motion(&speeds).unwrap().contradictions[0];
    assert_eq!((worst.wheel, worst.constraint), (2, Constraint::Rolling));
    let rim = RADIUS * libm::cos(FRAC_PI_4);
    assert!(
        (worst.by - rim).abs() < 1e-9,
        "off by {}, was {rim}",
        worst.by
    );
}

#[test]
fn skid_steering_contradicts_itself_in_a_turn_and_not_straight_on() {
    let chassis = skid_steered();
    assert!(chassis.motion(&[2.0; 4]).unwrap().residual < 1e-12);
    let motion = chassis.motion(&[-2.0, 2.0, -2.0, 2.0]).unwrap();
    assert!(motion.residual > 0.01 && motion.twist.turn > 0.0);
    // Slip makes it turn slower than the wheels say.
    assert!(motion.twist.turn < 2.0 * RADIUS * 2.0 / 0.2);
}

#[test]
fn source_has_the_second_wheel_turned_round() {
    // TDK 2016 §2.1 gives β = 0 to both wheels: then equal speeds turn on the spot. The erratum's β = π goes straight.
    let mut wheels = Chassis::differential(0.2, RADIUS)
        .unwrap()
        .wheels()
        .to_vec();
    wheels[1].orientation = 0.0;
    let printed = Chassis::new(wheels).unwrap().motion(&[1.0, 1.0]).unwrap();
    assert_near(&printed.twist, &twist(0.0, 0.0, -2.0 * RADIUS / 0.2));
    let corrected = Chassis::differential(0.2, RADIUS)
        .unwrap()
        .motion(&[1.0, 1.0])
        .unwrap();
    assert_near(&corrected.twist, &twist(RADIUS, 0.0, 0.0));
}

#[test]
fn caster_turns_until_it_trails() {
    // Driving straight on with the wheel trailing behind its joint nothing turns; off that way it swings at v sin / d.
    let offset = 0.03;
    for angle in [0.0, 0.3, -0.7] {
        let chassis = Chassis::new(vec![wheel_at(
            -0.1,
            0.0,
            angle,
            WheelKind::Caster { offset },
        )])
        .unwrap();
        let found = chassis.wheel_motions(&twist(0.2, 0.0, 0.0))[0];
        let expect = 0.2 * libm::sin(angle) / offset;
        assert!(
            (found.steering - expect).abs() < 1e-9 && found.skid == 0.0,
            "{found:?}, {expect}"
        );
    }
}

#[test]
fn tracks_of_a_step_are_the_twist_times_its_time() {
    let model = RobotModel::rp6();
    let chassis = Chassis::of(&model).unwrap();
    let motion = chassis.motion(&[3.0, 5.0]).unwrap();
    let (dt, radius) = (1e-4, model.drive.metres_per_radian);
    let tracks = Tracks {
        left: 3.0 * radius * dt,
        right: 5.0 * radius * dt,
    };
    let pose = tracks.exact_arc(model.track_width);
    assert!((pose.x() / dt - motion.twist.forward).abs() < 1e-6);
    assert!((pose.heading() / dt - motion.twist.turn).abs() < 1e-6);
}

#[test]
fn what_cannot_be_is_refused_by_name() {
    let message = |result: Result<Chassis, ChassisError>| result.unwrap_err().to_string();
    assert_eq!(Chassis::new(vec![]), Err(ChassisError::NoWheels));
    assert!(message(Chassis::differential(0.2, 0.0)).starts_with("wheel 0: radius is 0"));
    assert!(message(Chassis::differential(f64::NAN, 0.1)).starts_with("wheel 0: distance is NaN"));
    let wheel = |kind| Chassis::new(vec![wheel_at(0.1, 0.0, 0.0, kind)]);
    assert!(message(wheel(WheelKind::Caster { offset: 0.0 })).starts_with("wheel 0: offset is 0"));
    assert!(
        message(wheel(WheelKind::Swedish { rollers: PI / 2.0 }))
            .starts_with("wheel 0: rollers is 1.57")
    );
    let one = wheel(WheelKind::Fixed).unwrap();
    let open = one.motion(&[1.0]).unwrap_err();
    assert!(
        matches!(open, ChassisError::Underdetermined { rank: 2, .. }),
        "{open}"
    );
    assert!(
        one.motion(&[1.0, 2.0])
            .unwrap_err()
            .to_string()
            .contains("2 wheel speeds for 1 wheels")
    );
    let two = Chassis::differential(0.2, RADIUS).unwrap();
    assert!(
        two.motion(&[1.0, f64::NAN])
            .unwrap_err()
            .to_string()
            .starts_with("wheel 1: speed is NaN")
    );
}

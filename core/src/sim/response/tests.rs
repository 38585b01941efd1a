//! The controller on motors that differ from its model, compared with its requirements.

use super::*;

/// How far the right motor's magnets differ from the controller's model, as parts.
const MISMATCHES: [f64; 3] = [0.0, 0.3, -0.3];

fn trial(robot: &RobotModel, forward: f64, mismatch: f64) -> Trial {
    let mut trial = Trial::straight(robot, forward, 6.0);
    trial.motors.right = robot.drive.right.with_stronger_magnet(mismatch);
    trial
}

fn closed(trial: &Trial) -> Vec<ResponseSample> {
    trial.run(Loop::Closed).unwrap()
}

/// Mean speeds of both tracks over the last second, to average out the steps of the counts.
fn final_speeds(samples: &[ResponseSample]) -> [f64; 2] {
    let [begin, end] = [&samples[samples.len() - 1001], &samples[samples.len() - 1]];
    [0, 1].map(|side: usize| (end.ways[side] - begin.ways[side]) / (end.seconds - begin.seconds))
}

/// No lasting error: speeds to a thousandth, heading to a third of what one count of one track
/// makes.
fn assert_settled(trial: &Trial, samples: &[ResponseSample]) {
    let wished = samples[samples.len() - 1].wished;
    for (found, wished) in final_speeds(samples).iter().zip(wished) {
        assert!(
            (found - wished).abs() < 1e-3 * wished.abs().max(0.1),
            "{found}, wished {wished}"
        );
    }
    let last = &samples[samples.len() - 1000..];
    let mean = last.iter().map(|s| s.heading_error).sum::<f64>() / 1000.0;
    let count = trial.robot.metres_per_tick / trial.robot.track_width;
    assert!(
        mean.abs() < count / 3.0,
        "heading error {mean}, a count is {count}"
    );
}

fn fastest(samples: &[ResponseSample]) -> f64 {
    let speeds = samples.iter().flat_map(|s| s.speeds);
    speeds.map(f64::abs).fold(0.0, f64::max)
}

fn most_volts(samples: &[ResponseSample]) -> f64 {
    let volts = samples.iter().flat_map(|s| s.voltages);
    volts.map(f64::abs).fold(0.0, f64::max)
}

#[test]
fn steps_and_ramps_end_without_error_and_without_overshoot_on_any_motors() {
    for robot in [RobotModel::rp6(), RobotModel::pioneer()] {
        for part in [0.9, -0.5, 0.2] {
            for mismatch in MISMATCHES {
                for ramp in [1.0, f64::INFINITY] {
                    let forward = part * robot.max_speed;
                    let trial = Trial {
                        ramp,
                        ..trial(&robot, forward, mismatch)
                    };
                    let samples = closed(&trial);
                    assert_settled(&trial, &samples);
                    let over = fastest(&samples) / forward.abs() - 1.0;
                    // A slow step, which no command makes: the motor is faster than assumed by as
                    // much as its magnet is weaker, until a few counts have shown it; at this speed
                    // a count takes 8 ms.
                    let is_slow_step = part < 0.5 && ramp.is_infinite();
                    let most = if is_slow_step { 0.20 } else { 0.10 };
                    assert!(
                        over < most,
                        "{}, {forward} m/s, ramp {ramp}, {mismatch}: {over}",
                        robot.name
                    );
                }
            }
        }
    }
}

#[test]
fn straight_on_stays_straight_where_open_loop_veers_off() {
    let robot = RobotModel::rp6();
    for mismatch in [0.3, -0.3] {
        let trial = Trial {
            seconds: 5.0 / 0.25,
            ..trial(&robot, 0.25, mismatch)
        };
        let worst = closed(&trial)
            .iter()
            .map(|s| s.heading_error.abs())
            .fold(0.0, f64::max);
        assert!(worst.to_degrees() < 0.5, "{}", worst.to_degrees());
        let open = trial.run(Loop::Open).unwrap();
        let veered = open[open.len() - 1].heading_error.to_degrees().abs();
        assert!(veered > 90.0, "{veered}");
    }
}

#[test]
fn open_loop_veers_by_the_closed_form_of_its_motors() {
    let robot = RobotModel::rp6();
    let trial = trial(&robot, 0.2, 0.3);
    let open = trial.run(Loop::Open).unwrap();
    let shaft = 0.2 / robot.drive.metres_per_radian;
    let (_, voltage) = robot
        .drive
        .right
        .to_hold(shaft, 0.0, robot.drive.right.dry_friction);
    // u = (R f / c2 + c1) ω + R dry / c2 for the true motor.
    let motor = trial.motors.right;
    let per_torque = motor.resistance / motor.torque_constant;
    let speed = (voltage - per_torque * motor.dry_friction)
        / (per_torque * motor.friction + motor.speed_constant);
    let expect = speed * robot.drive.metres_per_radian;
    assert!((final_speeds(&open)[1] - expect).abs() < 1e-6);
}

#[test]
fn a_load_step_leaves_no_error_on_either_track() {
    let robot = RobotModel::rp6();
    for (left, right) in [(0.07, 0.0), (0.0, 0.07), (0.05, 0.05), (-0.05, 0.02)] {
        for mismatch in MISMATCHES {
            let mut trial = trial(&robot, 0.2, mismatch);
            trial.loads = vec![LoadStep {
                at: 2.0,
                left,
                right,
            }];
            let samples = closed(&trial);
            assert_settled(&trial, &samples);
            let worst = samples
                .iter()
                .map(|s| s.heading_error.abs())
                .fold(0.0, f64::max);
            assert!(
                worst.to_degrees() < 0.5,
                "{left} {right}: {}",
                worst.to_degrees()
            );
        }
    }
}

#[test]
fn saturated_start_ends_without_error_and_stays_straight() {
    let robot = RobotModel::rp6();
    for mismatch in MISMATCHES {
        let mut trial = trial(&robot, 0.30, mismatch);
        trial.ramp = f64::INFINITY;
        // A brake for a full second keeps both motors at the battery's voltage; then it is
        // released.
        trial.loads = vec![
            LoadStep {
                at: 0.0,
                left: 0.35,
                right: 0.35,
            },
            LoadStep {
                at: 1.0,
                left: 0.0,
                right: 0.0,
            },
        ];
        let samples = closed(&trial);
        let volts = most_volts(&samples);
        assert!((volts - robot.drive.battery).abs() < 1e-12, "{volts}");
        assert_settled(&trial, &samples);
        let over = fastest(&samples) / 0.30 - 1.0;
        assert!(over < 0.10, "{mismatch}: overshoot {over}");
    }
}

#[test]
fn turns_on_the_spot_and_arcs_are_ramps_of_the_difference() {
    let robot = RobotModel::rp6();
    for (forward, turn) in [(0.0, 1.5), (0.0, -0.5), (0.15, 0.8), (0.2, -0.3)] {
        for mismatch in MISMATCHES {
            let mut trial = trial(&robot, forward, mismatch);
            trial.turn = turn;
            let samples = closed(&trial);
            let [left, right] = final_speeds(&samples);
            assert!(
                (0.5 * (left + right) - forward).abs() < 1e-3,
                "{left} {right}"
            );
            assert!(
                ((right - left) / robot.track_width - turn).abs() < 5e-3,
                "{left} {right}"
            );
            let worst = samples
                .iter()
                .map(|s| s.heading_error.abs())
                .fold(0.0, f64::max);
            assert!(
                worst.to_degrees() < 2.0,
                "{forward} {turn} {mismatch}: {}",
                worst.to_degrees()
            );
        }
    }
}

#[test]
fn motors_that_cannot_be_are_refused() {
    let mut bad = trial(&RobotModel::rp6(), 0.2, 0.0);
    bad.motors.left.resistance = 0.0;
    let error = bad.run(Loop::Open).unwrap_err().to_string();
    assert!(error.starts_with("left motor: resistance is 0"), "{error}");
    bad.motors = bad.robot.drive;
    bad.robot.drive.right.torque_constant = 0.0;
    assert!(matches!(
        bad.run(Loop::Closed),
        Err(DesignError::Uncontrollable { .. })
    ));
}

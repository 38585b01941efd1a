//! The simulated drive compared with its commands, and with the limits of its model.

use proptest::prelude::*;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::*;

fn drive(model: &RobotModel, seed: u64) -> Drive {
    Drive::new(model, &mut ChaCha8Rng::seed_from_u64(seed)).unwrap()
}

struct Run {
    /// Distance of both tracks, m.
    way: Tracks,
    seconds: f64,
    /// The farthest that the middle of the tracks got along its path, m.
    furthest: f64,
}

/// Runs until idle.
fn run(drive: &mut Drive) -> Run {
    let (mut way, mut periods, mut furthest) = (Tracks::default(), 0, 0.0_f64);
    while drive.is_busy() || !drive.stands() {
        let step = drive.step(0.0);
        way.left += step.left;
        way.right += step.right;
        furthest = furthest.max((0.5 * (way.left + way.right)).abs());
        periods += 1;
        assert!(periods < 100_000, "never ends: {drive:?}");
    }
    Run {
        way,
        seconds: f64::from(periods) * DRIVE_PERIOD,
        furthest,
    }
}

fn models() -> impl Strategy<Value = RobotModel> {
    prop_oneof![Just(RobotModel::rp6()), Just(RobotModel::pioneer())]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn forward_ends_within_a_few_counts_in_time_and_does_not_overshoot(
        model in models(), metres in -5.0..5.0_f64, seed in 0..1000_u64,
    ) {
        let mut drive = drive(&model, seed);
        drive.command(Command::Forward(metres));
        let Run { way, seconds, furthest } = run(&mut drive);
        let few = 3.0 * model.metres_per_tick;
        prop_assert!((way.left - metres).abs() < few && (way.right - metres).abs() < few, "{way:?}");
        prop_assert!(furthest < metres.abs() + (0.1 * metres.abs()).min(6.0 * model.metres_per_tick).max(few));
        // The time of the ideal trapezoid: s/v + v/a, or 2 √(s/a) if the top speed is never
        // reached.
        let (v, a, s) = (model.max_speed, model.max_acceleration, metres.abs());
        let ideal = if s > v * v / a { s / v + v / a } else { 2.0 * (s / a).sqrt() };
        prop_assert!(seconds >= ideal - 0.1 && seconds < ideal + 0.8, "{seconds} against {ideal}");
    }

    #[test]
    fn turn_ends_within_a_few_counts_on_the_spot(model in models(), angle in -7.0..7.0_f64, seed in 0..1000_u64) {
        let mut drive = drive(&model, seed);
        drive.command(Command::Turn(angle));
        let way = run(&mut drive).way;
        let turned = (way.right - way.left) / model.track_width;
        prop_assert!((turned - angle).abs() < 4.0 * model.metres_per_tick / model.track_width, "{turned}");
        prop_assert!((way.right + way.left).abs() < 6.0 * model.metres_per_tick);
    }

    #[test]
    fn commands_given_on_the_run_still_end(metres in -1.0..1.0_f64, speed in -0.3..0.3_f64, turn in -2.0..2.0_f64) {
        let model = RobotModel::rp6();
        let mut drive = drive(&model, 1);
        drive.command(Command::Velocity { forward: speed, turn });
        for _ in 0..1500 {
            drive.step(0.0);
        }
        drive.command(Command::Forward(metres));
        let way = run(&mut drive).way;
        // The tracks also complete what they lag behind the desired motion.
        prop_assert!((0.5 * (way.left + way.right) - metres).abs() < 0.01, "{way:?}");
    }

    #[test]
    fn no_track_runs_much_faster_than_it_may(forward in -2.0..2.0_f64, turn in -9.0..9.0_f64, seed in 0..1000_u64) {
        let model = RobotModel::rp6();
        let mut drive = drive(&model, seed);
        drive.command(Command::Velocity { forward, turn });
        for _ in 0..2500 {
            let tracks = drive.step(0.0);
            let fastest = tracks.left.abs().max(tracks.right.abs()) / DRIVE_PERIOD;
            prop_assert!(fastest <= 1.1 * model.max_speed, "{fastest}");
        }
    }
}

#[test]
fn figures_that_are_not_finite_stop() {
    let mut drive = drive(&RobotModel::rp6(), 0);
    for command in [
        Command::Forward(f64::NAN),
        Command::Turn(f64::INFINITY),
        Command::Velocity {
            forward: f64::NAN,
            turn: 0.0,
        },
    ] {
        drive.command(Command::Velocity {
            forward: 0.3,
            turn: 0.0,
        });
        for _ in 0..1000 {
            drive.step(0.0);
        }
        assert!(!drive.stands());
        drive.command(command);
        run(&mut drive);
        assert!(drive.stands(), "{command:?}");
    }
}

#[test]
fn velocity_is_held_on_motors_unlike_the_models() {
    for seed in 0..20 {
        let mut drive = drive(&RobotModel::rp6(), seed);
        drive.command(Command::Velocity {
            forward: 0.2,
            turn: 0.5,
        });
        for _ in 0..3000 {
            drive.step(0.0);
        }
        let (mut ahead, mut turned) = (0.0, 0.0);
        for _ in 0..1000 {
            let step = drive.step(0.0);
            ahead += 0.5 * (step.left + step.right);
            turned += (step.right - step.left) / 0.197;
        }
        assert!(
            (ahead - 0.2).abs() < 1e-3 && (turned - 0.5).abs() < 5e-3,
            "{ahead} {turned}"
        );
    }
}

#[test]
fn a_track_that_scrubs_draws_more_current_and_one_that_is_stuck_gives_up() {
    let model = RobotModel::rp6();
    let mut free = drive(&model, 3);
    free.command(Command::Velocity {
        forward: 0.2,
        turn: 0.0,
    });
    let mut scrubbing = free.clone();
    let (mut rises, periods) = ([0.0; 2], 1000);
    for period in 0..4000 {
        free.step(0.0);
        scrubbing.step(model.drive.grip);
        // The steps of the counts make the currents ripple: take the mean of the last second.
        if period >= 4000 - periods {
            for (side, rise) in rises.iter_mut().enumerate() {
                *rise += (scrubbing.currents()[side] - free.currents()[side]) / f64::from(periods);
            }
        }
    }
    // c2 i carries the force times the lever arm; the motors' own constants are within a tenth of
    // the model's.
    let motor = &model.drive.left;
    let more = model.drive.grip * model.drive.metres_per_radian / motor.torque_constant;
    for rise in rises {
        assert!(
            (rise / more - 1.0).abs() < 0.15,
            "{rise} A, expected {more} A"
        );
    }
    let mut weak = model;
    // A brake that no motor overcomes.
    weak.drive.left.dry_friction = 10.0;
    weak.drive.right.dry_friction = 10.0;
    let mut stuck = drive(&weak, 0);
    stuck.command(Command::Forward(1.0));
    let Run { way, seconds, .. } = run(&mut stuck);
    assert!(
        way == Tracks::default() && seconds < 3.0,
        "{way:?} {seconds}"
    );
}

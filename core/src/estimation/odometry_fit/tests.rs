//! Fits drives whose errors are known; the truth must lie within the standard errors as often as
//! these claim.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::robot::{Odometry, Stamp, Tracks};

const TRUE_WEAR: TrackWear = TrackWear {
    left: -0.012,
    right: 0.014,
    track_width: 0.04,
};
const TRUE_NOISE: OdometryNoise = OdometryNoise {
    per_metre: 3e-4,
    lateral_per_metre: 2e-4,
    heading_per_radian: 1.5e-3,
};
/// Of the poses, m and rad.
const POSE_SIGMAS: [f64; 2] = [0.004, 0.002];

/// The sum of six uniform numbers has half a unit of variance: close enough to a Gaussian for a
/// likelihood, without sharing the simulator's code.
fn gaussian(rng: &mut ChaCha8Rng) -> f64 {
    let sum: f64 = (0..12).map(|_| rng.random_range(-0.5..0.5)).sum();
    sum
}

/// Distances of both tracks in each reading, m.
type Plan = Vec<[f64; 2]>;

/// Legs and turns as a person drives them, to both sides.
fn mixed(rng: &mut ChaCha8Rng, manoeuvres: usize) -> Plan {
    let mut plan = vec![];
    for _ in 0..manoeuvres {
        let (left, right) = match rng.random_range(0..4_u8) {
            0 => (0.003, 0.003),
            1 => (0.002, 0.003),
            2 => (-0.002, 0.002),
            _ => (0.002, -0.002),
        };
        plan.extend(std::iter::repeat_n(
            [left, right],
            rng.random_range(30..200),
        ));
    }
    plan
}

/// A robot that errs as in the model of [`OdometryNoise`], seen every twentieth reading.
fn driven(plan: &Plan, rng: &mut ChaCha8Rng) -> (Drive, Vec<Pose2>) {
    let model = RobotModel::rp6();
    let (mut drive, mut poses) = (Drive::default(), vec![]);
    let mut truth = Pose2::new(3.0, -2.0, 1.0);
    for (i, &[left, right]) in plan.iter().enumerate() {
        let counted = Tracks { left, right };
        let grip = |way: f64, g: f64| way + (TRUE_NOISE.per_metre * way.abs()).sqrt() * g;
        let ran = TRUE_WEAR.ran(&Tracks {
            left: grip(left, gaussian(rng)),
            right: grip(right, gaussian(rng)),
        });
        let moved = ran.motion(TRUE_WEAR.width(model.track_width));
        let (advance, turn) = (0.5 * (left + right), (right - left) / model.track_width);
        let sideways = (TRUE_NOISE.lateral_per_metre * advance.abs()).sqrt() * gaussian(rng);
        let heading = (TRUE_NOISE.heading_per_radian * turn.abs()).sqrt() * gaussian(rng);
        truth = truth * moved * Pose2::new(0.0, sideways, heading);
        drive.odometry(&Odometry {
            from: Stamp(10_000 * i as u64),
            to: Stamp(10_000 * (i as u64 + 1)),
            motion: counted.motion(model.track_width),
            cov: counted.covariance(model.track_width, &model.odometry_noise),
        });
        if i % 20 == 0 {
            drive.scan();
            let [position, heading] = POSE_SIGMAS;
            let off = [position, position, heading].map(|sigma| sigma * gaussian(rng));
            poses.push(truth * Pose2::new(off[0], off[1], off[2]));
        }
    }
    (drive, poses)
}

fn fit_of(seed: u64, plan: impl Fn(&mut ChaCha8Rng) -> Plan) -> OdometryFit {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let plan = plan(&mut rng);
    let (drive, poses) = driven(&plan, &mut rng);
    OdometryFit::new(&drive, &poses, &RobotModel::rp6()).unwrap()
}

/// Errors of left, right, width, and of the logarithms of the three coefficients, each divided by
/// its standard error.
fn standardised(fit: &OdometryFit) -> [f64; 6] {
    let [left, right, width] = fit.wear_sigmas();
    let [k, l, h] = fit.noise_log_sigmas;
    let log = |found: f64, truth: f64| libm::log(found / truth);
    [
        (fit.wear.left - TRUE_WEAR.left) / left,
        (fit.wear.right - TRUE_WEAR.right) / right,
        (fit.wear.track_width - TRUE_WEAR.track_width) / width,
        log(fit.noise.per_metre, TRUE_NOISE.per_metre) / k,
        log(fit.noise.lateral_per_metre, TRUE_NOISE.lateral_per_metre) / l,
        log(fit.noise.heading_per_radian, TRUE_NOISE.heading_per_radian) / h,
    ]
}

#[test]
fn the_truth_lies_within_the_standard_errors_as_often_as_these_say() {
    const RUNS: u64 = 80;
    let mut squares = [0.0; 6];
    let mut beyond = 0;
    for seed in 0..RUNS {
        let off = standardised(&fit_of(seed, |rng| mixed(rng, 60)));
        for (sum, z) in squares.iter_mut().zip(off) {
            *sum += z * z;
            beyond += u32::from(z.abs() > 1.96);
        }
    }
    let means = squares.map(|sum| sum / RUNS as f64);
    // The mean of 80 χ² with one degree of freedom: 1 ± 0.158; four of them.
    for (mean, name) in means.iter().zip(["left", "right", "width", "k", "l", "h"]) {
        assert!((0.37..1.63).contains(mean), "{name}: {mean} of {means:?}");
    }
    // One in twenty of 480, 24 ± 4.8, if they were independent.
    assert!(
        (8..=44).contains(&beyond),
        "{beyond} of 480 beyond 1.96: {means:?}"
    );
}

#[test]
fn poses_are_as_uncertain_as_they_were_made_and_the_known_is_offered_as_settings() {
    let fit = fit_of(3, |rng| mixed(rng, 200));
    let [position, heading] = fit.pose_sigmas;
    assert!((position / POSE_SIGMAS[0] - 1.0).abs() < 0.25, "{position}");
    assert!((heading / POSE_SIGMAS[1] - 1.0).abs() < 0.25, "{heading}");
    assert!(fit.left_out <= 1, "{fit:?}");
    let settings = fit.settings();
    let keys: Vec<&str> = settings.iter().map(|(key, _)| *key).collect();
    for key in ["wear.given", "odometry.left", "wear.track", "odometry.turn"] {
        assert!(keys.contains(&key), "{keys:?}");
    }
}

#[test]
fn a_drive_without_turns_does_not_tell_the_width_and_says_so() {
    // Straight on, for 24 m.
    let fit = fit_of(5, |_| vec![[0.003, 0.003]; 8000]);
    let unknown = |name: &str| {
        let found = fit.parameters().into_iter().find(|p| p.name == name);
        found.unwrap().unknown
    };
    assert!(
        unknown("Effective track width").contains("no turns"),
        "{fit:?}"
    );
    assert_eq!(unknown("Right track over left"), "");
    assert!(unknown("Chance of turns").contains("no turns"));
    assert!((fit.wear_sigmas()[2] / PRIOR - 1.0).abs() < 0.05);
    let keys: Vec<&str> = fit.settings().iter().map(|(key, _)| *key).collect();
    assert!(
        !keys.contains(&"odometry.track") && keys.contains(&"odometry.left"),
        "{keys:?}"
    );
}

#[test]
fn turns_on_one_spot_do_not_tell_width_from_tracks() {
    let fit = fit_of(6, |_| vec![[-0.002, 0.002]; 8000]);
    // Tracks that run farther turn as much as tracks that are closer together.
    for parameter in fit.parameters() {
        if parameter.keys.contains(&"odometry.track") || parameter.keys.contains(&"odometry.left") {
            assert!(
                parameter.unknown.contains("hardly any way"),
                "{parameter:?}"
            );
        }
    }
}

#[test]
fn a_push_is_left_out_and_told() {
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    let plan = mixed(&mut rng, 60);
    let (drive, mut poses) = driven(&plan, &mut rng);
    let half = poses.len() / 2;
    for pose in poses.iter_mut().skip(half) {
        *pose = Pose2::new(0.5, 0.2, 0.4) * *pose;
    }
    let fit = OdometryFit::new(&drive, &poses, &RobotModel::rp6()).unwrap();
    assert_eq!(fit.left_out, 1);
    for z in standardised(&fit) {
        assert!(z.abs() < 4.0, "{:?}", standardised(&fit));
    }
}

#[test]
fn too_short_a_drive_is_told_so() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let (drive, poses) = driven(&vec![[0.003, 0.003]; 400], &mut rng);
    let error = OdometryFit::new(&drive, &poses, &RobotModel::rp6()).unwrap_err();
    assert!(
        error.to_string().starts_with("the robot drove 1.2 m"),
        "{error}"
    );
}

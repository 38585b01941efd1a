//! Settings from a fit, applied to a robot and a sensor whose errors are known, and figures in
//! plain text.

use nalgebra::{Matrix2, Matrix3, Vector2};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::estimation::Drive;
use crate::geom::{Length, Pose2};
use crate::points::fixture::normal;
use crate::points::{Growth, SigmaBin, estimate_sigma};
use crate::robot::{Odometry, RobotModel, Scan, Stamp, TrackWear, Tracks};
use crate::settings::{Scope, Settings, Source};
use crate::sim::SensorModel;
use crate::slam::Method;

const WEAR: TrackWear = TrackWear {
    left: -0.012,
    right: 0.014,
    track_width: 0.04,
};

/// What the tracks counted, straight on and in turns to both sides.
fn counted() -> Vec<Tracks> {
    let manoeuvres = [
        (0.003, 0.003),
        (0.002, 0.003),
        (-0.002, 0.002),
        (0.003, 0.003),
        (0.002, -0.002),
    ];
    let one = |&(left, right): &(f64, f64)| std::iter::repeat_n(Tracks { left, right }, 150);
    let round: Vec<Tracks> = manoeuvres.iter().flat_map(one).collect();
    round
        .iter()
        .cycle()
        .take(8 * round.len())
        .copied()
        .collect()
}

fn reading(counted: &Tracks, model: &RobotModel) -> Odometry {
    Odometry {
        from: Stamp(0),
        to: Stamp(10_000),
        motion: counted.motion(model.track_width),
        cov: Matrix3::zeros(),
    }
}

fn fit_of_worn_tracks(model: &RobotModel) -> DriveFit {
    let (mut drive, mut poses, mut truth) = (Drive::default(), vec![], Pose2::identity());
    for (i, counted) in counted().iter().enumerate() {
        truth = truth * WEAR.ran(counted).motion(WEAR.width(model.track_width));
        drive.odometry(&reading(counted, model));
        if i % 20 == 0 {
            drive.scan();
            poses.push(truth);
        }
    }
    DriveFit {
        odometry: OdometryFit::new(&drive, &poses, model),
        ranges: None,
        is_lidar: true,
    }
}

fn settings_of(fit: &DriveFit, model: &RobotModel) -> Settings {
    let mut settings = Settings::of(SensorModel::lidar(), model);
    let scope = Scope {
        source: Source::Simulation,
        method: Method::LineEkf,
    };
    settings.take(&scope, fit.settings()).unwrap();
    settings
}

#[test]
fn settings_of_a_drive_turn_what_was_counted_into_what_was_driven() {
    let model = RobotModel::rp6();
    let settings = settings_of(&fit_of_worn_tracks(&model), &model);
    let fitted = settings.odometry.calibration(&model);
    let mut truth = Pose2::identity();
    let (mut raw, mut corrected) = (truth, truth);
    for counted in counted() {
        let reading = reading(&counted, &model);
        truth = truth * WEAR.ran(&counted).motion(WEAR.width(model.track_width));
        raw = raw * reading.motion;
        corrected = corrected * fitted.corrected(&reading, model.track_width).motion;
    }
    let off = |pose: &Pose2| (pose.position() - truth.position()).length();
    assert!(off(&raw) > 0.3, "{}", off(&raw));
    assert!(off(&corrected) < 0.01, "{}", off(&corrected));
    // The simulated robot becomes the twin of this one.
    assert!(settings.wear.is_given);
    let TrackWear {
        left,
        right,
        track_width,
    } = settings.wear.given;
    for (found, truth) in [
        (left, WEAR.left),
        (right, WEAR.right),
        (track_width, WEAR.track_width),
    ] {
        assert!((found - truth).abs() < 1e-4, "{found}, not {truth}");
    }
}

/// Scans of a sensor that stands, with σ(ρ) = 1 cm + 5 mm/m ρ.
fn standing_scans() -> Vec<Scan> {
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    let range = |beam: usize| 0.5 + 0.04 * beam as f64;
    let mut scan = |number: u64| Scan {
        stamp: Stamp(200_000 * number),
        robot_from_sensor: Pose2::identity(),
        bearings: (0..150).map(|beam| 0.01 * beam as f64).collect(),
        ranges: (0..150)
            .map(|beam| (range(beam) + (0.01 + 0.005 * range(beam)) * normal(&mut rng)) as f32)
            .collect(),
        sigmas: vec![0.03; 150],
        qualities: vec![],
        bearing_sigma: 0.0,
        max_range: 12.0,
        sweep: 0.0,
    };
    (0..200).map(&mut scan).collect()
}

#[test]
fn settings_of_ranges_are_those_of_the_sensor_that_took_them() {
    let model = RobotModel::rp6();
    let fit = DriveFit {
        odometry: Err(OdometryFitError::Poses { poses: 0, scans: 1 }),
        ranges: Some(estimate_sigma(&[&standing_scans()], Growth::Linear)),
        is_lidar: true,
    };
    let settings = settings_of(&fit, &model);
    let used = settings.slam.points.sigma.unwrap();
    let SensorModel::Lidar(lidar) = &settings.sensor else {
        panic!("a lidar stays one");
    };
    for range in [0.5, 3.0, 6.0] {
        let truth = 0.01 + 0.005 * range;
        for found in [used.at(range), lidar.sigma + lidar.sigma_per_metre * range] {
            assert!(
                (found / truth - 1.0).abs() < 0.05,
                "{range} m: {found}, not {truth}"
            );
        }
    }
    assert_eq!(fit.reasons().len(), 1);
}

/// σ(ρ) = a + b ρ or a + b ρ² with σ_a = 0.002 and σ_b = 0.0003, and 0.008 m the least that was
/// measured.
fn ranges(growth: Growth, a: f64, b: f64) -> DriveFit {
    let bin = |sigma| SigmaBin {
        range: 1.0,
        sigma,
        used: 100,
        clipped: 0,
    };
    DriveFit {
        odometry: Err(OdometryFitError::Poses { poses: 0, scans: 1 }),
        ranges: Some(Ok(SigmaFit {
            growth,
            coefficients: Vector2::new(a, b),
            cov: Matrix2::new(4e-6, -1e-7, -1e-7, 9e-8),
            chi_squared: 1.0,
            bins: vec![bin(0.02), bin(0.008), bin(0.03)],
        })),
        is_lidar: true,
    }
}

#[test]
fn a_fit_of_ranges_as_a_table_and_as_settings() {
    let fit = ranges(Growth::Linear, 0.01, 0.004);
    let parameters = fit.parameters();
    let numbers: Vec<_> = parameters.iter().map(|p| (p.value, p.unit)).collect();
    assert_eq!(numbers, [(0.01, "m"), (0.004, "m/m")]);
    for (parameter, sigma) in parameters.iter().zip([0.002, 0.0003]) {
        assert!((parameter.sigma - sigma).abs() < 1e-12, "{parameter:?}");
    }
    let of_points = [("points.sigma", 1.0), ("points.sigma_least", 0.004)];
    let mut all = of_points.to_vec();
    all.extend([("points.sigma_constant", 0.01), ("lidar.sigma", 0.01)]);
    all.extend([
        ("points.sigma_slope", 0.004),
        ("lidar.sigma_per_metre", 0.004),
    ]);
    assert_eq!(fit.settings(), all);
    let square = ranges(Growth::Square, 0.01, 0.004);
    assert_eq!(square.parameters()[1].unit, "m/m²");
    assert_eq!(square.settings()[0], ("points.sigma", 2.0));
}

#[test]
fn what_no_simulated_lidar_does_is_not_told_to_one() {
    let tells_lidar = |fit: &DriveFit| {
        fit.settings()
            .iter()
            .any(|(key, _)| key.starts_with("lidar."))
    };
    assert!(tells_lidar(&ranges(Growth::Linear, 0.01, 0.0)));
    let other = DriveFit {
        is_lidar: false,
        ..ranges(Growth::Linear, 0.01, 0.004)
    };
    for fit in [
        other,
        ranges(Growth::Square, 0.01, 0.004),
        ranges(Growth::Linear, 0.01, -0.001),
        ranges(Growth::Linear, 0.0, 0.004),
    ] {
        assert!(!tells_lidar(&fit) && fit.settings().len() == 4, "{fit:?}");
    }
}

#[test]
fn what_could_not_be_fitted_gives_reasons_and_nothing_else() {
    let mut fit = DriveFit {
        odometry: Err(OdometryFitError::Poses { poses: 0, scans: 1 }),
        ranges: Some(Err(SigmaError::TooFew { bins: 1 })),
        is_lidar: true,
    };
    assert!(fit.parameters().is_empty() && fit.settings().is_empty());
    let reasons = fit.reasons();
    assert!(
        reasons[0].starts_with("Odometry: ") && reasons[1].starts_with("Ranges, "),
        "{reasons:?}"
    );
    fit.ranges = None;
    assert_eq!(fit.reasons().len(), 1);
}

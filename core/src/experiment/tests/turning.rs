//! Estimate and truth are of the same instant, even between two scans of a turning robot; their
//! difference is slip.

use super::super::*;
use crate::geom::wrap;
use crate::robot::{OdometryBias, OdometryNoise, RobotModel, TrackNoise};
use crate::sim::{SensorKind, worlds};

/// Turn rate of the tests, rad/s: in one control period 2.9°, between two scans 11°.
const RATE: f64 = 1.0;

/// For a robot that turns on the spot: the error of the heading, rad, after each period; and the
/// error before each scan, divided by its standard deviation.
fn heading_errors(robot: RobotModel, rate: f64) -> (Vec<f64>, Vec<f64>) {
    let world = worlds::builtin("office").unwrap();
    // What the filter assumes about the odometry is true of the RP6.
    let noise = TrackNoise::Proportional(world.robot.model().odometry_noise);
    let calibration = OdometryCalibration {
        noise: Some(noise),
        ..OdometryCalibration::default()
    };
    let config = ExperimentConfig {
        calibration,
        ..ExperimentConfig::new(world, robot, SensorKind::Lidar.model(), 2)
    };
    let mut run = Experiment::new(config).unwrap();
    let (mut errors, mut ratios, mut last) = (vec![], vec![], None);
    while run.seconds() < 60.0 {
        run.drive(0.0, rate);
        let has_scanned = run.step().unwrap();
        let estimate = run.session().estimate();
        let error = wrap(estimate.pose.heading() - run.truth().heading());
        if run.seconds() < 5.0 {
            continue;
        }
        errors.push(error);
        if has_scanned {
            ratios.extend(last);
        }
        last = Some(error / estimate.cov[(2, 2)].sqrt());
    }
    (errors, ratios)
}

#[test]
fn without_slip_a_turning_robot_knows_its_heading_at_every_instant() {
    let rp6 = worlds::builtin("office").unwrap().robot.model();
    let robot = RobotModel {
        odometry_noise: OdometryNoise {
            per_metre: 0.0,
            lateral_per_metre: 0.0,
            heading_per_radian: 0.0,
        },
        odometry_bias: OdometryBias {
            track_mismatch: 0.0,
            track_width: 0.0,
        },
        ..rp6
    };
    for rate in [RATE, -RATE] {
        let (errors, _) = heading_errors(robot, rate);
        let mean = errors.iter().sum::<f64>() / errors.len() as f64;
        // An estimate that is 1 ms old would be off by as much on average, one that is a period old
        // by fifty times that.
        assert!(mean.abs() < 0.001 * RATE, "{}°", mean.to_degrees());
        let worst = errors.iter().fold(0.0_f64, |worst, e| worst.max(e.abs()));
        assert!(worst < 0.02 * RATE, "{}°", worst.to_degrees());
    }
}

#[test]
fn what_slip_makes_of_the_heading_between_scans_is_what_the_filter_claims() {
    let rp6 = worlds::builtin("office").unwrap().robot.model();
    for rate in [RATE, -RATE] {
        let (errors, ratios) = heading_errors(rp6, rate);
        let n = ratios.len() as f64;
        let mean = ratios.iter().map(|ratio| ratio * ratio).sum::<f64>() / n;
        // Slip after one scan is independent of slip after another: χ² with n degrees of freedom,
        // mean 1, variance 2/n.
        let band = 3.3 * (2.0 / n).sqrt();
        assert!(n > 200.0 && (mean - 1.0).abs() < band, "{mean} of {n}");
        // What the page occasionally shows as 2.2°.
        assert!(
            errors.iter().any(|error| error.abs() > 0.03),
            "it does not slip"
        );
    }
}

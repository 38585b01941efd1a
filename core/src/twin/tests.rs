//! A twin of the simulated robot: with the robot's figures it stays within what random errors
//! allow, with those of the model it diverges.

use super::*;
use crate::estimation::{Drive, OdometryFit};
use crate::geom::Length;
use crate::robot::{Command, RobotModel, Scan, TrackNoise, TrackWear};
use crate::sim::{SensorModel, Simulation, worlds};
use crate::slam::{Method, Slam, SlamConfig};

const WEAR: TrackWear = TrackWear {
    left: -0.02,
    right: 0.02,
    track_width: 0.06,
};

/// Corners of the free part of the arena around its start, world frame minus the start.
const CORNERS: [[f64; 2]; 5] = [[1.7, 0.0], [1.7, -0.3], [0.0, -0.3], [0.0, 1.2], [0.0, 0.0]];

/// Drives towards a corner with the robot's pose known, every second leg backwards; and whether it
/// is reached.
fn towards(corner: usize, at: &Pose2) -> (Command, bool) {
    let [x, y] = CORNERS[corner % CORNERS.len()];
    let way = Point2::new(x, y) - at.position();
    let backwards = corner % 2 == 1;
    let nose = if backwards { std::f64::consts::PI } else { 0.0 };
    let off = wrap(libm::atan2(way.y, way.x) - at.heading() - nose);
    let forward = match off.abs() > 0.3 {
        true => 0.0,
        false if backwards => -0.15,
        false => 0.2,
    };
    let turn = (1.5 * off).clamp(-1.2, 1.2);
    (Command::Velocity { forward, turn }, way.length() < 0.05)
}

/// A robot with this wear, driven about in the arena for `seconds`; each motion, and each scan with
/// the true pose at that time, is passed to `see`.
fn drive(seed: u64, seconds: u32, mut see: impl FnMut(&Odometry, Option<(Scan, Pose2)>)) {
    let world = worlds::builtin("arena").unwrap();
    let start = world.start;
    let mut sim = Simulation::new(world, RobotModel::rp6(), SensorModel::lidar(), seed).unwrap();
    sim.set_wear(WEAR);
    let mut corner = 0;
    for _ in 0..seconds * 50 {
        let truth = start.inverse() * sim.truth();
        let (command, is_there) = towards(corner, &truth);
        corner += usize::from(is_there);
        sim.command(command);
        sim.advance(0.02);
        let odometry = sim.odometry();
        let truth = start.inverse() * sim.truth();
        see(&odometry, sim.take_scan().map(|scan| (scan, truth)));
    }
    assert_eq!(sim.contacts().total(), 0, "the drive must be free of walls");
}

/// Without hits the ranges are not compared.
fn no_points() -> Points {
    let scan = Scan {
        stamp: crate::robot::Stamp(0),
        robot_from_sensor: Pose2::identity(),
        bearings: vec![0.0],
        ranges: vec![f32::INFINITY],
        sigmas: vec![0.01],
        qualities: vec![],
        bearing_sigma: 0.0,
        max_range: 6.0,
        sweep: 0.0,
    };
    Points::from_scan(
        &scan,
        &Pose2::identity(),
        &crate::points::PointConfig::default(),
    )
}

/// Parts of the samples that lie within three standard deviations: position, heading.
fn within(samples: &[TwinSample]) -> [f64; 2] {
    let part = |of: fn(&TwinSample) -> bool| {
        samples.iter().filter(|sample| of(sample)).count() as f64 / samples.len() as f64
    };
    [
        part(|s| s.position <= s.position_sigma3),
        part(|s| s.heading.abs() <= s.heading_sigma3),
    ]
}

#[test]
fn a_twin_with_the_robots_figures_stays_within_chance() {
    let model = RobotModel::rp6();
    let grid = Grid::new(crate::map::GridConfig::default()).unwrap();
    let noise = Some(TrackNoise::Proportional(model.odometry_noise));
    let mut alike = vec![];
    let mut ends = vec![];
    for seed in 0..40 {
        let calibration = OdometryCalibration { wear: WEAR, noise };
        let mut twin = Twin::new(calibration, model.track_width, Pose2::identity());
        drive(seed, 60, |odometry, scan| {
            twin.odometry(odometry);
            if let Some((_, truth)) = scan {
                twin.scan(1.0, &PoseEstimate::exact(truth), &no_points(), &grid);
            }
        });
        ends.extend(
            twin.samples()
                .last()
                .map(|end| 3.0 * end.heading / end.heading_sigma3),
        );
        alike.extend_from_slice(twin.samples());
    }
    let [position, heading] = within(&alike);
    assert!(position > 0.95 && heading > 0.95, "{position} {heading}");
    // The mean of 40 χ² values with one degree of freedom: 1 ± 0.22; four of them.
    let square = ends.iter().map(|z: &f64| z * z).sum::<f64>() / ends.len() as f64;
    assert!((0.3..1.9).contains(&square), "{square}");
    assert!(alike.iter().all(|sample| sample.ranges.is_none()));
}

#[test]
fn a_twin_with_other_figures_goes_another_way() {
    let width = RobotModel::rp6().track_width;
    let ahead = Odometry {
        motion: Pose2::new(1.0, 0.0, 0.0),
        ..Odometry::standing(crate::robot::Stamp(0))
    };
    let headings = [WEAR, TrackWear::default()].map(|wear| {
        let calibration = OdometryCalibration { wear, noise: None };
        let mut twin = Twin::new(calibration, width, Pose2::identity());
        twin.odometry(&ahead);
        twin.pose().heading()
    });
    // Δθ = (1.02 - 0.98) / (1.06 b): random errors hide that in a short drive, but add up to less
    // in a long one.
    assert!((headings[0] - 0.04 / (1.06 * width)).abs() < 1e-12);
    assert!(headings[1].abs() < 1e-12);
}

#[test]
fn the_simulators_own_wear_is_fitted_from_scan_matching_alone() {
    // The poses are from SLAM, which does not know the truth and was given the same worn odometry.
    let model = RobotModel::rp6();
    let mut slam = Slam::new(Method::ScanMatching, SlamConfig::default()).unwrap();
    let mut counted = Drive::default();
    drive(3, 240, |odometry, scan| {
        counted.odometry(odometry);
        slam.odometry(odometry).unwrap();
        if let Some((scan, _)) = scan {
            slam.scan(&scan).unwrap();
            counted.scan();
        }
    });
    slam.finish();
    let poses: Vec<Pose2> = slam.trajectory().iter().map(|(_, pose)| *pose).collect();
    let fit = OdometryFit::new(&counted, &poses, &model).unwrap();
    let found = [fit.wear.left, fit.wear.right, fit.wear.track_width];
    let truth = [WEAR.left, WEAR.right, WEAR.track_width];
    for ((found, truth), sigma) in found.iter().zip(truth).zip(fit.wear_sigmas()) {
        assert!(
            (found - truth).abs() < 4.0 * sigma && sigma < 0.02,
            "{fit:?}"
        );
    }
}

#[test]
fn ranges_of_a_twin_beside_the_robot_differ_by_half_a_cell_and_of_one_elsewhere_by_where_it_is() {
    let mut slam = Slam::new(Method::ScanMatching, SlamConfig::default()).unwrap();
    let mut off = vec![];
    drive(1, 12, |odometry, scan| {
        slam.odometry(odometry).unwrap();
        if let Some((scan, _)) = scan {
            slam.scan(&scan).unwrap();
            let at = slam.estimate();
            off = [0.0, 0.3]
                .map(|aside| {
                    let begin = at.pose * Pose2::new(aside, 0.0, 0.0);
                    let mut twin = Twin::new(OdometryCalibration::default(), 0.197, begin);
                    twin.scan(1.0, &at, slam.points().unwrap(), slam.grid());
                    twin.samples()[0].ranges.unwrap()
                })
                .to_vec();
        }
    });
    assert!(off[0] < slam.grid().resolution(), "{off:?}");
    assert!(off[1] > 2.0 * off[0] && off[1] < 0.35, "{off:?}");
}

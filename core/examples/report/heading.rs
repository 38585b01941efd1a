//! The lesson of `ekf-consistency`: a filter must not learn what nothing measures.
//!
//! In: a robot that has lost its heading by 3° before it sees the first wall, and then drives in
//! circles and keeps seeing the same six walls, with noise. Out, for both forms of the filter: NEES
//! of heading and pose, and how certain each is of its heading.
//!
//! No sighting says where the map's x axis points: robot and walls may be turned together by any
//! angle. So the heading's standard deviation can never fall below the 3°, which is the independent
//! truth. The textbook's filter takes its Jacobians at ever new estimates. These disagree about
//! which turns are unobservable, and the filter appears to learn the heading.
//!
//! Source: Huang, Mourikis & Roumeliotis (2010), "Observability-based rules for designing
//! consistent EKF SLAM estimators"; Bailey et al. (2006), "Consistency of the EKF-SLAM algorithm":
//! heading uncertainty above 1° to 2° is what breaks it.

use anyhow::Result;
use nalgebra::{Matrix2, Matrix3, Point2, Vector2, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use slamlab_core::estimation::{Consistency, EkfConfig, EkfSlam, OdometryErrors, SweepTiming};
use slamlab_core::features::LineFeature;
use slamlab_core::geom::{Line, Pose2, Segment, wrap};
use slamlab_core::robot::{Odometry, Stamp};

use crate::scenes::sides;
use crate::statistics::normal;

/// Standard deviation of the heading before the first wall is seen, rad.
pub(crate) const LOST: f64 = 3.0 * std::f64::consts::PI / 180.0;
/// σ of a sighting: α, rad, and r where the wall was seen, m.
const ALPHA_SIGMA: f64 = 0.03;
const R_SIGMA: f64 = 0.05;
/// σ of each odometry step: along, across, m, and heading, rad.
const STEP_SIGMAS: [f64; 3] = [0.03, 0.02, 0.03];
/// Each step on the circle, m and rad.
const STEP: (f64, f64) = (0.2, 0.2);

/// Twelve laps.
const SCANS: usize = 400;

/// What one form of the filter believes at the end of a run.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Belief {
    pub(crate) heading_nees: f64,
    pub(crate) pose_nees: f64,
    pub(crate) heading_sigma: f64,
}

/// One run.
pub(crate) fn run(consistency: Consistency, seed: u64) -> Result<Belief> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut slam = EkfSlam::new(EkfConfig {
        consistency,
        alpha_sigma: 0.0,
        r_sigma: 0.0,
        odometry_prior: OdometryErrors::default(),
        ..EkfConfig::default()
    })?;
    let mut truth = Pose2::identity();
    let walls = room();
    for scan in 0..SCANS {
        let ((forward, turn), sigmas) = match scan {
            0 => ((0.0, 0.0), [1e-3, 1e-3, LOST]),
            _ => (STEP, STEP_SIGMAS),
        };
        let motion = Pose2::new(forward, 0.0, turn);
        let e = sigmas.map(|sigma| sigma * normal(&mut rng));
        truth = truth * motion * Pose2::new(e[0], e[1], e[2]);
        slam.predict(&Odometry {
            motion,
            cov: Matrix3::from_diagonal(&Vector3::from(sigmas.map(|s| s * s))),
            ..Odometry::standing(Stamp(scan as u64))
        })?;
        let robot_from_map: Pose2 = truth.inverse();
        let sightings = walls
            .iter()
            .filter_map(|w| sighting(&robot_from_map, w, &mut rng));
        let seen: Vec<_> = sightings.collect();
        slam.update(&seen, &SweepTiming::at_once(Stamp(scan as u64)))?;
    }
    let estimate = slam.estimate();
    let off = wrap(estimate.pose.heading() - truth.heading());
    Ok(Belief {
        heading_nees: off * off / estimate.cov[(2, 2)],
        pose_nees: estimate.nees(&truth).unwrap_or(f64::NAN),
        heading_sigma: estimate.cov[(2, 2)].sqrt(),
    })
}

/// A room of six walls, no two parallel, around the circle, which the robot drives to its left.
fn room() -> Vec<Segment> {
    #[rustfmt::skip]
    let corners = [(-4.0, -2.0), (1.0, -3.0), (5.0, 0.0), (4.0, 5.0), (-1.0, 6.0), (-5.0, 3.0)];
    sides(&corners.map(|(x, y)| Point2::new(x, y))).collect()
}

fn sighting(robot_from_map: &Pose2, wall: &Segment, rng: &mut ChaCha8Rng) -> Option<LineFeature> {
    let ends = [*robot_from_map * wall.a, *robot_from_map * wall.b];
    let line = Line::through(ends[0], ends[1])?;
    // The errors of direction and distance are independent in the middle of the wall.
    let along = Vector2::new(-line.normal().y, line.normal().x);
    let lever = along.dot(&nalgebra::center(&ends[0], &ends[1]).coords);
    let e = [ALPHA_SIGMA * normal(rng), R_SIGMA * normal(rng)];
    let (a, r) = (ALPHA_SIGMA * ALPHA_SIGMA, R_SIGMA * R_SIGMA);
    let line = Line::new(line.alpha() + e[0], line.r() + e[1] + lever * e[0]);
    Some(LineFeature {
        line,
        cov: Matrix2::new(a, lever * a, lever * a, r + lever * lever * a),
        ends: ends.map(|end| line.project(end)),
        seen_from_origin_side: true,
        first_beam: 0,
        last_beam: 0,
        n_points: 30,
        chi2: 28.0,
        by_heading: [Vector2::zeros(); 2],
    })
}

//! What the tests share, and the tests of the input; the others are grouped by subject.

use nalgebra::{DMatrix, Vector2, Vector3};
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::features::PointKind;
use crate::geom::Line;
use crate::robot::Stamp;

mod association;
mod consistency;
mod dense;
mod innovation;
mod observability;
mod points;
mod run;

pub(super) const ONCE: SweepTiming = SweepTiming {
    lag: 0.0,
    stamp: Stamp(1),
    seconds: 0.0,
    n_beams: 0,
};

pub(super) fn odometry(motion: Pose2, cov: Matrix3<f64>) -> Odometry {
    Odometry {
        from: Stamp(0),
        to: Stamp(1),
        motion,
        cov,
    }
}

pub(super) fn feature(alpha: f64, r: f64) -> LineFeature {
    let line = Line::new(alpha, r);
    let foot = Point2::from(line.normal() * line.r());
    let tangent = Vector2::new(-line.normal().y, line.normal().x);
    LineFeature {
        line,
        cov: Matrix2::new(1e-4, 3e-5, 3e-5, 2e-4),
        ends: [foot - tangent, foot + tangent],
        seen_from_origin_side: true,
        first_beam: 0,
        last_beam: 20,
        n_points: 21,
        chi2: 19.0,
        by_heading: [Vector2::zeros(); 2],
    }
}

pub(super) fn point(position: Point2<f64>, kind: PointKind) -> PointFeature {
    PointFeature {
        position,
        cov: Matrix2::new(3e-4, 1e-4, 1e-4, 2e-4),
        kind,
        confidence: 0.9,
        beams: [40, 50],
    }
}

pub(super) fn dense(slam: &EkfSlam) -> DMatrix<f64> {
    let p = &slam.cov;
    DMatrix::from_fn(p.n(), p.n(), |i, j| p.get(i, j))
}

pub(super) fn plain() -> EkfConfig {
    EkfConfig {
        consistency: Consistency::Plain,
        alpha_sigma: 0.0,
        r_sigma: 0.0,
        odometry_prior: OdometryErrors::default(),
        ..EkfConfig::default()
    }
}

/// A filter that has moved and seen three walls.
pub(super) fn some_state() -> EkfSlam {
    let mut slam = EkfSlam::new(EkfConfig {
        odometry_prior: EkfConfig::default().odometry_prior,
        ..plain()
    })
    .unwrap();
    let noise = Matrix3::from_diagonal(&Vector3::new(4e-3, 2e-3, 1e-3));
    slam.predict(&odometry(Pose2::new(1.0, 0.3, 0.4), noise))
        .unwrap();
    slam.update(
        &[feature(0.2, 2.0), feature(1.8, 1.0), feature(-2.0, 3.0)],
        &ONCE,
    )
    .unwrap();
    slam.advance(&odometry(Pose2::new(0.5, -0.1, -0.3), noise));
    assert_eq!(slam.landmarks().count(), 3);
    slam
}

#[test]
fn bad_input_is_named_and_changes_nothing() {
    let mut slam = some_state();
    let before = (
        slam.pose,
        slam.landmarks.clone(),
        dense(&slam),
        slam.scans,
        slam.pending.len(),
    );
    let mut bad_cov = feature(0.2, 2.0);
    bad_cov.cov = Matrix2::new(1.0, 2.0, 2.0, 1.0);
    let mut bad_end = feature(0.2, 2.0);
    bad_end.ends[1].x = f64::NAN;
    for bad in [bad_cov, bad_end, feature(f64::NAN, 1.0)] {
        let error = slam.update(&[feature(0.2, 2.0), bad], &ONCE).unwrap_err();
        assert!(error.to_string().starts_with("feature 1: "), "{error}");
    }
    let nan = odometry(Pose2::new(f64::NAN, 0.0, 0.0), Matrix3::zeros());
    assert!(
        slam.predict(&nan)
            .unwrap_err()
            .to_string()
            .contains("motion is not finite")
    );
    let negative = odometry(Pose2::identity(), Matrix3::identity() * -1.0);
    assert!(slam.predict(&negative).is_err());
    let p = dense(&slam);
    let after = (slam.pose, slam.landmarks, p, slam.scans, slam.pending.len());
    assert_eq!(before, after);
}

#[test]
fn setting_out_of_range_is_named() {
    let fine = EkfConfig::default();
    let mut bad = [fine; 6];
    bad[0].merge.r = f64::NAN;
    bad[1].alpha_sigma = -1.0;
    bad[2].r_sigma = f64::INFINITY;
    bad[3].odometry_prior.curvature = -0.1;
    bad[4].confirm_sightings = 0;
    bad[5].association.gate = -1.0;
    let names = [
        "merge.r is NaN",
        "alpha_sigma is -1",
        "r_sigma is inf",
        "odometry_prior.curvature is -0.1",
        "confirm_sightings is 0",
        "association.gate is -1",
    ];
    for (config, name) in bad.into_iter().zip(names) {
        let error = EkfSlam::new(config).unwrap_err().to_string();
        assert!(error.starts_with(name), "{error}");
    }
}

proptest! {
    #[test]
    fn ids_are_never_given_twice(seed in 0..200_u64) {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut slam = EkfSlam::new(EkfConfig { patience: 1, ..plain() }).unwrap();
        let mut known = vec![];
        for _ in 0..30 {
            let report = slam.update(&[feature(rng.random_range(-3.0..3.0), rng.random_range(0.2..5.0))], &ONCE).unwrap();
            for (_, id) in &report.added {
                prop_assert!(!known.contains(id));
                known.push(*id);
            }
        }
    }
}

//! A line filter with a map of a given number of walls, for everything that measures the cost of an
//! update: the report `ekf-cost`, the bench `ekf_slam`, and the comparison of browser and native
//! program.

use nalgebra::{Matrix2, Matrix3, Point2, Vector2};
use slamlab_core::association::AssociationMethod;
use slamlab_core::estimation::{EkfConfig, EkfError, EkfSlam, SweepTiming};
use slamlab_core::features::LineFeature;
use slamlab_core::geom::{Line, Pose2};
use slamlab_core::robot::{Odometry, Stamp};

const NOW: SweepTiming = SweepTiming {
    stamp: Stamp(0),
    lag: 0.0,
    seconds: 0.0,
    n_beams: 0,
};

/// A filter with `n` landmarks, all confirmed.
pub(crate) fn mapped(n: usize, method: AssociationMethod) -> Result<EkfSlam, EkfError> {
    let mut config = EkfConfig::default();
    config.association.method = method;
    let mut slam = EkfSlam::new(config)?;
    let walls: Vec<_> = (0..n).map(wall).collect();
    // Often enough to be confirmed: a landmark seen once is soon forgotten.
    for _ in 0..4 {
        slam.update(&walls, &NOW)?;
    }
    let confirmed = slam.landmarks().filter(|l| l.is_confirmed).count();
    assert_eq!(confirmed, n, "walls in the map");
    Ok(slam)
}

/// One scan of a standing robot; returns how many of its lines were matched.
pub(crate) fn observe(slam: &mut EkfSlam, seen: &[LineFeature]) -> Result<usize, EkfError> {
    slam.predict(&Odometry {
        motion: Pose2::identity(),
        cov: Matrix3::identity() * 1e-6,
        ..Odometry::standing(Stamp(0))
    })?;
    Ok(slam.update(seen, &NOW)?.matches.len())
}

/// The `i`-th wall of a fan around the robot.
pub(crate) fn wall(i: usize) -> LineFeature {
    let line = Line::new(2.399_963 * i as f64, 1.0 + 0.02 * i as f64);
    let foot = Point2::from(line.normal() * line.r());
    let tangent = Vector2::new(-line.normal().y, line.normal().x);
    LineFeature {
        line,
        cov: Matrix2::new(1e-5, 0.0, 0.0, 1e-5),
        ends: [foot - tangent, foot + tangent],
        seen_from_origin_side: true,
        first_beam: 0,
        last_beam: 0,
        n_points: 20,
        chi2: 18.0,
        by_heading: [Vector2::zeros(); 2],
    }
}

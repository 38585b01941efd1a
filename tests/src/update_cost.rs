//! What an update of the line filter costs, by a clock that is handed in: the same code natively and in the browser.

use nalgebra::{Matrix2, Matrix3, Point2, Vector2};
use slamlab_core::association::AssociationMethod;
use slamlab_core::estimation::{EkfConfig, EkfError, EkfSlam, SweepTiming};
use slamlab_core::features::LineFeature;
use slamlab_core::geom::{Line, Pose2};
use slamlab_core::robot::{Odometry, Stamp};

/// Landmarks in the map.
pub const SIZES: [usize; 3] = [100, 300, 1000];
/// Milliseconds of one measurement, or a little more: less than what a busy system grants at a time, many times the grain of a browser's
/// clock (0.1 ms at most).
const MEASUREMENT_MS: f64 = 3.0;
const MEASUREMENTS: usize = 200;
const NOW: SweepTiming = SweepTiming {
    stamp: Stamp(0),
    lag: 0.0,
    seconds: 0.0,
    n_beams: 0,
};

/// Milliseconds of an update with one match for each of [`SIZES`]: of some measurements the shortest, for what other programs take of
/// the machine only ever adds.
///
/// # Errors    Of the filter.
pub fn update_ms(now_ms: impl Fn() -> f64) -> Result<[f64; SIZES.len()], EkfError> {
    let mut shortest = [f64::INFINITY; SIZES.len()];
    for (shortest, n) in shortest.iter_mut().zip(SIZES) {
        let mut slam = mapped(n)?;
        for _ in 0..MEASUREMENTS {
            let (begin, mut updates) = (now_ms(), 0.0);
            let mut passed = 0.0;
            while passed < MEASUREMENT_MS {
                for _ in 0..(4000 / n).max(1) {
                    update(&mut slam)?;
                    updates += 1.0;
                }
                passed = now_ms() - begin;
            }
            *shortest = shortest.min(passed / updates);
        }
    }
    Ok(shortest)
}

/// A filter that knows `n` walls.
fn mapped(n: usize) -> Result<EkfSlam, EkfError> {
    let mut config = EkfConfig::default();
    config.association.method = AssociationMethod::Nearest;
    let mut slam = EkfSlam::new(config)?;
    let walls: Vec<_> = (0..n).map(wall).collect();
    // Often enough to be confirmed: what was seen once is soon forgotten.
    for _ in 0..4 {
        slam.update(&walls, &NOW)?;
    }
    Ok(slam)
}

fn update(slam: &mut EkfSlam) -> Result<(), EkfError> {
    slam.predict(&Odometry {
        motion: Pose2::identity(),
        cov: Matrix3::identity() * 1e-6,
        ..Odometry::standing(Stamp(0))
    })?;
    let report = slam.update(&[wall(0)], &NOW)?;
    assert_eq!(report.matches.len(), 1, "the wall was not recognised");
    Ok(())
}

/// The `i`-th wall of a fan around the robot.
fn wall(i: usize) -> LineFeature {
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

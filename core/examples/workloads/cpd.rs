//! `cpd`: coherent point drift between clouds of 280, 2 000 and 10 000 points, like the peers'
//! `cpd_*`: `rigid` (and `affine`) in exactly 50 iterations (`fix50`), and until it converges
//! (`conv`). The error is the root mean square distance between the source's points mapped by the
//! found map and by the true one.

use anyhow::{Context, Result};
use nalgebra::{Matrix2, Point2, Vector2};
use slamlab_core::geom::{Length, Pose2};
use slamlab_core::registration::{AffineMap, CpdConfig, CpdKind, drift};

use crate::inputs::Inputs;
use crate::timing::{emit, median_ms};

const SIZES: [usize; 3] = [280, 2_000, 10_000];
const REPEATS: usize = 5;

pub(crate) fn run(inputs: &Inputs) -> Result<()> {
    for count in SIZES {
        for (name, kind) in [("rigid", CpdKind::Rigid), ("affine", CpdKind::Affine)] {
            let [source, target] = clouds(inputs, count, name)?;
            let truth = true_map(kind);
            for (mode, config) in [
                ("fix50", fixed_iterations()),
                ("conv", CpdConfig::default()),
            ] {
                let mut found = None;
                let ms = median_ms(REPEATS, || {
                    found = Some(drift(&source, &target, kind, &config)?);
                    Ok(())
                })?;
                let found = found.context("no run")?;
                let map = found.map.context("no linear map")?;
                let extra = format!(
                    "iters={} map_rms_err={:.5}",
                    found.iterations,
                    map_error(&map, &truth, &source),
                );
                emit("slamlab", &format!("cpd_{name}_{count}_{mode}"), ms, &extra);
            }
        }
    }
    Ok(())
}

/// Fifty iterations, without convergence tests.
fn fixed_iterations() -> CpdConfig {
    CpdConfig {
        max_iterations: 50,
        least_variance: 1e-12,
        still_iterations: usize::MAX,
        ..CpdConfig::default()
    }
}

/// The peers' clouds of `count` points: the source, and the target that the true map made of it.
pub(crate) fn clouds(inputs: &Inputs, count: usize, kind: &str) -> Result<[Vec<Point2<f64>>; 2]> {
    let cloud = |name: String| -> Result<Vec<Point2<f64>>> {
        let rows = inputs.table::<2>(&name)?.into_iter();
        Ok(rows.map(|[x, y]| Point2::new(x, y)).collect())
    };
    let source = cloud(format!("cpd_{count}_source.csv"))?;
    let target = cloud(format!("cpd_{count}_target_{kind}.csv"))?;
    Ok([source, target])
}

/// The map by which the peers made the targets.
pub(crate) fn true_map(kind: CpdKind) -> AffineMap {
    let shift = Vector2::new(0.3, -0.2);
    let linear = match kind {
        CpdKind::Affine => Matrix2::new(1.15, 0.25, -0.10, 0.85),
        CpdKind::Rigid | CpdKind::NonRigid => {
            let (cos, sin) = Pose2::new(0.0, 0.0, 25.0_f64.to_radians()).cos_sin();
            Matrix2::new(cos, -sin, sin, cos)
        }
    };
    AffineMap { linear, shift }
}

/// Root mean square distance between the points mapped by both maps.
pub(crate) fn map_error(found: &AffineMap, truth: &AffineMap, points: &[Point2<f64>]) -> f64 {
    let off =
        |p: &Point2<f64>| (found.linear - truth.linear) * p.coords + found.shift - truth.shift;
    let squares: f64 = points.iter().map(|p| off(p).length().powi(2)).sum();
    (squares / points.len().max(1) as f64).sqrt()
}

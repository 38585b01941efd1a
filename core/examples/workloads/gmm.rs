//! `gmm`: minimises the L2 distance of two Gaussian mixtures, between clouds of 280 and 2 000
//! points, like the peers' `gmml2_rigid_*`.

use anyhow::{Context, Result};
use slamlab_core::geom::Pose2;
use slamlab_core::registration::{CpdKind, GmmConfig, register_mixtures};

use crate::cpd::{clouds, map_error, true_map};
use crate::inputs::Inputs;
use crate::timing::{emit, median_ms};

const SIZES: [usize; 2] = [280, 2_000];
const REPEATS: usize = 5;

pub(crate) fn run(inputs: &Inputs) -> Result<()> {
    for count in SIZES {
        let [source, target] = clouds(inputs, count, "rigid")?;
        let config = GmmConfig::default();
        let mut found = None;
        let ms = median_ms(REPEATS, || {
            let start = Pose2::identity();
            found = register_mixtures(&source, &target, &start, &config);
            Ok(())
        })?;
        let found = found.context("no map")?;
        let error = map_error(&found.map, &true_map(CpdKind::Rigid), &source);
        let extra = format!("iters={} map_rms_err={error:.5}", found.iterations);
        emit("slamlab", &format!("gmml2_rigid_{count}"), ms, &extra);
    }
    Ok(())
}

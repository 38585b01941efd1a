//! In: a seed and a condition. Out: two clouds from a built-in world, and the motion between them.

use anyhow::{Context, Result};
use slamlab_core::geom::Pose2;
use slamlab_core::registration::Cloud;
use slamlab_core::sim::scan_pair::{Buildings, Condition, LEAST_SHARE};

/// Two scans, and the motion between them.
pub(crate) struct Pair {
    pub(crate) moving: Cloud,
    pub(crate) fixed: Cloud,
    pub(crate) start: Pose2,
    pub(crate) truth: Pose2,
}

/// A pair that determines the motion, with "has not moved" as its start.
pub(crate) fn pair(buildings: &Buildings, seed: u64, condition: &Condition) -> Result<Pair> {
    let pair = buildings.pair(seed, condition, |share| share >= LEAST_SHARE);
    let pair = pair.with_context(|| format!("seed {seed}: no such pair"))?;
    Ok(Pair {
        moving: Cloud::scan(pair.moving)?,
        fixed: Cloud::scan(pair.fixed)?,
        start: Pose2::identity(),
        truth: pair.truth,
    })
}

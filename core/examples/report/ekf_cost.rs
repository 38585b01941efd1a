//! `ekf-cost`: what does a line cost the filter, and how does the cost grow with the map?
//!
//! 1. A whole update with one match at 1 000 landmarks, against one pass that reads, changes and
//!    writes as many numbers: the limit that memory sets.
//! 2. A step of ten lines at 100, 200 and 500 landmarks, association included, line by line and
//!    with joint compatibility. The example `workloads` measures such steps against those of the
//!    peers.
//! 3. Allocations in updates that add no landmark, after some warm-up updates: none.
//!
//! Times are the first decile (point 1: the best of 20 of these, in turns), because other programs
//! on the machine only ever add. About 10 s.

use std::hint::black_box;
use std::time::Instant;

use anyhow::Result;
use slamlab_core::association::AssociationMethod;
use stats_alloc::Region;

use crate::Args;
use crate::mapped_filter::{mapped, observe, wall};
use crate::memory::ALLOCATOR;
use crate::outcome::Outcome;
use crate::statistics::quantile;

const STEP_SIZES: [usize; 3] = [100, 200, 500];
const LINES_IN_A_STEP: usize = 10;
const METHODS: [(&str, AssociationMethod); 2] = [
    ("nearest", AssociationMethod::Nearest),
    ("joint", AssociationMethod::Joint),
];

pub(crate) fn measure(_: &Args) -> Result<Outcome> {
    let mut outcome = Outcome::default();
    whole_update(&mut outcome)?;
    steps(&mut outcome)?;
    allocations(&mut outcome)?;
    Ok(outcome)
}

/// Point 1.
fn whole_update(outcome: &mut Outcome) -> Result<()> {
    let mut slam = mapped(1000, AssociationMethod::Nearest)?;
    let seen = [wall(0)];
    let n = 5 + 2 * 1000;
    let mut triangle = vec![1.0_f64; n * (n + 1) / 2];
    let (mut update, mut pass, mut failed) = (f64::INFINITY, f64::INFINITY, false);
    // In turns, so both see the same disturbances of the machine.
    for _ in 0..20 {
        update = update.min(quiet(11, || failed |= observe(&mut slam, &seen).is_err()));
        pass = pass.min(quiet(11, || {
            for value in black_box(&mut triangle) {
                *value -= 1e-9;
            }
        }));
    }
    anyhow::ensure!(!failed, "an update failed");
    outcome.figure("update_of_1000_ms", update * 1e3);
    outcome.figure("streaming_pass_ms", pass * 1e3);
    outcome.at_most("update_of_1000_in_streaming_passes", update / pass, 2.0);
    Ok(())
}

/// Point 2.
fn steps(outcome: &mut Outcome) -> Result<()> {
    for n in STEP_SIZES {
        for (name, method) in METHODS {
            let ms = 1e3 * step_seconds(n, method)?;
            outcome.figure(format!("step_of_10_lines_at_{n}_{name}_ms"), ms);
        }
    }
    Ok(())
}

fn step_seconds(n: usize, method: AssociationMethod) -> Result<f64> {
    let mut slam = mapped(n, method)?;
    let seen: Vec<_> = (0..LINES_IN_A_STEP).map(wall).collect();
    let mut failed = false;
    let seconds = quiet(201, || failed |= observe(&mut slam, &seen).is_err());
    anyhow::ensure!(!failed, "a step failed");
    let matched = slam.report().matches.len();
    anyhow::ensure!(matched == LINES_IN_A_STEP, "{matched} lines matched");
    Ok(seconds)
}

/// Point 3.
fn allocations(outcome: &mut Outcome) -> Result<()> {
    for (name, method) in METHODS {
        let mut slam = mapped(200, method)?;
        let seen: Vec<_> = (0..LINES_IN_A_STEP).map(wall).collect();
        for _ in 0..10 {
            observe(&mut slam, &seen)?;
        }
        let region = Region::new(ALLOCATOR);
        for _ in 0..100 {
            observe(&mut slam, &seen)?;
        }
        let change = region.change();
        let count = (change.allocations + change.reallocations) as f64;
        outcome.at_most(&format!("allocations_in_100_updates_{name}"), count, 0.0);
    }
    Ok(())
}

/// First decile of the seconds that `work` takes: its time when nothing disturbs it.
fn quiet(times: usize, mut work: impl FnMut()) -> f64 {
    work();
    let seconds = (0..times).map(|_| {
        let begin = Instant::now();
        work();
        begin.elapsed().as_secs_f64()
    });
    quantile(seconds, 0.1)
}

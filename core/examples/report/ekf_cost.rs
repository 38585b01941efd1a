//! `ekf-cost`: what does a line cost the filter, and how does that grow with the map?
//!
//! 1. One correction at 100, 300 and 1 000 landmarks, by parts: Z from a 5x5 block, P Hᵀ from five columns, and the pass over the
//!    triangle of P; the exponents of their growth, by a least-squares line through the logarithms.
//! 2. A whole update with one match at 1 000 landmarks against one pass over as many numbers that reads, changes and writes each:
//!    memory gives no more.
//! 3. A step of ten observations at N = 100, 200 and 500 landmarks, association included. The bar is Eigen's rank update of a
//!    triangle; `--bar-ms 100=0.2,200=0.7,500=4` hands in its milliseconds from the same machine, and each step may take
//!    1.2 times as long.
//! 4. Allocations in updates that add no landmark, after some to warm up: none.
//!
//! Points 2 and 3 match line by line, as the bar knows its matches; the time of the step with joint compatibility stands beside it.
//! Allocations are counted with both.
//!
//! Times are the fastest tenth's slowest (point 2: the best of 20 such, by turns): what other programs take of the machine only ever
//! adds. About 10 s.

use std::hint::black_box;
use std::time::Instant;

use anyhow::{Context, Result};
use nalgebra::{Matrix2, Matrix5};
use slamlab_core::association::AssociationMethod;
use slamlab_core::estimation::Covariance;
use stats_alloc::Region;

use crate::Args;
use crate::mapped_filter::{mapped, observe, wall};
use crate::memory::ALLOCATOR;
use crate::outcome::Outcome;
use crate::statistics::{fit_line, quantile};

const SIZES: [usize; 3] = [100, 300, 1000];
const STEP_SIZES: [usize; 3] = [100, 200, 500];
const LINES_IN_A_STEP: usize = 10;

pub(crate) fn measure(args: &Args) -> Result<Outcome> {
    let mut outcome = Outcome::default();
    parts_of_a_correction(&mut outcome);
    whole_update(&mut outcome)?;
    steps(&mut outcome, args.bar_ms.as_deref())?;
    allocations(&mut outcome)?;
    Ok(outcome)
}

/// Point 1.
fn parts_of_a_correction(outcome: &mut Outcome) {
    let mut seconds = [[0.0; SIZES.len()]; 3];
    for (index, n) in SIZES.into_iter().enumerate() {
        let mut p = covariance(n);
        let landmark = 5 + 2 * (n / 2);
        let h = [
            (0, [0.0, -1.0]),
            (1, [0.0, -0.1]),
            (2, [-1.0, 0.0]),
            (landmark, [1.0, 0.3]),
            (landmark + 1, [0.0, 1.0]),
        ];
        seconds[0][index] = quiet(201, || {
            // As often as a clock can tell.
            for _ in 0..100 {
                black_box(innovation(black_box(&p), black_box(&h)));
            }
        }) / 100.0;
        let (mut a, mut b) = (vec![], vec![]);
        seconds[1][index] = quiet(201, || p.product(black_box(&h), &mut a, &mut b));
        for value in a.iter_mut().chain(b.iter_mut()) {
            *value *= 1e-6;
        }
        seconds[2][index] = quiet(if n > 500 { 51 } else { 401 }, || {
            p.subtract(black_box(&a), black_box(&b));
            p.settle();
        });
    }
    let names = ["innovation", "gain", "triangle"];
    for ((name, seconds), most) in names.into_iter().zip(seconds).zip([0.2, 1.4, 2.4]) {
        let micros: Vec<f64> = seconds.iter().map(|s| s * 1e6).collect();
        outcome.figure(format!("{name}_us_at_100_300_1000"), micros);
        outcome.at_most(&format!("{name}_exponent"), exponent(&seconds), most);
    }
}

/// Z: H P Hᵀ from the elements of its five columns.
fn innovation(p: &Covariance, h: &[(usize, [f64; 2])]) -> Matrix2<f64> {
    let mut z = Matrix2::zeros();
    for (i, a) in h {
        for (j, b) in h {
            let p = p.get(*i, *j);
            z += Matrix2::new(a[0] * b[0], a[0] * b[1], a[1] * b[0], a[1] * b[1]) * p;
        }
    }
    z
}

/// Point 2.
fn whole_update(outcome: &mut Outcome) -> Result<()> {
    let mut slam = mapped(1000, AssociationMethod::Nearest)?;
    let seen = [wall(0)];
    let n = 5 + 2 * 1000;
    let mut triangle = vec![1.0_f64; n * (n + 1) / 2];
    let (mut update, mut pass, mut failed) = (f64::INFINITY, f64::INFINITY, false);
    // By turns, so that both meet with what else the machine does.
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

/// Point 3.
fn steps(outcome: &mut Outcome, bars: Option<&str>) -> Result<()> {
    for n in STEP_SIZES {
        let nearest = 1e3 * step_seconds(n, AssociationMethod::Nearest)?;
        let joint = 1e3 * step_seconds(n, AssociationMethod::Joint)?;
        outcome.figure(format!("step_of_10_lines_at_{n}_nearest_ms"), nearest);
        outcome.figure(format!("step_of_10_lines_at_{n}_joint_ms"), joint);
        if let Some(bar) = bar_of(bars, n)? {
            let key = format!("step_of_10_lines_at_{n}_nearest_in_eigen_steps");
            outcome.at_most(&key, nearest / bar, 1.2);
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

/// The bar for `n` landmarks in a list like `100=0.2,200=0.7`.
fn bar_of(bars: Option<&str>, n: usize) -> Result<Option<f64>> {
    for part in bars.into_iter().flat_map(|bars| bars.split(',')) {
        let (size, millis) = part
            .split_once('=')
            .with_context(|| format!("--bar-ms has `{part}`, expected N=MILLISECONDS"))?;
        if size.trim().parse::<usize>()? == n {
            return Ok(Some(millis.trim().parse()?));
        }
    }
    Ok(None)
}

/// Point 4.
fn allocations(outcome: &mut Outcome) -> Result<()> {
    for (name, method) in [
        ("nearest", AssociationMethod::Nearest),
        ("joint", AssociationMethod::Joint),
    ] {
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

/// Some covariance over `n` landmarks.
fn covariance(n: usize) -> Covariance {
    let mut p = Covariance::new(&Matrix5::identity());
    for _ in 0..n {
        let row = |length: usize| {
            let mut row = vec![0.01; length];
            row.push(1.0);
            row
        };
        let states = p.n();
        p.push_pair([row(states), row(states + 1)]);
    }
    p
}

/// Seconds that `work` takes when nothing disturbs it: the first decile.
fn quiet(times: usize, mut work: impl FnMut()) -> f64 {
    work();
    let seconds = (0..times).map(|_| {
        let begin = Instant::now();
        work();
        begin.elapsed().as_secs_f64()
    });
    quantile(seconds, 0.1)
}

/// Slope of the logarithm of the time over that of the size.
fn exponent(seconds: &[f64; SIZES.len()]) -> f64 {
    let sizes = SIZES.iter().map(|n| (*n as f64).ln());
    let logs: Vec<_> = sizes.zip(seconds.map(f64::ln)).collect();
    fit_line(&logs).1
}

//! `gauss-transform`: does the fast Gauss transform keep the requested error bound, and does its
//! time grow with M + N? About 30 s.
//!
//! 1. Error: 2 000 sources with weights of both signs, 1 000 targets, σ from a thousandth of the
//!    extent to ten times it, error bounds from 1e-2 to 1e-10; every algorithm against the direct
//!    sum. The error must never exceed the bound, in units of Σ|q|.
//! 2. Time: M = N from 1 000 to 256 000 points, σ a tenth of the extent, error 1e-6, with the
//!    algorithm that is chosen automatically. The time is fitted by c nᵖ. p must be at most 1.15:
//!    summing over every pair would give 2.

use anyhow::Result;
use nalgebra::Point2;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::json;
use slamlab_core::registration::{TransformMethod, gauss_transform};

use crate::Args;
use crate::clock::least_seconds;
use crate::outcome::Outcome;
use crate::statistics::fit_line;

const SOURCES: usize = 2_000;
const TARGETS: usize = 1_000;
/// Values of σ, as fractions of the extent.
const SIGMAS: [f64; 9] = [0.001, 0.003, 0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0];
const ERRORS: [f64; 5] = [1e-2, 1e-4, 1e-6, 1e-8, 1e-10];
const SIZES: [usize; 5] = [1_000, 4_000, 16_000, 64_000, 256_000];
/// For the timing: σ as a fraction of the extent, and the error bound.
const TIMED: (f64, f64) = (0.1, 1e-6);
const MOST_EXPONENT: f64 = 1.15;
/// Extent of the clouds, m.
const EXTENT: f64 = 10.0;
/// Rounding error, in units of Σ|q|.
const ROUNDING: f64 = 1e-13;

pub(crate) fn measure(_: &Args) -> Result<Outcome> {
    let mut outcome = Outcome::default();
    let (sources, targets) = (cloud(SOURCES, 1), cloud(TARGETS, 2));
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let weights: Vec<[f64; 1]> = (0..SOURCES)
        .map(|_| [rng.random_range(-1.0..1.0)])
        .collect();
    let total: f64 = weights.iter().map(|[weight]| weight.abs()).sum();
    let mut table = vec![];
    for part in SIGMAS {
        let sigma = part * EXTENT;
        let truth: Vec<f64> = targets
            .iter()
            .map(|t| plain(&sources, &weights, t, sigma))
            .collect();
        for asked in ERRORS {
            for (name, way) in TransformMethod::ALL {
                let found = gauss_transform(&sources, &weights, &targets, sigma, asked, Some(way));
                let off = found
                    .iter()
                    .zip(&truth)
                    .map(|([found], truth)| (found - truth).abs());
                let error = off.fold(0.0, f64::max) / total;
                outcome.require(error <= asked + ROUNDING, || {
                    format!("{name}, sigma {part} of the extent: error {error}, asked for {asked}")
                });
                table.push(json!({
                    "method": name, "sigma_in_extents": part, "asked": asked, "error": error,
                }));
            }
        }
    }
    outcome.figure("errors", table);
    let mut times = vec![];
    for size in SIZES {
        let (sources, targets) = (cloud(size, 4), cloud(size, 5));
        let weights = vec![[1.0]; size];
        let (sigma, error) = (TIMED.0 * EXTENT, TIMED.1);
        let seconds = least_seconds(|| {
            std::hint::black_box(gauss_transform(
                &sources, &weights, &targets, sigma, error, None,
            ));
        });
        times.push((size as f64, seconds));
    }
    let logs: Vec<_> = times.iter().map(|(n, t)| (n.ln(), t.ln())).collect();
    let (_, exponent, _) = fit_line(&logs);
    let rows = times
        .iter()
        .map(|(n, t)| json!({"points": n, "ms": 1e3 * t}));
    outcome.figure("times", rows.collect::<Vec<_>>());
    outcome.at_most("time_exponent", exponent, MOST_EXPONENT);
    Ok(outcome)
}

/// The direct sum.
fn plain(sources: &[Point2<f64>], weights: &[[f64; 1]], target: &Point2<f64>, sigma: f64) -> f64 {
    let scale = -0.5 / (sigma * sigma);
    let terms = sources.iter().zip(weights);
    terms
        .map(|(source, [weight])| weight * (scale * (source - target).norm_squared()).exp())
        .sum()
}

fn cloud(count: usize, seed: u64) -> Vec<Point2<f64>> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut number = || rng.random_range(0.0..EXTENT);
    (0..count)
        .map(|_| Point2::new(number(), number()))
        .collect()
}

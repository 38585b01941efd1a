//! `line-fit`: is a fitted line where it says, and as accurate as it says? Under 1 s.
//!
//! The experiment of TDK 2016 §4.1: a wall at α = 135°, r = 1.2388 m, 100 beams with σ = 0.1 m on
//! each range. In: 10 000 seeds. Out: bias of α and r in standard deviations, the observed spread
//! over the stated one, average NEES of (α, r). It holds if both biases are under 0.1 σ and the
//! average NEES lies in the 95 % band of a mean of χ²(2).

use std::f64::consts::FRAC_PI_4;

use anyhow::{Context, Result};
use nalgebra::Vector2;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use slamlab_core::features::fit_line;
use slamlab_core::geom::wrap;
use slamlab_core::points::Beam;

use crate::Args;
use crate::outcome::Outcome;
use crate::scenes::hit;
use crate::statistics::{chi2_mean_band, normal};

const ALPHA: f64 = 3.0 * FRAC_PI_4;
const R: f64 = 1.2388;
const SIGMA: f64 = 0.1;
const BEAMS: u32 = 100;
/// Where the visible part begins and ends along the wall, m.
const SEEN: [f64; 2] = [-1.2, 1.5];

pub(crate) fn measure(args: &Args) -> Result<Outcome> {
    let seeds = args.seeds.unwrap_or(10_000);
    let n = seeds as f64;
    let (mut nees, mut bias, mut stated, mut found) =
        (0.0, Vector2::zeros(), Vector2::zeros(), Vector2::zeros());
    for seed in 0..seeds {
        let fit = fit_line(&wall(seed), 0.0).context("no line")?;
        let error = Vector2::new(wrap(fit.line.alpha() - ALPHA), fit.line.r() - R);
        let sigma = Vector2::new(fit.cov[(0, 0)].sqrt(), fit.cov[(1, 1)].sqrt());
        let factor = fit.cov.cholesky().context("a singular covariance")?;
        nees += error.dot(&factor.solve(&error)) / n;
        bias += error.component_div(&sigma) / n;
        stated += sigma / n;
        found += error.component_mul(&error) / n;
    }
    let mut outcome = Outcome::default();
    outcome.figure("seeds", seeds);
    outcome.figure("alpha_sigma_stated_deg", stated.x.to_degrees());
    outcome.figure("alpha_sigma_found_deg", found.x.sqrt().to_degrees());
    outcome.figure("r_sigma_stated_m", stated.y);
    outcome.figure("r_sigma_found_m", found.y.sqrt());
    outcome.within("alpha_bias_sigmas", bias.x, [-0.1, 0.1]);
    outcome.within("r_bias_sigmas", bias.y, [-0.1, 0.1]);
    outcome.within("anees", nees, chi2_mean_band(2.0, n));
    Ok(outcome)
}

/// One noisy scan of the wall.
fn wall(seed: u64) -> Vec<Beam> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let [first, last] = SEEN.map(|t| libm::atan2(t, R));
    let mut beam = |i| {
        let off_normal = first + (last - first) * f64::from(i) / f64::from(BEAMS - 1);
        let range = R / libm::cos(off_normal) + SIGMA * normal(&mut rng);
        hit(i as usize, ALPHA + off_normal, range, SIGMA)
    };
    (0..BEAMS).map(&mut beam).collect()
}

//! `affine`: is the affine map between two clouds found without a start and without
//! correspondences? Under 10 s.
//!
//! 1. Copies: random clouds of 20 to 500 points, in another order, mapped by random affine maps,
//!    half of which reflect. In: 2 000 pairs (`--seeds`). Every method must put each point within
//!    1e-9 of the cloud's extent of its true place.
//! 2. Disturbances: noise of 1 % and 3 % of the extent, and a second cloud that lacks a tenth or
//!    half of the points at one side. Median error by method, as a fraction of the extent. There is
//!    no requirement: both methods use the cloud as a whole, and missing points change all moments.
//! 3. Time for 500 points, ms.

use anyhow::{Context, Result};
use nalgebra::{Matrix2, Point2, Vector2};
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use slamlab_core::registration::{AffineFit, AffineMap, AffineMethod, register_affine};

use crate::Args;
use crate::clock::cpu_seconds;
use crate::outcome::Outcome;
use crate::statistics::{median, normal};

const PAIRS: u64 = 2000;
/// Number of points in the timed clouds.
const TIMED: usize = 500;
const TIMES: usize = 20;
/// Maximum error of a copy, as a fraction of the extent.
const EXACT: f64 = 1e-9;
/// Maximum time for [`TIMED`] points, ms.
const MOST_MS: f64 = 2.0;
/// Extent of a cloud, m.
const EXTENT: f64 = 8.0;

/// How the second cloud differs from a copy.
struct Spoiled {
    name: &'static str,
    /// Standard deviation, as a fraction of the extent.
    noise: f64,
    /// Fraction of the points that is missing, at one side.
    missing: f64,
}

const SPOILED: [Spoiled; 4] = [
    Spoiled {
        name: "noise_1_percent",
        noise: 0.01,
        missing: 0.0,
    },
    Spoiled {
        name: "noise_3_percent",
        noise: 0.03,
        missing: 0.0,
    },
    Spoiled {
        name: "a_tenth_missing",
        noise: 0.0,
        missing: 0.1,
    },
    Spoiled {
        name: "half_missing",
        noise: 0.0,
        missing: 0.5,
    },
];
const COPY: Spoiled = Spoiled {
    name: "copy",
    noise: 0.0,
    missing: 0.0,
};

pub(crate) fn measure(args: &Args) -> Result<Outcome> {
    let pairs = args.seeds.unwrap_or(PAIRS);
    let mut outcome = Outcome::default();
    outcome.figure("pairs", pairs);
    for (name, method) in AffineMethod::ALL {
        let (mut worst, mut reflected) = (0.0_f64, 0.0);
        for seed in 0..pairs {
            let scene = Scene::of(seed, None, &COPY);
            let fit = scene
                .fit(method)
                .with_context(|| format!("{name}, seed {seed}"))?;
            worst = worst.max(scene.error(&fit.map));
            reflected += f64::from(u8::from(scene.truth.linear.determinant() < 0.0));
        }
        outcome.at_most(&format!("{name}_copy_error_worst"), worst, EXACT);
        outcome.at_least(&format!("{name}_reflected"), reflected, 0.25 * pairs as f64);
        for spoiled in &SPOILED {
            let errors = (0..pairs).filter_map(|seed| {
                let scene = Scene::of(seed, None, spoiled);
                Some(scene.error(&scene.fit(method).ok()?.map))
            });
            let error = median(errors);
            outcome.figure(format!("{name}_{}_error_median", spoiled.name), error);
        }
        let scenes: Vec<_> = (0..TIMES as u64)
            .map(|seed| Scene::of(seed, Some(TIMED), &COPY))
            .collect();
        let times = scenes.iter().filter_map(|scene| {
            let begin = cpu_seconds();
            scene.fit(method).ok()?;
            Some(1e3 * (cpu_seconds() - begin))
        });
        outcome.at_most(&format!("{name}_500_points_ms"), median(times), MOST_MS);
    }
    Ok(outcome)
}

/// Two clouds, and the map between them.
struct Scene {
    from: Vec<Point2<f64>>,
    to: Vec<Point2<f64>>,
    truth: AffineMap,
}

impl Scene {
    fn of(seed: u64, points: Option<usize>, spoiled: &Spoiled) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let count = points.unwrap_or_else(|| rng.random_range(20..=500));
        let number = |rng: &mut ChaCha8Rng, most: f64| rng.random_range(-most..most);
        let half = 0.5 * EXTENT;
        let from: Vec<_> = (0..count)
            .map(|_| Point2::new(number(&mut rng, half), number(&mut rng, half)))
            .collect();
        let truth = loop {
            let [a, b, c, d] = [0; 4].map(|_| number(&mut rng, 2.0));
            let linear = Matrix2::new(a, b, c, d);
            if linear.determinant().abs() > 0.2 {
                let shift = Vector2::new(number(&mut rng, 20.0), number(&mut rng, 20.0));
                break AffineMap { linear, shift };
            }
        };
        let seen_from = EXTENT * (spoiled.missing - 0.5);
        let seen = from.iter().filter(|point| point.x >= seen_from);
        let mut to: Vec<_> = seen
            .map(|point| {
                let sigma = spoiled.noise * EXTENT;
                let noise = sigma * Vector2::new(normal(&mut rng), normal(&mut rng));
                truth.apply(&(point + noise))
            })
            .collect();
        to.shuffle(&mut rng);
        Self { from, to, truth }
    }

    fn fit(&self, method: AffineMethod) -> Result<AffineFit> {
        Ok(register_affine(&self.from, &self.to, method)?)
    }

    /// Root mean square distance of the points from their true places, measured in the first cloud,
    /// as a fraction of its extent.
    fn error(&self, found: &AffineMap) -> f64 {
        let Some(back) = self.truth.linear.try_inverse() else {
            return f64::NAN;
        };
        let off = |point: &Point2<f64>| {
            (back * (found.apply(point) - self.truth.apply(point))).norm_squared()
        };
        let mean = self.from.iter().map(off).sum::<f64>() / self.from.len() as f64;
        mean.sqrt() / EXTENT
    }
}

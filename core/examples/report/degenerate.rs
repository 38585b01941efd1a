//! `degenerate`: does every method report that a corridor says nothing of the position along it,
//! and only there? About 1 min.
//!
//! Pairs of scans up to 0.3 m and 10° apart, σ 1 cm, like those of `registration`; in: 300 of each
//! kind (`--seeds`).
//!
//! 1. `corridor`, where the true walls visible in both scans give next to no information along one
//!    direction (less than a hundredth of their information in all directions). Required of every
//!    method: 95 % are called degenerate, with the axis of the walls to within 10°.
//! 2. `office`, where they give more than a twentieth in every direction. Required: at most 2 % are
//!    called degenerate.

use anyhow::{Context, Result};
use nalgebra::Vector2;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use slamlab_core::geom::{Length, Pose2};
use slamlab_core::registration::{Cloud, CloudMethod, JudgeConfig, Verdict, register_clouds};
use slamlab_core::sim::scan_pair::{Buildings, Condition, Observability};

use crate::Args;
use crate::outcome::Outcome;
use crate::ride::world_named;

const PAIRS: u64 = 300;
const SAYS_NOTHING: f64 = 0.01;
const SAYS_ENOUGH: f64 = 0.05;
const LEAST_TOLD: f64 = 0.95;
const MOST_FALSE: f64 = 0.02;
/// Cosine of the maximum error of the axis.
const AXIS: f64 = 0.985;
/// Maximum distance of scans, as a fraction of that in `registration`: 0.3 m, 10°.
const CLOSER: f64 = 0.3;
const TRIES: usize = 100_000;

struct Pair {
    fixed: Cloud,
    moving: Cloud,
    /// The direction in which the walls give least information, in the frame of the fixed scan.
    axis: Vector2<f64>,
}

pub(crate) fn measure(args: &Args) -> Result<Outcome> {
    let count = args.seeds.unwrap_or(PAIRS);
    let mut outcome = Outcome::default();
    outcome.figure("pairs", count);
    let nothing = pairs("corridor", count, |share| share < SAYS_NOTHING)?;
    let enough = pairs("office", count, |share| share > SAYS_ENOUGH)?;
    for (name, method) in CloudMethod::all() {
        let told = part(&nothing, |pair| {
            let axis = axis(pair, &method);
            axis.is_some_and(|axis| axis.dot(&pair.axis).abs() > AXIS)
        });
        outcome.at_least(&format!("{name}_told_in_corridor"), told, LEAST_TOLD);
        let falsely = part(&enough, |pair| axis(pair, &method).is_some());
        outcome.at_most(&format!("{name}_told_in_office"), falsely, MOST_FALSE);
    }
    Ok(outcome)
}

/// The axis that a method calls degenerate.
fn axis(pair: &Pair, method: &CloudMethod) -> Option<Vector2<f64>> {
    let judge = JudgeConfig::default();
    let start = Pose2::identity();
    match register_clouds(&pair.moving, &pair.fixed, &start, method, &judge).verdict {
        Verdict::Degenerate { direction } => Some(direction),
        _ => None,
    }
}

fn part(pairs: &[Pair], holds: impl Fn(&Pair) -> bool) -> f64 {
    pairs.iter().filter(|pair| holds(pair)).count() as f64 / pairs.len().max(1) as f64
}

/// Pairs in a world whose walls give the wanted information, seen from either scan.
fn pairs(world: &str, count: u64, is_wanted: impl Fn(f64) -> bool) -> Result<Vec<Pair>> {
    let building = Buildings::of([world_named(world)?]);
    let drawn = |seed: u64| {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        for _ in 0..TRIES {
            let Some([fixed, moving]) = building.poses(&mut rng) else {
                continue;
            };
            let between = fixed.delta_to(&moving);
            let turn = CLOSER * 0.75 * between.heading();
            let shift = between.position().coords * CLOSER;
            let moving = fixed * Pose2::new(shift.x, shift.y, turn);
            let seen = [fixed, moving].map(|pose| building.observability(&pose));
            let is_so = seen.iter().flatten().all(|seen| is_wanted(seen.share()));
            if !is_so || shift.length() < 1e-3 {
                continue;
            }
            let [Some(Observability { axis, .. }), _] = seen else {
                continue;
            };
            let [a, b] =
                [fixed, moving].map(|pose| building.scan(&pose, &Condition::CLEAN, &mut rng));
            return Ok(Pair {
                fixed: Cloud::scan(a)?,
                moving: Cloud::scan(b)?,
                axis: fixed.inverse().rotate(axis),
            });
        }
        None.with_context(|| format!("seed {seed}: no such pair in {TRIES} tries"))
    };
    (0..count).map(drawn).collect()
}

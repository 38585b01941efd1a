//! `split-merge`: which rule finds the walls of noisy scans? About 10 s.
//!
//! In: 1 000 rooms with boxes and round pillars ([`scenes`]), each scanned by 360 beams with σ from
//! 1 to 10 cm; the same rooms and the same random numbers for each rule. Out, for each σ and rule:
//! the scores of [`score`].
//!
//! | rule | what it is |
//! |---|---|
//! | `noise_aware` | TDK 2016 §4.2, k = 3 |
//! | `classic` | end-point line, threshold 0.1 m whatever the noise |
//! | `classic_3_sigma` | the same with a threshold of 3 σ: it knows the noise |
//! | `pilch` | Pilch 2016 §3.5.1 |
//! | `ransac` | random samples, several lines by removal, 3 σ |
//! | `hough` | votes over (α, r) with steps of 1.5° and 5 cm, 3 σ |
//! | `noise_aware_gated` | the first with the gates that SLAM uses: two points cut off each end, bent and uncertain lines refused |
//!
//! All but the last keep every line of at least 7 points and 0.5 m (`pilch`: 6 points), and all but
//! `pilch` split scans by the same adaptive rule. It holds if `noise_aware` decides more beams
//! rightly (ACC, mean over σ) than each other rule; `not_better_than_..` lists, by score, the
//! values of σ at which it is not better than a rule that keeps the same lines.

use std::collections::BTreeMap;

use anyhow::{Result, bail};
use serde_json::json;
use slamlab_core::features::{AcceptConfig, Hough, LineConfig, LineExtractor, Ransac, SplitRule};
use slamlab_core::points::SpacingModel;

use crate::Args;
use crate::outcome::Outcome;
use crate::scenes::BEAMS;
use crate::score::{Scene, Score};

const CENTIMETRES: std::ops::RangeInclusive<u32> = 1..=10;
/// The first rules of [`rules`], this many, keep the same lines.
const N_ALIKE: usize = 6;

pub(crate) fn measure(args: &Args) -> Result<Outcome> {
    let seeds = args.seeds.unwrap_or(1_000);
    let mut outcome = Outcome::default();
    outcome.figure("scenes", seeds);
    let mut not_better: BTreeMap<String, BTreeMap<&str, Vec<u32>>> = BTreeMap::new();
    let mut mean_acc: BTreeMap<&str, f64> = BTreeMap::new();
    for centimetres in CENTIMETRES {
        let sigma = 0.01 * f64::from(centimetres);
        let scores = (rules(sigma).into_iter())
            .map(|(name, config)| Ok((name, score(config, sigma, seeds)?.ratios())))
            .collect::<Result<Vec<_>>>()?;
        for (name, ratios) in &scores {
            *mean_acc.entry(name).or_default() += ratios["acc"] / CENTIMETRES.count() as f64;
        }
        let [(_, ours), others @ ..] = scores.as_slice() else {
            bail!("there is no rule to measure");
        };
        for (name, theirs) in others.iter().take(N_ALIKE - 1) {
            let table = not_better.entry(format!("not_better_than_{name}_at_cm"));
            let table = table.or_default();
            for quantity in ours.keys() {
                if !is_better(quantity, ours[quantity], theirs[quantity]) {
                    table.entry(quantity).or_default().push(centimetres);
                }
            }
        }
        let table: BTreeMap<_, _> = scores.into_iter().collect();
        outcome.figure(format!("sigma_{centimetres}_cm"), json!(table));
    }
    for (key, table) in not_better {
        outcome.figure(key, json!(table));
    }
    let ours = mean_acc["noise_aware"];
    for (name, theirs) in &mean_acc {
        outcome.figure(format!("{name}_mean_acc"), *theirs);
        outcome.require(ours > *theirs || *name == "noise_aware", || {
            format!("the mean ACC is {ours}, expected more than {theirs} of {name}")
        });
    }
    Ok(outcome)
}

/// Whether one score is better than another; false for NaN (a rule that claims nothing has no PPV).
fn is_better(quantity: &str, ours: f64, theirs: f64) -> bool {
    match quantity {
        "tpr" | "ppv" | "acc" => ours > theirs,
        _ => ours < theirs,
    }
}

/// The first six use the same criteria for which lines to keep; the first is ours.
fn rules(sigma: f64) -> [(&'static str, LineConfig); 7] {
    let by = |split| LineConfig {
        split,
        accept: AcceptConfig::all(7, 0.5),
        ..LineConfig::default()
    };
    let mut pilch = LineConfig::pilch(SpacingModel::even(BEAMS as f64));
    pilch.accept.min_length = 0.5;
    [
        ("noise_aware", by(SplitRule::default())),
        ("classic", LineConfig::classic(0.1)),
        ("classic_3_sigma", LineConfig::classic(3.0 * sigma)),
        ("pilch", pilch),
        ("ransac", by(SplitRule::Ransac(Ransac::default()))),
        ("hough", by(SplitRule::Hough(Hough::default()))),
        ("noise_aware_gated", LineConfig::default()),
    ]
}

fn score(config: LineConfig, sigma: f64, seeds: u64) -> Result<Score> {
    let mut extractor = LineExtractor::new(config);
    let (mut lines, mut score) = (vec![], Score::default());
    for seed in 0..seeds {
        let scene = Scene::drawn(seed, sigma);
        extractor.extract(&scene.points, &mut lines)?;
        score.add(&scene, &lines);
    }
    Ok(score)
}

//! `split-merge`: which rule finds the walls of noisy scans? About 10 s.
//!
//! In: 1 000 rooms with boxes and round pillars ([`scenes`]), each scanned by 360 beams with σ from 1 to 10 cm; the same rooms and the
//! same random numbers for each rule. Out, for each σ and rule: the scores of [`score`].
//!
//! | rule | what it is |
//! |---|---|
//! | `noise_aware` | TDK 2016 §4.2, k = 3 |
//! | `classic` | end-point line, threshold 0.1 m whatever the noise |
//! | `classic_3_sigma` | the same with a threshold of 3 σ: it is told the noise |
//! | `pilch` | Pilch 2016 §3.5.1 |
//! | `noise_aware_gated` | the first with the gates that SLAM uses: two points off each end, bent and unsure lines refused |
//!
//! All but the last keep every line of at least 7 points and 0.5 m (`pilch`: 6 points), and all but `pilch` break points by the
//! same adaptive rule. It holds if `noise_aware` decides more beams rightly (ACC) than `classic` at each σ; `not_better` lists every other
//! score at which it is not better than one of the rules that share its gates.

use anyhow::Result;
use serde_json::{Map, Value, json};
use slamlab_core::features::{AcceptConfig, LineConfig, LineExtractor};
use slamlab_core::points::SpacingModel;

use crate::Args;
use crate::outcome::Outcome;
use crate::scenes::{BEAMS, Scene};
use crate::score::Score;

const CENTIMETRES: std::ops::RangeInclusive<u32> = 1..=10;

pub(crate) fn measure(args: &Args) -> Result<Outcome> {
    let seeds = args.seeds.unwrap_or(1_000);
    let mut outcome = Outcome::default();
    outcome.figure("scenes", seeds);
    let mut not_better = vec![];
    for centimetres in CENTIMETRES {
        let sigma = 0.01 * f64::from(centimetres);
        let scores = (rules(sigma).into_iter())
            .map(|(name, config)| Ok((name, score(config, sigma, seeds)?)))
            .collect::<Result<Vec<_>>>()?;
        let table: Map<String, Value> = scores
            .iter()
            .map(|(name, score)| ((*name).to_owned(), json!(score.ratios())))
            .collect();
        outcome.figure(format!("sigma_{centimetres}_cm"), table);
        let ours = scores[0].1.ratios();
        for (name, score) in &scores[1..4] {
            for (quantity, theirs) in score.ratios() {
                let is_error = ["fpr", "over_segmented", "under_segmented", "missed"]
                    .iter()
                    .any(|error| quantity.starts_with(error));
                let sign = if is_error { -1.0 } else { 1.0 };
                // NaN (a rule that claims nothing has no PPV) is not better.
                if sign * (ours[quantity] - theirs) <= 0.0 {
                    not_better.push(format!("{quantity} than {name} at {centimetres} cm"));
                }
            }
        }
        let (ours, classic) = (ours["acc"], scores[1].1.ratios()["acc"]);
        outcome.require(ours > classic, || {
            format!("acc at {centimetres} cm is {ours}, expected more than classic's {classic}")
        });
    }
    outcome.figure("not_better", not_better);
    Ok(outcome)
}

/// The first four share what they keep; the first is ours.
fn rules(sigma: f64) -> [(&'static str, LineConfig); 5] {
    [
        (
            "noise_aware",
            LineConfig {
                accept: AcceptConfig::all(7, 0.5),
                ..LineConfig::default()
            },
        ),
        ("classic", LineConfig::classic(0.1)),
        ("classic_3_sigma", LineConfig::classic(3.0 * sigma)),
        ("pilch", {
            let mut config = LineConfig::pilch(SpacingModel::even(BEAMS as f64));
            config.accept.min_length = 0.5;
            config
        }),
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

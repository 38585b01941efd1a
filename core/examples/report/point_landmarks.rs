//! `point-landmarks`: which are the better landmarks for the filter: walls, corners and posts, or
//! both; and is its covariance honest with each?
//!
//! In: 20 seeds of a tour of `office` and of random errands in `arena` and `lab`; filters over
//! walls, over points and over both listen to the same run. Out, for each: the figures of
//! `ekf-consistency`, how many points were matched, and how many wrongly.
//!
//! It holds if the filter over both is not overconfident on the way: the mean of its NEES is no
//! larger than that of walls alone plus what a band of χ²(3) allows.

use anyhow::Result;
use slamlab_core::estimation::{EkfConfig, LandmarkKinds};

use crate::Args;
use crate::ekf_consistency::{all_seeds, summarise};
use crate::outcome::Outcome;
use crate::statistics::chi2_mean_band;
use crate::tour::{Listener, OFFICE, Tour};

const TOURS: [Tour; 3] = [OFFICE, Tour::errands("arena", 6), Tour::errands("lab", 6)];
const SEEDS: u64 = 20;

pub(crate) fn measure(args: &Args) -> Result<Outcome> {
    let seeds = args.seeds.unwrap_or(SEEDS);
    let band = chi2_mean_band(3.0, seeds as f64);
    let mut outcome = Outcome::default();
    outcome.figure("seeds", seeds);
    let worlds = args.worlds(TOURS.iter().map(|tour| tour.world))?;
    let forms: Vec<(&str, EkfConfig)> = (LandmarkKinds::ALL.iter())
        .map(|&(name, landmarks, _)| {
            let config = EkfConfig {
                landmarks,
                ..EkfConfig::default()
            };
            (name, config)
        })
        .collect();
    let configs: Vec<EkfConfig> = forms.iter().map(|(_, config)| *config).collect();
    for tour in TOURS.iter().filter(|tour| worlds.contains(&tour.world)) {
        let runs = all_seeds(tour, args.first_seed, seeds, &configs)?;
        let mut of_lines = f64::NAN;
        for (form, (name, _)) in forms.iter().enumerate() {
            let key = |quantity: &str| format!("{}_{name}_{quantity}", tour.world);
            let listeners: Vec<&Listener> = runs.iter().filter_map(|run| run.get(form)).collect();
            let anees = summarise(&mut outcome, &key, &listeners, band);
            let matches: usize = listeners.iter().map(|l| l.point_matches).sum();
            let wrong: usize = listeners.iter().map(|l| l.wrong_point_matches).sum();
            match *name {
                "lines" => of_lines = anees,
                "both" => outcome.at_most(&key("anees"), anees, of_lines.max(band[1])),
                _ => {}
            }
            if matches > 0 {
                let part = wrong as f64 / matches as f64;
                outcome.figure(key("wrong_points_part"), part);
            }
        }
    }
    Ok(outcome)
}

//! `ekf-consistency`: is the line filter's covariance honest, and does it keep its walls apart?
//!
//! In: 100 seeds of one lap of `loop` and of a tour of `office`; all forms of the filter listen to the same run. Out, for each
//! world and form: the pose's NEES averaged over the seeds (3 if honest) at each scan, its mean over the scans after the first
//! metre, and at the end; the part of the scans in which it lies in the 95 % band of a mean of χ²(3) over so many seeds; ATE; walls
//! that are in the map twice; matches with a wrong wall.
//!
//! It holds if the consistent form's average lies in the band, and if no wall is there twice. About 90 s of one core.

use std::collections::BTreeMap;
use std::thread;

use anyhow::{Result, anyhow};
use slamlab_core::association::AssociationMethod;
use slamlab_core::estimation::{Consistency, EkfConfig, OdometryErrors};

use crate::Args;
use crate::outcome::Outcome;
use crate::tour::{LOOP, Listener, OFFICE, Tour, drive};

/// First-estimate Jacobians, newest-estimate Jacobians, and the first form without states for the odometry's systematic errors.
/// The last one matches the lines of a scan one by one instead of together.
const FORMS: [&str; 4] = ["consistent", "plain", "uncalibrated", "nearest"];
/// Scans of the first metre: what is known of the start exactly still shows in them.
const FIRST_SCANS: usize = 20;

pub(crate) fn measure(args: &Args) -> Result<Outcome> {
    let seeds = args.seeds.unwrap_or(100);
    let band = chi2_mean_band(3.0, seeds as f64);
    let mut outcome = Outcome::default();
    outcome.figure("seeds", seeds);
    for tour in [&LOOP, &OFFICE] {
        let runs = all_seeds(tour, seeds)?;
        for (form, name) in FORMS.into_iter().enumerate() {
            let key = |quantity: &str| format!("{}_{name}_{quantity}", tour.world);
            let listeners: Vec<&Listener> = runs.iter().filter_map(|run| run.get(form)).collect();
            let over_scans = summarise(&mut outcome, &key, &listeners, band);
            if name == "consistent" {
                outcome.within(&key("anees"), over_scans, band);
                let duplicates: usize = listeners.iter().map(|l| l.duplicates).sum();
                outcome.at_most(&key("duplicate_walls"), duplicates as f64, 0.0);
            }
        }
    }
    Ok(outcome)
}

/// Adds the figures of one form in one world; gives the mean of the averaged NEES over the scans.
fn summarise(
    outcome: &mut Outcome,
    key: &dyn Fn(&str) -> String,
    listeners: &[&Listener],
    band: [f64; 2],
) -> f64 {
    let n = listeners.len() as f64;
    let mean = |of: &dyn Fn(&Listener) -> f64| listeners.iter().map(|l| of(l)).sum::<f64>() / n;
    let most = |of: &dyn Fn(&Listener) -> f64| listeners.iter().map(|l| of(l)).fold(0.0, f64::max);
    let total = |of: &dyn Fn(&Listener) -> usize| listeners.iter().map(|l| of(l)).sum::<usize>();
    let anees = average_nees(listeners);
    let later = anees.get(FIRST_SCANS..).unwrap_or_default();
    let over_scans = later.iter().sum::<f64>() / later.len() as f64;
    let inside = later
        .iter()
        .filter(|v| (band[0]..=band[1]).contains(*v))
        .count();
    let at_end = mean(&|l| l.nees.last().copied().unwrap_or(f64::NAN));
    outcome.figure(key("anees"), over_scans);
    outcome.figure(key("anees_at_end"), at_end);
    outcome.figure(key("duplicate_walls"), total(&|l| l.duplicates));
    outcome.figure(
        key("anees_scans_in_band_fraction"),
        inside as f64 / later.len() as f64,
    );
    let tenth = (later.len() / 10).max(1);
    let profile: Vec<f64> = later
        .chunks(tenth)
        .map(|part| part.iter().sum::<f64>() / part.len() as f64)
        .collect();
    outcome.figure(key("anees_by_tenth_of_the_way"), profile);
    let worst = most(&|l| l.nees.iter().sum::<f64>() / l.nees.len() as f64);
    outcome.figure(key("worst_seed_mean_nees"), worst);
    let degrees = total(&|l| l.nis_degrees);
    outcome.figure(
        key("nis_per_degree"),
        listeners.iter().map(|l| l.nis).sum::<f64>() / degrees as f64,
    );
    outcome.figure(key("ate_rmse_mean_m"), mean(&|l| l.ate));
    outcome.figure(key("ate_rmse_worst_m"), most(&|l| l.ate));
    outcome.figure(key("end_error_mean_m"), mean(&|l| l.end_error));
    outcome.figure(key("end_error_worst_m"), most(&|l| l.end_error));
    outcome.figure(key("matches"), total(&|l| l.matches));
    outcome.figure(key("wrong_matches"), total(&|l| l.wrong_matches));
    outcome.figure(key("matches_of_no_wall"), total(&|l| l.matches_of_no_wall));
    outcome.figure(key("merges"), total(&|l| l.merged));
    outcome.figure(key("wrong_merges"), total(&|l| l.wrong_merges));
    let mut pairs: BTreeMap<String, usize> = BTreeMap::new();
    for ((seen, known), times) in listeners.iter().flat_map(|l| &l.wrong_pairs) {
        *pairs.entry(format!("{seen} for {known}")).or_default() += times;
    }
    outcome.figure(key("wrong_matches_by_wall"), serde_json::json!(pairs));
    let having = |what: &dyn Fn(&Listener) -> bool| -> Vec<u64> {
        let chosen = listeners.iter().filter(|l| what(l));
        chosen.map(|l| l.seed).collect()
    };
    outcome.figure(key("seeds_with_duplicates"), having(&|l| l.duplicates > 0));
    outcome.figure(key("seeds_with_ate_over_0.1_m"), having(&|l| l.ate > 0.1));
    outcome.figure(key("confirmed_walls_mean"), mean(&|l| l.confirmed as f64));
    over_scans
}

/// The mean over the seeds at each scan, as far as all runs go.
fn average_nees(listeners: &[&Listener]) -> Vec<f64> {
    let scans = listeners.iter().map(|l| l.nees.len()).min().unwrap_or(0);
    let at = |scan: usize| {
        listeners
            .iter()
            .filter_map(|l| l.nees.get(scan))
            .sum::<f64>()
    };
    (0..scans)
        .map(|scan| at(scan) / listeners.len() as f64)
        .collect()
}

/// Both forms on each seed, spread over the cores.
fn all_seeds(tour: &'static Tour, seeds: u64) -> Result<Vec<Vec<Listener>>> {
    let consistent = EkfConfig::default();
    let plain = EkfConfig {
        consistency: Consistency::Plain,
        ..consistent
    };
    let uncalibrated = EkfConfig {
        odometry_prior: OdometryErrors::default(),
        ..consistent
    };
    let mut nearest = consistent;
    nearest.association.method = AssociationMethod::Nearest;
    let configs = [consistent, plain, uncalibrated, nearest];
    let workers = thread::available_parallelism().map_or(1, |n| n.get() as u64);
    let handles: Vec<_> = (0..workers)
        .map(|worker| {
            let own = (worker..seeds).step_by(workers as usize);
            thread::spawn(move || {
                own.map(|seed| drive(tour, seed, &configs))
                    .collect::<Result<Vec<_>>>()
            })
        })
        .collect();
    let mut runs = vec![];
    for handle in handles {
        runs.extend(handle.join().map_err(|_| anyhow!("a run panicked"))??);
    }
    Ok(runs)
}

/// The 95 % band of the mean of `n` values of χ² with `degrees` degrees of freedom.
///
/// Source: Wilson & Hilferty (1931): the cube root of χ²/k is nearly normal; good to 0.1 % for the hundreds of degrees here.
pub(crate) fn chi2_mean_band(degrees: f64, n: f64) -> [f64; 2] {
    let k = degrees * n;
    let part = 2.0 / (9.0 * k);
    [-1.959_964, 1.959_964].map(|z| {
        let root = 1.0 - part + z * part.sqrt();
        degrees * root * root * root
    })
}

//! `ekf-consistency`: is the line filter's covariance honest, and does it keep its walls apart?
//!
//! In: 100 seeds of one lap of `loop` and of a tour of `office`; all forms of the filter listen to
//! the same run. Out, for each world and form: the pose's NEES averaged over the seeds (3 if
//! honest) at each scan, its mean over the scans after the first metre, and at the end; the part of
//! the scans in which it lies in the 95 % band of a mean of χ²(3) over as many seeds; the NEES of
//! the heading alone (1 if honest); ATE; duplicate walls in the map; matches with a wrong wall.
//! Then the same for the consistent form on random errands in the other worlds, with half of the
//! seeds each, and the lesson ([`crate::heading`]), which shows what the forms differ in.
//!
//! It holds if the consistent form's average lies in the band, if no wall of `loop` and `office` is
//! in the map twice, and if the lesson shows the consistent form to be honest and the textbook's
//! not. About 4 minutes of one core. `--world lab` measures that world alone.

use std::collections::BTreeMap;
use std::thread;

use anyhow::{Result, anyhow};
use slamlab_core::association::AssociationMethod;
use slamlab_core::estimation::{Consistency, EkfConfig, OdometryErrors};

use crate::Args;
use crate::heading::{self, Belief};
use crate::outcome::Outcome;
use crate::statistics::chi2_mean_band;
use crate::tour::{LOOP, Listener, OFFICE, Tour, drive};

/// Worlds without requirements of their own: settings tuned to `loop` and `office` alone would show
/// here.
const OTHERS: [Tour; 5] = [
    Tour::errands("arena", 6),
    Tour::errands("doors", 6),
    Tour::errands("maze", 6),
    Tour::errands("lab", 6),
    Tour::errands("warehouse", 6),
];

/// First-estimate Jacobians; newest-estimate Jacobians; the first form without states for the
/// odometry's systematic errors; and one that matches the lines of a scan one by one instead of
/// together.
const FORMS: [&str; 4] = ["consistent", "plain", "uncalibrated", "nearest"];
/// Scans of the first metre, in which the exactly known start still has an effect.
const FIRST_SCANS: usize = 20;

pub(crate) fn measure(args: &Args) -> Result<Outcome> {
    let seeds = args.seeds.unwrap_or(100);
    let band = chi2_mean_band(3.0, seeds as f64);
    let mut outcome = Outcome::default();
    outcome.figure("seeds", seeds);
    outcome.figure("first_seed", args.first_seed);
    let tours = [&LOOP, &OFFICE].into_iter().chain(&OTHERS);
    let worlds = args.worlds(tours.map(|tour| tour.world))?;
    let is_wanted = |tour: &&Tour| worlds.contains(&tour.world);
    if args.worlds.is_empty() {
        lesson(&mut outcome, args.first_seed, 4 * seeds)?;
    }
    for tour in [&LOOP, &OFFICE].into_iter().filter(is_wanted) {
        let runs = all_seeds(tour, args.first_seed, seeds, &forms())?;
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
    let few = seeds.div_ceil(2);
    let band = chi2_mean_band(3.0, few as f64);
    for tour in OTHERS.iter().filter(is_wanted) {
        let runs = all_seeds(tour, args.first_seed, few, &[EkfConfig::default()])?;
        let listeners: Vec<&Listener> = runs.iter().flatten().collect();
        let key = |quantity: &str| format!("{}_{quantity}", tour.world);
        summarise(&mut outcome, &key, &listeners, band);
    }
    Ok(outcome)
}

/// The lesson: `n` runs of each form.
fn lesson(outcome: &mut Outcome, first_seed: u64, n: u64) -> Result<()> {
    let forms = [Consistency::FirstEstimates, Consistency::Plain];
    let known = heading::LOST.to_degrees();
    outcome.figure("circles_runs", n);
    outcome.figure("circles_heading_sigma_known_deg", known);
    for (form, name) in forms.into_iter().zip(FORMS) {
        let runs = (first_seed..first_seed + n).map(|seed| heading::run(form, seed));
        let runs = runs.collect::<Result<Vec<Belief>>>()?;
        let mean = |of: &dyn Fn(&Belief) -> f64| runs.iter().map(of).sum::<f64>() / n as f64;
        let key = |quantity: &str| format!("circles_{name}_{quantity}");
        let of_heading = mean(&|b| b.heading_nees);
        let of_pose = mean(&|b| b.pose_nees);
        let sigma = mean(&|b| b.heading_sigma).to_degrees();
        match form {
            Consistency::FirstEstimates => {
                let band = |degrees| chi2_mean_band(degrees, n as f64);
                outcome.within(&key("heading_anees"), of_heading, band(1.0));
                outcome.within(&key("pose_anees"), of_pose, band(3.0));
                outcome.at_least(&key("heading_sigma_deg"), sigma, known);
            }
            Consistency::Plain => {
                outcome.at_least(&key("heading_anees"), of_heading, 3.0);
                outcome.figure(key("pose_anees"), of_pose);
                outcome.figure(key("heading_sigma_deg"), sigma);
            }
        }
    }
    Ok(())
}

/// The settings of [`FORMS`].
fn forms() -> [EkfConfig; 4] {
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
    [consistent, plain, uncalibrated, nearest]
}

/// Adds the figures of one form in one world; returns the averaged NEES, averaged over the scans.
pub(crate) fn summarise(
    outcome: &mut Outcome,
    key: &dyn Fn(&str) -> String,
    listeners: &[&Listener],
    band: [f64; 2],
) -> f64 {
    let n = listeners.len() as f64;
    let mean = |of: &dyn Fn(&Listener) -> f64| listeners.iter().map(|l| of(l)).sum::<f64>() / n;
    let most = |of: &dyn Fn(&Listener) -> f64| listeners.iter().map(|l| of(l)).fold(0.0, f64::max);
    let total = |of: &dyn Fn(&Listener) -> usize| listeners.iter().map(|l| of(l)).sum::<usize>();
    let mean_of = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let later = average(listeners, |l| &l.nees);
    let over_scans = mean_of(&later);
    let is_inside = |v: &&f64| (band[0]..=band[1]).contains(*v);
    let inside = later.iter().filter(is_inside).count() as f64 / later.len() as f64;
    let at_end = mean(&|l| l.nees.last().copied().unwrap_or(f64::NAN));
    outcome.figure(key("anees"), over_scans);
    let of_heading = average(listeners, |l| &l.heading_nees);
    outcome.figure(key("heading_anees"), mean_of(&of_heading));
    outcome.figure(key("anees_at_end"), at_end);
    outcome.figure(key("duplicate_walls"), total(&|l| l.duplicates));
    outcome.figure(key("anees_scans_in_band_fraction"), inside);
    let tenths = later.chunks((later.len() / 10).max(1));
    let profile: Vec<f64> = tenths.map(mean_of).collect();
    outcome.figure(key("anees_by_tenth_of_the_way"), profile);
    outcome.figure(key("worst_seed_mean_nees"), most(&|l| mean_of(&l.nees)));
    let nis = listeners.iter().map(|l| l.nis).sum::<f64>();
    outcome.figure(
        key("nis_per_degree"),
        nis / total(&|l| l.nis_degrees) as f64,
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
    if total(&|l| l.point_matches) > 0 {
        outcome.figure(key("point_matches"), total(&|l| l.point_matches));
        let wrong = total(&|l| l.wrong_point_matches);
        outcome.figure(key("wrong_point_matches"), wrong);
        let confirmed = mean(&|l| l.confirmed_points as f64);
        outcome.figure(key("confirmed_points_mean"), confirmed);
    }
    over_scans
}

/// The mean over the seeds at each scan after the first metre, up to the end of the shortest run.
fn average(listeners: &[&Listener], of: impl Fn(&Listener) -> &Vec<f64>) -> Vec<f64> {
    let scans = listeners.iter().map(|l| of(l).len()).min().unwrap_or(0);
    let at = |scan: usize| {
        let values = listeners.iter().filter_map(|l| of(l).get(scan));
        values.sum::<f64>() / listeners.len() as f64
    };
    (FIRST_SCANS..scans).map(at).collect()
}

/// All forms on each seed, spread over the cores.
pub(crate) fn all_seeds(
    tour: &Tour,
    first: u64,
    seeds: u64,
    configs: &[EkfConfig],
) -> Result<Vec<Vec<Listener>>> {
    let workers = thread::available_parallelism().map_or(1, |n| n.get() as u64);
    let work = |worker| {
        let own = (worker..seeds).step_by(workers as usize);
        let runs = own.map(|seed| drive(tour, first + seed, configs));
        runs.collect::<Result<Vec<_>>>()
    };
    thread::scope(|scope| {
        let start = |worker| scope.spawn(move || work(worker));
        let handles: Vec<_> = (0..workers).map(start).collect();
        let mut runs = vec![];
        for handle in handles {
            runs.extend(handle.join().map_err(|_| anyhow!("a run panicked"))??);
        }
        Ok(runs)
    })
}

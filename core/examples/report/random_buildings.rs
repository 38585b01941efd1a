//! `random-buildings`: is a map ever ruined without being reported, where nothing could be tuned?
//! Some seconds for each run.
//!
//! 1. Building, robot, lidar and odometry are drawn from the seed ([`crate::random_building`]); 60
//!    seeds (`--seeds`). The robot explores by scan matching with the default settings, until
//!    everything is seen or for [`LONGEST`].
//! 2. A map is ruined if its trajectory is off by more than [`MOST_WAY_ERROR`], or one wall in
//!    twenty by more than [`MOST_WALL_ERROR`], after the rigid motion that aligns the trajectories.
//!    Ruined maps must be called torn or doubtful, and of the others at most [`MOST_FALSE_ALARMS`]
//!    may be called torn.
//! 3. A closure is false as in `look-alikes` ([`crate::closures`]).
//!
//! Each run is reported on standard error.

use anyhow::Result;
use serde_json::json;
use slamlab_core::estimation::MapVerdict;

use super::{Args, Outcome};
use crate::mapped::{Mapped, PART};
use crate::random_building;
use crate::statistics::{median, quantile};
use crate::threads::each;

const SEEDS: u64 = 60;
/// Maximum time of exploration, s.
const LONGEST: f64 = 900.0;
const MOST_WAY_ERROR: f64 = 0.5;
const MOST_WALL_ERROR: f64 = 0.5;
const MOST_FALSE_ALARMS: f64 = 0.05;

pub(crate) fn measure(args: &Args) -> Result<Outcome> {
    let seeds: Vec<u64> = args.seeds(SEEDS).collect();
    let runs = each(seeds.len(), |index| {
        let seed = seeds.get(index).copied().unwrap_or_default();
        let run = Mapped::of(random_building::experiment(seed), LONGEST)?;
        tell(&run, seed);
        Ok(run)
    })?;
    let count = |of: &dyn Fn(&Mapped) -> bool| runs.iter().filter(|run| of(run)).count();
    let called = |verdict| move |run: &Mapped| run.verdict == verdict;
    let is_torn = called(MapVerdict::Torn);
    let right = count(&|run| !is_ruined(run)) as f64;
    let mut outcome = Outcome::default();
    outcome.figure("runs", json!(runs.len()));
    outcome.figure("seen_to_the_end", json!(count(&|run| run.is_done)));
    outcome.figure("called_torn", json!(count(&is_torn)));
    outcome.figure(
        "called_doubtful",
        json!(count(&called(MapVerdict::Doubtful))),
    );
    outcome.figure("ruined", json!(count(&is_ruined)));
    let errors = || runs.iter().map(|run| run.trajectory_error);
    outcome.figure("trajectory_error_m_median", json!(median(errors())));
    outcome.figure("trajectory_error_m_p95", json!(quantile(errors(), PART)));
    let walls = runs.iter().flat_map(|run| &run.aligned);
    outcome.figure("wall_error_aligned_m_p95", json!(quantile(walls, PART)));
    let closures: usize = runs.iter().map(|run| run.closures.len()).sum();
    outcome.figure("closures", json!(closures));
    let false_closures: usize = runs.iter().map(|run| run.wrong().count()).sum();
    let in_silence = count(&|run| is_ruined(run) && run.verdict == MapVerdict::Good) as f64;
    outcome.at_most("ruined_in_silence", in_silence, 0.0);
    outcome.at_most("false_closures", false_closures as f64, 0.0);
    let false_alarms = count(&|run| !is_ruined(run) && is_torn(run)) as f64;
    outcome.at_most(
        "false_alarms_part",
        false_alarms / right.max(1.0),
        MOST_FALSE_ALARMS,
    );
    Ok(outcome)
}

fn is_ruined(run: &Mapped) -> bool {
    // NaN does not count as a small error.
    let is_right =
        run.trajectory_error <= MOST_WAY_ERROR && quantile(&run.aligned, PART) <= MOST_WALL_ERROR;
    !is_right
}

fn tell(run: &Mapped, seed: u64) {
    eprintln!(
        "seed {seed}: {}{}{}, {} submaps, {} closures, {} false; trajectory {:.3} m, 95 % of the walls within {:.3} m",
        if is_ruined(run) { "RUINED, " } else { "" },
        if run.is_done { "" } else { "not done, " },
        run.verdict.name(),
        run.submaps,
        run.closures.len(),
        run.wrong().count(),
        run.trajectory_error,
        quantile(&run.aligned, PART),
    );
    for closure in run.wrong() {
        eprintln!("seed {seed}: {closure}");
    }
}

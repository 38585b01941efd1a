//! `look-alikes`: does scan matching ever mistake one place for another, and are its walls where
//! they stand? Half a minute to four minutes for each run, the large worlds longest.
//!
//! 1. In each of [`WORLDS`], two of which were built to deceive, the lidar robot explores by scan
//!    matching until everything is seen; it fails after an hour of simulated time. 20 seeds
//!    (`--seeds`, `--world`). Postponed work is completed at the end.
//! 2. Whether a closure is false is judged by where the robot truly was ([`crate::closures`]). A
//!    closure whose robust kernel discounts it afterwards still counts as accepted.
//! 3. The error of a wall is the distance of the centre of an occupied cell from the nearest true
//!    wall, after the map is moved by the rigid motion that aligns the trajectory; the quantile is
//!    over the cells of all runs of a world. The pose of the map as a whole is not an error: the
//!    map begins where the robot did, and a robot that turns on the spot in its first sweeps knows
//!    its heading only to some milliradians, whose effect grows with the distance from there. The
//!    error of the map as it lies is given as well.
//! 4. It is also given how often the map was called torn or doubtful
//!    ([`slamlab_core::estimation::ScanMatcher::quality`]).
//!
//! Standard error names the false closures, with their runs and when their submaps began.

use anyhow::Result;
use serde_json::{Value, json};
use slamlab_core::estimation::MapVerdict;
use slamlab_core::experiment::ExperimentConfig;
use slamlab_core::sim::SensorModel;

use super::{Args, Outcome};
use crate::mapped::{Mapped, PART};
use crate::ride::world_named;
use crate::statistics::{median, quantile};
use crate::threads::each;

const WORLDS: [&str; 6] = [
    "loop",
    "office",
    "warehouse",
    "crowd",
    "look-alikes",
    "parallel",
];
const SEEDS: u64 = 20;
/// An exploration that takes longer has failed, s.
const LONGEST: f64 = 3600.0;
/// Maximum distance from the walls of [`PART`] of the cells of walls, m.
const MOST_WALL_ERROR: f64 = 0.05;

pub(crate) fn measure(args: &Args) -> Result<Outcome> {
    let names = args.worlds(WORLDS)?;
    let mut outcome = Outcome::default();
    let (mut closures, mut wrong, mut not_done) = (0, 0, 0);
    for name in names {
        let seeds: Vec<u64> = args.seeds(SEEDS).collect();
        let runs = each(seeds.len(), |index| {
            let seed = seeds.get(index).copied().unwrap_or_default();
            let world = world_named(name)?;
            let robot = world.robot.model();
            let config = ExperimentConfig::new(world, robot, SensorModel::lidar(), seed);
            let run = Mapped::of(config, LONGEST)?;
            tell(&run, name, seed);
            Ok(run)
        })?;
        closures += runs.iter().map(|run| run.closures.len()).sum::<usize>();
        wrong += runs.iter().map(|run| run.wrong().count()).sum::<usize>();
        not_done += runs.iter().filter(|run| !run.is_done).count();
        let wall_error = quantile(runs.iter().flat_map(|run| &run.aligned), PART);
        outcome.figure(name, row(&runs, wall_error));
        outcome.require(wall_error < MOST_WALL_ERROR, || {
            format!("{name}: 95 % of the walls are within {wall_error} m, expected less than {MOST_WALL_ERROR}")
        });
    }
    // A run that closes no loop at all has no false closure.
    outcome.at_least("closures", closures as f64, 1.0);
    outcome.at_most("false_closures", wrong as f64, 0.0);
    outcome.at_most("runs_that_do_not_end", f64::from(not_done as u32), 0.0);
    Ok(outcome)
}

/// The figures of a world.
fn row(runs: &[Mapped], wall_error: f64) -> Value {
    let sum = |of: fn(&Mapped) -> usize| runs.iter().map(of).sum::<usize>();
    let most = |of: fn(&Mapped) -> f64| runs.iter().map(of).fold(0.0, f64::max);
    let closures = || runs.iter().flat_map(|run| &run.closures);
    json!({
        "seeds": runs.len(),
        "done": sum(|run| run.is_done.into()),
        "submaps": sum(|run| run.submaps),
        "closures": sum(|run| run.closures.len()),
        "runs_without_closure": sum(|run| run.closures.is_empty().into()),
        "false_closures": sum(|run| run.wrong().count()),
        "closure_shift_error_m_p95": quantile(closures().map(|c| c.shift), PART),
        "closure_shift_error_m_most": closures().map(|c| c.shift).fold(0.0, f64::max),
        "closure_turn_error_rad_most": closures().map(|c| c.turn).fold(0.0, f64::max),
        "called_torn": sum(|run| (run.verdict == MapVerdict::Torn).into()),
        "called_doubtful": sum(|run| (run.verdict == MapVerdict::Doubtful).into()),
        "wall_error_m_p95": wall_error,
        "wall_error_as_it_lies_m_p95": quantile(runs.iter().flat_map(|run| &run.wall_errors), PART),
        "wall_error_as_it_lies_m_p95_worst_run": most(Mapped::wall_error),
        "map_turned_rad_worst_run": most(|run| run.turned),
        "trajectory_error_m_median": median(runs.iter().map(|run| run.trajectory_error)),
        "trajectory_error_m_worst_run": most(|run| run.trajectory_error),
    })
}

fn tell(run: &Mapped, name: &str, seed: u64) {
    eprintln!(
        "{name} seed {seed}: {}{}, {} submaps, {} closures, {} false; 95 % of the walls within {:.3} m, turned by {:.3} rad {:.3} m; trajectory {:.3} m",
        if run.is_done { "" } else { "not done, " },
        run.verdict.name(),
        run.submaps,
        run.closures.len(),
        run.wrong().count(),
        run.wall_error(),
        run.turned,
        quantile(&run.aligned, PART),
        run.trajectory_error,
    );
    for closure in run.wrong() {
        eprintln!("{name} seed {seed}: {closure}");
    }
}

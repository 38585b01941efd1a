//! `look-alikes`: does scan matching ever take one place for another, and are its walls where they
//! stand? Half a minute to four minutes for each run, the large worlds longest.
//!
//! 1. In each of [`WORLDS`], two of which were built to deceive, the lidar robot explores by scan
//!    matching until all is seen, or for an hour of simulated time, which is a failure; 20 seeds
//!    (`--seeds`, `--world`). What was put off is completed at the end.
//! 2. Whether a closure is false is judged by where the robot truly was ([`crate::closures`]). What
//!    is doubted by its kernel afterwards was accepted all the same.
//! 3. The error of a wall is the distance of the middle of an occupied cell from the nearest true
//!    wall. The map begins where the robot did, so that an error of the first heading grows with
//!    the distance from there; `aligned` is the error that is left of it when the map is moved by
//!    the rigid motion that aligns the trajectory. The quantiles are over the cells of all runs of
//!    a world; both are given, that of the map as it lies is judged.
//!
//! 4. Beside that it says how often the map was called torn or doubtful ([`ScanMatcher::quality`]).
//!
//! Which closure of which run is false, and when its submaps began, goes to standard error.

use std::collections::BTreeMap;

use anyhow::{Context, Result};
use nalgebra::Point2;
use serde_json::{Value, json};
use slamlab_core::estimation::{MapVerdict, ScanMatcher, align, ate_rmse};
use slamlab_core::experiment::{Experiment, ExperimentConfig};
use slamlab_core::geom::Pose2;
use slamlab_core::map::{CellIndex, CellState, Grid};
use slamlab_core::robot::Stamp;
use slamlab_core::sim::{Caster, SensorModel};
use slamlab_core::slam::Method;

use super::{Args, Outcome};
use crate::closures::{Closure, closures_of};
use crate::ride::{carry_out, world_named};
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
/// Part of the cells of walls, and how far the rest of them may be from the walls at most, m.
const PART: f64 = 0.95;
const MOST_WALL_ERROR: f64 = 0.05;
/// Walls farther away are not looked for, m.
const REACH: f64 = 2.0;

pub(crate) fn measure(args: &Args) -> Result<Outcome> {
    let names = args.worlds(WORLDS)?;
    let mut outcome = Outcome::default();
    let (mut closures, mut wrong, mut not_done) = (0, 0, 0);
    for name in names {
        let seeds: Vec<u64> = args.seeds(SEEDS).collect();
        let runs = each(seeds.len(), |index| {
            let seed = seeds.get(index).copied().unwrap_or_default();
            let run = Run::of(name, seed)?;
            run.tell(name, seed);
            Ok(run)
        })?;
        closures += runs.iter().map(|run| run.closures.len()).sum::<usize>();
        wrong += runs.iter().map(|run| run.wrong().count()).sum::<usize>();
        not_done += runs.iter().filter(|run| !run.is_done).count();
        let wall_error = quantile(runs.iter().flat_map(|run| &run.wall_errors), PART);
        outcome.figure(name, row(&runs, wall_error));
        outcome.require(wall_error < MOST_WALL_ERROR, || {
            format!("{name}: 95 % of the walls are within {wall_error} m, expected less than {MOST_WALL_ERROR}")
        });
    }
    // Who closes no loop at all closes none falsely.
    outcome.at_least("closures", closures as f64, 1.0);
    outcome.at_most("false_closures", wrong as f64, 0.0);
    outcome.at_most("runs_that_do_not_end", f64::from(not_done as u32), 0.0);
    Ok(outcome)
}

/// The figures of a world.
fn row(runs: &[Run], wall_error: f64) -> Value {
    let sum = |of: fn(&Run) -> usize| runs.iter().map(of).sum::<usize>();
    let most = |of: fn(&Run) -> f64| runs.iter().map(of).fold(0.0, f64::max);
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
        "wall_error_aligned_m_p95": quantile(runs.iter().flat_map(|run| &run.aligned), PART),
        "wall_error_m_p95_worst_run": most(Run::wall_error),
        "map_turned_rad_worst_run": most(|run| run.turned),
        "trajectory_error_m_median": median(runs.iter().map(|run| run.trajectory_error)),
        "trajectory_error_m_worst_run": most(|run| run.trajectory_error),
    })
}

/// What became of one exploration.
struct Run {
    is_done: bool,
    submaps: usize,
    closures: Vec<Closure>,
    /// Of each occupied cell, m.
    wall_errors: Vec<f64>,
    /// The same of the map as the trajectory is aligned.
    aligned: Vec<f64>,
    /// The turn by which it is aligned, rad.
    turned: f64,
    trajectory_error: f64,
    /// What the run itself thinks of its map.
    verdict: MapVerdict,
}

impl Run {
    fn of(name: &str, seed: u64) -> Result<Self> {
        let world = world_named(name)?;
        let caster = Caster::new(world.walls());
        let world_from_map = world.start;
        let robot = world.robot.model();
        let mut config = ExperimentConfig::new(world, robot, SensorModel::lidar(), seed);
        config.method = Method::ScanMatching;
        let mut experiment = Experiment::new(config)?;
        let is_done = carry_out(&mut experiment, LONGEST, |_| Ok(()))?;
        let mut matcher = experiment
            .session()
            .slam()
            .view()
            .map
            .context("the method keeps no submaps")?
            .clone();
        matcher.finish();
        let truth = truth_of(&experiment);
        let (true_way, estimated) = ways(&matcher, &truth);
        let truth_from_map = align(&true_way, &estimated).unwrap_or_else(Pose2::identity);
        let errors = |world_from_map: Pose2| {
            let walls = occupied(matcher.grid());
            walls
                .map(|in_map| caster.clearance(world_from_map * in_map, REACH))
                .collect()
        };
        Ok(Self {
            is_done,
            submaps: matcher.graph().poses().len(),
            closures: closures_of(&matcher, &truth)?,
            wall_errors: errors(world_from_map),
            turned: truth_from_map.heading().abs(),
            aligned: errors(world_from_map * truth_from_map),
            trajectory_error: ate_rmse(&true_way, &estimated).unwrap_or(f64::NAN),
            verdict: matcher.quality().verdict,
        })
    }

    fn wrong(&self) -> impl Iterator<Item = &Closure> {
        self.closures.iter().filter(|closure| closure.is_wrong())
    }

    fn wall_error(&self) -> f64 {
        quantile(&self.wall_errors, PART)
    }

    fn tell(&self, name: &str, seed: u64) {
        eprintln!(
            "{name} seed {seed}: {}{}, {} submaps, {} closures, {} false; 95 % of the walls within {:.3} m, turned by {:.3} rad {:.3} m; trajectory {:.3} m",
            if self.is_done { "" } else { "not done, " },
            self.verdict.name(),
            self.submaps,
            self.closures.len(),
            self.wrong().count(),
            self.wall_error(),
            self.turned,
            quantile(&self.aligned, PART),
            self.trajectory_error,
        );
        for closure in self.wrong() {
            eprintln!("{name} seed {seed}: {closure}");
        }
    }
}

/// Where the robot truly was, by the stamp of each scan; map frame.
fn truth_of(experiment: &Experiment) -> BTreeMap<Stamp, Pose2> {
    let samples = experiment.record().samples().iter();
    samples.map(|sample| (sample.stamp, sample.truth)).collect()
}

/// The middles of the cells that are occupied, map frame.
pub(crate) fn occupied(grid: &Grid) -> impl Iterator<Item = Point2<f64>> {
    let rect = grid.bounds();
    let states = rect.map_or(vec![], |rect| grid.states(rect));
    let middle = move |index: usize| {
        let rect = rect?;
        let (row, col) = (index / rect.width(), index % rect.width());
        let cell = CellIndex::new(rect.min.col + col as i32, rect.min.row + row as i32);
        Some(grid.centre_of(cell))
    };
    let cells = states.into_iter().enumerate();
    let occupied = cells.filter(|(_, state)| *state == CellState::Occupied);
    occupied.filter_map(move |(index, _)| middle(index))
}

/// Where the robot was at each scan and where it is known to have been at the end; map frame.
fn ways(
    matcher: &ScanMatcher,
    truth: &BTreeMap<Stamp, Pose2>,
) -> (Vec<Point2<f64>>, Vec<Point2<f64>>) {
    let pairs = matcher
        .trajectory()
        .filter_map(|(stamp, pose)| Some((truth.get(&stamp)?.position(), pose.position())));
    pairs.unzip()
}

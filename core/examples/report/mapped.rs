//! An exploration by scan matching, compared with the truth: its walls, its path and its closures.

use std::collections::BTreeMap;

use anyhow::{Context, Result};
use nalgebra::Point2;
use slamlab_core::estimation::{MapVerdict, ScanMatcher, align, ate_rmse};
use slamlab_core::experiment::{Experiment, ExperimentConfig};
use slamlab_core::geom::Pose2;
use slamlab_core::robot::Stamp;
use slamlab_core::sim::Caster;
use slamlab_core::slam::Method;

use crate::closures::{Closure, closures_of};
use crate::ride::carry_out;
use crate::statistics::quantile;

/// Walls farther away are not searched for, m.
const REACH: f64 = 2.0;

/// Part of the cells of walls that the stated maximum error applies to.
pub(crate) const PART: f64 = 0.95;

/// The result of one exploration.
pub(crate) struct Mapped {
    pub(crate) is_done: bool,
    pub(crate) submaps: usize,
    pub(crate) closures: Vec<Closure>,
    /// For each occupied cell, the distance of its centre from the nearest true wall, m.
    pub(crate) wall_errors: Vec<f64>,
    /// The same after the rigid motion that aligns the trajectory.
    pub(crate) aligned: Vec<f64>,
    /// The rotation of that alignment, rad.
    pub(crate) turned: f64,
    pub(crate) trajectory_error: f64,
    /// The run's own verdict on its map.
    pub(crate) verdict: MapVerdict,
}

impl Mapped {
    /// Explores by scan matching until everything is seen, for at most `longest` simulated seconds;
    /// postponed work is completed at the end.
    pub(crate) fn of(mut config: ExperimentConfig, longest: f64) -> Result<Self> {
        let caster = Caster::new(config.world.walls());
        let world_from_map = config.world.start;
        config.method = Method::ScanMatching;
        let mut experiment = Experiment::new(config)?;
        let is_done = carry_out(&mut experiment, longest, |_| Ok(()))?;
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
            let walls = matcher.grid().occupied();
            (walls.into_iter())
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

    /// The closures that are false.
    pub(crate) fn wrong(&self) -> impl Iterator<Item = &Closure> {
        self.closures.iter().filter(|closure| closure.is_wrong())
    }

    /// 95 % of the cells are nearer to a wall than this, without alignment, m.
    pub(crate) fn wall_error(&self) -> f64 {
        quantile(&self.wall_errors, PART)
    }
}

/// Where the robot truly was, by the stamp of each scan; map frame.
fn truth_of(experiment: &Experiment) -> BTreeMap<Stamp, Pose2> {
    let samples = experiment.record().samples().iter();
    samples.map(|sample| (sample.stamp, sample.truth)).collect()
}

/// Where the robot truly was at each scan, and where the map has it in the end; map frame.
fn ways(
    matcher: &ScanMatcher,
    truth: &BTreeMap<Stamp, Pose2>,
) -> (Vec<Point2<f64>>, Vec<Point2<f64>>) {
    let pairs = matcher
        .trajectory()
        .filter_map(|(stamp, pose)| Some((truth.get(&stamp)?.position(), pose.position())));
    pairs.unzip()
}

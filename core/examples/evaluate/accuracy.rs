//! How far the trajectory of a run is from the known truth.

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::{Context, bail};
use serde_json::{Value, json};
use slamlab_core::estimation::{
    PosesByStamp, RelationErrors, StampedMotion, absolute_errors, motions_over, relation_errors,
    revisits,
};
use slamlab_core::format::poses::read_poses;
use slamlab_core::format::relations;
use slamlab_core::geom::Pose2;
use slamlab_core::replay::Replay;

use crate::closures::{Closure, closures_of};

/// Relations over at least this time show whether loops close, s.
const LONG: f64 = 20.0;
/// Distances over which a trajectory is compared with a reference, m.
const WAYS: [f64; 3] = [1.0, 10.0, 100.0];

/// What is known of a log's truth.
#[derive(Default)]
pub(crate) struct References {
    /// Motions between scans.
    relations: Option<Vec<StampedMotion>>,
    /// The pose at each scan, by stamp.
    trajectory: Option<Vec<(f64, Pose2)>>,
}

impl References {
    pub(crate) fn read(relations: Option<&Path>, truth: Option<&Path>) -> anyhow::Result<Self> {
        Ok(Self {
            relations: relations.map(read_relations).transpose()?,
            trajectory: truth.map(read_trajectory).transpose()?,
        })
    }

    /// Errors over the relations.
    ///
    /// # Errors    If the relations belong to another log: without any figure it would look as if
    /// there were no error.
    pub(crate) fn relation_errors(&self, trajectory: &[(f64, Pose2)]) -> anyhow::Result<Value> {
        let Some(relations) = &self.relations else {
            return Ok(Value::Null);
        };
        let is_long = |(from, to, _): &&StampedMotion| (to - from).abs() >= LONG;
        let long = relations.iter().filter(is_long).copied();
        let all = errors(relations.iter().copied(), trajectory);
        if all.is_null() {
            bail!(
                "none of the {} relations joins two scans of the log; they belong to another one, or it is cut short",
                relations.len()
            );
        }
        Ok(json!({ "all": all, "long": errors(long, trajectory) }))
    }

    /// Errors against the reference trajectory: of positions, over distances, and at revisits.
    ///
    /// # Errors    If the trajectory belongs to another log.
    pub(crate) fn trajectory_errors(&self, trajectory: &[(f64, Pose2)]) -> anyhow::Result<Value> {
        let Some(truth) = &self.trajectory else {
            return Ok(Value::Null);
        };
        let Some(absolute) = absolute_errors(truth, trajectory) else {
            bail!(
                "fewer than two of the {} poses of the reference trajectory are those of scans of the log; it belongs to another one",
                truth.len()
            );
        };
        let over = |way: &f64| {
            let errors = errors(motions_over(truth, *way), trajectory);
            json!({ "way_m": way, "errors": errors })
        };
        Ok(json!({
            "count": absolute.count,
            "left_out": absolute.left_out,
            "ate_rmse_m": absolute.rmse,
            "ate_max_m": absolute.max,
            "rpe": WAYS.iter().map(over).collect::<Vec<_>>(),
            "revisits": errors(revisits(truth), trajectory),
        }))
    }

    /// The loop closures of a run that are false according to the reference trajectory. `None` if
    /// that does not cover every scan, or if the method has no submaps.
    pub(crate) fn false_closures(&self, replay: &Replay) -> Option<Vec<Closure>> {
        let truth = self.trajectory.as_deref()?;
        let poses = PosesByStamp::new(truth, &truth.iter().map(|(stamp, _)| *stamp));
        let scans = replay.scan_times();
        let truth = scans.map(|(stamp, seconds)| Some((stamp, poses.at(seconds)?)));
        let truth: BTreeMap<_, _> = truth.collect::<Option<_>>()?;
        let closures = closures_of(replay.session().slam().view().map?, &truth).ok()?;
        Some(closures.into_iter().filter(Closure::is_wrong).collect())
    }
}

/// Null if the trajectory covers none of the motions.
fn errors(motions: impl IntoIterator<Item = StampedMotion>, trajectory: &[(f64, Pose2)]) -> Value {
    let errors = relation_errors(motions, trajectory);
    match errors.count {
        0 => Value::Null,
        _ => figures(&errors),
    }
}

fn figures(errors: &RelationErrors) -> Value {
    let degrees = 1.0_f64.to_degrees();
    json!({
        "count": errors.count,
        "left_out": errors.left_out,
        "trans_abs_mean_m": errors.trans_abs_mean,
        "trans_abs_std_m": errors.trans_abs_std,
        "trans_sq_mean_m2": errors.trans_sq_mean,
        "wrong_part": errors.wrong_part,
        "rot_abs_mean_deg": errors.rot_abs_mean * degrees,
        "rot_abs_std_deg": errors.rot_abs_std * degrees,
        "rot_sq_mean_deg2": errors.rot_sq_mean * degrees * degrees,
    })
}

fn read_relations(path: &Path) -> anyhow::Result<Vec<StampedMotion>> {
    let name = || format!("relations {}", path.display());
    let relations = relations::parse(&std::fs::read(path).with_context(name)?);
    let relations = relations.with_context(name)?;
    Ok(relations.iter().map(|r| r.stamped_motion()).collect())
}

fn read_trajectory(path: &Path) -> anyhow::Result<Vec<(f64, Pose2)>> {
    let name = || format!("reference trajectory {}", path.display());
    let file = read_poses(&std::fs::read(path).with_context(name)?).with_context(name)?;
    Ok(file.poses)
}

//! One log, damaged or not, mapped by the default method and held against its reference.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use slamlab_core::estimation::{
    MapQuality, RelationErrors, ScanMatcher, StampedMotion, relation_errors, revisits,
};
use slamlab_core::format::{relations, tum};
use slamlab_core::geom::Pose2;
use slamlab_core::replay::{Log, Replay};
use slamlab_core::slam::Method;

use super::damage::Damage;
use crate::clock::cpu_seconds;
use crate::log_file;
use crate::peak_memory::peak_memory_mb;
use crate::statistics::quantile;

/// Of the map of a whole log a pose is taken each so many metres, as a reference at its revisits.
const THINNED: f64 = 0.5;
/// Relations over at least this time show whether loops close, s.
const LONG: f64 = 20.0;

/// A recorded building.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Building {
    pub(super) name: &'static str,
    pub(super) kind: Kind,
}

/// How it was recorded, and what it is held against.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Kind {
    /// Every scan; relations.
    Relations,
    /// A scan every metre; a trajectory, at its revisits.
    Keyframes,
}

impl Building {
    /// The log and its reference, in the folder of recorded data.
    fn files(self, data: &Path) -> [PathBuf; 2] {
        let name = self.name;
        let (folder, reference) = match self.kind {
            Kind::Relations => (name, "relations"),
            Kind::Keyframes => ("keyframes", "tum"),
        };
        ["clf", reference].map(|end| data.join(folder).join(format!("{name}.{end}")))
    }

    fn motions(self, data: &Path) -> Result<Vec<StampedMotion>> {
        let [_, path] = self.files(data);
        let name = || format!("reference {}", path.display());
        let bytes = std::fs::read(&path).with_context(name)?;
        match self.kind {
            Kind::Relations => {
                let relations = relations::parse(&bytes).with_context(name)?;
                Ok(relations.iter().map(|r| r.stamped_motion()).collect())
            }
            Kind::Keyframes => Ok(revisits(&tum::parse(&bytes).with_context(name)?)),
        }
    }
}

/// What came of a run.
pub(super) struct Run {
    pub(super) scans: usize,
    pub(super) closures: usize,
    /// Errors over all motions of the reference whose scans are left.
    pub(super) errors: RelationErrors,
    /// The same over those of at least 20 s.
    pub(super) long: RelationErrors,
    motions: Vec<StampedMotion>,
    trajectory: Vec<(f64, Pose2)>,
    /// In that of the log, processor time of the process: it means something where nothing else
    /// runs beside.
    pub(super) real_time_factor: f64,
    pub(super) scan_ms_p99: f64,
    /// Of the process until now, MB.
    pub(super) peak_memory_mb: Option<f64>,
    /// What the map is said to be worth, by itself.
    pub(super) quality: MapQuality,
}

impl Run {
    /// # Errors    A log or reference that cannot be read or belong to different logs.
    pub(super) fn of(building: Building, damage: Damage, data: &Path) -> Result<Self> {
        let [path, _] = building.files(data);
        let begin = cpu_seconds();
        let log = match log_file::read(&path)? {
            Log::Carmen(log) => Log::Carmen(damage.apply(log)),
            _ => bail!("{} is no CARMEN log", path.display()),
        };
        let (scans, seconds) = (log.scans(), log.duration());
        let settings = log.settings();
        let mut replay = Replay::new(log, Method::ScanMatching, &settings)?;
        let mut scan_ms = Vec::with_capacity(scans);
        let mut began = cpu_seconds();
        while replay.step()? {
            let now = cpu_seconds();
            scan_ms.push(1e3 * (now - began));
            began = now;
        }
        let real_time_factor = seconds / (cpu_seconds() - begin);
        let peak_memory_mb = peak_memory_mb();
        let trajectory = replay.trajectory();
        let motions = building.motions(data)?;
        let (errors, long) = held_against(&motions, &trajectory);
        if errors.count == 0 {
            bail!(
                "{}: no motion of its reference joins two scans",
                path.display()
            );
        }
        let view = replay.session().slam().view();
        let quality = view.map.map(ScanMatcher::quality);
        Ok(Self {
            quality: quality.context("scan matching keeps no map")?,
            scans,
            closures: view.loop_closures,
            errors,
            long,
            motions,
            trajectory,
            real_time_factor,
            scan_ms_p99: quantile(&scan_ms, 0.99),
            peak_memory_mb,
        })
    }

    /// How far the places seen again, in the map of the whole log, are off in this one, m.
    /// Relations are few and lie where their authors looked; this is everywhere.
    pub(super) fn errors_at_revisits(&self, whole: &Self) -> Vec<f64> {
        let mut thinned: Vec<(f64, Pose2)> = vec![];
        for (seconds, pose) in &whole.trajectory {
            let is_on =
                |(_, last): &(f64, Pose2)| (pose.position() - last.position()).norm() >= THINNED;
            if thinned.last().is_none_or(is_on) {
                thinned.push((*seconds, *pose));
            }
        }
        let error = |motion: StampedMotion| {
            let errors = relation_errors([motion], &self.trajectory);
            (errors.count > 0).then_some(errors.trans_abs_mean)
        };
        revisits(&thinned).into_iter().filter_map(error).collect()
    }

    /// Errors over those motions only whose scans another run has, too: what is left of a log may
    /// be easier or harder than the whole.
    pub(super) fn errors_over_those_of(&self, other: &Self) -> RelationErrors {
        let has =
            |motion: &&StampedMotion| relation_errors([**motion], &other.trajectory).count > 0;
        let both = self.motions.iter().filter(has).copied();
        relation_errors(both, &self.trajectory)
    }
}

fn held_against(
    motions: &[StampedMotion],
    trajectory: &[(f64, Pose2)],
) -> (RelationErrors, RelationErrors) {
    let is_long = |(from, to, _): &&StampedMotion| (to - from).abs() >= LONG;
    let long = motions.iter().filter(is_long).copied();
    let all = relation_errors(motions.iter().copied(), trajectory);
    (all, relation_errors(long, trajectory))
}

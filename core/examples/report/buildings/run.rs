//! One log, damaged or not, mapped by the default method and compared with its reference.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use slamlab_core::estimation::{
    MapQuality, RelationErrors, StampedMotion, relation_errors, revisits,
};
use slamlab_core::format::poses::read_poses;
use slamlab_core::format::relations;
use slamlab_core::geom::{Length, Pose2};
use slamlab_core::replay::{Log, Replay};
use slamlab_core::slam::Method;

use super::damage::Damage;
use crate::clock::cpu_seconds;
use crate::log_file;
use crate::peak_memory::peak_memory_mb;
use crate::statistics::quantile;

/// Poses within this distance, m, and at least this far apart in time, s, are visits of one place.
const SAME_PLACE: f64 = 2.0;
const OTHER_VISIT: f64 = 20.0;
/// With fewer other visits nothing can be said.
const LEAST_VISITS: usize = 4;
/// A turn counts as the shift of a wall this far away, m: a robot before a door.
const WALL_AWAY: f64 = 2.0;
/// This many consecutive poses have to be wrong: a single scan is not a part of a map.
const ON_END: usize = 3;
/// Stamps closer than this belong to the same scan, s.
const SAME_STAMP: f64 = 1e-3;
/// Relations over at least this time show whether loops close, s.
const LONG: f64 = 20.0;

/// A recorded building.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Building {
    pub(super) name: &'static str,
    pub(super) kind: Kind,
}

/// How it was recorded, and what it is compared with.
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
            Kind::Keyframes => Ok(revisits(&read_poses(&bytes).with_context(name)?.poses)),
        }
    }
}

/// The result of a run.
pub(super) struct Run {
    pub(super) scans: usize,
    pub(super) closures: usize,
    /// Errors over all motions of the reference whose scans are left.
    pub(super) errors: RelationErrors,
    /// The same over those of at least 20 s.
    pub(super) long: RelationErrors,
    motions: Vec<StampedMotion>,
    trajectory: Vec<(f64, Pose2)>,
    /// The part of the trajectory whose scans are drawn in the map.
    drawn: Vec<(f64, Pose2)>,
    /// Multiple of real time, by processor time of the process: meaningful only if nothing else
    /// runs in it.
    pub(super) real_time_factor: f64,
    pub(super) scan_ms_p99: f64,
    /// High-water mark of the process so far, MB.
    pub(super) peak_memory_mb: Option<f64>,
    /// The map's own verdict on itself.
    pub(super) quality: MapQuality,
}

/// A pose of the whole log's map, and the same pose in another map.
struct Visit {
    seconds: f64,
    reference: Pose2,
    mapped: Pose2,
}

impl Visit {
    /// Shift of its walls relative to the median of the other visits of its place, m.
    fn walls_off(&self, visits: &[Self]) -> Option<f64> {
        let place = self.reference.position();
        let others = visits.iter().filter(|other| {
            (other.seconds - self.seconds).abs() > OTHER_VISIT
                && (other.reference.position() - place).length() < SAME_PLACE
        });
        let mut off: Vec<f64> = others
            .map(|other| {
                let truth = self.reference.delta_to(&other.reference);
                let error = truth * self.mapped.delta_to(&other.mapped).inverse();
                error.position().coords.length() + WALL_AWAY * error.heading().abs()
            })
            .collect();
        if off.len() < LEAST_VISITS {
            return None;
        }
        let middle = off.len() / 2;
        let (_, median, _) = off.select_nth_unstable_by(middle, f64::total_cmp);
        Some(*median)
    }
}

impl Run {
    /// # Errors    A log or reference that cannot be read, or that do not belong together.
    pub(super) fn of(building: Building, damage: Damage, data: &Path) -> Result<Self> {
        let [path, _] = building.files(data);
        let begin = cpu_seconds();
        let log = match log_file::read(&path, &log_file::Topics::default())? {
            Log::Carmen(log) => Log::Carmen(damage.apply(log)),
            _ => bail!("{} is no CARMEN log", path.display()),
        };
        let settings = log.settings();
        let (scans, seconds) = (log.scans(), log.duration(&settings.log));
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
        let map = view.map.context("scan matching keeps no map")?;
        let times: Vec<f64> = replay.scan_times().map(|(_, seconds)| seconds).collect();
        let poses: Vec<Pose2> = map.trajectory().map(|(_, pose)| pose).collect();
        let drawn = map.drawn_scans();
        let drawn = drawn.filter_map(|scan| Some((*times.get(scan)?, *poses.get(scan)?)));
        let mut drawn: Vec<(f64, Pose2)> = drawn.collect();
        drawn.sort_by(|a, b| a.0.total_cmp(&b.0));
        Ok(Self {
            quality: map.quality(),
            drawn,
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

    /// How far this map has walls from where the other visits of the same place have them,
    /// according to the map of the whole log: the maximum over the drawn scans of what a few
    /// consecutive scans have in common, m. Relations are few and lie where their authors looked,
    /// and their mean hides one bad room; this looks everywhere, and at each place separately. The
    /// median over the other visits tells a wrong visit from those that it is compared with.
    pub(super) fn walls_off(&self, whole: &Self) -> f64 {
        let mut visits: Vec<Visit> = vec![];
        let mut mapped = self.drawn.iter().peekable();
        for (seconds, reference) in &whole.trajectory {
            while mapped
                .next_if(|(at, _)| at + SAME_STAMP < *seconds)
                .is_some()
            {}
            let Some((_, pose)) = mapped.next_if(|(at, _)| *at < seconds + SAME_STAMP) else {
                continue;
            };
            let visit = Visit {
                seconds: *seconds,
                reference: *reference,
                mapped: *pose,
            };
            visits.push(visit);
        }
        let off: Vec<f64> = (visits.iter())
            .map(|visit| visit.walls_off(&visits).unwrap_or(0.0))
            .collect();
        let in_common = |on_end: &[f64]| on_end.iter().copied().fold(f64::MAX, f64::min);
        off.windows(ON_END).map(in_common).fold(0.0, f64::max)
    }

    /// Errors over only those motions whose scans another run has, too: what is left of a log may
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

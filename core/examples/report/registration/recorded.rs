//! Pairs of scans from recorded buildings, with the map of the log as truth.

use std::collections::BTreeMap;

use anyhow::{Context, Result, bail};
use nalgebra::Point2;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use slamlab_core::geom::{Pose2, unit_vector};
use slamlab_core::registration::Cloud;
use slamlab_core::replay::{Log, Replay};
use slamlab_core::sim::scan_pair::{SHIFT, TURN};
use slamlab_core::slam::Method;

use super::pairs::Pair;
use crate::{Args, log_file};

/// Names and files, in the folder of data.
const LOGS: [(&str, &str); 3] = [
    ("intel", "intel/intel.clf"),
    ("fr079", "fr079/fr079.clf"),
    ("csail", "csail/csail.clf"),
];
/// Maximum number of scans between the two of a pair.
const APART: usize = 10;

/// `count` pairs of each building; none if no data folder was named and the default one is absent.
pub(super) fn pairs(args: &Args, count: usize) -> Result<Vec<(String, Vec<Pair>)>> {
    if args.data.is_none() {
        return Ok(vec![]);
    }
    let folder = args.data();
    let mut sets = vec![];
    for (name, file) in LOGS {
        let scans = placed(&folder.join(file))?;
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        let mut found = vec![];
        while found.len() < count {
            let first = rng.random_range(0..scans.len());
            let second = first + rng.random_range(1..=APART);
            let (Some((a, fixed)), Some((b, moving))) = (scans.get(first), scans.get(second))
            else {
                continue;
            };
            let way = SHIFT * rng.random_range(0.0..1.0_f64).sqrt();
            let shift = unit_vector(rng.random_range(-3.2..3.2)) * way;
            let off = Pose2::new(shift.x, shift.y, rng.random_range(-TURN..TURN));
            let truth = a.delta_to(b);
            found.push(Pair {
                moving: Cloud::scan(moving.clone())?,
                fixed: Cloud::scan(fixed.clone())?,
                start: truth * off,
                truth,
            });
        }
        sets.push((format!("recorded_{name}"), found));
    }
    Ok(sets)
}

/// The points that were hit, in the sensor frame, with the sensor's pose in the final map.
fn placed(path: &std::path::Path) -> Result<Vec<(Pose2, Vec<Point2<f64>>)>> {
    let log = log_file::read(path, &log_file::Topics::default())?;
    let settings = log.settings();
    let mut replay = Replay::new(log, Method::ScanMatching, &settings)?;
    while replay.step()? {}
    let poses: BTreeMap<u64, Pose2> = (replay.trajectory().into_iter())
        .map(|(seconds, pose)| (seconds.to_bits(), pose))
        .collect();
    let Log::Carmen(log) = replay.log() else {
        bail!("{} is no CARMEN log", path.display());
    };
    let mut placed = vec![];
    for scan in &log.scans {
        let Some(pose) = poses.get(&scan.ipc_seconds.to_bits()) else {
            continue;
        };
        let seen = log.scan(scan);
        let hits = seen.bearings.iter().zip(&seen.ranges);
        let hits = hits.filter(|(_, range)| range.is_finite());
        let points = hits.map(|(b, range)| Point2::from(unit_vector(*b) * f64::from(*range)));
        placed.push((*pose * scan.robot_from_sensor, points.collect()));
    }
    let count = placed.len();
    (count > 2 * APART)
        .then_some(placed)
        .with_context(|| format!("{count} scans with poses"))
}

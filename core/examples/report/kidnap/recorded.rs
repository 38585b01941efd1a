//! A robot that starts anywhere in the map of a recorded building.
//!
//! 1. The map: the whole log by scan matching, written as for map_server and read again. Its
//!    trajectory is the truth here.
//! 2. From places evenly spaced along the path, the log is replayed for some metres, with odometry
//!    as recorded and nothing known of the place.

use std::path::Path;

use anyhow::{Context, Result, bail};
use serde_json::json;
use slamlab_core::format::building::BuildingFile;
use slamlab_core::format::carmen::CarmenLog;
use slamlab_core::format::map_server::{self, MapImage, MapMode, OccupancyMap};
use slamlab_core::geom::{Length, Pose2};
use slamlab_core::replay::{Log, Replay};
use slamlab_core::slam::{Method, PriorMap};

use super::Belief;
use crate::statistics::{median, quantile};
use crate::threads::each;
use crate::{Args, Outcome};

/// The log that is used by default, in the folder of recorded data.
const LOG: &str = "intel";
const PLACES: usize = 100;
/// Distance driven from each place, m.
const WAY: f64 = 10.0;

/// The outcome for a robot that started anywhere.
struct Fate {
    /// Distance driven until it was found, m.
    found: Option<f64>,
    /// Whether it was found at the end.
    is_found: bool,
    /// Scans at which it was sure and wrong.
    deceived: usize,
}

pub(super) fn measure(args: &Args, outcome: &mut Outcome) -> Result<()> {
    let folder = args.data();
    let logs = match args.worlds.is_empty() {
        true => vec![LOG.to_owned()],
        false => args.worlds.clone(),
    };
    for log in logs {
        measure_log(&folder, &log, outcome)?;
    }
    Ok(())
}

fn measure_log(folder: &Path, name: &str, outcome: &mut Outcome) -> Result<()> {
    let path = folder.join(name).join(format!("{name}.clf"));
    let bytes =
        std::fs::read(&path).with_context(|| format!("reading {} (--data DIR)", path.display()))?;
    let log = CarmenLog::parse(&bytes).with_context(|| path.display().to_string())?;
    let (map, truth) = mapped(&log)?;
    let starts = starts(&truth)?;
    let fates = each(starts.len(), |i| {
        run(&log, starts[i], &map, &truth, i as u64)
    })?;
    for (start, fate) in starts.iter().zip(&fates) {
        if !fate.is_found || fate.deceived > 0 {
            let Fate {
                found,
                is_found,
                deceived,
            } = fate;
            eprintln!(
                "{name} scan {start}: found {found:?} m, at the end {is_found}, deceived {deceived} scans"
            );
        }
    }
    let places = fates.len() as f64;
    let found: Vec<f64> = fates.iter().map(|fate| fate.found.unwrap_or(WAY)).collect();
    let right = fates.iter().filter(|fate| fate.is_found).count() as f64;
    let deceived = fates.iter().filter(|fate| fate.deceived > 0).count() as f64;
    let key = |quantity: &str| format!("{name}_{quantity}");
    outcome.figure(key("places"), json!(fates.len()));
    outcome.at_least(&key("right_part"), right / places, 0.95);
    outcome.at_most(&key("wrong_and_sure"), deceived, 0.0);
    outcome.figure(key("found_after_m_median"), median(&found));
    outcome.figure(key("found_after_m_p90"), quantile(&found, 0.9));
    Ok(())
}

/// The map of a log, as if read from a file, and the pose at each of its scans.
fn mapped(log: &CarmenLog) -> Result<(PriorMap, Vec<(f64, Pose2)>)> {
    let settings = Log::from(log.clone()).settings();
    let mut replay = Replay::new(log.clone(), Method::ScanMatching, &settings)?;
    while replay.step()? {}
    let map = OccupancyMap::of_grid(replay.session().slam().grid(), MapMode::Trinary)?;
    let files = map_server::write(&map, MapMode::Trinary, MapImage::Png, "map.png")?;
    let map = map_server::read(files.yaml.as_bytes(), &files.image)?;
    let walls = BuildingFile::Map(map).prior_walls()?;
    let map = PriorMap {
        anywhere: true,
        ..PriorMap::of_faces(&walls.faces, walls.sigma, &Pose2::identity())
    };
    Ok((map, replay.trajectory()))
}

/// Scans evenly spaced along the path, with enough of it ahead.
fn starts(truth: &[(f64, Pose2)]) -> Result<Vec<usize>> {
    let mut gone = vec![0.0];
    for pair in truth.windows(2) {
        let step = (pair[1].1.position() - pair[0].1.position()).length();
        gone.push(gone.last().copied().unwrap_or(0.0) + step);
    }
    let ahead = gone.last().copied().unwrap_or(0.0) - 1.5 * WAY;
    if ahead <= 0.0 {
        bail!("the log is too short");
    }
    let scan = |k: usize| gone.partition_point(|&g| g < ahead * k as f64 / PLACES as f64);
    Ok((0..PLACES).map(scan).collect())
}

fn run(
    log: &CarmenLog,
    start: usize,
    map: &PriorMap,
    truth: &[(f64, Pose2)],
    seed: u64,
) -> Result<Fate> {
    let mut part = log.clone();
    part.scans.drain(..start);
    let mut settings = Log::from(part.clone()).settings();
    settings.slam.prior_map = map.clone();
    settings.slam.particles.seed = seed;
    let mut replay = Replay::new(part.clone(), Method::ParticleLocalisation, &settings)?;
    let mut fate = Fate {
        found: None,
        is_found: false,
        deceived: 0,
    };
    let mut scan = 0;
    while replay.session().distance() < WAY && replay.step()? {
        let seconds = part.scans.get(scan).map(|scan| scan.ipc_seconds);
        scan += 1;
        let at = seconds.map(|s| truth.partition_point(|(t, _)| *t < s - 1e-6));
        let Some((_, truth)) = at.and_then(|at| truth.get(at)) else {
            continue;
        };
        let belief = Belief::of(replay.session(), truth);
        fate.is_found = belief.is_found();
        fate.deceived += usize::from(belief.is_deceived());
        if fate.is_found && fate.found.is_none() {
            fate.found = Some(replay.session().distance());
        }
    }
    Ok(fate)
}

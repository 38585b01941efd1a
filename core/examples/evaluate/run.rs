//! One log by one method: reads, replays, measures, writes the requested files, prints the figures.

use std::ops::Range;
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

use anyhow::{Context, bail, ensure};
use serde_json::{Value, json};
use slamlab_core::estimation::{DriveFit, FittedParameter, ScanMatcher};
use slamlab_core::format::preset::{self, FittedLine, PresetFile};
use slamlab_core::geom::Pose2;
use slamlab_core::replay::Replay;
use slamlab_core::settings::{Scope, Source};
use slamlab_core::slam::{Method, PriorMapFit};

use crate::accuracy::References;
use crate::peak_memory::peak_memory_mb;
use crate::poses::{self, Poses};
use crate::{Arguments, log_file, options, print, prior_map, quality, worth};

/// The exit status says whether map and poses can be trusted.
pub(crate) fn evaluate(
    log_path: &Path,
    method: &str,
    arguments: &Arguments,
) -> anyhow::Result<ExitCode> {
    let method: Method = method.parse().context("--method")?;
    check(log_path, arguments)?;
    let truth = arguments.truth.as_deref();
    let references = References::read(arguments.relations.as_deref(), truth)?;
    let start = Instant::now();
    let poses = Poses::read(arguments)?;
    let mut log = log_file::read(log_path, &arguments.topics)?;
    if let Some(poses) = &poses {
        log = poses.drive(log)?;
    }
    let scans = log.scans();
    let mut settings = log.settings();
    let scope = Scope {
        source: Source::Recording,
        method: log.method(method),
    };
    let defaults = settings.clone();
    let saved = arguments.saved_map.read(&method)?;
    if let Some(experiment) = &saved {
        let those = experiment.settings.clone();
        settings.take(&scope, those).context("--go-on")?;
    }
    arguments.changes.apply_to(&mut settings, &scope)?;
    let changes = settings.changes_from(&defaults);
    let log_seconds = log.duration(&settings.log);
    match (&arguments.prior_map, method) {
        (Some(path), method) if method.needs_prior_map() => {
            settings.slam.prior_map = prior_map::read(path, arguments.svg_unit, &arguments.start)?;
        }
        (None, method) if method.needs_prior_map() => {
            bail!("--method {} needs a map: --prior-map FILE", method.name())
        }
        (Some(_), _) => bail!(
            "--prior-map needs a --method that finds the robot in a map, as prior-map, not {}",
            method.name()
        ),
        (None, _) => {}
    }
    let goes_on = saved.is_some();
    settings.slam.saved_map = saved.map(|saved| arguments.saved_map.earlier(saved));
    let mut replay = Replay::new(log, method, &settings)?;
    settings.slam.saved_map = None;
    if let Some(poses) = &poses {
        poses.hold(&mut replay)?;
    }
    ensure!(
        replay.session().slam().method() == method,
        "--method {}: {}",
        method.name(),
        replay.take_notes().join("; ")
    );
    let part = arguments.scans.clone().unwrap_or(0..usize::MAX);
    ensure!(
        part.start < scans,
        "--scans begins at scan {}, and the log has {scans}",
        part.start
    );
    replay.skip(part.start);
    let slam = replay.session().slam();
    arguments.outputs.check_method(slam, method.name())?;
    let mut scan_ms = Vec::with_capacity(scans);
    let mut began = Instant::now();
    let mut placed_after = None;
    while scan_ms.len() < part.len() && replay.step()? {
        let map = replay.session().slam().view().map;
        if placed_after.is_none() && map.is_some_and(ScanMatcher::is_placed) {
            placed_after = Some(scan_ms.len() + 1);
        }
        scan_ms.push(began.elapsed().as_secs_f64() * 1e3);
        began = Instant::now();
    }
    for note in replay.take_notes() {
        eprintln!("{}: {note}", log_path.display());
    }
    let left_out = replay
        .log()
        .left_out()
        .map(|left_out| json!({ "ranges": left_out.ranges.count, "lines": left_out.lines.count }));
    let view = replay.session().slam().view();
    let (fits, pose_quality) = (view.prior_map_fit, view.pose_quality);
    let lost = worth::lost(replay.session().slam());
    let log = log_path.display();
    if let Some(line) = lost {
        eprintln!("{log}: {line}");
    }
    let prior_map_overlap = fits.and_then(PriorMapFit::part);
    let wall_seconds = start.elapsed().as_secs_f64();
    let quality = replay.session().slam().view().map.map(ScanMatcher::quality);
    for line in quality.iter().flat_map(quality::words) {
        eprintln!("{log}: {line}");
    }
    let trajectory = replay.trajectory();
    let relations = references.relation_errors(&trajectory)?;
    let truth = references.trajectory_errors(&trajectory)?;
    let false_closures = references.false_closures(&replay);
    for closure in false_closures.iter().flatten() {
        eprintln!("{log}: false closure: {closure}");
    }
    let fit = arguments.fit.as_ref().map(|_| replay.fit());
    let map = replay.session().slam().view().map;
    if goes_on && !map.is_some_and(ScanMatcher::is_placed) {
        eprintln!("{log}: it is not proved where in the saved map this log was recorded");
    }
    save(
        log_path,
        arguments,
        &replay,
        &trajectory,
        fit.as_ref(),
        changes,
    )?;
    let figures = json!({
        "log": log.to_string(),
        "method": method.name(),
        "scans": scans,
        "left_out": left_out,
        "log_seconds": log_seconds,
        "wall_seconds": wall_seconds,
        "real_time_factor": log_seconds / wall_seconds,
        "scan_ms": {
            "mean": mean(&scan_ms),
            "median": quantile(&mut scan_ms, 0.5),
            "p99": quantile(&mut scan_ms, 0.99),
        },
        "peak_memory_mb": peak_memory_mb(),
        "loop_closures": replay.session().slam().view().loop_closures,
        "closures": map.map(worth::closures),
        "placed_after_scans": placed_after.filter(|_| goes_on),
        "false_closures": false_closures.map(|closures| closures.len()),
        "prior_map_overlap": prior_map_overlap,
        "localisation": pose_quality.map(|quality| quality.localisation.name()),
        "quality": quality.as_ref().map(quality::figures),
        "relations": relations,
        "truth": truth,
        "poses": poses::figures(&replay),
        "fit": fit.as_ref().map(fitted),
        "state_hash": format!("{:016x}", replay.state_hash()),
    });
    print(&figures, arguments.json)?;
    let is_believed = quality.as_ref().is_none_or(worth::is_believed);
    Ok(match is_believed && lost.is_none() {
        true => ExitCode::SUCCESS,
        false => ExitCode::from(worth::NOT_BELIEVED),
    })
}

/// Detects before a long run what would fail at its end.
fn check(log: &Path, arguments: &Arguments) -> anyhow::Result<()> {
    let mut read = options::given([
        ("--relations", &arguments.relations),
        ("--truth", &arguments.truth),
        ("--poses", &arguments.poses),
        ("--preset", &arguments.changes.preset),
    ]);
    read.push(("--log", log.to_owned()));
    read.extend(arguments.saved_map.read_paths());
    let mut written = arguments.outputs.paths();
    written.extend(arguments.saved_map.written_paths());
    written.extend(options::given([("--fit", &arguments.fit)]));
    options::check(read, written)
}

fn save(
    log: &Path,
    arguments: &Arguments,
    replay: &Replay,
    trajectory: &[(f64, Pose2)],
    fit: Option<&DriveFit>,
    changes: Vec<(String, f64)>,
) -> anyhow::Result<()> {
    let poses = trajectory.iter().copied();
    let slam = replay.session().slam();
    let (carmen, revolutions) = (|| replay.carmen_log(), || replay.revolution_log());
    let mut files = arguments.outputs.files(slam, poses, carmen, revolutions)?;
    if let (Some(path), Some(fit)) = (&arguments.fit, fit) {
        let settings = fit.settings().into_iter();
        let preset = PresetFile {
            name: format!("fitted to {}", log.display()),
            settings: settings.map(|(key, n)| (key.to_owned(), n)).collect(),
        };
        let text = preset::write(&preset, &fitted_lines(fit));
        files.push((path.clone(), text.into()));
    }
    files.extend(
        arguments
            .saved_map
            .file(log, || replay.saved_map(), changes)?,
    );
    options::write(&files)
}

/// The parameters of a fit, as text for people.
fn fitted_lines(fit: &DriveFit) -> Vec<FittedLine> {
    let line = |p: FittedParameter| FittedLine {
        name: p.name.to_owned(),
        unit: p.unit.to_owned(),
        value: p.value,
        sigma: Some(p.sigma).filter(|sigma| sigma.is_finite()),
        unknown: p.unknown.to_owned(),
    };
    fit.parameters().into_iter().map(line).collect()
}

fn fitted(fit: &DriveFit) -> Value {
    let odometry = fit.odometry.as_ref().ok();
    json!({
        "parameters": fitted_lines(fit),
        "reasons": fit.reasons(),
        "legs": odometry.map(|o| o.legs),
        "left_out": odometry.map(|o| o.left_out),
    })
}

fn mean(values: &[f64]) -> Option<f64> {
    let count = Some(values.len()).filter(|count| *count > 0)?;
    Some(values.iter().sum::<f64>() / count as f64)
}

fn quantile(values: &mut [f64], fraction: f64) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let last = values.len().checked_sub(1)?;
    values
        .get((last as f64 * fraction).round() as usize)
        .copied()
}

/// A part of a log, `FROM..TO`.
pub(crate) fn scans(text: &str) -> anyhow::Result<Range<usize>> {
    let (from, to) = text.split_once("..").context("expected FROM..TO")?;
    let number = |word: &str, otherwise: usize| match word.trim() {
        "" => Ok(otherwise),
        word => word
            .parse()
            .with_context(|| format!("`{word}` is no number")),
    };
    let (from, to) = (number(from, 0)?, number(to, usize::MAX)?);
    if from >= to {
        bail!("{from} does not come before {to}");
    }
    Ok(from..to)
}

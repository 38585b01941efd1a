//! Replays a recorded log (CARMEN, or MCAP of the bridge) and prints how well and how fast it was
//! mapped.
//!
//! `cargo run --release -p slamlab-core --example evaluate -- --log FILE [--relations FILE]
//! [--method NAME] [--tum OUT] [--map OUT.pgm|OUT.png] [--map-mode MODE] [--og-map OUT] [--carmen
//! OUT] [--g2o OUT] [--preset FILE] [--fit OUT.json] [--set KEY=NUMBER] [--prior-map MAP.yaml
//! [--start X,Y,DEGREES|anywhere]] [--json]`
//!
//! Or solves a pose graph, from the file's own poses:
//! `cargo run --release -p slamlab-core --example evaluate -- --graph FILE.g2o [--out OUT.g2o]`
//!
//! The exit status is 2 where the map is torn, and 1 where something failed.
//!
//! The core has no files and no clock; this program does the reading, the writing and the timing.
#![allow(
    clippy::disallowed_methods,
    reason = "the edge: files and the clock are here and nowhere below"
)]

mod graph;
#[path = "../shared/options.rs"]
mod options;
#[path = "../shared/prior_map.rs"]
mod prior_map;
mod quality;

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use anyhow::{Context, bail};
use clap::Parser;
use serde_json::{Value, json};
use slamlab_core::estimation::{
    DriveFit, FittedParameter, MapVerdict, RelationErrors, ScanMatcher, relation_errors,
};
use slamlab_core::format::preset::{self, FittedLine, PresetFile};
use slamlab_core::format::relations::{self, Relation};
use slamlab_core::geom::Pose2;
use slamlab_core::replay::{Log, LogReader, Replay};
use slamlab_core::settings::{Scope, Source};
use slamlab_core::slam::{Method, PriorMapFit};

/// Relations over at least this time show whether loops close, s.
const LONG: f64 = 20.0;

/// Replays a recorded log and measures the result.
#[derive(Parser)]
#[command(after_help = "Exit status: 0, 2 where the map is torn, 1 where something failed.")]
struct Arguments {
    /// CARMEN log (.log, .clf), or recording of the bridge (.mcap).
    #[arg(long, required_unless_present = "graph")]
    log: Option<PathBuf>,
    /// Instead of a log: a pose graph (.g2o), which is solved.
    #[arg(long, value_name = "FILE", conflicts_with = "log")]
    graph: Option<PathBuf>,
    /// Write the solved graph of `--graph`, with the names and edges of the file.
    #[arg(long, value_name = "FILE", requires = "graph")]
    out: Option<PathBuf>,
    /// Reference relations (.relations).
    #[arg(long)]
    relations: Option<PathBuf>,
    /// odometry, line-ekf, scan-matching, prior-map or particle-localisation.
    #[arg(long, default_value = "scan-matching")]
    method: String,
    /// The map that `--method prior-map` or `particle-localisation` finds the robot in: YAML of ROS
    /// map_server, OGmap.txt, floor plan (.svg) or world (.json).
    #[arg(long)]
    prior_map: Option<PathBuf>,
    /// Metres in a unit of a floor plan; by default what the drawing says of itself.
    #[arg(long, value_name = "METRES")]
    svg_unit: Option<f64>,
    /// Where the log begins in that map, as `x,y,heading` in metres and degrees. The default is
    /// where a map begins that was made of the same log. `anywhere`: it has to be found.
    #[arg(long, default_value = "0,0,0", value_name = "X,Y,DEGREES|anywhere", value_parser = prior_map::start, allow_hyphen_values = true)]
    start: prior_map::Start,
    #[command(flatten)]
    changes: options::Changes,
    #[command(flatten)]
    outputs: options::Outputs,
    /// Fit odometry and ranges to the drive, print them, and write what is known as a preset here.
    #[arg(long)]
    fit: Option<PathBuf>,
    /// Print one JSON object on one line.
    #[arg(long)]
    json: bool,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let done = match (&arguments.graph, &arguments.log) {
        (Some(graph), _) => graph::solve(graph, arguments.out.as_deref(), arguments.json)
            .map(|()| ExitCode::SUCCESS),
        (None, Some(log)) => evaluate(log, &arguments),
        (None, None) => Err(anyhow::anyhow!("neither --log nor --graph")),
    };
    match done {
        Ok(code) => code,
        Err(error) => {
            eprintln!("evaluate: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn evaluate(log_path: &Path, arguments: &Arguments) -> anyhow::Result<ExitCode> {
    let method: Method = arguments.method.parse().context("--method")?;
    check(log_path, arguments)?;
    let truth = arguments.relations.as_deref().map(read_relations);
    let truth = truth.transpose()?;
    let start = Instant::now();
    let log = read_log(log_path)?;
    let (scans, log_seconds) = (log.scans(), log.duration());
    let mut settings = log.settings();
    let scope = Scope {
        source: Source::Recording,
        method: log.method(method),
    };
    arguments.changes.apply_to(&mut settings, &scope)?;
    match (&arguments.prior_map, method) {
        (Some(path), method) if method.needs_prior_map() => {
            settings.slam.prior_map = prior_map::read(path, arguments.svg_unit, &arguments.start)?;
        }
        (None, method) if method.needs_prior_map() => {
            bail!("--method {} needs a map: --prior-map FILE", method.name())
        }
        (Some(_), _) => bail!(
            "--prior-map needs --method prior-map or particle-localisation, not {}",
            arguments.method
        ),
        (None, _) => {}
    }
    let mut replay = Replay::new(log, method, &settings)?;
    let slam = replay.session().slam();
    arguments.outputs.check_method(slam, method.name())?;
    let mut scan_ms = Vec::with_capacity(scans);
    let mut began = Instant::now();
    while replay.step()? {
        scan_ms.push(began.elapsed().as_secs_f64() * 1e3);
        began = Instant::now();
    }
    for note in replay.take_notes() {
        eprintln!("{}: {note}", log_path.display());
    }
    let fits = replay.session().slam().view().prior_map_fit;
    if fits.is_some_and(PriorMapFit::is_misfit) {
        let log = log_path.display();
        eprintln!("{log}: at its end, what is seen does not stand in the prior map");
    }
    let pose_quality = replay.session().slam().view().pose_quality;
    let prior_map_overlap = fits.and_then(PriorMapFit::part);
    let wall_seconds = start.elapsed().as_secs_f64();
    let quality = replay.session().slam().view().map.map(ScanMatcher::quality);
    for line in quality.iter().flat_map(quality::words) {
        eprintln!("{}: {line}", log_path.display());
    }
    let trajectory = replay.trajectory();
    let relations = truth.map(|truth| measure(&truth, &trajectory));
    let relations = relations.transpose()?;
    let fit = arguments.fit.as_ref().map(|_| replay.fit());
    save(log_path, arguments, &replay, &trajectory, fit.as_ref())?;
    let figures = json!({
        "log": log_path.display().to_string(),
        "method": method.name(),
        "scans": scans,
        "log_seconds": log_seconds,
        "wall_seconds": wall_seconds,
        "real_time_factor": log_seconds / wall_seconds,
        "scan_ms": { "median": quantile(&mut scan_ms, 0.5), "p99": quantile(&mut scan_ms, 0.99) },
        "peak_memory_mb": peak_memory_mb(),
        "loop_closures": replay.session().slam().view().loop_closures,
        "prior_map_overlap": prior_map_overlap,
        "localisation": pose_quality.map(|quality| quality.localisation.name()),
        "quality": quality.as_ref().map(quality::figures),
        "relations": relations,
        "fit": fit.as_ref().map(fitted),
        "state_hash": format!("{:016x}", replay.state_hash()),
    });
    print(&figures, arguments.json)?;
    Ok(match quality {
        Some(quality) if quality.verdict == MapVerdict::Torn => ExitCode::from(quality::TORN),
        _ => ExitCode::SUCCESS,
    })
}

fn print(figures: &Value, on_one_line: bool) -> anyhow::Result<()> {
    let mut out = std::io::stdout().lock();
    let printed = match on_one_line {
        true => writeln!(out, "{figures}"),
        false => writeln!(out, "{figures:#}"),
    };
    printed.context("cannot write to standard output")
}

/// Finds what would go wrong at the end of a long run before it begins.
fn check(log: &Path, arguments: &Arguments) -> anyhow::Result<()> {
    let (relations, preset) = (&arguments.relations, &arguments.changes.preset);
    let mut read = options::given([("--relations", relations), ("--preset", preset)]);
    read.push(("--log", log.to_owned()));
    let mut written = arguments.outputs.paths();
    written.extend(options::given([("--fit", &arguments.fit)]));
    options::check(read, written)
}

fn save(
    log: &Path,
    arguments: &Arguments,
    replay: &Replay,
    trajectory: &[(f64, Pose2)],
    fit: Option<&DriveFit>,
) -> anyhow::Result<()> {
    let poses = trajectory.iter().copied();
    let slam = replay.session().slam();
    let mut files = arguments
        .outputs
        .files(slam, poses, || replay.carmen_log())?;
    if let (Some(path), Some(fit)) = (&arguments.fit, fit) {
        let settings = fit.settings().into_iter();
        let preset = PresetFile {
            name: format!("fitted to {}", log.display()),
            settings: settings.map(|(key, n)| (key.to_owned(), n)).collect(),
        };
        let text = preset::write(&preset, &fitted_lines(fit));
        files.push((path.clone(), text.into()));
    }
    options::write(&files)
}

/// The parameters of a fit, for people.
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

/// Reads in chunks, so that the text is never in memory as a whole.
fn read_log(path: &Path) -> anyhow::Result<Log> {
    use std::io::BufRead;
    let name = || format!("log {}", path.display());
    let file = std::fs::File::open(path).with_context(name)?;
    let mut file = std::io::BufReader::with_capacity(1 << 16, file);
    let mut reader = LogReader::default();
    loop {
        let chunk = file.fill_buf().with_context(name)?;
        if chunk.is_empty() {
            return reader.finish().with_context(name);
        }
        reader.push(chunk).with_context(name)?;
        let count = chunk.len();
        file.consume(count);
    }
}

fn read_relations(path: &Path) -> anyhow::Result<Vec<Relation>> {
    let name = || format!("relations {}", path.display());
    relations::parse(&std::fs::read(path).with_context(name)?).with_context(name)
}

/// # Errors    If the relations are those of another log: no figure at all would look like no error
/// at all.
fn measure(truth: &[Relation], trajectory: &[(f64, Pose2)]) -> anyhow::Result<Value> {
    let chosen = |long: bool| {
        let relations = truth
            .iter()
            .filter(move |r| !long || (r.to_seconds - r.from_seconds).abs() >= LONG)
            .map(|r| (r.from_seconds, r.to_seconds, r.motion));
        let errors = relation_errors(relations, trajectory);
        (errors.count > 0).then(|| figures(&errors))
    };
    let Some(all) = chosen(false) else {
        bail!(
            "none of the {} relations joins two scans of the log; they belong to another one, or it is cut short",
            truth.len()
        );
    };
    Ok(json!({ "all": all, "long": chosen(true) }))
}

fn figures(errors: &RelationErrors) -> Value {
    let degrees = 1.0_f64.to_degrees();
    json!({
        "count": errors.count,
        "left_out": errors.left_out,
        "trans_abs_mean_m": errors.trans_abs_mean,
        "trans_abs_std_m": errors.trans_abs_std,
        "trans_sq_mean_m2": errors.trans_sq_mean,
        "rot_abs_mean_deg": errors.rot_abs_mean * degrees,
        "rot_abs_std_deg": errors.rot_abs_std * degrees,
        "rot_sq_mean_deg2": errors.rot_sq_mean * degrees * degrees,
    })
}

fn quantile(values: &mut [f64], fraction: f64) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let last = values.len().checked_sub(1)?;
    values
        .get((last as f64 * fraction).round() as usize)
        .copied()
}

/// High-water mark of the resident memory, MB; `None` where the system does not tell.
fn peak_memory_mb() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    let kilobytes: f64 = line.split_ascii_whitespace().nth(1)?.parse().ok()?;
    Some(kilobytes / 1024.0)
}

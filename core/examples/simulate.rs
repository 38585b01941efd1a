//! Runs one experiment in the simulated world and prints its figures.
//!
//! The exit status is 0; 3 if the map is torn, nothing was matched to it or the robot is lost in
//! the given map; 4 if a lesson's goal is missed; and 1 if something failed.
//!
//! ```text
//! cargo run --release -p slamlab-core --example simulate -- --world office --sensor lidar --seed 7 --mode explore --json
//! ```

#![allow(
    clippy::disallowed_methods,
    reason = "an example reads files and the clock; the core does not"
)]

#[path = "shared/options.rs"]
mod options;
#[path = "shared/prior_map.rs"]
mod prior_map;
#[path = "shared/quality.rs"]
mod quality;
#[path = "shared/saved_map.rs"]
mod saved_map;
#[path = "shared/worth.rs"]
mod worth;

use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use anyhow::{Context, Result, bail};
use clap::{Parser, ValueEnum};
use nalgebra::Point2;
use serde_json::{Value, json};
use slamlab_core::estimation::MapQuality;
use slamlab_core::experiment::{Experiment, ExperimentConfig, Link};
use slamlab_core::format::revolution_log::RevolutionLog;
use slamlab_core::format::{floor_plan, tum};
use slamlab_core::geom::{Length, Pose2, Segment};
use slamlab_core::lesson::{Goal, Grade, LESSONS, Lesson, Mark};
use slamlab_core::pilot::{Mode, Status};
use slamlab_core::settings::{Scope, Settings, Source};
use slamlab_core::sim::{SensorKind, World, reachable_area, worlds};
use slamlab_core::slam::{Method, PriorMap};

use prior_map::{Start, load};

/// A robot in a simulated world: it maps, finds itself, plans and drives.
#[derive(Parser)]
#[command(
    after_help = "Exit status: 0, 3 where the map is torn, nothing was matched to it or the robot is lost in it, 4 where a lesson's goal is missed, 1 where something failed."
)]
struct Args {
    /// A built-in world, or the path of a world file (.json), of a map of ROS map_server (.yaml),
    /// of an OGmap.txt, of a submap (.smap) or of a floor plan (.svg).
    #[arg(long, default_value = "office")]
    world: String,
    /// Do the experiment of a link again, as the page copies it: the address, or what stands behind
    /// its `#`; or `@FILE`, a file with it. It fails where another state comes of it than the link
    /// says.
    #[arg(long, value_name = "LINK|@FILE", conflicts_with_all = ["world", "sensor", "seed", "mode", "goal", "method", "prior_map", "start", "kidnap", "settings", "preset", "go_on"])]
    link: Option<String>,
    /// Do a lesson: its run, with what `--method` and `--set` mend. Graded when its errand is over
    /// or its time is up; the exit status is 4 where a goal is missed.
    #[arg(long, value_name = "NAME", value_parser = lesson, conflicts_with_all = ["link", "world", "sensor", "seed", "mode", "goal", "prior_map", "start", "kidnap", "preset", "go_on", "max_seconds"])]
    lesson: Option<&'static Lesson>,
    /// Metres in a unit of a floor plan; by default what the drawing says of itself.
    #[arg(long, value_name = "METRES")]
    svg_unit: Option<f64>,
    /// What the robot sees with: lidar, sick, rangers or sonar; the world's own sensor by default.
    #[arg(long)]
    sensor: Option<SensorKind>,
    /// The same seed gives the same run, to the bit; the world's own seed by default.
    #[arg(long)]
    seed: Option<u64>,
    /// What the robot does.
    #[arg(long, default_value = "explore")]
    mode: Errand,
    /// Goal of `--mode goto` in the world, as `x,y` in metres; the world's own goal by default.
    #[arg(long, allow_hyphen_values = true)]
    goal: Option<String>,
    /// How the robot estimates its pose: odometry, line-ekf, scan-matching, grid-particles,
    /// prior-map, particle-localisation or histogram-localisation; line-ekf, or the lesson's own,
    /// by default.
    #[arg(long)]
    method: Option<String>,
    /// The map that `--method prior-map`, `particle-localisation` or `histogram-localisation` finds
    /// the robot in: YAML of ROS map_server, OGmap.txt, submap (.smap), floor plan (.svg) or world
    /// (.json). By default the walls of the world.
    #[arg(long, value_name = "FILE")]
    prior_map: Option<PathBuf>,
    /// Where the robot begins in that map, as `x,y,heading` in metres and degrees. By default where
    /// the map shows the walls of the world: in the frame of the world, as in a plan of it, or in
    /// one that begins where the robot does, as of a map that was made in it. `anywhere`: it has to
    /// be found, also among the walls of the world.
    #[arg(long, value_name = "X,Y,DEGREES|anywhere", value_parser = prior_map::start, allow_hyphen_values = true)]
    start: Option<Start>,
    /// Carry the robot elsewhere without telling it, after so many simulated seconds; can be given
    /// several times.
    #[arg(long, value_name = "SECONDS", value_parser = duration, allow_hyphen_values = true)]
    kidnap: Vec<f64>,
    /// Simulated seconds after which the run is given up.
    #[arg(long, default_value = "3600", value_parser = duration, allow_hyphen_values = true)]
    max_seconds: f64,
    #[command(flatten)]
    saved_map: saved_map::SavedMapOptions,
    #[command(flatten)]
    changes: options::Changes,
    /// Write the vector map as FILE.svg, FILE.dxf and FILE.geojson.
    #[arg(long, value_name = "FILE")]
    plan: Option<String>,
    #[command(flatten)]
    outputs: options::Outputs,
    /// Write where the robot truly was at each scan, as a TUM trajectory: beside the log of
    /// `--carmen`, for `evaluate`.
    #[arg(long, value_name = "FILE")]
    truth: Option<PathBuf>,
    /// Print one JSON object instead of a table.
    #[arg(long)]
    json: bool,
}

/// A place of a prior map shows a wall of the world within this distance, m: a few cells of a grid.
const ON_WALL: f64 = 0.15;
/// Walls are tested in pieces of this length, m.
const PIECE: f64 = 0.1;
/// Exit status if a lesson's goal is missed.
const NOT_MENDED: u8 = 4;
/// A map of which a smaller part shows walls of the world may be of another world.
const LEAST_SHOWN: f64 = 0.7;

#[derive(Clone, Copy, ValueEnum)]
enum Errand {
    Explore,
    Goto,
}

fn lesson(name: &str) -> Result<&'static Lesson, String> {
    let names = || LESSONS.iter().map(|lesson| lesson.name).collect::<Vec<_>>();
    Lesson::named(name).ok_or_else(|| format!("expected one of {}", names().join(", ")))
}

fn duration(text: &str) -> Result<f64, &'static str> {
    let is_duration = |s: &f64| s.is_finite() && *s > 0.0;
    let seconds = text.parse().ok().filter(is_duration);
    seconds.ok_or("expected a finite number of seconds above 0")
}

fn main() -> ExitCode {
    match run(Args::parse()) {
        Ok(code) => code,
        Err(error) => {
            eprintln!("simulate: {error:#}");
            ExitCode::FAILURE
        }
    }
}

/// The run of a link or a lesson, as if its parts had been given as options.
fn linked(mut args: Args) -> Result<(Args, Option<Link>)> {
    let method = args.method.as_deref().map(str::parse);
    let link = match (args.lesson, &args.link) {
        (Some(lesson), _) => {
            let method = method.transpose().context("--method")?;
            let mended = lesson.mended(method, &args.changes.settings);
            args.max_seconds = lesson.seconds;
            mended.with_context(|| format!("--lesson {}", lesson.name))?
        }
        (None, Some(given)) => {
            let text = match given.strip_prefix('@') {
                Some(path) => {
                    fs::read_to_string(path).with_context(|| format!("--link: {path}"))?
                }
                None => given.clone(),
            };
            Link::read(&text).context("--link")?
        }
        (None, None) => return Ok((args, None)),
    };
    (args.sensor, args.seed) = (Some(link.sensor), Some(link.seed));
    args.method = Some(link.method.name().to_owned());
    args.changes.settings.clone_from(&link.settings);
    Ok((args, Some(link)))
}

fn run(args: Args) -> Result<ExitCode> {
    let (args, link) = linked(args)?;
    let args = &args;
    let method = args.method.as_deref().map(str::parse);
    let method = method.unwrap_or(Ok(Method::LineEkf)).context("--method")?;
    let (prior_map, preset) = (&args.prior_map, &args.changes.preset);
    let mut read = options::given([("--prior-map", prior_map), ("--preset", preset)]);
    read.extend(args.saved_map.read_paths());
    let mut written = args.outputs.paths();
    written.extend(args.saved_map.written_paths());
    written.extend(options::given([("--truth", &args.truth)]));
    options::check(read, written)?;
    let world = match &link {
        Some(link) => link.world.load().context("--link")?,
        None => load_world(args)?,
    };
    let mode = match args.mode {
        Errand::Explore if args.goal.is_some() => bail!("--goal is for `--mode goto` only"),
        Errand::Explore => Mode::Explore,
        Errand::Goto => Mode::GoTo(goal_in_map(args, &world)?),
    };
    let sensor = args.sensor.unwrap_or(world.sensor);
    let (name, seed) = (world.name.clone(), args.seed.unwrap_or(world.seed));
    let robot = world.robot.model();
    let area = reachable_area(&world, robot.radius(), 0.05);
    let mut settings = Settings::of(sensor.model(), &robot);
    let scope = Scope {
        source: Source::Simulation,
        method,
    };
    let defaults = settings.clone();
    let saved = args.saved_map.read(&method)?;
    if let Some(saved) = &saved {
        let those = saved.settings.clone();
        settings.take(&scope, those).context("--go-on")?;
    }
    args.changes.apply_to(&mut settings, &scope)?;
    let changes = settings.changes_from(&defaults);
    settings.slam.saved_map = saved.map(|saved| args.saved_map.earlier(saved));
    let mut config = ExperimentConfig {
        method,
        mode,
        ..ExperimentConfig::of(&settings, world, robot, seed)
    };
    if let Some(path) = &args.prior_map {
        // The map's frame begins where the robot does, whether it knows that or not, so figures are
        // comparable.
        config.slam.prior_map = match args.start {
            Some(Start::At(start)) => prior_map::read(path, args.svg_unit, &Start::At(start))?,
            Some(Start::Anywhere) | None => placed_in_world(path, args, &config.world)?,
        };
    } else if let Some(Start::At(_)) = args.start {
        bail!("--start: a pose is one in the map of --prior-map, which is not given");
    }
    config.slam.prior_map.anywhere = matches!(args.start, Some(Start::Anywhere));
    if let Some(link) = &link {
        (config.mode, config.cycle) = (link.mode, link.cycle);
    }
    let mut experiment = Experiment::new(config)?;
    experiment.follow(link.iter().flat_map(|link| link.actions.clone()));
    let result = link.as_ref().and_then(|link| link.result);
    let slam = experiment.session().slam();
    args.outputs.check_method(slam, method.name())?;
    let mut kidnaps = args.kidnap.clone();
    kidnaps.sort_by(f64::total_cmp);
    let mut kidnaps = kidnaps.iter().peekable();
    let begin = Instant::now();
    let goes_on = |experiment: &Experiment| match result {
        Some((until, _)) => experiment.periods() < until,
        None => !experiment.session().status().is_over(),
    };
    while goes_on(&experiment) && experiment.seconds() < args.max_seconds {
        experiment.step()?;
        if kidnaps.next_if(|at| experiment.seconds() >= **at).is_some() {
            experiment.kidnap(None)?;
        }
    }
    let wall_seconds = begin.elapsed().as_secs_f64();
    write_files(args, &experiment, &name, changes)?;
    let figures = experiment.figures(&area);
    let finished = matches!(experiment.session().status(), Status::Finished(_));
    let reason = if experiment.session().status().is_over() {
        experiment.session().status().to_string()
    } else {
        format!("given up after {} simulated seconds", args.max_seconds)
    };
    let mode_name = match args.mode {
        Errand::Explore => "explore",
        Errand::Goto => "goto",
    };
    let mut report = json!({
        "world": name,
        "sensor": sensor.name(),
        "seed": seed,
        "mode": mode_name,
        "method": method.name(),
        "finished": finished,
        "reason": reason,
        "sim_seconds": figures.sim_seconds,
        "wall_seconds": wall_seconds,
        "real_time_factor": figures.sim_seconds / wall_seconds,
        "explored_fraction": figures.explored_fraction,
        "contacts": figures.contacts.total(),
        "contacts_wall": figures.contacts.walls,
        "contacts_drove_into_person": figures.contacts.drove_into_mover,
        "contacts_person_walked_in": figures.contacts.mover_walked_in,
        "position_error_m": figures.position_error,
        "heading_error_deg": figures.heading_error.to_degrees(),
        "odometry_error_m": figures.odometry_error,
        "ate_rmse_m": figures.ate_rmse,
        "nees_mean": figures.nees_mean,
        "features": figures.features,
        "distance_m": figures.distance,
        "state_hash": format!("{:016x}", figures.state_hash),
    });
    let grade = args.lesson.map(|lesson| lesson.grade(&experiment, &area));
    report["grade"] = grade.as_ref().map(marks).into();
    if let Some(quality) = experiment.session().slam().view().pose_quality {
        report["localisation"] = quality.localisation.name().into();
    }
    let cov = experiment.session().estimate().cov;
    let cov = cov.fixed_view::<2, 2>(0, 0).into_owned();
    // Along the most uncertain direction, according to the filter itself.
    report["position_sigma_m"] = cov.symmetric_eigenvalues().max().max(0.0).sqrt().into();
    if let Mode::GoTo(goal) = mode {
        let off = (goal - experiment.truth().position()).length();
        report["goal_distance_m"] = off.into();
    }
    if let Some((until, hash)) = result {
        let (found, periods) = (experiment.state_hash(), experiment.periods());
        if periods < until {
            bail!("--link: it goes on for {until} periods, and was given up after {periods}");
        }
        if found != hash {
            bail!("--link: it says that {hash:016x} comes of it, and {found:016x} came");
        }
        report["link"] = "the same, to the bit".into();
    }
    if let Err(full) = experiment.session().slam().grid().is_whole() {
        eprintln!("simulate: {full}");
    }
    let quality = judged(&experiment);
    report["quality"] = quality.as_ref().map(quality::figures).into();
    let map = experiment.session().slam().view().map;
    report["closures"] = map.map(worth::closures).into();
    let lost = worth::lost(experiment.session().slam());
    let doubts = quality.iter().flat_map(quality::words);
    for line in doubts.chain(lost.map(str::to_owned)) {
        eprintln!("simulate: {line}");
    }
    print(&report, args.json).context("cannot write to standard output")?;
    if let Some(grade) = grade {
        return Ok(match grade.is_passed() {
            true => ExitCode::SUCCESS,
            false => ExitCode::from(NOT_MENDED),
        });
    }
    let is_believed = quality.as_ref().is_none_or(worth::is_believed);
    Ok(match is_believed && lost.is_none() {
        true => ExitCode::SUCCESS,
        false => ExitCode::from(worth::NOT_BELIEVED),
    })
}

/// The results of a lesson's run, goal by goal.
fn marks(grade: &Grade) -> Value {
    let mark = |mark: &Mark| {
        let Goal { measure, bound } = mark.goal;
        let sense = if measure.is_least() {
            "at_least"
        } else {
            "at_most"
        };
        json!({ "measure": measure.name(), sense: bound, "value": mark.value, "is_met": mark.is_met })
    };
    let marks: Vec<Value> = grade.marks.iter().map(mark).collect();
    json!({ "is_over": grade.is_over, "is_passed": grade.is_passed(), "marks": marks })
}

/// The quality of the map with all scans included, for a method that is judged. The run may go on
/// in a saved map, so a copy of its map is completed for that.
fn judged(experiment: &Experiment) -> Option<MapQuality> {
    let mut map = experiment.session().slam().view().map?.clone();
    map.finish();
    Some(map.quality())
}

/// A prior map without a given start: the robot begins at the start of the world or at the origin,
/// whichever puts more of the map on walls of the world.
fn placed_in_world(path: &Path, args: &Args, world: &World) -> Result<PriorMap> {
    let walls = world.walls();
    let walls = walls.iter().map(|wall| wall.segment);
    let truth = PriorMap::of_walls(walls, &world.start).faces;
    let own = prior_map::read(path, args.svg_unit, &Start::At(Pose2::identity()))?;
    let of_world = PriorMap::of_faces(&own.faces, own.sigma, &world.start);
    let parts = [&own, &of_world].map(|map| part_on(&map.faces, &truth));
    let (map, part, frame) = match parts[0] > parts[1] {
        true => (own, parts[0], "that begins where the robot does"),
        false => (of_world, parts[1], "of the world"),
    };
    let (path, percent) = (path.display(), 100.0 * part);
    eprintln!(
        "simulate: {path} is taken to be in the frame {frame}: {percent:.0} % of its walls are walls there"
    );
    if part < LEAST_SHOWN {
        eprintln!("simulate: that is little: say by --start where the robot begins in it");
    }
    Ok(map)
}

/// The part of `faces`, by length, that lies on `walls`.
fn part_on(faces: &[Segment], walls: &[Segment]) -> f64 {
    let (mut all, mut on) = (0.0, 0.0);
    for face in faces {
        let pieces = (face.length() / PIECE).ceil().max(1.0);
        for piece in 0..pieces as usize {
            let place = face.a + face.vector() * ((piece as f64 + 0.5) / pieces);
            let length = face.length() / pieces;
            all += length;
            if walls.iter().any(|wall| wall.distance(place) < ON_WALL) {
                on += length;
            }
        }
    }
    on / f64::max(all, f64::MIN_POSITIVE)
}

/// Writes the requested files.
fn write_files(
    args: &Args,
    experiment: &Experiment,
    world: &str,
    changes: Vec<(String, f64)>,
) -> Result<()> {
    let slam = experiment.session().slam();
    let poses = slam.trajectory().into_iter();
    let poses = poses.map(|(stamp, pose)| (stamp.seconds(), pose));
    let log = || experiment.log().clone();
    let revolutions = || RevolutionLog::of_carmen(experiment.log());
    let mut files = args.outputs.files(slam, poses, log, revolutions)?;
    if let Some(path) = &args.truth {
        // By the stamps of the log, because a scan ends before the step of the simulation does.
        let scans = experiment.log().scans.iter();
        let samples = scans.zip(experiment.record().samples());
        let poses = samples.map(|(scan, sample)| (scan.ipc_seconds, sample.truth));
        files.push((path.clone(), tum::write(poses).into()));
    }
    let map = || slam.saved_map(vec![]);
    files.extend(args.saved_map.file(Path::new(world), map, changes)?);
    if let Some(stem) = &args.plan {
        let walls = slam.vector_map().walls();
        let named =
            |extension: &str, text: String| (format!("{stem}.{extension}").into(), text.into());
        let began = slam.trajectory().first().map(|(_, pose)| pose.position());
        files.push(named("svg", floor_plan::svg(&walls, began)?));
        files.push(named("dxf", floor_plan::dxf(&walls)?));
        files.push(named("geojson", floor_plan::geojson(&walls)?));
    }
    options::write(&files)
}

fn print(report: &Value, json: bool) -> std::io::Result<()> {
    let mut out = std::io::stdout().lock();
    if json {
        return writeln!(out, "{report}");
    }
    for (key, value) in report.as_object().into_iter().flatten() {
        match (key.as_str(), &value["verdict"]) {
            ("quality", Value::String(verdict)) => writeln!(out, "{key:>20}  {verdict}")?,
            ("quality", _) => writeln!(out, "{key:>20}  {}", worth::NOT_JUDGED)?,
            _ => writeln!(out, "{key:>20}  {value}")?,
        }
    }
    Ok(())
}

fn load_world(args: &Args) -> Result<World> {
    let name = args.world.as_str();
    if let Some(world) = worlds::builtin(name) {
        return Ok(world);
    }
    let path = Path::new(name);
    if !path.exists() {
        bail!(
            "there is no world `{name}`; built in are {}, or give the path of a world file, of a map's YAML, of a submap or of a floor plan",
            worlds::NAMES.join(", ")
        );
    }
    let imported = load(path, args.svg_unit)?
        .into_world(name)
        .with_context(|| format!("{name} is no building"))?;
    for what in &imported.skipped {
        eprintln!("simulate: {name}: skipped {what}");
    }
    Ok(imported.world)
}

/// The map begins at the robot's start, so the goal is transformed from the world's frame.
fn goal_in_map(args: &Args, world: &World) -> Result<Point2<f64>> {
    let in_world = match &args.goal {
        Some(text) => {
            let Some([x, y]) = prior_map::numbers(text) else {
                bail!("--goal is `{text}`, expected two finite numbers `x,y` in metres")
            };
            Point2::new(x, y)
        }
        None => world.goal.with_context(|| {
            format!("world `{}` has no goal; give one by --goal x,y", world.name)
        })?,
    };
    Ok(world.start.inverse() * in_world)
}

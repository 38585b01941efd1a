//! Replays recorded logs (CARMEN, MCAP of the bridge or of ROS 2, bags of ROS 1, a rover's, four
//! rangers', revolutions of a lidar) and prints how well and how fast they were mapped.
//! `--set log.odometry=0` maps a log without its odometry.
//!
//! One log by one method, as a JSON object: `cargo run --release -p slamlab-core --example evaluate
//! -- --log FILE [--scan-topic TOPIC] [--odometry-topic TOPIC] [--relations FILE]
//! [--truth FILE.tum] [--poses FILE --poses-as odometry|truth] [--method NAME] [--tum OUT] [--map
//! OUT.pgm|OUT.png] [--map-mode MODE] [--og-map OUT] [--smap OUT] [--carmen OUT] [--revolutions
//! OUT] [--g2o OUT] [--preset FILE] [--fit OUT.json] [--set KEY=NUMBER] [--prior-map MAP.yaml
//! [--start X,Y,DEGREES|anywhere]] [--scans FROM..TO] [--go-on MAP.slamlab [--from
//! paused|left|anywhere|X,Y,DEGREES]] [--save MAP.slamlab] [--json]`
//!
//! Several logs, several methods, as a Markdown table, or with `--json` as one JSON object per
//! line: `cargo run --release -p slamlab-core --example evaluate -- FILE… [--method NAME,NAME…]
//! [--set KEY=NUMBER] [--json]`
//!
//! Or optimises a pose graph, from the file's own poses:
//! `cargo run --release -p slamlab-core --example evaluate -- --graph FILE.g2o [--out OUT.g2o]`
//!
//! The exit status is 0 only if everything was evaluated; it is 3 if a map is torn, if nothing was
//! matched to it or if the robot is lost in the given map, and 1 if something failed. The core has
//! no files and no clock; this program does the reading, the writing and the timing.
#![allow(
    clippy::disallowed_methods,
    reason = "the edge: files and the clock are here and nowhere below"
)]

mod accuracy;
#[path = "../shared/closures.rs"]
mod closures;
mod graph;
#[path = "../shared/log_file.rs"]
mod log_file;
#[path = "../shared/options.rs"]
mod options;
#[path = "../shared/peak_memory.rs"]
mod peak_memory;
mod poses;
#[path = "../shared/prior_map.rs"]
mod prior_map;
#[path = "../shared/quality.rs"]
mod quality;
mod run;
#[path = "../shared/saved_map.rs"]
mod saved_map;
mod several;
mod table;
#[path = "../shared/worth.rs"]
mod worth;

use std::io::Write as _;
use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::Context;
use clap::error::ErrorKind;
use clap::parser::ValueSource;
use clap::{ArgMatches, CommandFactory as _, FromArgMatches as _, Parser};
use serde_json::Value;

/// Replays recorded logs and measures the result.
#[derive(Parser)]
#[command(
    after_help = "Exit status: 0, 3 where a map is torn, nothing was matched to it or the robot is lost in it, 1 where something failed."
)]
struct Arguments {
    /// CARMEN logs (.log, .clf), recordings of the bridge or of ROS 2 (.mcap), bags of ROS 1
    /// (.bag), logs of a rover with an RPLIDAR (.log), of four rangers (.csv) or of an RPLIDAR
    /// alone, a revolution a line (.txt); what they are shows in their first bytes.
    #[arg(value_name = "LOG")]
    logs: Vec<PathBuf>,
    /// One more of them; can be given several times.
    #[arg(long = "log", value_name = "FILE")]
    more_logs: Vec<PathBuf>,
    /// Instead of a log: a pose graph (.g2o), which is solved.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["logs", "more_logs"])]
    graph: Option<PathBuf>,
    /// Write the solved graph of `--graph`, with the names and edges of the file.
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Reference relations (.relations) of one log. Those of several lie beside them and have their
    /// names.
    #[arg(long, value_name = "FILE")]
    relations: Option<PathBuf>,
    /// Reference trajectory (.tum) of one log. Those of several lie beside them and have their
    /// names.
    #[arg(long, value_name = "FILE")]
    truth: Option<PathBuf>,
    /// Poses over time of one log, on its clock: TUM, or a table with a header (time,x,y,theta in
    /// any order, units in the names, as theta_deg).
    #[arg(long, value_name = "FILE", requires = "poses_as")]
    poses: Option<PathBuf>,
    /// What they are: `odometry` to map the log with in place of its own, interpolated at each
    /// scan's time, or the `truth` to hold the run against, aligned to it.
    #[arg(long, value_name = "odometry|truth", requires = "poses")]
    poses_as: Option<poses::PosesAs>,
    /// odometry, line-ekf, scan-matching, grid-particles, prior-map, particle-localisation or
    /// histogram-localisation; several apart by commas.
    #[arg(
        long = "method",
        value_name = "NAME",
        value_delimiter = ',',
        default_value = "scan-matching"
    )]
    methods: Vec<String>,
    /// The map that `--method prior-map`, `particle-localisation` or `histogram-localisation` finds
    /// the robot in: YAML of ROS map_server, OGmap.txt, submap (.smap), floor plan (.svg) or world
    /// (.json).
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
    saved_map: saved_map::SavedMapOptions,
    /// Only these scans of the log, counted from 0, the second left out: `FROM..TO`; either may be
    /// missing.
    #[arg(long, value_name = "FROM..TO", value_parser = run::scans)]
    scans: Option<std::ops::Range<usize>>,
    #[command(flatten)]
    topics: log_file::Topics,
    #[command(flatten)]
    changes: options::Changes,
    #[command(flatten)]
    outputs: options::Outputs,
    /// Fit odometry and ranges to the drive, print them, and write what is known as a preset here.
    #[arg(long)]
    fit: Option<PathBuf>,
    /// Print one JSON object on one line for each run.
    #[arg(long)]
    json: bool,
}

fn main() -> ExitCode {
    let matches = Arguments::command().get_matches();
    let arguments = match Arguments::from_arg_matches(&matches) {
        Ok(arguments) => arguments,
        Err(error) => error.exit(),
    };
    if let Err(error) = check_graph_options(&matches) {
        error.exit();
    }
    let logs: Vec<PathBuf> = [&arguments.logs[..], &arguments.more_logs].concat();
    let done = match (&arguments.graph, &logs[..], &arguments.methods[..]) {
        (Some(graph), _, _) => graph::solve(graph, arguments.out.as_deref(), arguments.json)
            .map(|()| ExitCode::SUCCESS),
        (None, [], _) => Err(anyhow::anyhow!("neither a log nor --graph")),
        (None, [log], [method]) => run::evaluate(log, method, &arguments),
        (None, logs, methods) => several::evaluate(logs, methods, &arguments, &matches),
    };
    match done {
        Ok(code) => code,
        Err(error) => {
            eprintln!("evaluate: {error:#}");
            ExitCode::FAILURE
        }
    }
}

/// Names of the options that go with `--graph`.
const OF_A_GRAPH: [&str; 3] = ["graph", "out", "json"];

/// Refuses options that would be ignored: those of a log with `--graph`, and those of `--graph`
/// with a log. The parser's own rules cannot do this: where `--graph` is in conflict, it is no
/// longer required.
fn check_graph_options(matches: &ArgMatches) -> Result<(), clap::Error> {
    let is_given = |id: &str| matches.value_source(id) == Some(ValueSource::CommandLine);
    let conflict =
        |text: String| Err(Arguments::command().error(ErrorKind::ArgumentConflict, text));
    if !is_given("graph") {
        return match is_given("out") {
            true => conflict(
                "--out writes the graph that --graph names, solved; the pose graph of a log is written by --g2o".to_owned(),
            ),
            false => Ok(()),
        };
    }
    let command = Arguments::command();
    let idle = command.get_arguments().find(|argument| {
        let id = argument.get_id().as_str();
        is_given(id) && !OF_A_GRAPH.contains(&id)
    });
    match idle.and_then(clap::Arg::get_long) {
        Some(option) => conflict(format!(
            "--{option} is of logs: with --graph it has no effect"
        )),
        None => Ok(()),
    }
}

fn print(figures: &Value, on_one_line: bool) -> anyhow::Result<()> {
    let mut out = std::io::stdout().lock();
    let printed = match on_one_line {
        true => writeln!(out, "{figures}"),
        false => writeln!(out, "{figures:#}"),
    };
    printed.context("cannot write to standard output")
}

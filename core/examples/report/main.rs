//! Measures what the project claims, one claim at a time.
//!
//! ```text
//! cargo run --release -p slamlab-core --example report -- NAME [--seeds N] [--data DIR] [--json]
//! ```
//!
//! | NAME | standard output |
//! |---|---|
//! | a report | one JSON object whose keys say quantity and unit, on lines or one (`--json`) |
//! | `all` | one such object per line for each report, as it finishes |
//! | `list` | the names of the reports, one a line |
//!
//! Exit status: 0 if every requirement holds; 1 if some do not, which standard error names; 2 if
//! something could not be measured at all.
//!
//! The speed of single stages is measured by `benches/`, and ratios to other programs by the
//! example `workloads`.
//!
//! Each report is a file of its own, with its run time in its head comment; [`REPORTS`] is the
//! table of names.

#![allow(
    clippy::disallowed_methods,
    reason = "an example uses the clock, threads and floating point of the platform; the core does not"
)]

mod affine;
mod buildings;
mod clock;
#[path = "../shared/closures.rs"]
mod closures;
mod controller;
#[path = "../shared/cpu_clock.rs"]
mod cpu_clock;
mod crowd;
mod degenerate;
mod distance;
mod ekf_consistency;
mod ekf_cost;
mod errand;
mod explore;
mod features;
mod gauss_transform;
mod graphs;
mod grid;
mod heading;
mod kidnap;
mod line_fit;
#[path = "../shared/log_file.rs"]
mod log_file;
mod look_alikes;
mod mapped;
#[path = "../shared/mapped_filter.rs"]
mod mapped_filter;
mod memory;
mod outcome;
#[path = "../shared/peak_memory.rs"]
mod peak_memory;
mod peers;
mod people;
mod planners;
mod point_landmarks;
mod random_building;
mod random_buildings;
mod ray_cast;
mod registration;
mod ride;
mod rounding;
mod safe_drive;
mod scenes;
mod score;
mod split_merge;
mod statistics;
mod threads;
mod tour;
mod vector_map;

use std::ops::Range;
use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::{Result, bail};
use clap::Parser;
use serde_json::Value;

use outcome::Outcome;

/// Name of a report, and the function that measures it.
type Entry = (&'static str, fn(&Args) -> Result<Outcome>);

/// All reports, by name.
const REPORTS: &[Entry] = &[
    ("affine", affine::measure),
    ("buildings", buildings::measure),
    ("controller", controller::measure),
    ("crowd", crowd::measure),
    ("degenerate", degenerate::measure),
    ("distance", distance::measure),
    ("ekf-consistency", ekf_consistency::measure),
    ("ekf-cost", ekf_cost::measure),
    ("explore", explore::measure),
    ("features", features::measure),
    ("gauss-transform", gauss_transform::measure),
    ("graphs", graphs::measure),
    ("grid", grid::measure),
    ("kidnap", kidnap::measure),
    ("line-fit", line_fit::measure),
    ("look-alikes", look_alikes::measure),
    ("people", people::measure),
    ("planners", planners::measure),
    ("point-landmarks", point_landmarks::measure),
    ("random-buildings", random_buildings::measure),
    ("ray-cast", ray_cast::measure),
    ("registration", registration::measure),
    ("rounding", rounding::measure),
    ("safe-drive", safe_drive::measure),
    ("split-merge", split_merge::measure),
    ("vector-map", vector_map::measure),
];

/// Measures one claim of the project; exit status 0 if it holds, 1 if it does not, 2 if it could
/// not be measured.
#[derive(Parser)]
struct Args {
    /// Which claim; or `all`, or `list`.
    name: String,
    /// For `buildings`, `kidnap`, `graphs` and `registration`: the folder of recorded data, as its
    /// README lays it out; `registration` does without where none is named. Default `SLAMLAB_DATA`,
    /// or else `shared/data` beside the repository.
    #[arg(long, value_name = "DIR")]
    data: Option<PathBuf>,
    /// For `buildings`: only this row of its table; can be given several times. Default all.
    #[arg(long, value_name = "ROW")]
    only: Vec<String>,
    /// Number of seeds (runs, scenes), for a quick look; each report has its own default.
    #[arg(long)]
    seeds: Option<u64>,
    /// Number of the first seed, to try others than the report's own.
    #[arg(long, default_value_t = 0)]
    first_seed: u64,
    /// For `planners`: number of random queries in each world. Default 1000.
    #[arg(long)]
    queries: Option<usize>,
    /// For `planners`, `explore`, `crowd`, `look-alikes`, `features`, `ekf-consistency` and
    /// `point-landmarks`: only in this world; can be given several times. Default all. For
    /// `kidnap`: in these logs. Default `intel`.
    #[arg(long = "world")]
    worlds: Vec<String>,
    /// For `safe-drive`: number of trials. Default 10 000.
    #[arg(long)]
    trials: Option<u64>,
    /// For `explore`: only by this strategy; can be given several times. Default all.
    #[arg(long = "strategy")]
    strategies: Vec<String>,
    /// For `explore`: only by this sensor, `lidar` or `rangers`. Default both.
    #[arg(long)]
    sensor: Option<String>,
    /// For `grid`, `planners` and `graphs`: lines of the peers' programs and of the example
    /// `workloads`, from one machine and hour. `graphs` looks for lines
    /// `peer workload median_ms chi2=..` of peers `g2o..` and `gtsam..` for the workloads
    /// `posegraph_intel` and `posegraph_m3500`; its own time it takes itself.
    #[arg(long)]
    peers: Option<PathBuf>,
    /// Print the JSON object on one line.
    #[arg(long)]
    json: bool,
}

fn main() -> ExitCode {
    let args = Args::parse();
    if let Err(error) = args.check() {
        eprintln!("report: {error:#}");
        return CANNOT.into();
    }
    match args.name.as_str() {
        "list" => {
            REPORTS.iter().for_each(|(name, _)| println!("{name}"));
            ExitCode::SUCCESS
        }
        "all" => {
            let status = |entry| run(entry, &args, |json| println!("{json}"));
            REPORTS.iter().map(status).max().unwrap_or(CANNOT).into()
        }
        name => match REPORTS.iter().find(|(known, _)| *known == name) {
            Some(entry) if args.json => run(entry, &args, |json| println!("{json}")).into(),
            Some(entry) => run(entry, &args, |json| println!("{json:#}")).into(),
            None => {
                let names: Vec<_> = REPORTS.iter().map(|(name, _)| *name).collect();
                let names = names.join(", ");
                eprintln!(
                    "report: there is no report `{name}`; expected all, list or one of: {names}"
                );
                CANNOT.into()
            }
        },
    }
}

/// Exit status if every requirement holds, if one does not, and if nothing could be measured.
const HOLDS: u8 = 0;
const FAILS: u8 = 1;
const CANNOT: u8 = 2;

/// Measures, prints and judges; returns the exit status.
fn run((name, measure): &Entry, args: &Args, print: impl Fn(&Value)) -> u8 {
    match measure(args) {
        Ok(outcome) => {
            print(&outcome.to_json(name));
            for failure in outcome.failures() {
                eprintln!("report: {name} does not hold: {failure}");
            }
            if outcome.failures().is_empty() {
                HOLDS
            } else {
                FAILS
            }
        }
        Err(error) => {
            eprintln!("report: {name}: {error:#}");
            CANNOT
        }
    }
}

impl Args {
    fn check(&self) -> Result<()> {
        let queries = self.queries.map(|queries| queries as u64);
        let counts = [
            ("seeds", self.seeds),
            ("trials", self.trials),
            ("queries", queries),
        ];
        match counts.iter().find(|(_, count)| *count == Some(0)) {
            Some((option, _)) => bail!("--{option} is 0, expected at least 1"),
            None => Ok(()),
        }
    }

    /// The folder of recorded data.
    fn data(&self) -> PathBuf {
        let named = || std::env::var_os("SLAMLAB_DATA").map(PathBuf::from);
        let beside = || concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/data").into();
        self.data.clone().or_else(named).unwrap_or_else(beside)
    }

    /// The seeds of a report, as many as `--seeds` says or else `default`.
    fn seeds(&self, default: u64) -> Range<u64> {
        let count = self.seeds.unwrap_or(default);
        self.first_seed..self.first_seed.saturating_add(count)
    }

    /// The worlds of a report that `--world` asks for; all if it is not given.
    fn worlds(&self, all: impl IntoIterator<Item = &'static str>) -> Result<Vec<&'static str>> {
        chosen("world", &self.worlds, all)
    }
}

/// Those that were asked for by name; all if none was.
fn chosen<'a>(
    kind: &str,
    asked: &[String],
    all: impl IntoIterator<Item = &'a str>,
) -> Result<Vec<&'a str>> {
    let mut names: Vec<&str> = all.into_iter().collect();
    if let Some(name) = asked.iter().find(|name| !names.contains(&name.as_str())) {
        let names = names.join(", ");
        bail!("not measured: {kind} `{name}`; expected one of {names}");
    }
    names.retain(|name| asked.is_empty() || asked.iter().any(|one| one == name));
    Ok(names)
}

//! Measures what the project claims, one claim at a time.
//!
//! ```text
//! cargo run --release -p slamlab-core --example report -- NAME [--seeds N]
//! ```
//!
//! In: the name of a report. Out: one JSON object on standard output whose keys say quantity and unit, and by exit status
//! whether each requirement holds: 0 all do; 1 some do not, named on standard error; 2 nothing could be measured.
//!
//! Each report is a file of its own, with its run time in its head comment; [`REPORTS`] is the table of names.

#![allow(
    clippy::disallowed_methods,
    reason = "an example uses the clock, threads and floating point of the platform; the core does not"
)]

mod clock;
mod controller;
mod crowd;
mod distance;
mod ekf_consistency;
mod ekf_cost;
mod errand;
mod explore;
mod grid;
mod heading;
mod line_fit;
mod outcome;
mod peers;
mod planners;
mod ray_cast;
mod rounding;
mod safe_drive;
mod scenes;
mod score;
mod split_merge;
mod tour;
mod vector_map;

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::{Result, bail};
use clap::Parser;

use outcome::Outcome;

/// Name of a report, and what measures it.
type Entry = (&'static str, fn(&Args) -> Result<Outcome>);

/// All reports, by name.
const REPORTS: &[Entry] = &[
    ("controller", controller::measure),
    ("crowd", crowd::measure),
    ("distance", distance::measure),
    ("ekf-consistency", ekf_consistency::measure),
    ("ekf-cost", ekf_cost::measure),
    ("explore", explore::measure),
    ("grid", grid::measure),
    ("line-fit", line_fit::measure),
    ("planners", planners::measure),
    ("ray-cast", ray_cast::measure),
    ("rounding", rounding::measure),
    ("safe-drive", safe_drive::measure),
    ("split-merge", split_merge::measure),
    ("vector-map", vector_map::measure),
];

/// Measures one claim of the project; exit status 0 if it holds, 1 if it does not, 2 if it could not be measured.
#[derive(Parser)]
struct Args {
    /// Which claim.
    name: String,
    /// Number of seeds (runs, scenes), for a quick look; each report has its own default.
    #[arg(long)]
    seeds: Option<u64>,
    /// Number of the first seed, to try others than the report's own.
    #[arg(long, default_value_t = 0)]
    first_seed: u64,
    /// For `planners`: number of random queries in each world. Default 1000.
    #[arg(long)]
    queries: Option<usize>,
    /// For `planners`, `explore`, `crowd` and `ekf-consistency`: only in this world; can be given several times. Default all.
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
    /// For `ekf-cost`: milliseconds of the bar of a step by number of landmarks, as `100=0.2,200=0.7,500=4`.
    #[arg(long)]
    bar_ms: Option<String>,
    /// For `grid` and `planners`: lines of the peers' programs and of the example `workloads`, from one machine and hour.
    #[arg(long)]
    peers: Option<PathBuf>,
}

fn main() -> ExitCode {
    let args = Args::parse();
    match measure(&args) {
        Ok(outcome) => {
            println!("{:#}", outcome.to_json(&args.name));
            for failure in outcome.failures() {
                eprintln!("report: {} does not hold: {failure}", args.name);
            }
            if outcome.failures().is_empty() {
                ExitCode::SUCCESS
            } else {
                ExitCode::from(1)
            }
        }
        Err(error) => {
            eprintln!("report: {error:#}");
            ExitCode::from(2)
        }
    }
}

fn measure(args: &Args) -> Result<Outcome> {
    let Some((_, measure)) = REPORTS.iter().find(|(name, _)| *name == args.name) else {
        let names: Vec<_> = REPORTS.iter().map(|(name, _)| *name).collect();
        bail!(
            "there is no report `{}`; expected one of: {}",
            args.name,
            names.join(", ")
        );
    };
    if args.seeds == Some(0) {
        bail!("--seeds is 0, expected at least 1");
    }
    if args.trials == Some(0) {
        bail!("--trials is 0, expected at least 1");
    }
    if args.queries == Some(0) {
        bail!("--queries is 0, expected at least 1");
    }
    measure(args)
}

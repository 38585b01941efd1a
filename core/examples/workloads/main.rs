//! Runs the workloads of the peers' folder, on exactly the inputs that the peers read.
//!
//! ```text
//! cargo run --release -p slamlab-core --example workloads -- --inputs DIR [WORKLOAD..]
//! ```
//!
//! In: the folder of inputs that the peers' `gen_inputs.py` writes, and names of workloads; without
//! a name, all. Out: one line for each measurement, in the peers' own form:
//! `peer workload median_ms extra`. The time is processor time, the median of some runs after one
//! warm-up run, and can be compared with a peer's of the same machine and hour.
//!
//! A workload is a file with one function; [`WORKLOADS`] is the table of names.

#![allow(
    clippy::disallowed_methods,
    reason = "an example reads files and the clock of the platform; the core does not"
)]

mod cpd;
#[path = "../shared/cpu_clock.rs"]
mod cpu_clock;
mod ekf_step;
mod gmm;
mod grid;
mod inputs;
mod plan;
mod rays;
mod register;
#[path = "../report/score.rs"]
mod score;
mod slam;
mod split_and_merge;
mod timing;

use std::path::PathBuf;

use anyhow::{Context, Result, bail};
use clap::Parser;

use inputs::Inputs;

/// Name of a workload, and the function that runs it.
type Entry = (&'static str, fn(&Inputs) -> Result<()>);

/// All workloads, by name.
const WORKLOADS: [Entry; 9] = [
    ("cpd", cpd::run),
    ("ekf_step", ekf_step::run),
    ("gmm", gmm::run),
    ("grid", grid::run),
    ("plan", plan::run),
    ("rays", rays::run),
    ("register", register::run),
    ("slam", slam::run),
    ("split_and_merge", split_and_merge::run),
];

/// Runs the peers' workloads on the peers' inputs and prints what they cost.
#[derive(Parser)]
struct Args {
    /// The folder with the peers' inputs.
    #[arg(long)]
    inputs: PathBuf,
    /// Which workloads; all where none is named.
    workloads: Vec<String>,
}

fn main() -> Result<()> {
    let args = Args::parse();
    let inputs = Inputs {
        folder: args.inputs,
    };
    let known = WORKLOADS.map(|(name, _)| name);
    if let Some(name) = (args.workloads.iter()).find(|name| !known.contains(&name.as_str())) {
        bail!("no workload `{name}`; there are {}", known.join(", "));
    }
    let wanted = |name: &str| args.workloads.is_empty() || args.workloads.iter().any(|w| w == name);
    for (name, run) in WORKLOADS.iter().filter(|(name, _)| wanted(name)) {
        run(&inputs).with_context(|| format!("workload {name}"))?;
    }
    Ok(())
}

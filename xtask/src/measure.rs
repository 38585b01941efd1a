//! Measures what the bridge promises: figures as JSON, and whether they hold.

use anyhow::Result;
use clap::ValueEnum;

use crate::tools;

/// What can be measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Promise {
    /// From a fault to the order to stop, 100 times each
    Faults,
    /// From the robot to a client, alone and beside 50 watchers
    Latency,
    /// Who is refused, and how
    Access,
}

/// Measures it, over sockets of this machine.
///
/// # Errors
/// If a figure does not hold.
pub fn measure(promise: Promise) -> Result<()> {
    let name = match promise {
        Promise::Faults => "faults",
        Promise::Latency => "latency",
        Promise::Access => "access",
    };
    let run = "run --release --quiet --package slamlab-tests --example bridge_report --";
    tools::run(tools::cargo().args(run.split(' ')).arg(name))
}

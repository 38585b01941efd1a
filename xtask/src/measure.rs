//! Measures what is promised of page and bridge: figures as JSON, and whether they hold.

use anyhow::Result;
use clap::ValueEnum;

use crate::{browser_cost, tools};

/// What can be measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Promise {
    /// From a fault to the order to stop, 100 times each
    Faults,
    /// From the robot to a client, alone and beside 50 watchers
    Latency,
    /// Who is refused, and how
    Access,
    /// An update of the line filter in headless Chromium takes at most 1.5 times as long as natively
    BrowserCost,
}

/// Measures it; the bridge over sockets of this machine.
///
/// # Errors
/// If a figure does not hold.
pub fn measure(promise: Promise) -> Result<()> {
    let name = match promise {
        Promise::Faults => "faults",
        Promise::Latency => "latency",
        Promise::Access => "access",
        Promise::BrowserCost => return browser_cost::report(),
    };
    let run = "run --release --quiet --package slamlab-tests --example bridge_report --";
    tools::run(tools::cargo().args(run.split(' ')).arg(name))
}

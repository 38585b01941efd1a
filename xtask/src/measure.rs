//! Measures what is promised of page and bridge: figures as JSON, and whether they hold.

use std::path::Path;

use anyhow::{Context, Result};
use clap::ValueEnum;

use crate::{browser_cost, firmware, tools};

/// What can be measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Promise {
    /// From a fault to motors without voltage, by the registers of the real firmware, and to the order to stop
    Faults,
    /// From the robot to a client, alone and beside 50 watchers
    Latency,
    /// Who is refused, and how
    Access,
    /// Nothing grows: 24 simulated hours of a device, and a bridge in real time
    Soak,
    /// No decoder crashes on changed input
    Fuzz,
    /// An update of the line filter in headless Chromium takes at most 1.5 times as long as natively
    BrowserCost,
}

/// Measures it; the bridge over sockets of this machine. `minutes`: how long to soak, or to fuzz each decoder; `trials`: how often each
/// fault is tried.
///
/// # Errors
/// If a figure does not hold.
pub fn measure(promise: Promise, minutes: Option<f64>, trials: Option<usize>) -> Result<()> {
    let name = match promise {
        Promise::Faults => return faults(trials.unwrap_or(100)),
        Promise::Latency => return latency(),
        Promise::Access => "access",
        Promise::Soak => "soak",
        Promise::Fuzz => return example("fuzz", &minutes_or(minutes, 10.0)),
        Promise::BrowserCost => return browser_cost::report(),
    };
    if promise != Promise::Soak {
        return example("bridge_report", &[name.to_owned()]);
    }
    let mut words = minutes_or(minutes, 30.0);
    words.insert(0, name.to_owned());
    example("bridge_report", &words)
}

/// At the registers of the real firmware, too: without its simulator there is no report.
fn faults(trials: usize) -> Result<()> {
    let robot = firmware::build_simulator()?;
    let robot = robot.context("the faults are measured at the registers of the real firmware")?;
    let words = ["faults".to_owned(), trials.to_string()];
    example_with(
        "bridge_report",
        &words,
        &[("SLAMLAB_RP6_SIM", robot.as_path())],
    )
}

/// From an encoder's edge, too, where its simulator can be built.
fn latency() -> Result<()> {
    let robot = firmware::build_simulator()?;
    let programs = robot.as_deref().map(|robot| ("SLAMLAB_RP6_SIM", robot));
    let words = ["latency".to_owned()];
    example_with("bridge_report", &words, programs.as_slice())
}

fn minutes_or(minutes: Option<f64>, default: f64) -> Vec<String> {
    vec![minutes.unwrap_or(default).to_string()]
}

/// Runs an example of the tests, optimised, with the optimised bridge where it wants one in a process of its own.
fn example(name: &str, words: &[String]) -> Result<()> {
    example_with(name, words, &[])
}

fn example_with(name: &str, words: &[String], programs: &[(&str, &Path)]) -> Result<()> {
    tools::run(tools::cargo().args("build --release --quiet --package slamlab-bridge".split(' ')))?;
    let bridge = tools::target_dir()
        .join("release/slamlab-bridge")
        .with_extension(std::env::consts::EXE_EXTENSION);
    let run = "run --release --quiet --package slamlab-tests --example";
    tools::run(
        tools::cargo()
            .env("SLAMLAB_BRIDGE", bridge)
            .envs(programs.iter().copied())
            .args(run.split(' '))
            .args([name, "--"])
            .args(words),
    )
}

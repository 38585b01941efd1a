//! All tests: natively, in a browser, and the page as a user uses it.

use std::path::PathBuf;

use anyhow::Result;
use clap::ValueEnum;

use crate::report::Report;
use crate::wasm::Profile;
use crate::{firmware, page, serve, tools};

/// A group of tests that runs by itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Suite {
    /// Unit, integration, property and documentation tests, compiled for this machine
    Native,
    /// Tests compiled for wasm32, in headless Chromium
    Wasm,
    /// The page in headless Chromium, served by the bridge, at desktop and phone size
    Page,
    /// The robot's firmware in a simulated microcontroller; skipped where avr-gcc or what simavr is built from is missing
    Firmware,
}

/// Runs the named suites, or all of them if none is named.
///
/// # Errors
/// If a suite fails; the others run all the same.
pub fn run(suites: &[Suite]) -> Result<()> {
    let suites = if suites.is_empty() {
        Suite::value_variants()
    } else {
        suites
    };
    let mut report = Report::default();
    for suite in suites {
        match suite {
            Suite::Native => report.step("native tests", native),
            Suite::Wasm => report.step("tests in the browser", wasm),
            Suite::Page => report.step("the page", the_page),
            Suite::Firmware => report.step("the firmware", firmware::test),
        }
    }
    report.finish()
}

fn native() -> Result<()> {
    // Apart from the rest: together, cargo would join their features and compile the wasm-bindgen tool once more.
    let rest = tools::run(
        tools::cargo().args("test --workspace --exclude xtask --no-fail-fast".split(' ')),
    );
    rest.and(tools::run(
        tools::cargo().args("test --package xtask".split(' ')),
    ))
}

fn wasm() -> Result<()> {
    tools::need_wasm_target()?;
    tools::run(
        tools::cargo()
            .env("CHROME", tools::chrome()?)
            .env("CHROMEDRIVER", tools::chromedriver()?)
            .args(
                "test --package slamlab-tests --package slamlab-web --tests --no-fail-fast"
                    .split(' '),
            )
            .args(["--target", "wasm32-unknown-unknown"]),
    )
}

fn the_page() -> Result<()> {
    let chrome = tools::chrome()?;
    page::build(Profile::Release)?;
    let bridge = serve::build_bridge()?;
    // The run on the command line whose bits those in the page must equal.
    let simulate = build_example("slamlab-core", "simulate")?;
    let wired_robot = build_example("slamlab-tests", "wired_robot")?;
    let real_firmware = firmware::build_simulator()?;
    let folder = tools::root().join("tests/page");
    page::install(&folder)?;
    let mut npm = tools::npm(&folder)?;
    npm.env("CHROME", chrome)
        .env("SLAMLAB_BRIDGE", bridge)
        .env("SLAMLAB_SIMULATE", simulate)
        .env("SLAMLAB_WIRED_ROBOT", wired_robot)
        .env("SLAMLAB_RP6_SIM", real_firmware.unwrap_or_default());
    tools::run(npm.args(["run", "--silent", "test"]))
}

/// An example's program, compiled for this machine.
fn build_example(package: &str, name: &str) -> Result<PathBuf> {
    tools::run(tools::cargo().args(["build", "--package", package, "--example", name]))?;
    Ok(tools::target_dir()
        .join("debug/examples")
        .join(name)
        .with_extension(std::env::consts::EXE_EXTENSION))
}

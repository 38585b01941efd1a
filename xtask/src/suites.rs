//! All tests: natively, in a browser, and the page as a user uses it.

use std::thread;

use anyhow::Result;
use clap::ValueEnum;

use crate::report::Report;
use crate::wasm::{self, Profile};
use crate::{dist, firmware, npm, page, rules, setup, skips, tools};

/// A group of tests that runs by itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Suite {
    /// What one runs between edits: the core's unit tests but for the slow ones, order of imports,
    /// house rules, types
    Quick,
    /// Unit, integration, property and documentation tests, compiled for this machine
    Native,
    /// Tests compiled for wasm32, in headless Chromium
    Wasm,
    /// The page in headless Chromium, served by the bridge; on a phone what is different there
    Page,
    /// The robot's firmware in a simulated microcontroller; skipped where avr-gcc or what simavr is
    /// built from is missing
    Firmware,
}

/// All but [`Suite::Quick`], which is part of them.
const ALL: [Suite; 4] = [Suite::Native, Suite::Wasm, Suite::Page, Suite::Firmware];

/// Compiles the programs that the page's tests start: for the whole workspace and in the profile of
/// tests, so the dependencies are already compiled by the native tests.
const PROGRAMS: &str = "build --profile test --workspace --exclude xtask --exclude slamlab-storage-report --bin slamlab-bridge \
                        --example simulate --example wired_robot";

/// Parts of the names of those unit tests of `core` that take seconds: nine tenths of the total
/// time. [`Suite::Quick`] leaves them out, and says how many.
const SLOW: &[&str] = &[
    // Whole runs.
    "pilot::tests::",
    "experiment::tests::",
    "session::tests::",
    "prior_map_tests::",
    "scan_matching::tests::",
    "odometry_fit::tests::",
    "consistency::",
    "dead_reckoning_is_lost",
    "who_turns_before_a_wall",
    // Comparisons with brute force.
    "svg_tests::",
    "area_is_all_centres_between_the_beams",
    "no_place_of_a_wall_is_ever_inside",
    "every_world_is_closed",
    "only_the_outline_finds_a_way",
    "walls_longer_or_farther_than_can_be_held",
    "that_of_the_naive_grid",
    "in_any_order_of_things",
    "of_a_chessboard_are_all_found",
    "touch_what_sampled_poses_touch",
    "wavefront_ways_are_free",
    "none_beats_the_visibility_graph",
    "what_changed_makes_the_old_field",
    "the_proof_of_no_path",
];

/// Runs the named suites, or all of them if none is named; first installs what they lack.
///
/// # Errors
/// If a suite fails; the others still run. In CI, also if something was skipped that may not be.
pub fn run(suites: &[Suite]) -> Result<()> {
    let suites = if suites.is_empty() { &ALL } else { suites };
    skips::begin()?;
    let mut report = Report::default();
    let missing = setup::missing(suites);
    if !missing.is_empty() {
        report.step("set-up", || setup::install(&missing));
    }
    for suite in suites {
        match suite {
            Suite::Quick => quick(&mut report),
            Suite::Native => report.step("native tests", native),
            Suite::Wasm => report.step("tests in the browser", wasm::test),
            Suite::Page => report.step("the page", the_page),
            Suite::Firmware => report.step("the firmware", firmware::test),
        }
    }
    report.finish_with(&skips::all()?, tools::is_ci())
}

fn quick(report: &mut Report) {
    report.step("house rules", rules::check);
    report.step("order of imports, and the commands", || {
        tools::run_cargo("test --quiet --package xtask")
    });
    report.step("types of the page", page::check_types_of_last_build);
    report.step("types of the page's tests", page::check_types_of_tests);
    report.step("unit tests of core", || {
        let mut cargo = tools::cargo();
        cargo.args("test --quiet --package slamlab-core --lib --".split(' '));
        for test in SLOW {
            cargo.args(["--skip", test]);
        }
        tools::run(&mut cargo)
    });
}

fn native() -> Result<()> {
    // Examples are compiled by `cargo xtask check`. xtask is run separately: together, cargo would
    // unify their features and compile the wasm-bindgen tool once more.
    let most = "test --workspace --exclude xtask --exclude slamlab-storage-report --no-fail-fast";
    let steps = [
        tools::run_cargo(&format!("{most} --lib --bins --tests")),
        tools::run_cargo(&format!("{most} --doc")),
        tools::run_cargo("test --package xtask"),
    ];
    steps.into_iter().collect()
}

fn the_page() -> Result<()> {
    let chrome = tools::chrome()?;
    let folder = tools::root().join("tests/page");
    let (bridge, real_firmware) = thread::scope(|scope| {
        // In parallel with the module, whose last step keeps only one core busy.
        let real_firmware = scope.spawn(firmware::build_simulator);
        let bridge = page::build_with_bridge(Profile::Release, PROGRAMS)?;
        page::install(&folder)?;
        anyhow::Ok((bridge, tools::joined(real_firmware)?))
    })?;
    let site = tools::target_dir().join("page-tests/dist");
    dist::fill_from(&tools::root().join("www/dist"), &site)?;
    let package = npm::pack_built(&tools::target_dir().join("page-tests/npm"))?;
    let mut npm = tools::npm(&folder)?;
    npm.env("CHROME", chrome)
        .env("SLAMLAB_BRIDGE", bridge)
        // The run on the command line must equal the one in the page to the bit.
        .env("SLAMLAB_SIMULATE", tools::built("debug/examples/simulate"))
        .env(
            "SLAMLAB_WIRED_ROBOT",
            tools::built("debug/examples/wired_robot"),
        )
        .env("SLAMLAB_RP6_SIM", real_firmware.unwrap_or_default())
        .env("SLAMLAB_DIST", site)
        .env("SLAMLAB_NPM", package);
    tools::run(npm.args(["run", "--silent", "test"]))
}

//! From `web`, in Rust, to `www/pkg`: the WebAssembly module, its JavaScript bindings and their
//! types.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::thread;

use anyhow::{Context, Result};

use crate::tools;

/// Compiles what runs tests in a browser (`.cargo/config.toml`).
const RUNNER: &str = "build --package xtask --features wasm-tests --bin wasm-test-runner";

/// How the module is compiled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Profile {
    /// Optimised, cargo profile `wasm`.
    Release,
    /// Quick to compile, slow to run, cargo profile `wasm-dev`.
    Dev,
}

impl Profile {
    /// Cargo's name of the profile, and of its folder under `target`.
    fn name(self) -> &'static str {
        match self {
            Self::Release => "wasm",
            Self::Dev => "wasm-dev",
        }
    }
}

const TARGET: &str = "wasm32-unknown-unknown";

/// Runs the tests that are compiled for wasm32, in headless Chromium. What they stand on is
/// compiled as it is for the page, once for both.
///
/// # Errors
/// If the wasm32 target or the browser is missing, or a test fails.
pub fn test() -> Result<()> {
    tools::need_wasm_target()?;
    let cargo = |arguments: &str| {
        let mut cargo = tools::cargo();
        cargo.args("test --package slamlab-tests --package slamlab-web --tests".split(' '));
        cargo.args([
            "--target",
            TARGET,
            "--profile",
            Profile::Release.name(),
            arguments,
        ]);
        cargo
    };
    // Cargo would compile the program that runs them only when they are there.
    thread::scope(|scope| {
        let runner = scope.spawn(|| tools::run_cargo(RUNNER));
        tools::run(&mut cargo("--no-run"))?;
        tools::joined(runner)
    })?;
    tools::run(
        cargo("--no-fail-fast")
            .env("CHROME", tools::chrome()?)
            .env("CHROMEDRIVER", tools::chromedriver()?),
    )
}

/// Compiles the module and returns its file.
///
/// # Errors
/// If the wasm32 target is missing or the sources do not compile.
pub fn compile(profile: Profile) -> Result<PathBuf> {
    tools::need_wasm_target()?;
    let name = profile.name();
    tools::run_cargo(&format!(
        "build --package slamlab-web --target {TARGET} --profile {name}"
    ))?;
    Ok(tools::target_dir().join(format!("{TARGET}/{name}/slamlab_web.wasm")))
}

/// Compiles the program that makes bindings and returns it.
///
/// # Errors
/// If it does not compile.
pub fn build_binder() -> Result<PathBuf> {
    tools::run_cargo("build --package xtask --features bindings --bin make-bindings")?;
    Ok(tools::built("debug/make-bindings"))
}

/// Writes `slamlab_web.js`, `slamlab_web.d.ts` and `slamlab_web_bg.wasm` into `www/pkg`, unless
/// they were made from this very module.
///
/// # Errors
/// If the bindings cannot be made.
pub fn bind(binder: &Path, module: &Path, profile: Profile) -> Result<()> {
    let out = tools::root().join("www/pkg");
    let stamp = stamp(module)?;
    let stamp_file = out.join(".made-from");
    if fs::read_to_string(&stamp_file).is_ok_and(|made_from| made_from == stamp) {
        return Ok(());
    }
    if out.exists() {
        fs::remove_dir_all(&out).with_context(|| format!("cannot empty {}", out.display()))?;
    }
    let mut bind = Command::new(binder);
    bind.arg(module).arg(&out);
    if profile == Profile::Dev {
        bind.arg("--debug");
    }
    tools::run(&mut bind)?;
    fs::write(&stamp_file, stamp)?;
    report_size(&out.join("slamlab_web_bg.wasm"))
}

/// Which module this is: path, size and time of the last change.
fn stamp(module: &Path) -> Result<String> {
    let facts = fs::metadata(module).with_context(|| format!("{} is missing", module.display()))?;
    Ok(format!(
        "{} {} {:?}",
        module.display(),
        facts.len(),
        facts.modified()?
    ))
}

fn report_size(module: &Path) -> Result<()> {
    let bytes = fs::metadata(module)
        .with_context(|| format!("{} was not made", module.display()))?
        .len();
    eprintln!("  module: {} kB before compression", bytes / 1000);
    Ok(())
}

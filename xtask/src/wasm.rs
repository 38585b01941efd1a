//! From `web`, in Rust, to `www/pkg`: the WebAssembly modules, their JavaScript bindings and their
//! types.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::thread;

use anyhow::{Context, Result};

use crate::tools;

/// Compiles the program that runs tests in a browser (`.cargo/config.toml`).
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
    /// Cargo's name for the profile, and for its folder under `target`.
    fn name(self) -> &'static str {
        match self {
            Self::Release => "wasm",
            Self::Dev => "wasm-dev",
        }
    }
}

const TARGET: &str = "wasm32-unknown-unknown";

/// Runs the tests that are compiled for wasm32, in headless Chromium. Their dependencies are
/// compiled as for the page, once for both.
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
    // Cargo would otherwise compile the program that runs them only after the tests.
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

/// The modules of the page, each with the feature of `web` that it is compiled with
/// (`web/src/lib.rs`).
const MODULES: [(&str, &str); 4] = [
    ("slamlab_web", "run"),
    ("slamlab_files", "files"),
    ("slamlab_lab", "lab"),
    ("slamlab_cable", "cable"),
];

/// A compiled module: the page's name for it, and its file.
pub type Module = (&'static str, PathBuf);

/// Compiles the modules. They are one package, and each overwrites the same file: so each is copied
/// to a file of its own.
///
/// # Errors
/// If the wasm32 target is missing or the sources do not compile.
pub fn compile(profile: Profile) -> Result<Vec<Module>> {
    tools::need_wasm_target()?;
    let name = profile.name();
    let folder = tools::target_dir().join(format!("{TARGET}/{name}"));
    let mut modules = vec![];
    for (module, feature) in MODULES {
        tools::run_cargo(&format!(
            "build --package slamlab-web --lib --target {TARGET} --profile {name} --no-default-features --features {feature}"
        ))?;
        let (built, own) = (
            folder.join("slamlab_web.wasm"),
            folder.join(format!("modules/{module}.wasm")),
        );
        copy_if_changed(&built, &own)?;
        modules.push((module, own));
    }
    Ok(modules)
}

/// Leaves an identical copy and its time stamp alone: what was made from it is still valid.
fn copy_if_changed(from: &Path, to: &Path) -> Result<()> {
    let bytes = fs::read(from).with_context(|| format!("cannot read {}", from.display()))?;
    if fs::read(to).is_ok_and(|old| old == bytes) {
        return Ok(());
    }
    if let Some(folder) = to.parent() {
        fs::create_dir_all(folder)?;
    }
    fs::write(to, bytes).with_context(|| format!("cannot write {}", to.display()))
}

/// Compiles the program that makes bindings and returns its path.
///
/// # Errors
/// If it does not compile.
pub fn build_binder() -> Result<PathBuf> {
    tools::run_cargo(
        "build --package xtask --features bindings --bin make-bindings --bin split-module",
    )?;
    Ok(tools::built("debug/make-bindings"))
}

/// Writes `NAME.js`, `NAME.d.ts` and `NAME_bg.wasm` of each module into `www/pkg`, unless they were
/// made from these same modules.
///
/// # Errors
/// If the bindings cannot be made.
pub fn bind(binder: &Path, modules: &[Module], profile: Profile) -> Result<()> {
    let out = tools::root().join("www/pkg");
    let stamps: Vec<String> = modules
        .iter()
        .map(|(_, module)| stamp(module))
        .collect::<Result<_>>()?;
    let stamp = stamps.join("\n");
    let stamp_file = out.join(".made-from");
    if fs::read_to_string(&stamp_file).is_ok_and(|made_from| made_from == stamp) {
        return Ok(());
    }
    if out.exists() {
        fs::remove_dir_all(&out).with_context(|| format!("cannot empty {}", out.display()))?;
    }
    for (_, module) in modules {
        let mut bind = Command::new(binder);
        bind.arg(module).arg(&out);
        if profile == Profile::Dev {
            bind.arg("--debug");
        }
        tools::run(&mut bind)?;
    }
    // The positions of numbers in the modules' flat arrays, for the page and its package.
    tools::run(tools::node(&tools::root().join("www"))?.arg("layout.mjs"))?;
    fs::write(&stamp_file, stamp)?;
    for (name, _) in modules {
        report_size(&out.join(format!("{name}_bg.wasm")))?;
    }
    Ok(())
}

/// Splits the module of runs into what a first visit runs and the rest, in `www/pkg/split`, unless
/// that was already done. `www/first_visit.mjs`, which needs npm's packages, finds out what is run.
///
/// # Errors
/// If the module cannot be split, or a first visit fails.
pub fn split() -> Result<()> {
    let www = tools::root().join("www");
    let out = www.join("pkg/split");
    let visit = fs::read_to_string(www.join("first_visit.mjs"))?;
    // The visit by which it was split.
    let split_by = www.join("pkg/.split-by");
    if fs::read_to_string(&split_by).is_ok_and(|by| by == visit) {
        return Ok(());
    }
    if out.exists() {
        fs::remove_dir_all(&out).with_context(|| format!("cannot empty {}", out.display()))?;
    }
    let splitter = tools::built("debug/split-module");
    let module = www.join("pkg/slamlab_web_bg.wasm");
    let folder = tools::target_dir().join("split");
    fs::create_dir_all(&folder)?;
    let (counting, called) = (folder.join("counting.wasm"), folder.join("called.json"));
    let mut count = Command::new(&splitter);
    tools::run(count.arg("count").args([&module, &counting]))?;
    let mut visitor = tools::node(&www)?;
    tools::run(visitor.arg("first_visit.mjs").args([&counting, &called]))?;
    // All or nothing: what is there is not made again.
    let unfinished = www.join("pkg/split.unfinished");
    let mut split = Command::new(&splitter);
    tools::run(split.arg("split").args([&module, &called, &unfinished]))?;
    fs::rename(&unfinished, &out).with_context(|| format!("cannot make {}", out.display()))?;
    Ok(fs::write(&split_by, visit)?)
}

/// Identifies a module: path, size and time of the last change.
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
    let name = module.file_stem().unwrap_or_default().to_string_lossy();
    eprintln!("  {name}: {} kB before compression", bytes / 1000);
    Ok(())
}

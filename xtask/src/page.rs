//! From `www`, in TypeScript, and the module in `www/pkg`, to `www/dist`: the page as a browser
//! loads it.
//!
//! Independent steps run in parallel: the module and the programs of this machine have separate
//! build folders, and npm needs neither.

use std::fs;
use std::path::{Path, PathBuf};
use std::thread;

use anyhow::{Context, Result};

use crate::tools;
use crate::wasm::{self, Profile};

/// Compiles the module, bundles the page, and compresses its files if they are for use.
///
/// # Errors
/// If a tool is missing or a step fails.
pub fn build(profile: Profile) -> Result<()> {
    make_module(profile)?;
    let www = tools::root().join("www");
    tools::run(tools::npm(&www)?.args(["run", "--silent", "build"]))?;
    match profile {
        Profile::Release => compress(&www.join("dist")),
        // For a page that is tried once, compression takes longer than sending.
        Profile::Dev => Ok(()),
    }
}

/// [`build`], and in parallel the bridge and whatever else cargo compiles with these arguments;
/// returns the path of the bridge.
///
/// # Errors
/// As [`build`], and if the programs do not compile.
pub fn build_with_bridge(profile: Profile, arguments: &str) -> Result<PathBuf> {
    thread::scope(|scope| {
        let programs = scope.spawn(|| tools::run_cargo(arguments));
        build(profile).and(tools::joined(programs))
    })?;
    Ok(tools::built("debug/slamlab-bridge"))
}

/// Type-checks the page.
///
/// # Errors
/// If a tool is missing or a type is wrong.
pub fn check_types() -> Result<()> {
    make_module(Profile::Release)?;
    check_types_of_last_build()
}

/// Type-checks the page against the bindings of the last build; makes them quickly if there are
/// none.
///
/// # Errors
/// If a tool is missing or a type is wrong.
pub fn check_types_of_last_build() -> Result<()> {
    let www = tools::root().join("www");
    if !www.join("pkg/slamlab_cable.d.ts").is_file() {
        make_module(Profile::Dev)?;
    }
    install(&www)?;
    tools::run(tools::npm(&www)?.args(["run", "--silent", "types"]))
}

/// Type-checks the page's tests.
///
/// # Errors
/// If a tool is missing or a type is wrong.
pub fn check_types_of_tests() -> Result<()> {
    // They use types of the page, which use those of its packages.
    install(&tools::root().join("www"))?;
    let folder = tools::root().join("tests/page");
    install(&folder)?;
    tools::run(tools::npm(&folder)?.args(["run", "--silent", "types"]))
}

/// The modules and their bindings in `www/pkg`, and npm's packages.
///
/// # Errors
/// If a tool is missing or a step fails.
pub fn make_module(profile: Profile) -> Result<()> {
    thread::scope(|scope| {
        let packages = scope.spawn(|| install(&tools::root().join("www")));
        let binder = scope.spawn(wasm::build_binder);
        let modules = wasm::compile(profile)?;
        wasm::bind(&tools::joined(binder)?, &modules, profile)?;
        tools::joined(packages)
    })?;
    match profile {
        Profile::Release => wasm::split(),
        // What is tried once is loaded from this machine.
        Profile::Dev => Ok(()),
    }
}

/// Installs the packages that `folder`'s lock file names, unless they are there. Browsers are never
/// downloaded.
///
/// # Errors
/// If npm is missing or cannot install.
pub fn install(folder: &Path) -> Result<()> {
    let lock = folder.join("package-lock.json");
    let lock = fs::read(&lock).with_context(|| format!("cannot read {}", lock.display()))?;
    let installed = folder.join("node_modules/.installed-lock.json");
    if fs::read(&installed).is_ok_and(|installed| installed == lock) {
        return Ok(());
    }
    tools::run(
        tools::npm(folder)?
            .args(["ci", "--no-audit", "--no-fund", "--loglevel", "error"])
            .env("PLAYWRIGHT_SKIP_BROWSER_DOWNLOAD", "1"),
    )?;
    fs::create_dir_all(folder.join("node_modules"))?;
    fs::write(&installed, lock).with_context(|| format!("cannot write {}", installed.display()))
}

/// Puts `.br` and `.gz` beside each file that becomes smaller; the bridge sends those. Node has
/// both codecs built in.
fn compress(dist: &Path) -> Result<()> {
    let script = tools::root().join("xtask/compress.mjs");
    tools::run(tools::node(dist)?.arg(script).arg("."))
}

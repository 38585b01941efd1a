//! From `www`, in TypeScript, and the module in `www/pkg`, to `www/dist`: the page as a browser loads it.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result};

use crate::tools;
use crate::wasm::{self, Profile};

/// Compiles the module, bundles the page, and compresses every file beforehand.
///
/// # Errors
/// If a tool is missing or a step fails.
pub fn build(profile: Profile) -> Result<()> {
    let www = tools::root().join("www");
    wasm::build(profile)?;
    install(&www)?;
    tools::run(tools::npm(&www)?.args(["run", "--silent", "build"]))?;
    compress(&www.join("dist"))
}

/// Type-checks the page.
///
/// # Errors
/// If a tool is missing or a type is wrong.
pub fn check_types() -> Result<()> {
    let www = tools::root().join("www");
    wasm::build(Profile::Release)?;
    install(&www)?;
    tools::run(tools::npm(&www)?.args(["run", "--silent", "types"]))
}

/// Installs the packages that `folder`'s lock file names, unless they are there. Browsers are never downloaded.
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

/// Puts `.br` and `.gz` beside each file that shrinks by it; the bridge sends those. Node has both codecs built in.
fn compress(dist: &Path) -> Result<()> {
    let script = tools::root().join("xtask/compress.mjs");
    tools::run(tools::node(dist)?.arg(script).arg("."))
}

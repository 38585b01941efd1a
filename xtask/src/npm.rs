//! The WebAssembly modules as npm installs them: bindings, types, a description, and a README with
//! an example. This is a separate command from the one for the page's folder, because a program
//! that uses the modules does not need the page.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};

use crate::{page, tools};

/// The version of the whole workspace.
const VERSION: &str = env!("CARGO_PKG_VERSION");
/// The placeholder for it in the description.
const PLACE: &str = "\"version\": \"0.0.0\"";

/// Builds the modules, assembles the package below `out` (`target/npm` if none is named), and packs
/// it; returns the packed file.
///
/// # Errors
/// If a tool is missing or a step fails.
pub fn pack(out: Option<PathBuf>) -> Result<PathBuf> {
    page::make_module(crate::wasm::Profile::Release)?;
    pack_built(&out.unwrap_or_else(|| tools::target_dir().join("npm")))
}

/// As [`pack`], from modules that are already built.
///
/// # Errors
/// If a file is missing, or npm cannot pack.
pub fn pack_built(out: &Path) -> Result<PathBuf> {
    let out = std::path::absolute(out)?;
    let package = out.join("package");
    if package.exists() {
        fs::remove_dir_all(&package)
            .with_context(|| format!("cannot empty {}", package.display()))?;
    }
    fs::create_dir_all(&package).with_context(|| format!("cannot make {}", package.display()))?;
    let root = tools::root();
    copy_all(&root.join("web/npm"), &package, |_| true)?;
    copy_all(&root.join("www/pkg"), &package, |name| {
        name.starts_with("slamlab_") && !name.ends_with("_bg.wasm.d.ts")
    })?;
    for licence in ["LICENSE-MIT", "LICENSE-APACHE"] {
        copy(&root.join(licence), &package.join(licence))?;
    }
    number(&package.join("package.json"))?;
    name_columns(&package)?;
    let mut npm = tools::npm(&package)?;
    npm.args(["pack", "--silent", "--pack-destination", ".."]);
    tools::output(&mut npm)?;
    Ok(out.join(format!("slamlab-{VERSION}.tgz")))
}

/// Writes the version into the description: the workspace's is the only one maintained.
fn number(description: &Path) -> Result<()> {
    let text = fs::read_to_string(description)?;
    let numbered = text.replace(PLACE, &format!("\"version\": \"{VERSION}\""));
    anyhow::ensure!(numbered != text, "{} has no {PLACE}", description.display());
    Ok(fs::write(description, numbered)?)
}

/// Makes `layout.js` with its types, from the modules' description of their flat arrays.
fn name_columns(package: &Path) -> Result<()> {
    let www = tools::root().join("www");
    let mut compile = tools::node(&www)?;
    compile
        .arg("node_modules/typescript/bin/tsc")
        .args([
            "pkg/layout.ts",
            "--ignoreConfig",
            "--declaration",
            "--target",
            "es2022",
        ])
        .args(["--module", "esnext", "--types", "", "--outDir"])
        .arg(package);
    tools::run(&mut compile)
}

fn copy_all(from: &Path, to: &Path, is_wanted: impl Fn(&str) -> bool) -> Result<()> {
    for entry in fs::read_dir(from).with_context(|| format!("cannot read {}", from.display()))? {
        let entry = entry?;
        let name = entry.file_name();
        if is_wanted(&name.to_string_lossy()) {
            copy(&entry.path(), &to.join(name))?;
        }
    }
    Ok(())
}

fn copy(from: &Path, to: &Path) -> Result<()> {
    fs::copy(from, to)
        .with_context(|| format!("cannot copy {}", from.display()))
        .map(drop)
}

//! From `web`, in Rust, to `www/pkg`: the WebAssembly module, its JavaScript bindings and their types.
//!
//! The library form of wasm-bindgen's tool is part of this program, so there is nothing to install, and cargo pins it
//! to the version of the crate: the two must be equal.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result};
use wasm_bindgen_cli_support::Bindgen;

use crate::tools;

/// How the module is compiled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Profile {
    /// Optimised, cargo profile `wasm`.
    Release,
    /// Quick to compile, slow to run, cargo profile `dev`.
    Dev,
}

impl Profile {
    /// Cargo's name of the profile, and of its folder under `target`.
    fn names(self) -> (&'static str, &'static str) {
        match self {
            Self::Release => ("wasm", "wasm"),
            Self::Dev => ("dev", "debug"),
        }
    }
}

/// Compiles the module and writes `slamlab_web.js`, `slamlab_web.d.ts` and `slamlab_web_bg.wasm` into `www/pkg`.
///
/// # Errors
/// If the wasm32 target is missing, the sources do not compile, or the bindings cannot be made.
pub fn build(profile: Profile) -> Result<()> {
    tools::need_wasm_target()?;
    let (name, folder) = profile.names();
    tools::run(tools::cargo().args([
        "build",
        "--package",
        "slamlab-web",
        "--target",
        "wasm32-unknown-unknown",
        "--profile",
        name,
    ]))?;
    let module = tools::target_dir()
        .join("wasm32-unknown-unknown")
        .join(folder)
        .join("slamlab_web.wasm");
    bind(&module, &tools::root().join("www/pkg"), profile)
}

/// Makes the bindings of `module` in `out`, unless they were made from this very module.
fn bind(module: &Path, out: &Path, profile: Profile) -> Result<()> {
    let stamp = stamp(module)?;
    let stamp_file = out.join(".made-from");
    if fs::read_to_string(&stamp_file).is_ok_and(|made_from| made_from == stamp) {
        return Ok(());
    }
    if out.exists() {
        fs::remove_dir_all(out).with_context(|| format!("cannot empty {}", out.display()))?;
    }
    let release = profile == Profile::Release;
    Bindgen::new()
        .input_path(module)
        .web(true)?
        .typescript(true)
        .debug(!release)
        .keep_debug(!release)
        .remove_name_section(false)
        .remove_producers_section(true)
        .generate(out)
        .with_context(|| format!("wasm-bindgen cannot process {}", module.display()))?;
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

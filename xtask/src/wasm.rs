//! From `web`, in Rust, to `www/pkg`: the WebAssembly module, its JavaScript bindings and their
//! types.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result};

use crate::tools;

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

/// Compiles the module and returns its file.
///
/// # Errors
/// If the wasm32 target is missing or the sources do not compile.
pub fn compile(profile: Profile) -> Result<PathBuf> {
    tools::need_wasm_target()?;
    const TARGET: &str = "wasm32-unknown-unknown";
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

//! The robot's firmware, compiled by avr-gcc and run in simavr.

use std::path::PathBuf;
use std::process::Command;

use anyhow::Result;

use crate::tools;

/// Compiles the firmware and runs its tests, where everything they need is there; else says what is missing, and passes.
///
/// # Errors
/// If the firmware does not compile without warnings, or a test fails.
pub fn test() -> Result<()> {
    if is_missing("the firmware's tests") {
        return Ok(());
    }
    tools::run(cargo("test").arg("--no-fail-fast"))
}

/// Compiles the real firmware's robot on a pseudo-terminal; `None`, and a sentence, where what it needs is not there.
///
/// # Errors
/// If it does not compile.
pub fn build_simulator() -> Result<Option<PathBuf>> {
    if is_missing("the test with the real firmware") {
        return Ok(None);
    }
    tools::run(cargo("build").args(["--bin", "rp6_sim"]))?;
    Ok(Some(tools::target_dir().join("debug/rp6_sim")))
}

fn is_missing(what: &str) -> bool {
    let missing = missing();
    if !missing.is_empty() {
        eprintln!(
            "skipped: {what} needs {}. On Debian: sudo apt-get install gcc-avr avr-libc make pkg-config libclang-dev \
             libelf-dev zlib1g-dev libzstd-dev",
            missing.join(", ")
        );
    }
    !missing.is_empty()
}

/// Cargo, in the workspace of the firmware's tests.
fn cargo(command: &str) -> Command {
    let manifest = tools::root().join("tests/firmware/Cargo.toml");
    let mut cargo = tools::cargo();
    cargo.env("CARGO_TARGET_DIR", tools::target_dir());
    // libclang alone does not bring the compiler's own headers.
    if let Some(headers) = compiler_headers() {
        cargo.env(
            "BINDGEN_EXTRA_CLANG_ARGS",
            format!("-I{}", headers.display()),
        );
    }
    cargo.arg(command).arg("--manifest-path").arg(manifest);
    cargo
}

fn missing() -> Vec<&'static str> {
    let programs = ["avr-gcc", "avr-objcopy", "make", "cc", "pkg-config"];
    let absent = |name: &&str| tools::in_path(name).is_none();
    let mut missing: Vec<_> = programs.into_iter().filter(absent).collect();
    let libraries = ["libelf", "zlib", "libzstd"];
    missing.extend(libraries.into_iter().filter(|name| !has_library(name)));
    if !cfg!(target_os = "linux") {
        missing.push("Linux");
    } else if !has_libclang() {
        missing.push("libclang");
    }
    missing
}

fn has_library(name: &str) -> bool {
    let mut pkg_config = Command::new("pkg-config");
    pkg_config
        .args(["--exists", name])
        .status()
        .is_ok_and(|status| status.success())
}

/// Where bindgen looks for it: the variable, or LLVM's folders.
fn has_libclang() -> bool {
    if std::env::var_os("LIBCLANG_PATH").is_some() {
        return true;
    }
    let folders = [
        "/usr/lib",
        "/usr/lib64",
        "/usr/lib/x86_64-linux-gnu",
        "/usr/lib/aarch64-linux-gnu",
    ];
    let of_versions = std::fs::read_dir("/usr/lib")
        .into_iter()
        .flatten()
        .flatten()
        .filter(|entry| entry.file_name().to_string_lossy().starts_with("llvm"))
        .map(|entry| entry.path().join("lib"));
    folders
        .iter()
        .map(PathBuf::from)
        .chain(of_versions)
        .any(|folder| holds_libclang(&folder))
}

fn holds_libclang(folder: &std::path::Path) -> bool {
    let is_it = |name: String| {
        name.starts_with("libclang") && !name.starts_with("libclang-cpp") && name.contains(".so")
    };
    std::fs::read_dir(folder)
        .into_iter()
        .flatten()
        .flatten()
        .any(|entry| is_it(entry.file_name().to_string_lossy().into_owned()))
}

fn compiler_headers() -> Option<PathBuf> {
    let output = Command::new("cc")
        .arg("-print-file-name=include")
        .output()
        .ok()?;
    let path = PathBuf::from(String::from_utf8_lossy(&output.stdout).trim());
    path.is_absolute().then_some(path)
}

//! The robot's firmware, compiled by avr-gcc and run in simavr.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::Result;

use crate::suites::Suite;
use crate::{setup, skips, tools};

/// Compiles the firmware and runs its tests, if everything they need is there; otherwise reports
/// what is missing, and passes.
///
/// # Errors
/// If the firmware does not compile without warnings, or a test fails.
pub fn test() -> Result<()> {
    if is_skipped("the firmware's tests")? {
        return Ok(());
    }
    tools::run(cargo("test").arg("--no-fail-fast"))
}

/// Compiles the robot with the real firmware on a pseudo-terminal; `None`, and a message, if
/// something that it needs is missing.
///
/// # Errors
/// If it does not compile.
pub fn build_simulator() -> Result<Option<PathBuf>> {
    if is_skipped("the page's tests with the real firmware")? {
        return Ok(None);
    }
    tools::run(cargo("build").args(["--bin", "rp6_sim"]))?;
    Ok(Some(tools::target_dir().join("debug/rp6_sim")))
}

/// Whether this cannot run here; it is then recorded as skipped.
fn is_skipped(what: &str) -> Result<bool> {
    let missing = missing();
    if missing.is_empty() {
        return Ok(false);
    }
    skips::note(what, &format!("it needs {}", missing.join(", ")))?;
    Ok(true)
}

/// Cargo in the workspace of the firmware's tests.
fn cargo(command: &str) -> Command {
    let manifest = tools::root().join("tests/firmware/Cargo.toml");
    let mut cargo = tools::cargo();
    cargo.env("CARGO_TARGET_DIR", tools::target_dir());
    // libclang alone does not include the compiler's own headers.
    if let Some(headers) = compiler_headers() {
        cargo.env(
            "BINDGEN_EXTRA_CLANG_ARGS",
            format!("-I{}", headers.display()),
        );
    }
    cargo.arg(command).arg("--manifest-path").arg(manifest);
    cargo
}

/// What is missing, by the names of Debian's packages.
fn missing() -> Vec<&'static str> {
    let mut missing = setup::missing(&[Suite::Firmware]);
    if !tools::is_in_path("cc") {
        missing.push("a C compiler");
    }
    if !cfg!(target_os = "linux") {
        missing.push("Linux");
    }
    missing
}

/// Whether the compiler for the robot's processor finds its C library.
#[must_use]
pub fn has_avr_libc() -> bool {
    let mut compiler = Command::new("avr-gcc");
    file_of(compiler.args(["-mmcu=atmega32", "-print-file-name=libc.a"])).is_some()
}

/// Whether this library is there to compile against.
#[must_use]
pub fn has_library(name: &str) -> bool {
    let mut pkg_config = Command::new("pkg-config");
    tools::quiet_output(pkg_config.args(["--exists", name])).is_ok()
}

/// Whether libclang is where bindgen looks for it: in the folder named by the variable, or in
/// LLVM's folders.
#[must_use]
pub fn has_libclang() -> bool {
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

fn holds_libclang(folder: &Path) -> bool {
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
    file_of(Command::new("cc").arg("-print-file-name=include"))
}

/// The file that a compiler names; it names a file that it does not find without a folder.
fn file_of(compiler: &mut Command) -> Option<PathBuf> {
    let path = PathBuf::from(tools::quiet_output(compiler).ok()?);
    path.is_absolute().then_some(path)
}

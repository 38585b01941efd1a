//! Finds the programs that the commands need, runs them in the repository, and says how to install
//! a missing one.

use std::env;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Stdio};
use std::thread::ScopedJoinHandle;

use anyhow::{Context, Result, anyhow, bail};

use crate::skips;

/// The repository's root.
#[must_use]
pub fn root() -> PathBuf {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.parent().unwrap_or(here).to_owned()
}

/// The folder of cargo's output: `CARGO_TARGET_DIR`, or `target`.
#[must_use]
pub fn target_dir() -> PathBuf {
    match env::var_os("CARGO_TARGET_DIR") {
        Some(dir) => root().join(dir),
        None => root().join("target"),
    }
}

/// A program under [`target_dir`], by its path without the extension that Windows needs.
#[must_use]
pub fn built(program: &str) -> PathBuf {
    target_dir()
        .join(program)
        .with_extension(env::consts::EXE_EXTENSION)
}

/// Whether this runs in CI, where nothing may be left out: `CI` is set.
#[must_use]
pub fn is_ci() -> bool {
    env::var_os("CI").is_some_and(|value| !["", "0", "false"].contains(&&*value.to_string_lossy()))
}

/// Recorded data for tests: the folder beside the repository, or the one that `SLAMLAB_DATA` names.
#[must_use]
pub fn data_folder() -> PathBuf {
    match env::var_os("SLAMLAB_DATA") {
        Some(folder) => folder.into(),
        None => root().join("../shared/data"),
    }
}

/// The cargo that runs this command, at the repository's root.
#[must_use]
pub fn cargo() -> Command {
    let mut command = Command::new(env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.current_dir(root());
    if is_ci() && env::var_os("CARGO_INCREMENTAL").is_none() {
        // Incremental compilation pays off only for repeated builds, which never happen here.
        command.env("CARGO_INCREMENTAL", "0");
    }
    with_places(command)
}

/// Runs cargo with these arguments, see [`run`].
///
/// # Errors
/// If it fails.
pub fn run_cargo(words: &str) -> Result<()> {
    run(cargo().args(words.split(' ')))
}

/// Adds where tests find recorded data, and where they record what they leave out.
fn with_places(mut command: Command) -> Command {
    command
        .env("SLAMLAB_DATA", data_folder())
        .env("SLAMLAB_SKIPPED", skips::file());
    command
}

/// Node, in `folder`.
///
/// # Errors
/// If it is not installed.
pub fn node(folder: &Path) -> Result<Command> {
    let mut command = Command::new(need("node", NODE)?);
    command.current_dir(folder);
    Ok(command)
}

/// npm, in `folder`.
///
/// # Errors
/// If it is not installed.
pub fn npm(folder: &Path) -> Result<Command> {
    let mut command = Command::new(need("npm", NODE)?);
    command.current_dir(folder);
    Ok(with_places(command))
}

const NODE: &str = "install Node 20 or later: `sudo apt-get install nodejs npm`, `brew install node`, or \
                    `winget install OpenJS.NodeJS.LTS`";

/// Chromium or Chrome: the one that the variable `CHROME` names, one in the path, or the one that
/// Playwright has installed.
///
/// # Errors
/// If none is installed.
pub fn chrome() -> Result<PathBuf> {
    find_chrome().context(
        "Chromium is missing; install it by `npx --prefix tests/page playwright install chromium`, \
         `sudo apt-get install chromium` or `brew install --cask chromium`, or name an installed one \
         in the variable CHROME",
    )
}

/// [`chrome`], if there is one.
#[must_use]
pub fn find_chrome() -> Option<PathBuf> {
    let names = [
        "chromium",
        "chromium-browser",
        "google-chrome",
        "google-chrome-stable",
    ];
    env::var_os("CHROME")
        .map(PathBuf::from)
        .or_else(|| names.iter().find_map(|name| in_path(name)))
        .or_else(playwright_chromium)
}

/// The newest Chromium that `playwright install` has installed.
fn playwright_chromium() -> Option<PathBuf> {
    let home = || env::var_os("HOME").map(PathBuf::from);
    let folder = match env::var_os("PLAYWRIGHT_BROWSERS_PATH") {
        Some(folder) => folder.into(),
        None if cfg!(target_os = "macos") => home()?.join("Library/Caches/ms-playwright"),
        None if cfg!(windows) => PathBuf::from(env::var_os("LOCALAPPDATA")?).join("ms-playwright"),
        None => home()?.join(".cache/ms-playwright"),
    };
    let number = |path: &Path| -> Option<u32> {
        let name = path.file_name()?.to_str()?;
        name.strip_prefix("chromium-")?.parse().ok()
    };
    let mut versions: Vec<(u32, PathBuf)> = std::fs::read_dir(folder)
        .ok()?
        .flatten()
        .filter_map(|entry| Some((number(&entry.path())?, entry.path())))
        .collect();
    versions.sort();
    let programs = [
        "chrome-linux64/chrome",
        "chrome-linux/chrome",
        "chrome-mac/Chromium.app/Contents/MacOS/Chromium",
        "chrome-win64/chrome.exe",
        "chrome-win/chrome.exe",
    ];
    versions
        .iter()
        .rev()
        .flat_map(|(_, version)| programs.map(|program| version.join(program)))
        .find(|program| program.is_file())
}

/// chromedriver: the one that the variable `CHROMEDRIVER` names, or one in the path.
///
/// # Errors
/// If none is installed.
pub fn chromedriver() -> Result<PathBuf> {
    find_chromedriver().context(
        "chromedriver is missing; install it by `sudo apt-get install chromium-driver` or \
         `brew install --cask chromedriver`, or name an installed one in the variable CHROMEDRIVER",
    )
}

/// [`chromedriver`], if there is one.
#[must_use]
pub fn find_chromedriver() -> Option<PathBuf> {
    env::var_os("CHROMEDRIVER")
        .map(PathBuf::from)
        .or_else(|| in_path("chromedriver"))
}

/// Debian's tool for packages.
///
/// # Errors
/// If it is not installed.
pub fn dpkg_deb() -> Result<PathBuf> {
    need("dpkg-deb", "install it by `sudo apt-get install dpkg`")
}

/// Makes sure that rustc can compile for wasm32: adds the target by rustup if it is missing.
///
/// # Errors
/// If it is missing and rustup cannot add it.
pub fn need_wasm_target() -> Result<()> {
    need_target("wasm32-unknown-unknown")
}

/// Makes sure that rustc can compile for `target`: adds it by rustup if it is missing.
///
/// # Errors
/// If it is missing and rustup cannot add it.
pub fn need_target(target: &str) -> Result<()> {
    let mut rustc = Command::new(env::var_os("RUSTC").unwrap_or_else(|| "rustc".into()));
    let output = rustc
        .current_dir(root())
        .args(["--print", "target-libdir", "--target", target])
        .output()
        .context("cannot start rustc")?;
    let folder = String::from_utf8_lossy(&output.stdout);
    if output.status.success() && Path::new(folder.trim()).is_dir() {
        return Ok(());
    }
    let added = Command::new("rustup")
        .current_dir(root())
        .args(["target", "add", target])
        .status();
    if !added.is_ok_and(|status| status.success()) {
        bail!("Rust cannot compile for {target} yet; add it by `rustup target add {target}`");
    }
    Ok(())
}

/// Runs `command` with its output shown, and fails if it fails.
///
/// # Errors
/// If the program cannot be started or ends with an error.
pub fn run(command: &mut Command) -> Result<()> {
    let shown = shown(command);
    eprintln!("$ {shown}");
    let status: ExitStatus = command
        .status()
        .with_context(|| format!("cannot start `{shown}`"))?;
    if !status.success() {
        bail!("`{shown}` failed ({status})");
    }
    Ok(())
}

/// Runs a command and returns what it prints on standard output.
///
/// # Errors
/// If it cannot be started or fails; the error contains what it printed.
pub fn output(command: &mut Command) -> Result<String> {
    let shown = shown(command);
    eprintln!("$ {shown}");
    let output = command
        .stderr(Stdio::inherit())
        .output()
        .with_context(|| format!("cannot start `{shown}`"))?;
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    if !output.status.success() {
        bail!("`{shown}` failed ({}):\n{text}", output.status);
    }
    Ok(text)
}

/// The output of git with these arguments, at the repository's root.
///
/// # Errors
/// If it cannot be started or fails.
pub fn git(words: &str) -> Result<String> {
    quiet_output(
        Command::new("git")
            .current_dir(root())
            .args(words.split(' ')),
    )
}

/// What a command prints, without the end of line; nothing is shown.
///
/// # Errors
/// If it cannot be started or fails; the error contains its messages.
pub fn quiet_output(command: &mut Command) -> Result<String> {
    let shown = shown(command);
    let output = command.output();
    let output = output.with_context(|| format!("cannot start `{shown}`"))?;
    if !output.status.success() {
        let why = String::from_utf8_lossy(&output.stderr);
        bail!("`{shown}` failed: {}", why.trim());
    }
    Ok(String::from_utf8_lossy(&output.stdout)
        .trim_end()
        .to_owned())
}

/// The command as a person would type it.
fn shown(command: &Command) -> String {
    let program = Path::new(command.get_program());
    let mut words: Vec<OsString> = vec![program.file_stem().unwrap_or_default().into()];
    words.extend(command.get_args().map(Into::into));
    words.join(" ".as_ref()).to_string_lossy().into_owned()
}

fn need(program: &str, install: &str) -> Result<PathBuf> {
    in_path(program).with_context(|| format!("{program} is missing; {install}"))
}

/// Whether a program is in the path.
#[must_use]
pub fn is_in_path(name: &str) -> bool {
    in_path(name).is_some()
}

/// Where a program is, if it is in the path.
#[must_use]
pub fn in_path(name: &str) -> Option<PathBuf> {
    let endings: &[&str] = match cfg!(windows) {
        true => &[".exe", ".cmd"],
        false => &[""],
    };
    env::split_paths(&env::var_os("PATH")?)
        .flat_map(|folder| {
            endings
                .iter()
                .map(move |ending| folder.join(format!("{name}{ending}")))
        })
        .find(|file| file.is_file())
}

/// The result of a thread; if it panicked, it has printed why.
///
/// # Errors
/// Those of the thread, and that it panicked.
pub fn joined<T>(thread: ScopedJoinHandle<'_, Result<T>>) -> Result<T> {
    let panicked = |_| Err(anyhow!("a step of the build panicked"));
    thread.join().unwrap_or_else(panicked)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_missing_program_is_named_with_the_command_that_installs_it() {
        let error = need("no-such-program", "install it by `get it`").unwrap_err();
        assert_eq!(
            error.to_string(),
            "no-such-program is missing; install it by `get it`"
        );
    }

    #[test]
    fn commands_are_shown_as_typed() {
        let mut command = Command::new("/usr/bin/npm");
        command.args(["run", "build"]);
        assert_eq!(shown(&command), "npm run build");
    }
}

//! Finds the programs that the commands need, runs them in the repository, and says how to install a missing one.

use std::env;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Stdio};

use anyhow::{Context, Result, bail};

/// The repository's root.
#[must_use]
pub fn root() -> PathBuf {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.parent().unwrap_or(here).to_owned()
}

/// Where cargo puts what it builds: `CARGO_TARGET_DIR`, or `target`.
#[must_use]
pub fn target_dir() -> PathBuf {
    match env::var_os("CARGO_TARGET_DIR") {
        Some(dir) => root().join(dir),
        None => root().join("target"),
    }
}

/// The cargo that runs this command, at the repository's root.
#[must_use]
pub fn cargo() -> Command {
    let mut command = Command::new(env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.current_dir(root());
    command
}

/// Node, in `folder`.
///
/// # Errors
/// If it is not installed.
pub fn node(folder: &Path) -> Result<Command> {
    let mut command = Command::new(need("node", &["node"], NODE)?);
    command.current_dir(folder);
    Ok(command)
}

/// npm, in `folder`.
///
/// # Errors
/// If it is not installed.
pub fn npm(folder: &Path) -> Result<Command> {
    let mut command = Command::new(need("npm", &["npm"], NODE)?);
    command.current_dir(folder);
    Ok(command)
}

const NODE: &str = "install Node 20 or later: `sudo apt-get install nodejs npm`, `brew install node`, or \
                    `winget install OpenJS.NodeJS.LTS`";

/// Chromium or Chrome; the variable `CHROME` names one that is not in the path.
///
/// # Errors
/// If none is installed.
pub fn chrome() -> Result<PathBuf> {
    if let Some(path) = env::var_os("CHROME") {
        return Ok(path.into());
    }
    need(
        "Chromium",
        &[
            "chromium",
            "chromium-browser",
            "google-chrome",
            "google-chrome-stable",
        ],
        "install it by `sudo apt-get install chromium` or `brew install --cask chromium`, or name an installed one in \
         the variable CHROME",
    )
}

/// chromedriver; the variable `CHROMEDRIVER` names one that is not in the path.
///
/// # Errors
/// If none is installed.
pub fn chromedriver() -> Result<PathBuf> {
    if let Some(path) = env::var_os("CHROMEDRIVER") {
        return Ok(path.into());
    }
    need(
        "chromedriver",
        &["chromedriver"],
        "install it by `sudo apt-get install chromium-driver` or `brew install --cask chromedriver`, or name an \
         installed one in the variable CHROMEDRIVER",
    )
}

/// Debian's packer.
///
/// # Errors
/// If it is not installed.
pub fn dpkg_deb() -> Result<PathBuf> {
    need(
        "dpkg-deb",
        &["dpkg-deb"],
        "install it by `sudo apt-get install dpkg`",
    )
}

/// Makes sure that rustc can compile for wasm32: asks rustup for the target if it is missing.
///
/// # Errors
/// If it is missing and rustup cannot add it.
pub fn need_wasm_target() -> Result<()> {
    need_target("wasm32-unknown-unknown")
}

/// Makes sure that rustc can compile for `target`: asks rustup for it if it is missing.
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

/// Runs `command` with its output shown, and fails when it fails.
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
/// If it cannot be started or fails; what it printed is told then.
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

/// The command as a person would type it: the program's name and its arguments.
fn shown(command: &Command) -> String {
    let program = Path::new(command.get_program());
    let mut words: Vec<OsString> = vec![program.file_stem().unwrap_or_default().into()];
    words.extend(command.get_args().map(Into::into));
    words.join(" ".as_ref()).to_string_lossy().into_owned()
}

fn need(what: &str, names: &[&str], install: &str) -> Result<PathBuf> {
    let Some(found) = names.iter().find_map(|name| in_path(name)) else {
        bail!("{what} is missing; {install}");
    };
    Ok(found)
}

/// Where a program is, if it is in the path.
#[must_use]
pub fn in_path(name: &str) -> Option<PathBuf> {
    let endings: &[&str] = if cfg!(windows) {
        &[".exe", ".cmd"]
    } else {
        &[""]
    };
    env::split_paths(&env::var_os("PATH")?)
        .flat_map(|folder| {
            endings
                .iter()
                .map(move |ending| folder.join(format!("{name}{ending}")))
        })
        .find(|file| file.is_file())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_missing_program_is_named_with_the_command_that_installs_it() {
        let error = need(
            "Frobnicator",
            &["no-such-program"],
            "install it by `get it`",
        )
        .unwrap_err();
        assert_eq!(
            error.to_string(),
            "Frobnicator is missing; install it by `get it`"
        );
    }

    #[test]
    fn commands_are_shown_as_typed() {
        let mut command = Command::new("/usr/bin/npm");
        command.args(["run", "build"]);
        assert_eq!(shown(&command), "npm run build");
    }
}

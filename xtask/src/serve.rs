//! Replaces this process by the bridge: signals reach it directly, and it prints the address.

use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result};

use crate::tools;

/// Serves `www/dist` on `port` of this machine with this program, until stopped.
///
/// # Errors
/// If it cannot serve.
pub fn serve(bridge: &Path, port: u16, open: bool) -> Result<()> {
    let mut bridge = Command::new(bridge);
    bridge
        .current_dir(tools::root())
        .args(["--page", "www/dist", "--port", &port.to_string()]);
    if open {
        bridge.arg("--open");
    }
    become_program(&mut bridge)
}

#[cfg(unix)]
fn become_program(program: &mut Command) -> Result<()> {
    use std::os::unix::process::CommandExt;
    // Returns only if the program cannot be started.
    Err(program.exec()).with_context(|| cannot_start(program))
}

#[cfg(not(unix))]
fn become_program(program: &mut Command) -> Result<()> {
    let status = program.status().with_context(|| cannot_start(program))?;
    std::process::exit(status.code().unwrap_or(1))
}

fn cannot_start(program: &Command) -> String {
    format!("cannot start {}", program.get_program().display())
}

//! The RP6's firmware in a simulated ATmega32, with the motors, encoders and rangers of the
//! simulated robot around it.
//!
//! In: bytes and commands for the serial line. Out: what the firmware answers, and what its
//! registers and the robot do.
//!
//! 1. [`firmware()`] compiles the C sources, once.
//! 2. [`Chip`] runs them in simavr, instruction by instruction: time is the chip's, so every run is
//!    the same.
//! 3. [`Rig`] turns the motors by the duty in OCR1A and OCR1B, counts their angles into edges at
//!    INT0 and INT1, and puts voltages on the converter.
//! 4. [`Host`] is the other end of the line: the very [`Link`](slamlab_core::wire::rp6::Link) that
//!    drives a real robot.
//! 5. [`Wired`] puts the rig on a pseudo-terminal instead, in real time, for a whole bridge.

mod chip;
mod edge;
mod host;
mod rig;
mod wired;

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

use anyhow::{Context, Result, bail};

pub use chip::Chip;
pub use edge::EdgeWatch;
pub use host::Host;
pub use rig::Rig;
pub use wired::Wired;

/// The compiled firmware.
///
/// # Errors
/// If `make` or avr-gcc is missing, or the sources do not compile without a warning.
pub fn firmware() -> Result<&'static Path> {
    static BUILT: OnceLock<Result<PathBuf, String>> = OnceLock::new();
    match BUILT.get_or_init(|| build().map_err(|error| format!("{error:#}"))) {
        Ok(path) => Ok(path),
        Err(error) => bail!("{error}"),
    }
}

fn build() -> Result<PathBuf> {
    let sources = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../bridge/firmware");
    let output = Command::new("make")
        .current_dir(&sources)
        .output()
        .context("cannot start make")?;
    if !output.status.success() {
        bail!(
            "the firmware does not compile:\n{}",
            String::from_utf8_lossy(&output.stderr)
        );
    }
    Ok(sources.join("build/rp6.elf"))
}

//! `page` and `page-frames`: is the page as light, as quickly there, and as fast as promised?
//!
//! In: a machine with Chromium; for `page-frames` the recorded data. Out: the figures of a file of
//! `tests/page/*.measure.ts`, as JSON, for the page as everybody builds it.
//!
//! | report | what |
//! |---|---|
//! | `page` | weight of a first visit, first frame, map, frames per second, work per frame, long tasks, input to frame, memory, a large map |
//! | `page-frames` | time for 60 frames per second while a recorded building plays at 50 times its speed |

use std::fs;
use std::path::Path;

use anyhow::{Context, Result, bail};

use crate::wasm::Profile;
use crate::{page, tools};

/// Measures all that is promised of the page, and prints it. Runs at top speed last `minutes`.
///
/// # Errors
/// If something cannot be built or run, or a figure does not hold.
pub fn report(minutes: &str) -> Result<()> {
    measured("page", "page.measure.ts", &[("SLAMLAB_MINUTES", minutes)])
}

/// Plays the recording, prints the figures, and judges.
///
/// # Errors
/// If something cannot be built or run, the recorded data is absent, or frames take too long.
pub fn frames() -> Result<()> {
    let log = tools::data_folder().join("intel/intel.clf");
    if !log.is_file() {
        bail!("{} is missing: it is what plays", log.display());
    }
    measured("page-frames", "frames.measure.ts", &[])
}

/// Builds the page, runs one file of measurements, and prints its figures.
fn measured(name: &str, file: &str, settings: &[(&str, &str)]) -> Result<()> {
    let bridge = page::build_with_bridge(Profile::Release, "build --package slamlab-bridge")?;
    let (figures, judged) = figures(name, file, &bridge, settings)?;
    println!("{figures}");
    judged
}

/// Runs one file of measurements on the page that is already built, which writes its figures to a
/// file; returns these, and whether they hold.
///
/// # Errors
/// If it cannot be run, or leaves no figures.
pub fn figures(
    name: &str,
    file: &str,
    bridge: &Path,
    settings: &[(&str, &str)],
) -> Result<(String, Result<()>)> {
    let folder = tools::root().join("tests/page");
    page::install(&folder)?;
    let figures = tools::target_dir().join(format!("{name}.json"));
    if figures.exists() {
        fs::remove_file(&figures)
            .with_context(|| format!("cannot remove {}", figures.display()))?;
    }
    let mut npm = tools::npm(&folder)?;
    npm.args(["run", "--silent", "measure", "--", file])
        .env("CHROME", tools::chrome()?)
        .env("SLAMLAB_BRIDGE", bridge)
        .env("SLAMLAB_DATA", tools::data_folder())
        .env("SLAMLAB_FIGURES", &figures)
        .envs(settings.iter().copied());
    let measured = tools::output(&mut npm).map(|_| ());
    match fs::read_to_string(&figures) {
        Ok(figures) => Ok((figures, measured)),
        // The error that prevented the measurement says more.
        Err(error) => {
            measured?;
            Err(error).with_context(|| format!("no figures in {}", figures.display()))
        }
    }
}

//! `page-frames`: has the page time for 60 pictures a second while a recorded building plays at 50
//! times its speed?
//!
//! In: a machine with Chromium, and the recorded data. Out: the figures of
//! `tests/page/frames.measure.ts`, as JSON, of the page as everybody builds it.

use std::fs;

use anyhow::{Context, Result, bail};

use crate::wasm::Profile;
use crate::{page, tools};

/// Builds the page, plays the recording, prints the figures, and judges.
///
/// # Errors
/// If something cannot be built or run, the recorded data is absent, or pictures take too long.
pub fn report() -> Result<()> {
    let data = tools::data_folder();
    let log = data.join("intel/intel.clf");
    if !log.is_file() {
        bail!("{} is missing: it is what plays", log.display());
    }
    let bridge = page::build_with_bridge(Profile::Release, "build --package slamlab-bridge")?;
    let folder = tools::root().join("tests/page");
    page::install(&folder)?;
    let figures = tools::target_dir().join("page-frames.json");
    if figures.exists() {
        fs::remove_file(&figures)
            .with_context(|| format!("cannot remove {}", figures.display()))?;
    }
    let mut npm = tools::npm(&folder)?;
    npm.args(["run", "--silent", "measure"])
        .env("CHROME", tools::chrome()?)
        .env("SLAMLAB_BRIDGE", bridge)
        .env("SLAMLAB_DATA", data)
        .env("SLAMLAB_FIGURES", &figures);
    let measured = tools::output(&mut npm);
    match fs::read_to_string(&figures) {
        Ok(figures) => println!("{figures}"),
        // What kept it from measuring says more.
        Err(error) => {
            measured?;
            return Err(error).with_context(|| format!("no figures in {}", figures.display()));
        }
    }
    measured.map(|_| ())
}

//! Saved maps (`.slamlab`): to go on in one, and to save one.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Context, Result, bail};
use slamlab_core::estimation::{SavedMap, Start};
use slamlab_core::format::slamlab::{self, Experiment};
use slamlab_core::slam::{EarlierMap, Method};

use crate::{options, prior_map};

/// The map to go on in, and where to save the new one.
#[derive(clap::Args)]
pub(crate) struct SavedMapOptions {
    /// Go on in this map (.slamlab) of earlier runs. Only by scan matching.
    #[arg(long, value_name = "FILE")]
    go_on: Option<PathBuf>,
    /// Where in that map the robot is. `left`: where the last run ended; it is searched for where
    /// it does not see that. `anywhere`: it has to be found. `paused`: the last run goes on as if
    /// it had not been paused. Or about there, as `x,y,heading` in metres and degrees.
    #[arg(
        long, value_name = "left|anywhere|paused|X,Y,DEGREES", default_value = "left",
        value_parser = start, allow_hyphen_values = true, requires = "go_on"
    )]
    from: Start,
    /// Save the map with all that a later run needs to go on in it (.slamlab).
    #[arg(long, value_name = "FILE")]
    save: Option<PathBuf>,
}

impl SavedMapOptions {
    pub(crate) fn read_paths(&self) -> Vec<(&'static str, PathBuf)> {
        options::given([("--go-on", &self.go_on)])
    }

    pub(crate) fn written_paths(&self) -> Vec<(&'static str, PathBuf)> {
        options::given([("--save", &self.save)])
    }

    /// The map to go on in, with its settings.
    pub(crate) fn read(&self, method: &Method) -> Result<Option<Experiment>> {
        let is_matching = *method == Method::ScanMatching;
        let mut options = self.read_paths().into_iter().chain(self.written_paths());
        if let (false, Some((option, _))) = (is_matching, options.next()) {
            bail!(
                "{option} needs --method scan-matching, not {}",
                method.name()
            );
        }
        let Some(path) = &self.go_on else {
            return Ok(None);
        };
        let name = || format!("saved map {}", path.display());
        let bytes = std::fs::read(path).with_context(name)?;
        slamlab::read(&bytes).with_context(name).map(Some)
    }

    /// The map to go on in, for a run.
    pub(crate) fn earlier(&self, saved: Experiment) -> EarlierMap {
        EarlierMap {
            map: Arc::new(saved.map),
            start: self.from,
        }
    }

    /// The file to save from a run in `of`, a log or a world, with the settings that differed from
    /// their defaults.
    pub(crate) fn file(
        &self,
        of: &Path,
        map: impl FnOnce() -> Option<SavedMap>,
        settings: Vec<(String, f64)>,
    ) -> Result<Option<options::File>> {
        // Saving a map takes as much memory again as the map itself.
        let Some(path) = &self.save else {
            return Ok(None);
        };
        let Some(map) = map() else {
            return Ok(None);
        };
        let title = of.file_stem().unwrap_or_default().to_string_lossy();
        let experiment = Experiment {
            title: title.into_owned(),
            program: concat!("slamlab ", env!("CARGO_PKG_VERSION")).to_owned(),
            method: Method::ScanMatching.name().to_owned(),
            settings,
            map,
        };
        let file = slamlab::write(&experiment).context("the map cannot be saved")?;
        Ok(Some((path.clone(), file)))
    }
}

fn start(text: &str) -> Result<Start> {
    Ok(match text {
        "paused" => Start::Paused,
        "left" => Start::Left,
        "anywhere" => Start::Anywhere,
        text => Start::At(prior_map::pose(text)?),
    })
}

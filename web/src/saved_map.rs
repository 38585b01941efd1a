//! A saved map (`.slamlab`) that runs go on in.

use std::sync::Arc;

use serde::{Deserialize, Serialize};
use slamlab_core::estimation::{Pruned, SavedMap, ScanMatcher, ScanMatcherConfig, Start};
use slamlab_core::format::slamlab::{self, Experiment};
use slamlab_core::geom::Pose2;
use slamlab_core::slam::{EarlierMap, Method};
use tsify::{Ts, Tsify};
use wasm_bindgen::prelude::wasm_bindgen;

use crate::border::{Typed, WebError, typed};
use crate::export::SavedFile;
use crate::run::{RunError, Source, WebRun};
use crate::view::GridChange;

/// A saved map.
#[wasm_bindgen]
#[derive(Debug)]
pub struct WebSavedMap {
    title: String,
    settings: Vec<(String, f64)>,
    map: Arc<SavedMap>,
    picture: SavedMapPicture,
}

/// What was removed from a map because newer parts of it cover the same area.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Tsify)]
pub struct TakenOut {
    /// Number of submaps.
    pub submaps: usize,
    /// Number of keyframes.
    pub keyframes: usize,
}

/// What a saved map looks like to a run that goes on in it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
#[tsify(missing_as_null)]
pub struct SavedMapPicture {
    /// Its grid; none if nothing is drawn in it.
    pub grid: Option<GridChange>,
    /// x y heading of the robot as it was left, map frame, m and rad.
    pub left: [f64; 3],
}

/// Where the robot is when a run goes on in a saved map.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Tsify)]
#[serde(tag = "from", rename_all = "kebab-case")]
pub enum MapStart {
    /// Where the last run left it; if the surroundings do not match, anywhere.
    Left,
    /// Near this pose, map frame, m and rad.
    At {
        /// x y heading.
        pose: [f64; 3],
    },
    /// Unknown.
    Anywhere,
}

#[wasm_bindgen]
impl WebSavedMap {
    /// Reads a file.
    ///
    /// # Errors    A sentence on what is wrong with it, and where.
    #[wasm_bindgen(constructor)]
    pub fn new(bytes: &[u8]) -> Result<Self, WebError> {
        let experiment = slamlab::read(bytes)?;
        Self::of(experiment.title, experiment.settings, experiment.map)
    }

    /// Merges this map with another, given as the bytes of its file, in the frame of this one.
    ///
    /// # Errors    A sentence on what is wrong with the file, and where; or that it is not proved
    /// how the two lie relative to each other.
    pub fn merged(&self, bytes: &[u8]) -> Result<Self, WebError> {
        let other = slamlab::read(bytes)?;
        let config = ScanMatcherConfig::default();
        let (one, two) = (self.map.matcher(config)?, other.map.matcher(config)?);
        let map = one.merged(two)?.saved([&self.map.times, &other.map.times]);
        let title = format!("{} and {}", self.title, other.title);
        Self::of(title, self.settings.clone(), map)
    }

    /// Removes what newer parts of the map cover.
    ///
    /// # Errors    None that a page can cause.
    pub fn prune(&mut self) -> Typed<TakenOut> {
        let mut matcher = self.map.matcher(ScanMatcherConfig::default())?;
        matcher.finish();
        let Pruned { submaps, keyframes } = matcher.prune();
        let map = matcher.saved(self.map.times.clone());
        *self = Self::of(self.title.clone(), self.settings.clone(), map)?;
        typed(&TakenOut { submaps, keyframes })
    }

    /// The file to save, named after `stem`.
    ///
    /// # Errors    The map is too large for a file.
    pub fn file(&self, stem: &str) -> Typed<SavedFile> {
        let map = SavedMap::clone(&self.map);
        let bytes = written(self.title.clone(), self.settings.clone(), map)?;
        typed(&SavedFile::slamlab(stem, bytes))
    }

    /// What it looks like.
    ///
    /// # Errors    None that a page can cause.
    pub fn picture(&self) -> Typed<SavedMapPicture> {
        typed(&self.picture)
    }
}

impl WebSavedMap {
    /// # Errors    A map that cannot be restored is refused here, not when a run begins.
    fn of(title: String, settings: Vec<(String, f64)>, map: SavedMap) -> Result<Self, WebError> {
        let mut matcher = map.matcher(ScanMatcherConfig::default())?;
        matcher.go_on(Start::Left);
        Ok(Self {
            title,
            settings,
            map: Arc::new(map),
            picture: SavedMapPicture::of(&matcher),
        })
    }
}

impl SavedMapPicture {
    fn of(matcher: &ScanMatcher) -> Self {
        let pose = matcher.estimate().pose;
        Self {
            grid: GridChange::whole(matcher.grid()),
            left: [pose.x(), pose.y(), pose.heading()],
        }
    }
}

impl From<MapStart> for Start {
    fn from(start: MapStart) -> Self {
        match start {
            MapStart::Left => Self::Left,
            MapStart::At {
                pose: [x, y, heading],
            } => Self::At(Pose2::new(x, y, heading)),
            MapStart::Anywhere => Self::Anywhere,
        }
    }
}

#[wasm_bindgen]
impl WebRun {
    /// Goes on in a saved map; only before anything was seen.
    ///
    /// # Errors    A sentence on why it is impossible: another method than scan matching.
    pub fn go_on_in(&mut self, saved: &WebSavedMap, start: &Ts<MapStart>) -> Result<(), WebError> {
        let saved = EarlierMap {
            map: Arc::clone(&saved.map),
            start: start.to_rust()?.into(),
        };
        match &mut self.source {
            Source::Simulation(sim) => sim.experiment.go_on_in(saved)?,
            Source::Recording(replay) => replay.go_on_in(saved)?,
            Source::Live(live) => live.go_on_in(saved)?,
        }
        Ok(())
    }

    /// The present map as a saved map, to go on in.
    ///
    /// # Errors    A sentence on why there is none: another method than scan matching.
    pub fn as_saved_map(&self, title: &str) -> Result<WebSavedMap, WebError> {
        WebSavedMap::of(title.to_owned(), vec![], self.saved_map()?)
    }
}

impl WebRun {
    /// The map as a file, to go on in later.
    ///
    /// # Errors    [`RunError::NoSavedMap`] of methods other than scan matching.
    pub(crate) fn experiment_file(&self, stem: &str) -> Result<SavedFile, WebError> {
        let bytes = written(stem.to_owned(), vec![], self.saved_map()?)?;
        Ok(SavedFile::slamlab(stem, bytes))
    }

    fn saved_map(&self) -> Result<SavedMap, RunError> {
        let map = match &self.source {
            Source::Recording(replay) => replay.saved_map(),
            _ => self.slam().saved_map(vec![]),
        };
        map.ok_or(RunError::NoSavedMap)
    }
}

impl SavedFile {
    fn slamlab(stem: &str, bytes: Vec<u8>) -> Self {
        Self::new(format!("{stem}.slamlab"), "application/octet-stream", bytes)
    }
}

/// A map as the bytes of its file.
fn written(
    title: String,
    settings: Vec<(String, f64)>,
    map: SavedMap,
) -> Result<Vec<u8>, WebError> {
    let experiment = Experiment {
        title,
        program: concat!("slamlab ", env!("CARGO_PKG_VERSION")).to_owned(),
        method: Method::ScanMatching.name().to_owned(),
        settings,
        map,
    };
    Ok(slamlab::write(&experiment)?)
}

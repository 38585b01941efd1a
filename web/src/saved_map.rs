//! A saved map (`.slamlab`) that runs go on in.

use std::sync::Arc;

use serde::{Deserialize, Serialize};
use slamlab_core::estimation::{SavedMap, ScanMatcher, ScanMatcherConfig, Start};
use slamlab_core::format::slamlab::{self, Experiment};
use slamlab_core::geom::Pose2;
use slamlab_core::slam::{EarlierMap, Method};
use tsify::{Ts, Tsify};
use wasm_bindgen::prelude::wasm_bindgen;

use crate::border::{Typed, WebError, typed};
use crate::run::{RunError, Source, WebRun};
use crate::view::GridChange;

/// A saved map.
#[wasm_bindgen]
#[derive(Debug)]
pub struct WebSavedMap {
    map: Arc<SavedMap>,
    picture: SavedMapPicture,
}

/// What a saved map looks like to a run that goes on in it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
#[tsify(missing_as_null)]
pub struct SavedMapPicture {
    /// Its grid; none of a map in which nothing was drawn.
    pub grid: Option<GridChange>,
    /// x y heading of the robot as it was left, map frame, m and rad.
    pub left: [f64; 3],
}

/// Where the robot is when a run goes on in a saved map.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Tsify)]
#[serde(tag = "from", rename_all = "kebab-case")]
pub enum MapStart {
    /// Where it was left; where it does not see that, anywhere.
    Left,
    /// About here, map frame, m and rad.
    At {
        /// x y heading.
        pose: [f64; 3],
    },
    /// Nothing is known of it.
    Anywhere,
}

#[wasm_bindgen]
impl WebSavedMap {
    /// Reads a file.
    ///
    /// # Errors    A sentence on what is wrong with it, and where.
    #[wasm_bindgen(constructor)]
    pub fn new(bytes: &[u8]) -> Result<Self, WebError> {
        let map = slamlab::read(bytes)?.map;
        // What cannot be taken up is said now, not when a run begins.
        let mut matcher = map.matcher(ScanMatcherConfig::default())?;
        matcher.go_on(Start::Left);
        Ok(Self {
            map: Arc::new(map),
            picture: SavedMapPicture::of(&matcher),
        })
    }

    /// What it looks like.
    ///
    /// # Errors    None that a page can cause.
    pub fn picture(&self) -> Typed<SavedMapPicture> {
        typed(&self.picture)
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
    /// Goes on in a saved map, before anything was seen.
    ///
    /// # Errors    A sentence on why not: another method than scan matching.
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
}

impl WebRun {
    /// The map, to be gone on in later.
    ///
    /// # Errors    [`RunError::NoSavedMap`] of methods other than scan matching.
    pub(crate) fn experiment_file(&self, title: &str) -> Result<Vec<u8>, WebError> {
        let map = match &self.source {
            Source::Recording(replay) => replay.saved_map(),
            _ => self.slam().saved_map(vec![]),
        };
        let experiment = Experiment {
            title: title.to_owned(),
            program: concat!("slamlab ", env!("CARGO_PKG_VERSION")).to_owned(),
            method: Method::ScanMatching.name().to_owned(),
            settings: vec![],
            map: map.ok_or(RunError::NoSavedMap)?,
        };
        Ok(slamlab::write(&experiment)?)
    }
}

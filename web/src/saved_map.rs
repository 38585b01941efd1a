//! A saved map (`.slamlab`) that runs go on in.

use std::sync::Arc;

use slamlab_core::estimation::{SavedMap, ScanMatcherConfig, Start};
use slamlab_core::format::slamlab::{self, Experiment};
use slamlab_core::slam::{EarlierMap, Method};
use wasm_bindgen::prelude::wasm_bindgen;

use crate::border::WebError;
use crate::run::{RunError, Source, WebRun};

/// A saved map.
#[wasm_bindgen]
#[derive(Debug)]
pub struct WebSavedMap {
    map: Arc<SavedMap>,
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
        map.matcher(ScanMatcherConfig::default())?;
        Ok(Self { map: Arc::new(map) })
    }
}

#[wasm_bindgen]
impl WebRun {
    /// Goes on in a saved map, before anything was seen: where the robot was left, or, where it
    /// does not see that, wherever it finds itself.
    ///
    /// # Errors    A sentence on why not: another method than scan matching.
    pub fn go_on_in(&mut self, saved: &WebSavedMap) -> Result<(), WebError> {
        let saved = EarlierMap {
            map: Arc::clone(&saved.map),
            start: Start::Left,
        };
        match &mut self.source {
            Source::Simulation(sim) => sim.experiment.go_on_in(saved)?,
            Source::Recording(replay) => replay.go_on_in(saved)?,
            Source::Live(live) => live.go_on_in(saved)?,
        }
        Ok(())
    }

    /// Whether it is known where in the map the robot is; not while a run that goes on in a saved
    /// map has not found its place.
    #[must_use]
    pub fn is_placed(&self) -> bool {
        self.slam().view().map.is_none_or(|map| map.is_placed())
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

//! Recordings of ROS, made into recordings that a run reads.

use serde::{Deserialize, Serialize};
use slamlab_core::format::ros::{RosLog, RosReader};
use slamlab_core::replay::{Offered, RosChoice, RosOffer, import_ros};
use tsify::Tsify;
use wasm_bindgen::prelude::wasm_bindgen;

use crate::border::{ErrorKind, Typed, Uint8Array, WebError, typed};

/// What a recording of ROS has to choose from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
#[serde(rename_all = "camelCase")]
pub struct RosTopics {
    /// Topics with scans.
    pub scans: Vec<OfferedTopic>,
    /// Topics with odometry, then transforms that move.
    pub odometry: Vec<OfferedTopic>,
    /// Whether only a person can tell what is meant.
    pub must_ask: bool,
}

/// One thing to choose.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
pub struct OfferedTopic {
    /// What it is chosen by.
    pub name: String,
    /// What stands in it.
    pub words: String,
}

/// A recording of ROS as one of ours.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
pub struct ImportedLog {
    /// A file that the reader of logs takes.
    #[tsify(type = "Uint8Array<ArrayBuffer>")]
    pub bytes: Uint8Array,
    /// What a person should know of it.
    pub notes: Vec<String>,
}

/// A recording of ROS that is being read.
#[wasm_bindgen]
#[derive(Debug, Default)]
pub struct WebRosReader {
    reader: RosReader,
    log: RosLog,
}

#[wasm_bindgen]
impl WebRosReader {
    /// Of a file that begins with the first bytes that are pushed.
    #[wasm_bindgen(constructor)]
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Takes the next bytes, as many as there are.
    ///
    /// # Errors    A sentence on what the file is instead.
    pub fn push(&mut self, bytes: &[u8]) -> Result<(), WebError> {
        Ok(self.reader.push(bytes)?)
    }

    /// The file is all there: what it has to choose from.
    ///
    /// # Errors    A sentence on what is missing in it.
    pub fn finish(&mut self) -> Typed<RosTopics> {
        self.log = std::mem::take(&mut self.reader).finish()?;
        let offer = RosOffer::of(&self.log)?;
        let all = |offered: Vec<Offered>| offered.into_iter().map(Into::into).collect();
        typed(&RosTopics {
            scans: all(offer.scans),
            odometry: all(offer.odometry),
            must_ask: offer.must_ask,
        })
    }

    /// The recording of these topics, or of those that can only be meant; odometry may be `none`.
    ///
    /// # Errors    A sentence on what has to be chosen, or what is missing.
    pub fn import(&self, scans: Option<String>, odometry: Option<String>) -> Typed<ImportedLog> {
        let choice = RosChoice { scans, odometry };
        let imported = import_ros(&self.log, &choice)?;
        let bytes = imported.recording.write().map_err(|error| WebError {
            kind: ErrorKind::Internal,
            text: error.to_string(),
        })?;
        typed(&ImportedLog {
            bytes: bytes.into(),
            notes: imported.notes,
        })
    }
}

impl From<Offered> for OfferedTopic {
    fn from(Offered { name, words }: Offered) -> Self {
        Self { name, words }
    }
}

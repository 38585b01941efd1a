//! Converts recordings of ROS into recordings that a run can read.

use serde::{Deserialize, Serialize};
use slamlab_core::format::ros::{RosLog, RosReader};
use slamlab_core::replay::{Offered, RosChoice, RosOffer, import_ros};
use tsify::Tsify;
use wasm_bindgen::prelude::wasm_bindgen;

use crate::border::{ErrorKind, Typed, Uint8Array, WebError, typed};

/// The choices in a recording of ROS.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
#[serde(rename_all = "camelCase")]
pub struct RosTopics {
    /// Topics with scans.
    pub scans: Vec<OfferedTopic>,
    /// Topics with odometry, then moving transforms.
    pub odometry: Vec<OfferedTopic>,
    /// Whether a person has to choose, because it is ambiguous.
    pub must_ask: bool,
}

/// One thing to choose.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
pub struct OfferedTopic {
    /// The name by which it is chosen.
    pub name: String,
    /// Its content, in words.
    pub words: String,
}

/// A recording of ROS as one of ours.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
pub struct ImportedLog {
    /// A file that the reader of logs accepts.
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
    /// For a file whose first bytes are the next to be pushed.
    #[wasm_bindgen(constructor)]
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Takes the next bytes, as many as there are.
    ///
    /// # Errors    A sentence on what kind of file it is instead.
    pub fn push(&mut self, bytes: &[u8]) -> Result<(), WebError> {
        Ok(self.reader.push(bytes)?)
    }

    /// Ends the file; returns the choices in it.
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

    /// The recording with these topics, or with the only possible ones if none are given; odometry
    /// may be `none`.
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

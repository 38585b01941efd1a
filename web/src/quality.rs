//! What the map is worth, for the page: whether it is torn, and where.

use serde::{Deserialize, Serialize};
use slamlab_core::estimation::{self, MapQuality, ScanMatcher};
use slamlab_core::robot::Stamp;
use tsify::{Ts, Tsify};
use wasm_bindgen::prelude::wasm_bindgen;

use crate::border::{MapVerdictName, TearName, WebError, typed};
use crate::run::WebRun;

/// What a map is worth.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
#[tsify(missing_as_null)]
pub struct Quality {
    /// In a word.
    pub verdict: MapVerdictName,
    /// Of what was seen twice, the part that agrees, 0 to 1.
    pub agreement: Option<f64>,
    /// Where it is torn or doubtful, the worst first.
    pub tears: Vec<Tear>,
}

/// A place where a map is torn, or may be.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
#[tsify(missing_as_null)]
pub struct Tear {
    /// Why.
    pub kind: TearName,
    /// x y, map frame, m.
    pub place: [f64; 2],
    /// How far its sides are off, m.
    pub off: Option<f64>,
    /// Seconds, from and to, in which the one side was seen.
    pub earlier: [f64; 2],
    /// The same of the other side.
    pub later: [f64; 2],
}

#[wasm_bindgen]
impl WebRun {
    /// What the map is worth; nothing of methods that keep no submaps. Takes up to a second.
    ///
    /// # Errors    None that a page can cause.
    pub fn quality(&self) -> Result<Option<Ts<Quality>>, WebError> {
        let quality = self.slam().view().map.map(ScanMatcher::quality);
        let quality = quality.as_ref().map(Quality::from);
        quality.as_ref().map(typed).transpose()
    }
}

impl From<&MapQuality> for Quality {
    fn from(quality: &MapQuality) -> Self {
        Self {
            verdict: (&quality.verdict).into(),
            agreement: quality.agreement,
            tears: quality.tears.iter().map(Into::into).collect(),
        }
    }
}

impl From<&estimation::Tear> for Tear {
    fn from(tear: &estimation::Tear) -> Self {
        let seconds = |seen: [Stamp; 2]| seen.map(Stamp::seconds);
        Self {
            kind: (&tear.kind).into(),
            place: tear.place.into(),
            off: tear.off,
            earlier: seconds(tear.earlier),
            later: seconds(tear.later),
        }
    }
}

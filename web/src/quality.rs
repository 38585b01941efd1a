//! The quality of the map, for the page: whether it is torn, and where.

use serde::{Deserialize, Serialize};
use slamlab_core::estimation::{self, MapJudgement, MapQuality, ScanMatcher};
use slamlab_core::robot::Stamp;
use tsify::{Ts, Tsify};
use wasm_bindgen::prelude::wasm_bindgen;

use crate::border::{MapVerdictName, TearName, UnjudgeableName, WebError, typed};
use crate::run::WebRun;

/// The quality of a map.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
#[serde(rename_all = "camelCase")]
#[tsify(missing_as_null)]
pub struct Quality {
    /// The verdict.
    pub verdict: MapVerdictName,
    /// Why the map cannot be judged, if that is so.
    pub unjudgeable: Option<UnjudgeableName>,
    /// Part of what was seen twice that agrees, 0 to 1.
    pub agreement: Option<f64>,
    /// The same for each stretch of the trajectory, in the order of time.
    pub over_time: Vec<Stretch>,
    /// Where it is torn or doubtful, the worst first.
    pub tears: Vec<Tear>,
    /// The loops that were closed, in the order of time.
    pub loops: Vec<ClosedLoop>,
    /// Median of the loop errors, in units of what was known of the relative poses. None if there
    /// are too few.
    pub loop_ratio: Option<f64>,
    /// Whether the errors are systematically larger than stated.
    pub is_overconfident: bool,
}

/// A loop that was closed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
pub struct ClosedLoop {
    /// When its later end was first seen, s.
    pub at: f64,
    /// What was known of the relative pose: standard deviations, m and rad.
    pub doubt: [f64; 2],
    /// By how much it was off, m and rad.
    pub found: [f64; 2],
    /// The error in units of the standard deviations.
    pub ratio: f64,
}

/// A stretch of the trajectory, as long as a submap.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
#[tsify(missing_as_null)]
pub struct Stretch {
    /// Time in which it was seen: from and to, s.
    pub seen: [f64; 2],
    /// Part of what the rest of the trajectory says of its walls that agrees, 0 to 1.
    pub agreement: Option<f64>,
}

/// A place where a map is torn, or may be.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
#[tsify(missing_as_null)]
pub struct Tear {
    /// The kind of tear.
    pub kind: TearName,
    /// x y, map frame, m.
    pub place: [f64; 2],
    /// How far its two sides are apart, m.
    pub off: Option<f64>,
    /// Time in which the one side was seen: from and to, s.
    pub earlier: [f64; 2],
    /// The same of the other side.
    pub later: [f64; 2],
    /// Number of pairs of submaps that show it.
    pub witnesses: usize,
}

/// A judgement in progress, in steps between which the page can do other things.
#[wasm_bindgen]
#[derive(Debug)]
pub struct WebJudgement {
    judgement: MapJudgement,
}

#[wasm_bindgen]
impl WebRun {
    /// Begins to judge the map as it is now; nothing for methods without submaps.
    #[must_use]
    pub fn judge(&self) -> Option<WebJudgement> {
        let judgement = self.slam().view().map.map(ScanMatcher::judgement);
        judgement.map(|judgement| WebJudgement { judgement })
    }
}

#[wasm_bindgen]
impl WebJudgement {
    /// Judges one more submap, in some milliseconds. `false` if none is left.
    pub fn step(&mut self, run: &WebRun) -> bool {
        let map = run.slam().view().map;
        map.is_some_and(|map| map.judge_on(&mut self.judgement))
    }

    /// The part that is done, 0 to 1.
    #[must_use]
    pub fn progress(&self) -> f64 {
        self.judgement.progress()
    }

    /// The quality of the map.
    ///
    /// # Errors    None that a page can cause.
    pub fn quality(&self, run: &WebRun) -> Result<Option<Ts<Quality>>, WebError> {
        let map = run.slam().view().map;
        let quality = map.map(|map| Quality::from(&map.judged(&self.judgement)));
        quality.as_ref().map(typed).transpose()
    }
}

impl From<&MapQuality> for Quality {
    fn from(quality: &MapQuality) -> Self {
        Self {
            verdict: (&quality.verdict).into(),
            unjudgeable: quality.unjudgeable.as_ref().map(Into::into),
            agreement: quality.agreement,
            over_time: quality.stretches.iter().map(Into::into).collect(),
            tears: quality.tears.iter().map(Into::into).collect(),
            loops: quality.loops.iter().map(Into::into).collect(),
            loop_ratio: quality.loop_ratio(),
            is_overconfident: quality.is_overconfident(),
        }
    }
}

fn seconds(seen: [Stamp; 2]) -> [f64; 2] {
    seen.map(Stamp::seconds)
}

impl From<&estimation::ClosedLoop> for ClosedLoop {
    fn from(closed: &estimation::ClosedLoop) -> Self {
        let error = &closed.error;
        Self {
            at: closed.later[0].seconds(),
            doubt: [error.doubt.shift, error.doubt.turn],
            found: [error.shift, error.turn],
            ratio: error.ratio,
        }
    }
}

impl From<&estimation::Stretch> for Stretch {
    fn from(stretch: &estimation::Stretch) -> Self {
        Self {
            seen: seconds(stretch.seen),
            agreement: stretch.agreement,
        }
    }
}

impl From<&estimation::Tear> for Tear {
    fn from(tear: &estimation::Tear) -> Self {
        Self {
            kind: (&tear.kind).into(),
            place: tear.place.into(),
            off: tear.off,
            earlier: seconds(tear.earlier),
            later: seconds(tear.later),
            witnesses: tear.witnesses,
        }
    }
}

//! The verdict on a map, compared with the errors of its trajectory.
//!
//! 1. A map is really torn if it has the walls of a place more than [`TORN_BEYOND`] from where the
//!    other visits of that place have them, according to the whole log's map, which is known to be
//!    good ([`Run::walls_off`]). That is what the verdict claims: an error somewhere, not on
//!    average, and an error of walls, because a scan with a wrong heading draws them wrong even if
//!    its position is right. It is also torn if more of its motions are wrong (off by over half a
//!    metre) than of the whole log's map over the same motions, by a part that noise does not
//!    explain: [`TORN_PART`]. A whole log is compared with no wrong motions at all. References of
//!    keyframes are themselves only good to some centimetres, and hold few motions:
//!    [`TORN_PART_OF_KEYFRAMES`].
//! 2. Every map that is really torn has to be called torn, and of the others less than
//!    [`MOST_FALSE`]. `doubtful` does not count as torn.

use serde_json::{Value, json};
use slamlab_core::estimation::{MapVerdict, Tear};

use super::run::{Kind, Run};
use crate::Outcome;

/// A map is really torn if its part of wrong motions exceeds that of the whole log by this.
const TORN_PART: f64 = 0.005;
const TORN_PART_OF_KEYFRAMES: f64 = 0.02;
/// A good map is off by less than this everywhere, m, as in `estimation::map_quality`.
const TORN_BEYOND: f64 = 0.3;
/// Maximum part of the good maps that may be called torn.
const MOST_FALSE: f64 = 0.05;

/// The judgement of one run.
pub(super) struct Judged {
    name: String,
    /// The verdict on the map.
    verdict: MapVerdict,
    tears: Vec<Tear>,
    agreement: Option<f64>,
    /// Parts of wrong motions: in this map, and in the whole log's map over the same motions.
    wrong: f64,
    wrong_of_whole: f64,
    /// How far walls are off at the worst place, according to the whole log's map, m.
    walls_off: Option<f64>,
    is_torn: bool,
}

impl Judged {
    /// From a run, and the run of the whole log if that is another one.
    pub(super) fn of(name: String, kind: Kind, run: &Run, whole: Option<&Run>) -> Self {
        let wrong = run.errors.wrong_part;
        let wrong_of_whole = whole.map_or(0.0, |whole| whole.errors_over_those_of(run).wrong_part);
        let most = match kind {
            Kind::Relations => TORN_PART,
            Kind::Keyframes => TORN_PART_OF_KEYFRAMES,
        };
        let walls_off = whole.map(|whole| run.walls_off(whole));
        let is_torn =
            wrong - wrong_of_whole > most || walls_off.is_some_and(|off| off > TORN_BEYOND);
        Self {
            name,
            verdict: run.quality.verdict,
            tears: run.quality.tears.clone(),
            agreement: run.quality.agreement,
            wrong,
            wrong_of_whole,
            walls_off,
            is_torn,
        }
    }

    fn is_called_torn(&self) -> bool {
        self.verdict == MapVerdict::Torn
    }

    fn is_right(&self) -> bool {
        self.is_called_torn() == self.is_torn
    }

    /// Row for the table of the report.
    fn json(&self) -> Value {
        let place = |tear: &Tear| {
            let kind = tear.kind.name();
            json!({ "kind": kind, "off_m": tear.off, "x_m": tear.place.x, "y_m": tear.place.y })
        };
        json!({
            "row": self.name,
            "said": self.verdict.name(),
            "tears": self.tears.iter().map(place).collect::<Vec<_>>(),
            "agreement": self.agreement,
            "wrong_part": self.wrong,
            "wrong_part_of_whole": self.wrong_of_whole,
            "walls_off_m": self.walls_off,
            "is_torn": self.is_torn,
            "is_right": self.is_right(),
        })
    }

    /// Row for the table on standard error.
    fn row(&self) -> String {
        let part = |part: f64| format!("{:.2} %", 100.0 * part);
        let is = if self.is_torn { "torn" } else { "whole" };
        let right = if self.is_right() { "yes" } else { "no" };
        let (said, tears) = (self.verdict.name(), self.tears.len());
        let (wrong, of_whole) = (part(self.wrong), part(self.wrong_of_whole));
        let off = self.walls_off.map_or("–".into(), |m| format!("{m:.2} m"));
        let name = &self.name;
        format!("| {name} | {said} ({tears}) | {is} | {wrong} | {of_whole} | {off} | {right} |")
    }
}

/// Adds the verdicts on all maps, and which of them are wrong.
pub(super) fn report(judged: &[Judged], outcome: &mut Outcome) {
    eprintln!("\n| row | said (places) | is | wrong | of the whole log | walls off | right |");
    eprintln!("| --- | --- | --- | --- | --- | --- | --- |");
    for judged in judged {
        eprintln!("{}", judged.row());
    }
    let (torn, good): (Vec<&Judged>, Vec<&Judged>) = judged.iter().partition(|j| j.is_torn);
    let missed = torn.iter().filter(|j| !j.is_called_torn()).count();
    let called = good.iter().filter(|j| j.is_called_torn()).count();
    let rows: Vec<Value> = judged.iter().map(Judged::json).collect();
    outcome.figure("map_verdicts", rows);
    outcome.figure("torn_maps", torn.len());
    outcome.figure("whole_maps", good.len());
    outcome.at_most("torn_maps_not_called_torn", missed as f64, 0.0);
    let part = called as f64 / good.len().max(1) as f64;
    outcome.figure("whole_maps_called_torn", called);
    outcome.figure("whole_maps_called_torn_part", part);
    outcome.require(part < MOST_FALSE, || {
        let names = good.iter().filter(|j| j.is_called_torn());
        let names: Vec<&str> = names.map(|j| j.name.as_str()).collect();
        format!(
            "{called} of {} whole maps are called torn, expected less than 5 %: {}",
            good.len(),
            names.join(", ")
        )
    });
    for judged in torn.iter().filter(|j| !j.is_called_torn()) {
        outcome.require(false, || {
            format!(
                "{}: torn, and called {}",
                judged.name,
                judged.verdict.name()
            )
        });
    }
}

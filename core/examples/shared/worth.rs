//! Whether the result of a run can be trusted. `evaluate` and `simulate` share this file.

use serde_json::{Value, json};
use slamlab_core::estimation::{
    ClosureFate, ClosureRecord, Localisation, MapQuality, MapVerdict, Refusal, ScanMatcher,
    Unjudgeable,
};
use slamlab_core::slam::{PriorMapFit, Slam};

/// The exit status if the result of a run cannot be trusted: the map is torn, nothing was matched
/// to it, or the robot is lost in the given map. 2 is that of a wrong command line.
pub(crate) const NOT_BELIEVED: u8 = 3;

/// The verdict on a map whose method is not judged; only scan matching is.
pub(crate) const NOT_JUDGED: &str = "not judged";

/// In what way a robot is lost in the given map at the end of a run; `None` if it is not.
pub(crate) fn lost(slam: &Slam) -> Option<&'static str> {
    let view = slam.view();
    let pose_quality = view.pose_quality;
    if pose_quality.is_some_and(|quality| quality.localisation == Localisation::Lost) {
        Some("at its end, the robot is lost in the map")
    } else if view.prior_map_fit.is_some_and(PriorMapFit::is_misfit) {
        Some("at its end, what is seen does not stand in the prior map")
    } else {
        None
    }
}

/// Whether map and poses can be trusted. A map of a single scan cannot be judged, and is trusted.
pub(crate) fn is_believed(quality: &MapQuality) -> bool {
    let is_founded = matches!(quality.unjudgeable, None | Some(Unjudgeable::OneScan));
    is_founded && quality.verdict != MapVerdict::Torn
}

/// What became of the loops that were considered, for the JSON. Waiting, refused and revoked ones
/// are counted as far as the matcher still knows them: the last few hundred. The doubts are the
/// widest among those accepted after a search: how well their places were known before.
pub(crate) fn closures(map: &ScanMatcher) -> Value {
    let records: Vec<_> = map.closure_records().collect();
    let count = |is: fn(&ClosureFate) -> bool| {
        let fates = records.iter().map(|record| &record.fate);
        fates.filter(|fate| is(fate)).count()
    };
    let widest = |of: fn(&ClosureRecord) -> f64| {
        let accepted = records.iter().filter(|record| {
            record.is_searched && matches!(record.fate, ClosureFate::Accepted { .. })
        });
        accepted.map(|record| of(record)).reduce(f64::max)
    };
    json!({
        "accepted": count(|fate| matches!(fate, ClosureFate::Accepted { .. })),
        "waiting": count(|fate| matches!(fate, ClosureFate::Waiting { .. })),
        "placed_elsewhere": count(|fate| *fate == ClosureFate::Refused { why: Refusal::PlacedElsewhere }),
        "never_proved": count(|fate| *fate == ClosureFate::Refused { why: Refusal::NeverProved }),
        "revoked": count(|fate| matches!(fate, ClosureFate::Revoked { .. })),
        "widest_doubt_m": widest(|record| record.doubt.shift),
        "widest_doubt_rad": widest(|record| record.doubt.turn),
    })
}

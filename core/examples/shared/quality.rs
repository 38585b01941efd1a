//! The quality of a map: for JSON, and in words.

use serde_json::{Value, json};
use slamlab_core::estimation::{ClosedLoop, MapQuality, MapVerdict, Tear, TearKind, Unjudgeable};
use slamlab_core::robot::Stamp;

/// Maximum number of tears that are described in words.
const MOST_TOLD: usize = 10;

/// The fields of the JSON.
pub(crate) fn figures(quality: &MapQuality) -> Value {
    let seen = |[from, to]: [Stamp; 2]| [from.seconds(), to.seconds()];
    let tear = |tear: &Tear| {
        json!({
            "kind": tear.kind.name(),
            "x_m": tear.place.x,
            "y_m": tear.place.y,
            "off_m": tear.off,
            "earlier_s": seen(tear.earlier),
            "later_s": seen(tear.later),
            "witnesses": tear.witnesses,
        })
    };
    let closed = |closed: &ClosedLoop| {
        let error = &closed.error;
        json!({
            "earlier_s": seen(closed.earlier),
            "later_s": seen(closed.later),
            "doubt_m": error.doubt.shift,
            "doubt_rad": error.doubt.turn,
            "found_m": error.shift,
            "found_rad": error.turn,
            "ratio": error.ratio,
        })
    };
    let stretches = quality.stretches.iter();
    json!({
        "verdict": quality.verdict.name(),
        "unjudgeable": quality.unjudgeable.map(Unjudgeable::name),
        "agreement": quality.agreement,
        "torn": quality.tears.iter().map(tear).collect::<Vec<_>>(),
        "over_time": stretches
            .map(|stretch| json!({ "seen_s": seen(stretch.seen), "agreement": stretch.agreement }))
            .collect::<Vec<_>>(),
        "loops": quality.loops.iter().map(closed).collect::<Vec<_>>(),
        "loop_ratio": quality.loop_ratio(),
    })
}

/// What a person should know of it; empty for a good map whose figures are all as certain as
/// stated.
pub(crate) fn words(quality: &MapQuality) -> Vec<String> {
    let ratio = quality.loop_ratio().filter(|_| quality.is_overconfident());
    let overconfident = ratio.map(|ratio| {
        format!(
            "ways were known worse than is said: when loops were closed over them, they were off \
             by {ratio:.1} times what was known of them, on the median"
        )
    });
    let verdict = words_of_verdict(quality);
    verdict.into_iter().chain(overconfident).collect()
}

fn words_of_verdict(quality: &MapQuality) -> Vec<String> {
    let mut lines = match quality.verdict {
        MapVerdict::Good => return vec![],
        MapVerdict::Doubtful => vec!["the map is doubtful".to_owned()],
        MapVerdict::Torn => vec!["the map is torn".to_owned()],
    };
    let why = quality.unjudgeable.map(|why| match why {
        Unjudgeable::NoSurfaces => "no scan showed a surface that others could be matched to",
        Unjudgeable::OneScan => "there is one scan",
        Unjudgeable::Unmatched => {
            "only the first scan was drawn, and the last could not be matched to it"
        }
    });
    lines.extend(why.map(|why| format!("{why}: nothing can be said of the map")));
    lines.extend(quality.tears.iter().take(MOST_TOLD).map(told));
    if let Some(more) = quality
        .tears
        .len()
        .checked_sub(MOST_TOLD)
        .filter(|&n| n > 0)
    {
        lines.push(format!("and at {more} more places"));
    }
    lines
}

fn told(tear: &Tear) -> String {
    let [then, now] = [tear.earlier, tear.later].map(|[from, to]| {
        let seconds = |stamp: Stamp| stamp.seconds();
        format!("{:.0} to {:.0} s", seconds(from), seconds(to))
    });
    let off = tear
        .off
        .map_or("far".to_owned(), |off| format!("{off:.1} m"));
    let why = match tear.kind {
        TearKind::Doubled => format!("the same walls stand twice, {off} apart"),
        TearKind::Contradicted => "walls stand where was nothing at the other time".to_owned(),
        TearKind::Loose => format!("the robot was lost in between, by about {off}"),
        TearKind::Unproven => format!("nothing proves the way between them, known to {off}"),
    };
    let (x, y) = (tear.place.x, tear.place.y);
    format!("at ({x:.1}, {y:.1}) m: {why}; seen from {then} and from {now}")
}

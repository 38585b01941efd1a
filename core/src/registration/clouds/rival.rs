//! Whether another pose is as good as the one that was found.
//!
//! In symmetric rooms, scans match in several ways, and the scans alone cannot tell which is meant.
//! The start can: the pose nearest to it is wanted. A method that compares whole clouds may end at
//! another pose, far away. That pose is believed only if a search about the start finds no other
//! pose that the judge accepts.
//!
//! Scans that show partly different things, such as those of a sensor with a narrow field of view,
//! may also match in several ways, because what would contradict all but one is out of sight. Such
//! a pose is believed only near the start, and only if the search finds no other on which about as
//! many points agree.

use super::super::{SearchWindow, Verdict};
use super::Cloud;
use super::bearings::Bearings;
use super::correlation::{self, CorrelationConfig};
use super::judge::{JudgeConfig, Judged, judge};
use crate::geom::{Length, Pose2};

/// Poses farther apart than this count as two, m, ...
const OTHER_SHIFT: f64 = 0.1;
/// ... and so do those turned by more than this, rad.
const OTHER_TURN: f64 = 0.1;

/// Whether another pose is as good as what was found from `start`, or may well be.
pub(super) fn is_ambiguous(
    moving: &Cloud,
    fixed: &Cloud,
    start: &Pose2,
    found: &Judged,
    config: &JudgeConfig,
) -> bool {
    let pose = &found.registration.estimate.pose;
    let is_apart = |other: &Pose2, shift: f64, turn: f64| {
        let way = pose.minus(other);
        way.xy().length() > shift || way.z.abs() > turn
    };
    let is_far = is_apart(start, config.far_shift, config.far_turn);
    if found.registration.verdict != Verdict::Converged || !(is_far || found.is_partial) {
        return false;
    }
    let looks_all_round = |cloud: &Cloud| cloud.view().is_none_or(Bearings::is_all_round);
    if is_far && (found.is_partial || ![moving, fixed].into_iter().all(looks_all_round)) {
        return true;
    }
    // Only where the pose would not be far: a pose there may be worse than the one found, and still
    // be the one that is meant.
    let window = SearchWindow {
        shift: config.far_shift,
        turn: config.far_turn,
    };
    let search = CorrelationConfig {
        window,
        ..CorrelationConfig::default()
    };
    let near = correlation::run(moving, fixed, start, &search, &mut ());
    let rival = judge(moving, fixed, &near, config);
    let is_good = matches!(
        rival.registration.verdict,
        Verdict::Converged | Verdict::Degenerate { .. } | Verdict::NotConverged
    );
    let is_other = is_apart(&rival.registration.estimate.pose, OTHER_SHIFT, OTHER_TURN);
    let is_as_good = rival.agree as f64 >= config.as_good * found.agree as f64;
    is_good && is_other && (is_far || is_as_good)
}

//! Whether another pose is as good as the one that was found.
//!
//! Where rooms are symmetric, scans lie on each other in several ways, and the scans alone do not
//! say which is meant. The start does: what is asked for is the pose nearest to it. A method that
//! looks at the whole clouds at once may come to another one, far away. It is believed only where a
//! search about the start finds no other that the judge lets pass.
//!
//! Scans that show partly different things, as of a sensor that looks one way, may lie on each
//! other in several ways as well, for what would contradict all but one is out of sight. There,
//! a pose is believed only near the start, and where the search finds no other on which about as
//! many points agree.

use super::super::{SearchWindow, Verdict};
use super::Cloud;
use super::bearings::Bearings;
use super::correlation::{self, CorrelationConfig};
use super::judge::{JudgeConfig, Judged, judge};
use crate::geom::{Length, Pose2};

/// Poses that are farther from each other than this are two, m, ...
const OTHER_SHIFT: f64 = 0.1;
/// ... and those that are turned by more than this, rad.
const OTHER_TURN: f64 = 0.1;

/// Whether another pose than what was found from `start` is as good, or may well be.
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
    // Only where the pose would not be far: what lies there may be worse than what was found, and
    // still what is meant.
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

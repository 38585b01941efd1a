//! Whether another pose is as good as the one that was found.
//!
//! Where rooms are symmetric, scans lie on each other in several ways, and the scans alone do not
//! say which is meant. The start does: what is asked for is the pose nearest to it. A method that
//! looks at the whole clouds at once may come to another one, far away. It is believed only where a
//! search about the start finds no other that the judge lets pass.

use super::super::{Registration, Verdict};
use super::Cloud;
use super::correlation::{self, CorrelationConfig};
use super::judge::{JudgeConfig, judge};
use crate::geom::{Length, Pose2};

/// Poses that are turned by more than this from each other are two, rad.
const OTHER_TURN: f64 = 0.1;

/// Whether what was found from `start` lies far from it, while another pose about it is as good.
pub(super) fn is_ambiguous(
    moving: &Cloud,
    fixed: &Cloud,
    start: &Pose2,
    found: &Registration,
    config: &JudgeConfig,
) -> bool {
    let pose = &found.estimate.pose;
    let is_apart = |other: &Pose2, shift: f64, turn: f64| {
        let way = pose.minus(other);
        way.xy().length() > shift || way.z.abs() > turn
    };
    if found.verdict != Verdict::Converged || !is_apart(start, config.far_shift, config.far_turn) {
        return false;
    }
    let search = CorrelationConfig::default();
    let near = correlation::run(moving, fixed, start, &search, &mut ());
    let rival = judge(moving, fixed, &near, config);
    let is_good = matches!(
        rival.verdict,
        Verdict::Converged | Verdict::Degenerate { .. }
    );
    let is_other = is_apart(&rival.estimate.pose, config.beside, OTHER_TURN);
    is_good && is_other
}

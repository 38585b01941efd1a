//! How certain a run's pose is, in the form of the wire.

use crate::estimation::{Localisation, ScanMatcher};
use crate::slam::Slam;
use crate::wire::message::PoseState;

/// Whether the pose of `slam` can be trusted.
pub(super) fn of(slam: &Slam) -> PoseState {
    let view = slam.view();
    if slam.points().is_none() {
        return PoseState::Unknown;
    }
    if !view.map.is_none_or(ScanMatcher::is_placed) {
        return PoseState::Unplaced;
    }
    match view.pose_quality.map(|quality| quality.localisation) {
        None | Some(Localisation::Localised) => PoseState::Localised,
        Some(Localisation::Ambiguous) => PoseState::Ambiguous,
        Some(Localisation::Lost) => PoseState::Lost,
    }
}

//! What one scan did to the map.

use super::LandmarkId;
use crate::geom::Pose2;

/// What one scan did to the map.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct UpdateReport {
    /// Recognised lines.
    pub matches: Vec<Match>,
    /// New landmarks, with the index of their feature.
    pub added: Vec<(usize, LandmarkId)>,
    /// Lines not used.
    pub rejected: Vec<Rejected>,
    /// Landmarks forgotten after this scan.
    pub forgotten: Vec<LandmarkId>,
    /// Normalised innovation squared, summed over the matches: χ² with 2 degrees of freedom for each.
    pub nis: f64,
    /// What the recognised lines said of the pose, in order of time.
    pub fixes: Vec<Fix>,
}

impl UpdateReport {
    pub(super) fn reject(&mut self, feature: usize, reason: Rejection) {
        self.rejected.push(Rejected { feature, reason });
    }
}

/// What a recognised line said of the pose at the instant at which it was seen, map frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fix {
    /// When the middle of the line was seen, s.
    pub seconds: f64,
    /// The estimate without the line.
    pub before: Pose2,
    /// The estimate with it.
    pub after: Pose2,
    /// Variance of the heading that the line alone gives, relative to its wall, rad².
    pub heading_variance: f64,
}

/// A line that was recognised.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Match {
    /// Index of the feature in the scan's list.
    pub feature: usize,
    /// The landmark.
    pub landmark: LandmarkId,
    /// Squared Mahalanobis distance before the update.
    pub d2: f64,
}

/// A line that was not used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rejected {
    /// Index of the feature in the scan's list.
    pub feature: usize,
    /// Why.
    pub reason: Rejection,
}

/// Why a line was not used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rejection {
    /// It may be one of several landmarks.
    Ambiguous,
    /// It is near a landmark, but outside of the gate.
    OutsideGate,
    /// Its landmark was already seen in this scan.
    Taken,
    /// It lies across the seam of the sweep: its parts were seen a whole sweep apart, and the robot moved meanwhile.
    Seam,
}

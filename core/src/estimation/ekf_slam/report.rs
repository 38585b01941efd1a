//! What one scan did to the map.

use super::LandmarkId;

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
}

impl UpdateReport {
    pub(super) fn reject(&mut self, feature: usize, reason: Rejection) {
        self.rejected.push(Rejected { feature, reason });
    }
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

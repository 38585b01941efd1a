//! What one scan did to the map, and why: enough for a page to answer "why this match?".

use nalgebra::{Matrix2, Vector2};

use super::LandmarkId;
use crate::association::{AssociationConfig, Candidate, Compared, Flip, Innovation, flips};
use crate::geom::Pose2;

/// What one scan did to the map.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct UpdateReport {
    /// Recognised lines.
    pub matches: Vec<Match>,
    /// New landmarks, with the index of their feature.
    pub added: Vec<(usize, LandmarkId)>,
    /// Landmarks forgotten after this scan.
    pub forgotten: Vec<LandmarkId>,
    /// Landmarks that turned out to be parts of one wall, or one point.
    pub merged: Vec<Merged>,
    /// Normalised innovation squared, summed over the matches: χ² with [`Self::nis_degrees`]
    /// degrees of freedom.
    pub nis: f64,
    /// What the recognised lines contributed to the pose, in order of time.
    pub fixes: Vec<Fix>,
    /// Recognised points, with the index of each in the scan's list of points.
    pub point_matches: Vec<Match>,
    /// New points, with the index of their feature.
    pub points_added: Vec<(usize, LandmarkId)>,
    pub(super) of_lines: Explained,
    pub(super) of_points: Explained,
}

/// Why the sightings of one kind were matched as they were.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Explained {
    /// Candidates of all sightings; those of the sighting for which [`Self::conclude`] is called
    /// next are at the end.
    pub(super) considered: Vec<Considered>,
    sightings: Vec<Concluded>,
}

/// The contribution of a recognised line to the pose at the instant at which it was seen, map
/// frame.
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

/// A line or a point that was recognised.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Match {
    /// Index of the feature in the scan's list.
    pub feature: usize,
    /// The landmark.
    pub landmark: LandmarkId,
    /// Squared Mahalanobis distance before the update.
    pub d2: f64,
}

/// Two landmarks that became one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Merged {
    /// The one that stays.
    pub kept: LandmarkId,
    /// The other, whose name is never reused.
    pub gone: LandmarkId,
    /// Squared Mahalanobis distance between the two, χ² with 2 degrees of freedom if they are one
    /// wall.
    pub d2: f64,
    /// Whether the two were joined by a measurement; otherwise they lay on each other without
    /// agreeing, and `gone` was dropped.
    pub is_joined: bool,
}

/// Why a line or a point was not used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rejection {
    /// It may be one of several landmarks.
    Ambiguous,
    /// It is near a landmark, but outside of the gate.
    OutsideGate,
    /// Its landmark was already seen in this scan.
    Taken,
    /// A point on beams by which a wall was found too, if such points are not to be used.
    OnAWall,
    /// It lies across the seam of the sweep: its parts were seen a whole sweep apart, and the robot
    /// moved meanwhile.
    Seam,
    /// The covariance of its innovation is not positive definite; the state was left alone.
    Singular,
}

/// Why a line or a point was matched as it was.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Explanation<'a> {
    /// Index of the feature in the scan's list.
    pub feature: usize,
    /// The landmarks it was compared with, the most likely first; far ones are left out, except for
    /// the nearest.
    pub candidates: &'a [Considered],
    /// What became of it.
    pub decision: Decision,
}

/// A landmark that a line or a point was compared with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Considered {
    /// The landmark.
    pub landmark: LandmarkId,
    /// Squared Mahalanobis distance, χ² with 2 degrees of freedom if it is this one.
    pub d2: f64,
    /// Free distance between the seen and the known part along the wall, m, minus the uncertainty
    /// of the robot's position along it; 0 or less if they overlap. 0 for a point.
    pub gap: f64,
    /// (α, r) seen minus expected, rad and m; for a point (x, y), robot frame, m.
    pub innovation: [f64; 2],
    /// Standard deviations of `innovation`.
    pub sigmas: [f64; 2],
    /// Covariance of the two.
    pub covariance: f64,
    /// What the gates say.
    pub gate: Gate,
    /// Whether its position along the wall rules out that it is a part of this wall.
    pub is_beyond: bool,
    /// Whether the landmark had been seen often enough to be a wall.
    pub is_confirmed: bool,
}

/// Inside which gate a candidate lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Gate {
    /// It may be this wall.
    Match,
    /// Too far for a match, too near for a new wall.
    Near,
    /// By its direction or distance it is another wall.
    Far,
    /// Beside the known part, but not its continuation: the gap is too large, or it is too
    /// uncertain whether both lie on one line.
    Beyond,
}

/// What became of a line or a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Decision {
    /// Recognised as this wall.
    Matched(LandmarkId),
    /// The first sighting of this wall.
    Added(LandmarkId),
    /// Not used.
    Rejected(Rejection),
}

/// How the explanation of one feature is stored: its candidates are a part of one list for all.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Concluded {
    feature: usize,
    first: usize,
    end: usize,
    decision: Decision,
}

impl UpdateReport {
    /// For each line of the scan, in the order in which they were processed, what it was compared
    /// with and what became of it.
    pub fn explanations(&self) -> impl Iterator<Item = Explanation<'_>> {
        self.of_lines.iter()
    }

    /// The same for each point.
    pub fn point_explanations(&self) -> impl Iterator<Item = Explanation<'_>> {
        self.of_points.iter()
    }

    /// Number of lines that were not used.
    #[must_use]
    pub fn rejected(&self) -> usize {
        let is_rejected = |e: &Explanation| matches!(e.decision, Decision::Rejected(_));
        self.explanations().filter(is_rejected).count()
    }

    /// Degrees of freedom of [`Self::nis`]: two for each match.
    #[must_use]
    pub fn nis_degrees(&self) -> usize {
        2 * (self.matches.len() + self.point_matches.len())
    }

    /// Clears the report, but keeps its memory.
    pub(super) fn clear(&mut self) {
        self.matches.clear();
        self.added.clear();
        self.forgotten.clear();
        self.merged.clear();
        self.point_matches.clear();
        self.points_added.clear();
        for explained in [&mut self.of_lines, &mut self.of_points] {
            explained.considered.clear();
            explained.sightings.clear();
        }
        self.fixes.clear();
        self.nis = 0.0;
    }
}

impl Explanation<'_> {
    /// What would flip this match if the sighting's first number alone were smaller or larger, and
    /// the same for its second; nothing for a sighting that was not matched. Outcomes name
    /// landmarks.
    #[must_use]
    pub fn flips(&self, config: &AssociationConfig) -> Option<[Option<Flip>; 4]> {
        let Decision::Matched(id) = self.decision else {
            return None;
        };
        let (own, others): (Vec<Compared>, Vec<Compared>) = (self.candidates.iter())
            .filter_map(Considered::compared)
            .partition(|each| each.candidate.index == id.0 as usize);
        let matched = own.first()?;
        let [[a, b], [c, d]] = [0, 1].map(|axis| flips(matched, &others, axis, config));
        Some([a, b, c, d])
    }
}

impl Considered {
    /// In the form that the association rule takes, with the landmark's number as its index; `None`
    /// if the covariance of the innovation is not positive definite.
    fn compared(&self) -> Option<Compared> {
        let [sigma_a, sigma_b] = self.sigmas;
        let (c, v) = (self.covariance, Vector2::from(self.innovation));
        let cov = Matrix2::new(sigma_a * sigma_a, c, c, sigma_b * sigma_b);
        Some(Compared {
            candidate: Candidate {
                index: self.landmark.0 as usize,
                d2: self.d2,
                gap: self.gap,
                is_beyond: self.is_beyond,
                is_confirmed: self.is_confirmed,
                expected: (-v).into(),
            },
            innovation: Innovation::new(v, cov)?,
        })
    }
}

impl Explained {
    fn iter(&self) -> impl Iterator<Item = Explanation<'_>> {
        self.sightings.iter().map(|concluded| Explanation {
            feature: concluded.feature,
            candidates: self
                .considered
                .get(concluded.first..concluded.end)
                .unwrap_or_default(),
            decision: concluded.decision,
        })
    }

    /// Records what became of a sighting, and keeps its `most` likeliest candidates: those with d²
    /// up to `far`, and the nearest.
    pub(super) fn conclude(&mut self, feature: usize, decision: Decision, most: usize, far: f64) {
        let first = self.sightings.last().map_or(0, |e| e.end);
        let own = self.considered.get_mut(first..).unwrap_or_default();
        own.sort_unstable_by(|a, b| a.d2.total_cmp(&b.d2).then(a.landmark.cmp(&b.landmark)));
        let near = own.partition_point(|c| c.d2 <= far).max(1).min(own.len());
        let end = first + near.min(most);
        self.considered.truncate(end);
        self.sightings.push(Concluded {
            feature,
            first,
            end,
            decision,
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn considered(landmark: u32, d2: f64) -> Considered {
        Considered {
            landmark: LandmarkId(landmark),
            d2,
            gap: -1.0,
            innovation: [0.0; 2],
            sigmas: [1.0; 2],
            covariance: 0.0,
            gate: Gate::Match,
            is_beyond: false,
            is_confirmed: true,
        }
    }

    #[test]
    fn each_line_keeps_its_own_candidates_likeliest_first() {
        let mut report = UpdateReport::default();
        for c in [considered(0, 7.0), considered(1, 2.0), considered(2, 400.0)] {
            report.of_lines.considered.push(c);
        }
        report
            .of_lines
            .conclude(4, Decision::Matched(LandmarkId(1)), 8, 100.0);
        report.of_lines.considered.push(considered(3, 500.0));
        report
            .of_lines
            .conclude(1, Decision::Added(LandmarkId(5)), 8, 100.0);
        report
            .of_lines
            .conclude(0, Decision::Rejected(Rejection::Seam), 8, 100.0);
        let of = |feature| {
            let explanation = report
                .explanations()
                .find(|e| e.feature == feature)
                .unwrap();
            let ids: Vec<_> = explanation
                .candidates
                .iter()
                .map(|c| c.landmark.0)
                .collect();
            (ids, explanation.decision)
        };
        assert_eq!(of(4), (vec![1, 0], Decision::Matched(LandmarkId(1))));
        // The nearest one is reported however far it is: it explains why the line is new.
        assert_eq!(of(1), (vec![3], Decision::Added(LandmarkId(5))));
        assert_eq!(of(0), (vec![], Decision::Rejected(Rejection::Seam)));
        assert_eq!(report.rejected(), 1);
        assert_eq!(report.explanations().count(), 3);
        report.clear();
        assert_eq!(report, UpdateReport::default());
    }
}

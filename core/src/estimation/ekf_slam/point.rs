//! Points in the state (corners and the centres of round objects): steps 3 to 6 for them.
//!
//! They share one state with the walls, and pass the same gates. Of the points that a scan shows
//! ([`crate::features::find_points`]), corners and circles become landmarks. Crossings do not:
//! where two lines cross says nothing beyond the lines. Spikes do not: where the silhouette of an
//! object ends depends on the viewpoint. [`super::shared`] handles what corners and walls have in
//! common.
//!
//! Walls alone are the default. Over 20 tours each, ATE with walls, points, both is 8, 89, 7 mm in
//! `office`, 4, 11, 4 mm in `arena` and 19, 57, 33 mm in `lab`; the worst tour with points is 0.67
//! m off in `office`, the worst with both 0.39 m in `lab`. NEES of the pose during the tour (3 is
//! honest) with both is 3.4, 2.2, 3.4, with points alone 424, 4.9, 9.8: a corner errs in the same
//! way from scan to scan (`report -- point-landmarks`).

use nalgebra::{Matrix2, Point2, SMatrix, Vector2};

use super::point_model::{Places, observe, place};
use super::report::Considered;
use super::sighting::Jacobian;
use super::{Consistency, Decision, EkfSlam, LandmarkId, Match, Merged, REPORTED, Rejection};
use crate::association::{Candidate, Choice, Innovation, Paired, are_alike, choose, choose_paired};
use crate::features::{PointFeature, PointKind};
use crate::geom::Length;

/// A point in the map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointLandmark {
    /// Its name.
    pub id: LandmarkId,
    /// Its kind.
    pub kind: PointKind,
    /// Where it is, map frame, m.
    pub position: Point2<f64>,
    /// Covariance of the position, m².
    pub cov: Matrix2<f64>,
    /// How often it was seen.
    pub sightings: u32,
    /// Whether that is often enough to be believed.
    pub is_confirmed: bool,
}

impl PointLandmark {
    /// How often it was found again.
    ///
    /// # Source   Pilch 2016 §3.5.2: the confidence of a landmark grows by 1 each time.
    #[must_use]
    pub fn confidence(&self) -> u32 {
        self.sightings.saturating_sub(1)
    }
}

/// Whether points of a kind are landmarks.
pub(super) fn is_landmark(kind: &PointKind) -> bool {
    matches!(kind, PointKind::Corner | PointKind::Circle { .. })
}

/// A point in the state.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct PointEntry {
    pub(super) id: LandmarkId,
    /// The state's row of x; that of y is the next.
    pub(super) row: usize,
    pub(super) kind: PointKind,
    pub(super) position: Point2<f64>,
    /// Where it was at the first sighting.
    pub(super) first_position: Point2<f64>,
    pub(super) sightings: u32,
    pub(super) last_seen: u32,
}

impl PointEntry {
    /// Counts a sighting; a radius is the mean of all, by their information.
    fn see(&mut self, kind: &PointKind, scans: u32) {
        self.sightings += 1;
        self.last_seen = scans;
        self.kind.refine(kind);
    }
}

/// The expected sighting of one point.
#[derive(Clone, Debug)]
pub(super) struct ExpectedPoint {
    /// Robot frame, m.
    pub(super) position: Point2<f64>,
    /// H P Hᵀ.
    pub(super) cov: Matrix2<f64>,
    pub(super) jacobian: Jacobian,
}

impl EkfSlam {
    /// All points in the order of the state, including those not yet confirmed.
    pub fn point_landmarks(&self) -> impl Iterator<Item = PointLandmark> + '_ {
        self.points.iter().map(|entry| PointLandmark {
            id: entry.id,
            kind: entry.kind,
            position: entry.position,
            cov: self.block(entry.row),
            sightings: entry.sightings,
            is_confirmed: entry.sightings >= self.config.confirm_sightings,
        })
    }

    /// Steps 3 and 4 for point number `index`, in the robot frame of the state; `paired` is its
    /// match, if all of the scan were matched together.
    pub(super) fn take_in_point(
        &mut self,
        index: usize,
        seen: &PointFeature,
        paired: Option<Paired>,
    ) -> Decision {
        let compared = (0..self.points.len()).filter_map(|point| self.compare_point(point, seen));
        let (candidates, considered): (Vec<_>, Vec<_>) = compared.unzip();
        self.report.of_points.considered.extend(considered);
        let config = &self.config.association;
        let choice = match paired {
            Some(paired) => {
                let place = |row| self.points.iter().position(|entry| entry.row == row);
                choose_paired(&candidates, by_index(paired, place), config)
            }
            None => choose(&candidates, config),
        };
        let decision = match choice {
            Choice::Match(found) => self.recognise_point(index, &found, seen),
            Choice::Ambiguous => Decision::Rejected(Rejection::Ambiguous),
            Choice::NearMiss => Decision::Rejected(Rejection::OutsideGate),
            Choice::New => {
                let id = self.augment_point(seen);
                self.report.points_added.push((index, id));
                Decision::Added(id)
            }
        };
        self.conclude_point(index, decision);
        decision
    }

    pub(super) fn conclude_point(&mut self, index: usize, decision: Decision) {
        let far = self.reported_far();
        let explained = &mut self.report.of_points;
        explained.conclude(index, decision, REPORTED, far);
    }

    fn recognise_point(
        &mut self,
        feature: usize,
        found: &Candidate,
        seen: &PointFeature,
    ) -> Decision {
        let scans = self.scans;
        let Some(entry) = self.points.get(found.index) else {
            return Decision::Rejected(Rejection::OutsideGate);
        };
        if entry.last_seen == scans {
            return Decision::Rejected(Rejection::Taken);
        }
        let expected = self.expect_point(entry);
        let is_used = self
            .point_innovation(&expected, seen)
            .is_some_and(|innovation| {
                let columns = expected.jacobian.columns();
                self.absorb(&innovation.v, &innovation.cov, &columns)
            });
        let Some(entry) = self.points.get_mut(found.index).filter(|_| is_used) else {
            return Decision::Rejected(Rejection::Singular);
        };
        entry.see(&seen.kind, scans);
        let landmark = entry.id;
        self.report.nis += found.d2;
        self.report.point_matches.push(Match {
            feature,
            landmark,
            d2: found.d2,
        });
        Decision::Matched(landmark)
    }

    /// How far a sighting is from the expected one of a point; `None` if it is something else.
    pub(super) fn compare_point(
        &self,
        point: usize,
        seen: &PointFeature,
    ) -> Option<(Candidate, Considered)> {
        let entry = self.points.get(point)?;
        if !are_alike(&entry.kind, &seen.kind) {
            return None;
        }
        let expected = self.expect_point(entry);
        let innovation = self.point_innovation(&expected, seen)?;
        let candidate = Candidate {
            index: point,
            d2: innovation.d2,
            gap: 0.0,
            is_beyond: false,
            is_confirmed: entry.sightings >= self.config.confirm_sightings,
            expected: [expected.position.x, expected.position.y],
        };
        let considered = Considered {
            landmark: entry.id,
            d2: innovation.d2,
            gap: 0.0,
            innovation: innovation.v.into(),
            sigmas: [innovation.cov[(0, 0)].sqrt(), innovation.cov[(1, 1)].sqrt()],
            covariance: innovation.cov[(0, 1)],
            gate: self.gate(&candidate),
            is_beyond: candidate.is_beyond,
            is_confirmed: candidate.is_confirmed,
        };
        Some((candidate, considered))
    }

    pub(super) fn expect_point(&self, entry: &PointEntry) -> ExpectedPoint {
        let at = Places {
            robot: self.linearised_at(),
            point: match self.config.consistency {
                Consistency::Plain => entry.position,
                Consistency::FirstEstimates => entry.first_position,
            },
        };
        let (position, by_pose, by_own) = observe(&self.pose, entry.position, &at);
        let jacobian = Jacobian {
            row: entry.row,
            by_pose,
            by_own,
        };
        ExpectedPoint {
            position,
            cov: self.expected_cov(&jacobian),
            jacobian,
        }
    }

    pub(super) fn point_innovation(
        &self,
        expected: &ExpectedPoint,
        seen: &PointFeature,
    ) -> Option<Innovation> {
        let v = seen.position - expected.position;
        Innovation::new(v, expected.cov + self.point_cov(seen))
    }

    /// The covariance of a sighting: that of its fit, and what is added to it.
    pub(super) fn point_cov(&self, seen: &PointFeature) -> Matrix2<f64> {
        let beside = self.config.point_sigma * self.config.point_sigma;
        seen.cov + Matrix2::identity() * beside
    }

    /// Step 4.
    pub(super) fn augment_point(&mut self, seen: &PointFeature) -> LandmarkId {
        let (position, by_pose, by_seen) = place(&self.pose, seen.position, self.linearised_at());
        let own = by_pose * self.pose_cov() * by_pose.transpose()
            + by_seen * self.point_cov(seen) * by_seen.transpose();
        let (id, row) = self.append(&by_pose, &own);
        self.points.push(PointEntry {
            id,
            row,
            kind: seen.kind,
            position,
            first_position: position,
            sightings: 1,
            last_seen: self.scans,
        });
        id
    }

    /// Step 5: merges the points that this scan saw with others of their kind that are surely the
    /// same, as with walls.
    pub(super) fn merge_points(&mut self) {
        for point in (0..self.points.len()).rev() {
            if let Some((other, difference)) = self.twin_point(point) {
                self.merge_point(point, other, &difference);
            }
        }
    }

    /// The likeliest point that is surely the same.
    fn twin_point(&self, point: usize) -> Option<(usize, Innovation)> {
        let is_known = |e: &&PointEntry| e.sightings >= self.config.confirm_sightings;
        let own = self.points.get(point).filter(is_known)?;
        if own.last_seen != self.scans {
            return None;
        }
        let merge = &self.config.merge;
        let others = self.points.iter().enumerate().filter(|(index, other)| {
            *index != point
                && is_known(other)
                && are_alike(&own.kind, &other.kind)
                && (other.position - own.position).length() <= 2.0 * merge.r
        });
        let same = others.filter_map(|(index, other)| {
            let v = other.position - own.position;
            let columns = apart(own, other);
            let h = SMatrix::<f64, 2, 4>::from_fn(|row, k| columns[k].1[row]);
            let p = SMatrix::<f64, 4, 4>::from_fn(|k, l| self.cov.get(columns[k].0, columns[l].0));
            let difference = Innovation::new(v, h * p * h.transpose())?;
            let is_small = |axis: usize| {
                let variance = difference.cov[(axis, axis)];
                merge.is_small(v[axis], variance, merge.r)
            };
            let is_one = difference.d2 <= merge.gate && is_small(0) && is_small(1);
            is_one.then_some((index, difference))
        });
        same.min_by(|a, b| a.1.d2.total_cmp(&b.1.d2))
    }

    /// Merges two, of which the older stays: a measurement without noise that their difference is
    /// zero.
    fn merge_point(&mut self, point: usize, other: usize, difference: &Innovation) {
        let Some((own, twin)) = self.points.get(point).zip(self.points.get(other)) else {
            return;
        };
        let columns = apart(own, twin);
        let (kept, gone) = if own.id < twin.id {
            (point, other)
        } else {
            (other, point)
        };
        if !self.absorb(&-difference.v, &difference.cov, &columns) {
            return;
        }
        let gone = self.points.remove(gone);
        self.remove_rows(gone.row);
        let Some(kept) = self.points.get_mut(kept) else {
            return;
        };
        // The radius of the removed point counts as one more sighting.
        kept.see(&gone.kind, kept.last_seen.max(gone.last_seen));
        kept.sightings += gone.sightings - 1;
        self.report.merged.push(Merged {
            kept: kept.id,
            gone: gone.id,
            d2: difference.d2,
            is_joined: true,
        });
    }
}

/// H of the difference of two points, second minus first.
fn apart(first: &PointEntry, second: &PointEntry) -> [crate::estimation::Column; 4] {
    [
        (first.row, [-1.0, 0.0]),
        (first.row + 1, [0.0, -1.0]),
        (second.row, [1.0, 0.0]),
        (second.row + 1, [0.0, 1.0]),
    ]
}

/// Replaces rows by indices in a match.
pub(super) fn by_index(paired: Paired, place: impl Fn(usize) -> Option<usize>) -> Paired {
    match paired {
        Paired::Landmark(row) => place(row).map_or(Paired::Nothing, Paired::Landmark),
        other => other,
    }
}

/// Variance of the heading that a point alone gives, if its position is known, rad²; `None` for a
/// point at the robot's position.
pub(super) fn heading_variance(cov: &Matrix2<f64>, seen: Point2<f64>) -> Option<f64> {
    let across = Vector2::new(-seen.y, seen.x);
    let distance2 = across.norm_squared();
    let variance = across.dot(&(cov * across)) / (distance2 * distance2);
    variance.is_finite().then_some(variance)
}

//! Steps 3, 4 and 6: a sighting corrects the whole state, a new line widens it, a line that was not seen again leaves it.

use nalgebra::{Matrix2, Vector2};

use super::super::covariance::Column;
use super::super::line_model::place;
use super::expect::from_anchor;
use super::landmark::{Entry, hull};
use super::{Consistency, EkfSlam, Gain, LandmarkId, POSE, ROBOT, UpdateReport};
use crate::features::LineFeature;
use crate::geom::{Pose2, wrap};

impl EkfSlam {
    /// Step 3. Tells whether it could: where Z is not positive definite, the state is left alone.
    pub(super) fn correct(&mut self, landmark: usize, seen: &LineFeature, gain: &mut Gain) -> bool {
        let expected = self.expect(landmark);
        let Some(innovation) = self.innovation(&expected, seen) else {
            return false;
        };
        let (hx, hf, first) = (expected.by_pose, expected.by_line, ROBOT + 2 * landmark);
        let column = |state, h: [f64; 2]| (state, h);
        let columns = [
            column(0, [hx[(0, 0)], hx[(1, 0)]]),
            column(1, [hx[(0, 1)], hx[(1, 1)]]),
            column(2, [hx[(0, 2)], hx[(1, 2)]]),
            column(first, [hf[(0, 0)], hf[(1, 0)]]),
            column(first + 1, [hf[(0, 1)], hf[(1, 1)]]),
        ];
        let is_used = self.absorb(&innovation.v, &innovation.cov, &columns, gain);
        if is_used {
            self.extend(landmark, seen);
        }
        is_used
    }

    /// Corrects the whole state by two numbers that are `v` more than expected, with covariance `z` = H P Hᵀ + R, where H has
    /// the given `columns` (state, its column). `false`, and nothing done, where `z` is not positive definite.
    ///
    /// # Source   The update of TDK 2016 §3.4 as P -= W Wᵀ with Z = L Lᵀ, W = P Hᵀ L⁻ᵀ: then K Z Kᵀ = W Wᵀ and K v = W L⁻¹ v.
    pub(super) fn absorb(
        &mut self,
        v: &Vector2<f64>,
        z: &Matrix2<f64>,
        columns: &[Column],
        gain: &mut Gain,
    ) -> bool {
        let l00 = z[(0, 0)].sqrt();
        let l10 = z[(1, 0)] / l00;
        let l11 = (z[(1, 1)] - l10 * l10).sqrt();
        if !(l00 > 0.0 && l11 > 0.0 && (v.x + v.y + l00 + l11).is_finite()) {
            return false;
        }
        let whitened = [v.x / l00, (v.y - l10 * v.x / l00) / l11];
        let Gain { first, second } = gain;
        self.cov.product(columns, first, second);
        for (a, b) in first.iter_mut().zip(second.iter_mut()) {
            (*a, *b) = (*a / l00, (*b - l10 * *a / l00) / l11);
        }
        let mut shifts = first
            .iter()
            .zip(second.iter())
            .map(|(a, b)| a * whitened[0] + b * whitened[1]);
        let mut shift = || shifts.next().unwrap_or(0.0);
        self.pose = Pose2::new(
            self.pose.x() + shift(),
            self.pose.y() + shift(),
            self.pose.heading() + shift(),
        );
        self.errors.curvature += shift();
        self.errors.turn_scale += shift();
        for entry in &mut self.landmarks {
            entry.line = [wrap(entry.line[0] + shift()), entry.line[1] + shift()];
        }
        self.cov.subtract(first, second);
        true
    }

    /// Counts a sighting and widens the known part of the wall.
    fn extend(&mut self, landmark: usize, seen: &LineFeature) {
        let (pose, scans) = (self.pose, self.scans);
        if let Some(entry) = self.landmarks.get_mut(landmark) {
            let tangent = entry.tangent();
            let [a, b] = seen
                .ends
                .map(|end| tangent.dot(&(pose * end - entry.anchor)));
            let seen = [a.min(b), a.max(b)];
            entry.extent = hull(entry.extent, seen);
            if entry.last_seen == scans {
                // Another part of the wall, behind something that stands before it.
                entry.seen_now = hull(entry.seen_now, seen);
            } else {
                entry.seen_now = seen;
                entry.sightings += 1;
                entry.last_seen = scans;
            }
        }
    }

    /// Step 4.
    pub(super) fn augment(&mut self, seen: &LineFeature) -> LandmarkId {
        let oriented = self.oriented(seen);
        let at = match self.config.consistency {
            Consistency::Plain => self.pose.position(),
            Consistency::FirstEstimates => self.predicted,
        };
        let anchor = self.pose * nalgebra::center(&seen.ends[0], &seen.ends[1]);
        let (line, by_pose, by_seen) = place(
            &from_anchor(&self.pose, &anchor),
            [oriented.alpha, oriented.r],
            at - anchor.coords,
        );
        let corner = by_pose * self.pose_cov() * by_pose.transpose()
            + by_seen * oriented.cov * by_seen.transpose();
        // Eq. (3.31): the new rows are G_x times the rows of the pose.
        let cov = &self.cov;
        let element = |h: usize, column: usize| -> f64 {
            (0..POSE)
                .map(|k| by_pose[(h, k)] * cov.get(k, column))
                .sum()
        };
        let row = |h: usize| (0..cov.n()).map(move |column| element(h, column));
        let alpha_row: Vec<f64> = row(0).chain([corner[(0, 0)]]).collect();
        let mixed = 0.5 * (corner[(0, 1)] + corner[(1, 0)]);
        let r_row: Vec<f64> = row(1).chain([mixed, corner[(1, 1)]]).collect();
        self.cov.push_pair([alpha_row, r_row]);
        let id = LandmarkId(self.next_id);
        self.next_id += 1;
        self.landmarks.push(Entry {
            id,
            anchor,
            line,
            first_alpha: line[0],
            extent: [f64::INFINITY, f64::NEG_INFINITY],
            seen_now: [f64::INFINITY, f64::NEG_INFINITY],
            sightings: 0,
            last_seen: 0,
        });
        self.extend(self.landmarks.len() - 1, seen);
        id
    }

    /// Step 6.
    pub(super) fn forget(&mut self, report: &mut UpdateReport) {
        for index in (0..self.landmarks.len()).rev() {
            let entry = &self.landmarks[index];
            if entry.sightings < self.config.confirm_sightings
                && self.scans - entry.last_seen > self.config.patience
            {
                report.forgotten.push(entry.id);
                self.landmarks.remove(index);
                self.cov.remove_pair(ROBOT + 2 * index);
            }
        }
    }
}

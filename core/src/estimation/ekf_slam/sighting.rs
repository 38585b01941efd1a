//! Step 3: the expected sighting of a landmark, how far a sighting is from it, and how the sighting
//! corrects the whole state.

use nalgebra::{Matrix2, Matrix2x3, Point2, Vector2, Vector3};

use super::super::covariance::Column;
use super::super::line_model::{Linearisation, observe};
use super::{Considered, EkfSlam, Gate, POSE};
use crate::association::{Candidate, ExpectedLine, Innovation, OrientedLine, gap};
use crate::features::LineFeature;
use crate::geom::{Length, Pose2, sin_cos, wrap};

/// The derivative of the expected sighting of one landmark with respect to the state.
#[derive(Clone, Debug)]
pub(super) struct Jacobian {
    /// The landmark's first row in the state.
    pub(super) row: usize,
    /// With respect to (x, y, θ).
    pub(super) by_pose: Matrix2x3<f64>,
    /// With respect to the landmark's own two numbers.
    pub(super) by_own: Matrix2<f64>,
}

impl Jacobian {
    /// The nonzero columns of H.
    pub(super) fn columns(&self) -> [Column; 5] {
        let (hx, hf) = (&self.by_pose, &self.by_own);
        [
            (0, [hx[(0, 0)], hx[(1, 0)]]),
            (1, [hx[(0, 1)], hx[(1, 1)]]),
            (2, [hx[(0, 2)], hx[(1, 2)]]),
            (self.row, [hf[(0, 0)], hf[(1, 0)]]),
            (self.row + 1, [hf[(0, 1)], hf[(1, 1)]]),
        ]
    }
}

/// The expected sighting of one wall.
#[derive(Clone, Debug)]
pub(super) struct Expectation {
    pub(super) line: ExpectedLine,
    pub(super) jacobian: Jacobian,
    pub(super) along_sigma: f64,
}

impl EkfSlam {
    /// How far a sighting is from the expected one of a landmark; `None` if its direction or
    /// distance alone rules it out.
    pub(super) fn compare(
        &self,
        landmark: usize,
        seen: &LineFeature,
    ) -> Option<(Candidate, Considered)> {
        let entry = self.landmarks.get(landmark)?;
        let turn = wrap(entry.line[0] - self.pose.heading() - OrientedLine::of(seen).alpha);
        if turn.abs() > self.config.max_turn || self.is_far(landmark, seen) {
            return None;
        }
        let expected = self.expect(landmark);
        let innovation = self.innovation(&expected, seen)?;
        // The wall's ends are known no better than the robot's position along it.
        let free = gap(expected.line.ends, seen);
        let gap = free - self.config.along_sigmas * expected.along_sigma;
        let candidate = Candidate {
            index: landmark,
            d2: innovation.d2,
            gap,
            is_beyond: gap > self.config.association.max_gap
                || (free > 0.0 && !self.is_surely_on(&expected.line, &innovation, seen)),
            is_confirmed: entry.sightings >= self.config.confirm_sightings,
            expected: [expected.line.alpha, expected.line.r],
        };
        let considered = Considered {
            landmark: entry.id,
            d2: innovation.d2,
            gap,
            innovation: innovation.v.into(),
            sigmas: [innovation.cov[(0, 0)].sqrt(), innovation.cov[(1, 1)].sqrt()],
            covariance: innovation.cov[(0, 1)],
            gate: self.gate(&candidate),
            is_beyond: candidate.is_beyond,
            is_confirmed: candidate.is_confirmed,
        };
        Some((candidate, considered))
    }

    /// Whether a sighting beside the known part of a wall is known to lie on its line, as reliably
    /// as two landmarks must to be merged ([`super::MergeConfig`]). A gate that is wide because
    /// little is known also includes the next wall, 10 cm further back.
    fn is_surely_on(
        &self,
        expected: &ExpectedLine,
        innovation: &Innovation,
        seen: &LineFeature,
    ) -> bool {
        let pairs = expected
            .ends
            .iter()
            .flat_map(|known| seen.ends.iter().map(move |end| (known, end)));
        let nearest = pairs.min_by(|a, b| (a.0 - a.1).length().total_cmp(&(b.0 - b.1).length()));
        let Some((known, end)) = nearest else {
            return false;
        };
        let (sin, cos) = sin_cos(expected.alpha);
        let along = Vector2::new(-sin, cos).dot(&nalgebra::center(known, end).coords);
        let across = Vector2::new(-along, 1.0);
        let merge = &self.config.merge;
        merge.is_small(innovation.v.x, innovation.cov[(0, 0)], merge.alpha)
            && merge.is_small(
                across.dot(&innovation.v),
                across.dot(&(innovation.cov * across)),
                merge.r,
            )
    }

    /// Whether the distance r alone rules a landmark out, by a variance bound that needs only the
    /// diagonal of P: the variance of a sum of n terms is at most n times the sum of their
    /// variances.
    fn is_far(&self, landmark: usize, seen: &LineFeature) -> bool {
        let entry = &self.landmarks[landmark];
        let oriented = OrientedLine::of(seen);
        let tangent = entry.tangent();
        let from = self.pose.position() - entry.anchor;
        let off = oriented.r - (entry.line[1] - tangent.y * from.x + tangent.x * from.y);
        let variance = |state| self.cov.variance_bound(state);
        let first = entry.row;
        let lever = from.norm_squared();
        let terms = variance(0) + variance(1) + lever * variance(first) + variance(first + 1);
        let sensor = oriented.cov[(1, 1)] + self.config.r_sigma * self.config.r_sigma;
        off * off
            > self.config.far_gates * self.config.association.new_gate * (4.0 * terms + sensor)
    }

    pub(super) fn gate(&self, candidate: &Candidate) -> Gate {
        let config = &self.config.association;
        match candidate.d2 {
            d2 if d2 > config.new_gate.max(config.gate) => Gate::Far,
            _ if candidate.is_beyond => Gate::Beyond,
            d2 if d2 > config.gate => Gate::Near,
            _ => Gate::Match,
        }
    }

    pub(super) fn expect(&self, landmark: usize) -> Expectation {
        let entry = &self.landmarks[landmark];
        let at = Linearisation {
            robot: self.linearised_at() - entry.anchor.coords,
            alpha: self.linearised_alpha(entry),
        };
        let (z, by_pose, by_own) =
            observe(&from_anchor(&self.pose, &entry.anchor), entry.line, &at);
        let jacobian = Jacobian {
            row: entry.row,
            by_pose,
            by_own,
        };
        let (pose_cov, cov) = (self.pose_cov(), self.expected_cov(&jacobian));
        let robot_from_map = self.pose.inverse();
        let tangent = entry.tangent();
        let along = tangent.x * tangent.x * pose_cov[(0, 0)]
            + 2.0 * tangent.x * tangent.y * pose_cov[(0, 1)]
            + tangent.y * tangent.y * pose_cov[(1, 1)];
        Expectation {
            line: ExpectedLine {
                alpha: z.x,
                r: z.y,
                cov,
                ends: entry.ends().map(|end| robot_from_map * end),
            },
            jacobian,
            along_sigma: along.max(0.0).sqrt(),
        }
    }

    /// H P Hᵀ.
    pub(super) fn expected_cov(&self, jacobian: &Jacobian) -> Matrix2<f64> {
        let Jacobian {
            row: first,
            by_pose,
            by_own,
        } = jacobian;
        let cross = Matrix2x3::from_fn(|row, column| self.cov.get(first + row, column));
        let mixed = by_own * cross * by_pose.transpose();
        by_pose * self.pose_cov() * by_pose.transpose()
            + by_own * self.block(*first) * by_own.transpose()
            + mixed
            + mixed.transpose()
    }

    pub(super) fn innovation(
        &self,
        expected: &Expectation,
        seen: &LineFeature,
    ) -> Option<Innovation> {
        expected.line.innovation(&self.oriented(seen))
    }

    pub(super) fn oriented(&self, seen: &LineFeature) -> OrientedLine {
        let mut oriented = OrientedLine::of(seen);
        oriented.cov[(0, 0)] += self.config.alpha_sigma * self.config.alpha_sigma;
        oriented.cov[(1, 1)] += self.config.r_sigma * self.config.r_sigma;
        oriented
    }

    /// Step 3. Returns whether it was possible: if Z is not positive definite, the state is
    /// unchanged.
    pub(super) fn correct(&mut self, landmark: usize, seen: &LineFeature) -> bool {
        let expected = self.expect(landmark);
        let Some(innovation) = self.innovation(&expected, seen) else {
            return false;
        };
        let columns = expected.jacobian.columns();
        let is_used = self.absorb(&innovation.v, &innovation.cov, &columns);
        if is_used {
            self.extend(landmark, seen);
        }
        is_used
    }

    /// Corrects the whole state by two numbers that are `v` more than expected, with covariance `z`
    /// = H P Hᵀ + R, where H has the given `columns` (state, its column). Returns `false` and
    /// changes nothing if `z` is not positive definite.
    ///
    /// # Source   The update of TDK 2016 §3.4 as P -= W Wᵀ with Z = L Lᵀ, W = P Hᵀ L⁻ᵀ: then K Z Kᵀ
    /// = W Wᵀ and K v = W L⁻¹ v.
    pub(super) fn absorb(
        &mut self,
        v: &Vector2<f64>,
        z: &Matrix2<f64>,
        columns: &[Column],
    ) -> bool {
        let l00 = z[(0, 0)].sqrt();
        let l10 = z[(1, 0)] / l00;
        let l11 = (z[(1, 1)] - l10 * l10).sqrt();
        if !(l00 > 0.0 && l11 > 0.0 && (v.x + v.y + l00 + l11).is_finite()) {
            return false;
        }
        let whitened = [v.x / l00, (v.y - l10 * v.x / l00) / l11];
        let [first, second] = &mut self.gain;
        self.cov.product(columns, first, second);
        for (a, b) in first.iter_mut().zip(second.iter_mut()) {
            (*a, *b) = (*a / l00, (*b - l10 * *a / l00) / l11);
        }
        let shift = |row: usize| {
            let both = first.get(row).zip(second.get(row));
            both.map_or(0.0, |(a, b)| a * whitened[0] + b * whitened[1])
        };
        self.pose = self.pose.plus(&Vector3::from_fn(|row, _| shift(row)));
        self.errors.curvature += shift(POSE);
        self.errors.turn_scale += shift(POSE + 1);
        for entry in &mut self.landmarks {
            let (alpha, r) = (shift(entry.row), shift(entry.row + 1));
            entry.line = [wrap(entry.line[0] + alpha), entry.line[1] + r];
        }
        for entry in &mut self.points {
            entry.position += Vector2::new(shift(entry.row), shift(entry.row + 1));
        }
        self.cov.subtract(first, second);
        true
    }
}

/// The pose with its position relative to `anchor`.
pub(super) fn from_anchor(pose: &Pose2, anchor: &Point2<f64>) -> Pose2 {
    let from = pose.position() - anchor;
    Pose2::new(from.x, from.y, pose.heading())
}

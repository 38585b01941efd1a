//! In: odometry, and the lines of each scan. Out: the robot's pose and the walls, with one covariance over all of it.
//!
//! The state is (x, y, θ, α₁, r₁, α₂, r₂, …) in the map frame, which starts at the robot's first pose. Each line is oriented:
//! its normal points from the side it was seen from into the wall, and r is signed (`association::gate`).
//!
//! 1. **Predict**: the pose moves by the odometry; only P_xx and P_xf change. O(n), TDK 2016 eq. (3.18)-(3.20).
//! 2. **Associate**: for each line seen, the landmarks it may be ([`choose`]); lines with the fewest candidates and the most
//!    points go first.
//! 3. **Update** with one match at a time, re-linearised after each (TDK 2016 §3.2 says why): Z from a 5x5 block, gain O(n), and
//!    P -= (P Hᵀ) Z⁻¹ (P Hᵀ)ᵀ as one symmetric rank-2 update of the triangle. Candidates are judged again with the pose that
//!    the match before has corrected.
//! 4. **Augment** with lines that are far from everything known: block rows by eq. (3.31), (3.32).
//! 5. **Forget** lines that were not seen again soon: their rows and columns are deleted, which is the marginal of a Gaussian.
//!
//! Consistency: an EKF that takes its Jacobians at ever new estimates believes to learn its absolute heading, which nothing
//! measures (Huang, Mourikis & Roumeliotis 2010, "Observability-based rules for designing consistent EKF SLAM
//! estimators"). [`Consistency::FirstEstimates`] takes them at the first ones.

use nalgebra::{Matrix2, Matrix2x3, Matrix3, Point2, Vector2};

use super::line_model::{Linearisation, observe, place};
use super::triangle::SymmetricMatrix;
use crate::association::{
    AssociationConfig, Candidate, Choice, ExpectedLine, Innovation, OrientedLine, choose,
};
use crate::features::LineFeature;
use crate::geom::{Line, Pose2, PoseEstimate, sin_cos, wrap};
use crate::robot::Odometry;

/// Index of the first landmark's α in the state.
const POSE: usize = 3;

/// Where the Jacobians are taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Consistency {
    /// At the newest estimate: the textbook filter.
    Plain,
    /// At the first estimate of each landmark and the predicted pose, so that what cannot be observed stays unobserved.
    FirstEstimates,
}

/// Settings of the filter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EkfConfig {
    /// How sightings are matched.
    pub association: AssociationConfig,
    /// Where the Jacobians are taken.
    pub consistency: Consistency,
    /// Sightings after which a line counts as a wall. Default 3.
    pub confirm_sightings: u32,
    /// Scans after which a line that is not confirmed is forgotten. Default 15.
    pub patience: u32,
    /// What the fit does not know about α (skew within a sweep, walls that are not flat), rad. Default 0.001. Added to each
    /// sighting; growing makes the filter more cautious.
    pub alpha_sigma: f64,
    /// What the fit does not know about r, m. Default 0.002.
    pub r_sigma: f64,
}

impl Default for EkfConfig {
    fn default() -> Self {
        Self {
            association: AssociationConfig::default(),
            consistency: Consistency::FirstEstimates,
            confirm_sightings: 3,
            patience: 15,
            alpha_sigma: 0.001,
            r_sigma: 0.002,
        }
    }
}

/// Name of a landmark, the same for its whole life and never given again.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct LandmarkId(pub u32);

/// A wall in the map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Landmark {
    /// Its name.
    pub id: LandmarkId,
    /// The line in the map frame.
    pub line: Line,
    /// Covariance of (α, r).
    pub cov: Matrix2<f64>,
    /// Where the part seen so far begins and ends, map frame.
    pub ends: [Point2<f64>; 2],
    /// How often it was seen.
    pub sightings: u32,
    /// Whether that is often enough to be a wall.
    pub is_confirmed: bool,
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

/// Why a line was not used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rejection {
    /// It may be one of several landmarks.
    Ambiguous,
    /// It is near a landmark, but outside of the gate.
    OutsideGate,
    /// Its landmark was already seen in this scan.
    Taken,
}

/// A line that was not used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rejected {
    /// Index of the feature in the scan's list.
    pub feature: usize,
    /// Why.
    pub reason: Rejection,
}

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

/// Why the filter refused an input; the state is untouched.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum EkfError {
    /// Odometry with a number that is not finite, or with a negative variance.
    #[error(
        "odometry from {from:.3} s to {to:.3} s: {what}; expected finite numbers and variances of at least 0"
    )]
    Odometry {
        /// Start of the motion, s.
        from: f64,
        /// End of the motion, s.
        to: f64,
        /// The part at fault.
        what: &'static str,
    },
    /// A line with a number that is not finite, or a covariance that is not positive definite.
    #[error("feature {feature}: {what}")]
    Feature {
        /// Index in the scan's list.
        feature: usize,
        /// The part at fault.
        what: &'static str,
    },
}

/// A landmark's place in the state is `POSE + 2 * index`.
#[derive(Clone, Debug, PartialEq)]
struct Entry {
    id: LandmarkId,
    /// (α, r), r signed.
    line: [f64; 2],
    /// α at the first sighting.
    first_alpha: f64,
    /// From where to where it was seen, m along (-sin α, cos α) from the foot of the perpendicular.
    extent: [f64; 2],
    sightings: u32,
    last_seen: u32,
}

/// Line EKF-SLAM.
#[derive(Clone, Debug)]
pub struct EkfSlam {
    config: EkfConfig,
    pose: Pose2,
    /// Position at which the Jacobians of this scan are taken.
    predicted: Point2<f64>,
    landmarks: Vec<Entry>,
    cov: SymmetricMatrix,
    next_id: u32,
    scans: u32,
    scratch: Scratch,
}

/// Buffers kept between updates.
#[derive(Clone, Debug, Default)]
struct Scratch {
    /// P Hᵀ L⁻ᵀ, one row for each state.
    gain: Vec<[f64; 2]>,
    /// (feature, landmark) pairs worth a look.
    pairs: Vec<(usize, usize)>,
    order: Vec<usize>,
    taken: Vec<bool>,
    candidates: Vec<Candidate>,
}

/// What is expected of one landmark, with the Jacobians that led to it.
struct Expectation {
    line: ExpectedLine,
    by_pose: Matrix2x3<f64>,
    by_line: Matrix2<f64>,
    along_sigma: f64,
}

impl EkfSlam {
    /// A filter at the origin of an empty map.
    #[must_use]
    pub fn new(config: EkfConfig) -> Self {
        Self {
            config,
            pose: Pose2::identity(),
            predicted: Point2::origin(),
            landmarks: vec![],
            cov: SymmetricMatrix::zeros(POSE),
            next_id: 0,
            scans: 0,
            scratch: Scratch::default(),
        }
    }

    /// The pose in the map frame.
    #[must_use]
    pub fn estimate(&self) -> PoseEstimate {
        PoseEstimate {
            pose: self.pose,
            cov: self.pose_cov(),
        }
    }

    /// All landmarks in the order of the state, those not yet confirmed too.
    pub fn landmarks(&self) -> impl Iterator<Item = Landmark> + '_ {
        self.landmarks.iter().enumerate().map(|(index, entry)| {
            let [alpha, r] = entry.line;
            let mut cov = self.block(POSE + 2 * index);
            if r < 0.0 {
                cov[(0, 1)] = -cov[(0, 1)];
                cov[(1, 0)] = -cov[(1, 0)];
            }
            Landmark {
                id: entry.id,
                line: Line::new(alpha, r),
                cov,
                ends: entry.ends(),
                sightings: entry.sightings,
                is_confirmed: entry.sightings >= self.config.confirm_sightings,
            }
        })
    }

    /// The covariance of the whole state (x, y, θ, α₁, r₁, …), landmarks in the order of [`Self::landmarks`], r signed.
    #[must_use]
    pub fn covariance(&self) -> &SymmetricMatrix {
        &self.cov
    }

    /// Step 1: moves the pose by `odometry`.
    ///
    /// # Errors   [`EkfError::Odometry`]; then nothing has changed.
    /// # Source   TDK 2016 eq. (3.1)-(3.4), (3.18)-(3.20).
    pub fn predict(&mut self, odometry: &Odometry) -> Result<(), EkfError> {
        check_odometry(odometry)?;
        let moved = self.pose * odometry.motion;
        let from = match self.config.consistency {
            Consistency::Plain => self.pose.position(),
            Consistency::FirstEstimates => self.predicted,
        };
        // F_x is the identity but for the two elements that turn the step.
        let step = moved.position() - from;
        let f = [-step.y, step.x];
        let (cos, sin) = self.pose.cos_sin();
        let by_motion = Matrix3::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0);
        let added = by_motion * odometry.cov * by_motion.transpose();
        let by_pose = Matrix3::new(1.0, 0.0, f[0], 0.0, 1.0, f[1], 0.0, 0.0, 1.0);
        let pose_cov = by_pose * self.pose_cov() * by_pose.transpose() + added;
        for row in 0..POSE {
            for column in 0..=row {
                let value = 0.5 * (pose_cov[(row, column)] + pose_cov[(column, row)]);
                self.cov.set(row, column, value);
            }
        }
        for row in self.cov.rows_mut(POSE) {
            if let [x, y, turn, ..] = row {
                *x += f[0] * *turn;
                *y += f[1] * *turn;
            }
        }
        self.pose = moved;
        self.predicted = moved.position();
        Ok(())
    }

    /// Steps 2 to 5: takes in the lines of one scan, in the robot frame.
    ///
    /// # Errors   [`EkfError::Feature`] for the first line whose numbers cannot be used; then nothing has changed.
    pub fn update(&mut self, features: &[LineFeature]) -> Result<UpdateReport, EkfError> {
        for (index, feature) in features.iter().enumerate() {
            check_feature(index, feature)?;
        }
        self.scans += 1;
        let mut report = UpdateReport::default();
        let mut scratch = std::mem::take(&mut self.scratch);
        self.find_pairs(features, &mut scratch);
        order(features, &mut scratch);
        let mut unknown = vec![];
        for &feature in &scratch.order {
            self.candidates(feature, features, &scratch.pairs, &mut scratch.candidates);
            match choose(&scratch.candidates, &self.config.association) {
                Choice::Match(found) if scratch.taken[found.index] => {
                    report.reject(feature, Rejection::Taken);
                }
                Choice::Match(found) => {
                    scratch.taken[found.index] = true;
                    self.correct(found.index, &features[feature], &mut scratch.gain);
                    report.nis += found.d2;
                    report.matches.push(Match {
                        feature,
                        landmark: self.landmarks[found.index].id,
                        d2: found.d2,
                    });
                }
                Choice::Ambiguous => report.reject(feature, Rejection::Ambiguous),
                Choice::Near => report.reject(feature, Rejection::OutsideGate),
                Choice::New => unknown.push(feature),
            }
        }
        // Judged again with the corrected pose, and against each other.
        for feature in unknown {
            let all = (0..self.landmarks.len()).map(|landmark| (feature, landmark));
            scratch.pairs.clear();
            scratch.pairs.extend(all);
            self.candidates(feature, features, &scratch.pairs, &mut scratch.candidates);
            match choose(&scratch.candidates, &self.config.association) {
                Choice::New => {
                    let id = self.augment(&features[feature]);
                    report.added.push((feature, id));
                }
                Choice::Ambiguous => report.reject(feature, Rejection::Ambiguous),
                Choice::Match(_) | Choice::Near => report.reject(feature, Rejection::OutsideGate),
            }
        }
        self.scratch = scratch;
        self.forget(&mut report);
        Ok(report)
    }

    fn pose_cov(&self) -> Matrix3<f64> {
        Matrix3::from_fn(|row, column| self.cov.get(row, column))
    }

    fn block(&self, first: usize) -> Matrix2<f64> {
        Matrix2::from_fn(|row, column| self.cov.get(first + row, first + column))
    }

    /// Fills `scratch.pairs` with what a coarse look does not rule out.
    fn find_pairs(&self, features: &[LineFeature], scratch: &mut Scratch) {
        scratch.pairs.clear();
        scratch.taken.clear();
        scratch.taken.resize(self.landmarks.len(), false);
        for landmark in 0..self.landmarks.len() {
            let expected = self.expect(landmark);
            for (feature, seen) in features.iter().enumerate() {
                if self
                    .candidate(landmark, &expected, seen)
                    .is_some_and(|c| c.d2 <= 4.0 * self.config.association.new_gate)
                {
                    scratch.pairs.push((feature, landmark));
                }
            }
        }
    }

    /// Writes the landmarks that `feature` may be, as the state stands now.
    fn candidates(
        &self,
        feature: usize,
        features: &[LineFeature],
        pairs: &[(usize, usize)],
        candidates: &mut Vec<Candidate>,
    ) {
        candidates.clear();
        let mine = pairs.iter().filter(|pair| pair.0 == feature);
        candidates.extend(mine.filter_map(|&(_, landmark)| {
            self.candidate(landmark, &self.expect(landmark), features.get(feature)?)
        }));
    }

    fn candidate(
        &self,
        landmark: usize,
        expected: &Expectation,
        seen: &LineFeature,
    ) -> Option<Candidate> {
        let innovation = self.innovation(expected, seen)?;
        // The wall's ends are known no better than where the robot is along it.
        let gap = expected.line.gap(seen) - 3.0 * expected.along_sigma;
        Some(Candidate {
            index: landmark,
            d2: innovation.d2,
            gap,
            expected: [expected.line.alpha, expected.line.r],
        })
    }

    fn innovation(&self, expected: &Expectation, seen: &LineFeature) -> Option<Innovation> {
        expected.line.innovation(&self.oriented(seen))
    }

    fn oriented(&self, seen: &LineFeature) -> OrientedLine {
        let mut oriented = OrientedLine::of(seen);
        oriented.cov[(0, 0)] += self.config.alpha_sigma * self.config.alpha_sigma;
        oriented.cov[(1, 1)] += self.config.r_sigma * self.config.r_sigma;
        oriented
    }

    fn expect(&self, landmark: usize) -> Expectation {
        let entry = &self.landmarks[landmark];
        let at = match self.config.consistency {
            Consistency::Plain => Linearisation {
                robot: self.pose.position(),
                alpha: entry.line[0],
            },
            Consistency::FirstEstimates => Linearisation {
                robot: self.predicted,
                alpha: entry.first_alpha,
            },
        };
        let (z, by_pose, by_line) = observe(&self.pose, entry.line, &at);
        let first = POSE + 2 * landmark;
        let pose_cov = self.pose_cov();
        let cross = Matrix2x3::from_fn(|row, column| self.cov.get(first + row, column));
        let mixed = by_line * cross * by_pose.transpose();
        let cov = by_pose * pose_cov * by_pose.transpose()
            + by_line * self.block(first) * by_line.transpose()
            + mixed
            + mixed.transpose();
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
            by_pose,
            by_line,
            along_sigma: along.max(0.0).sqrt(),
        }
    }

    /// Step 3. Leaves the state alone where Z is not positive definite.
    fn correct(&mut self, landmark: usize, seen: &LineFeature, gain: &mut Vec<[f64; 2]>) {
        let expected = self.expect(landmark);
        let Some(innovation) = self.innovation(&expected, seen) else {
            return;
        };
        let z = innovation.cov;
        // Z = L Lᵀ, and W = P Hᵀ L⁻ᵀ, so that K Z Kᵀ = W Wᵀ and K v = W L⁻¹ v.
        let l00 = z[(0, 0)].sqrt();
        let l10 = z[(1, 0)] / l00;
        let l11 = (z[(1, 1)] - l10 * l10).sqrt();
        if !(l00 > 0.0 && l11 > 0.0) {
            return;
        }
        let whitened = [
            innovation.v.x / l00,
            (innovation.v.y - l10 * innovation.v.x / l00) / l11,
        ];
        let (hx, hf, first) = (expected.by_pose, expected.by_line, POSE + 2 * landmark);
        gain.clear();
        gain.extend((0..self.cov.n()).map(|row| {
            let p = |column| self.cov.get(row, column);
            let (px, pf) = ([p(0), p(1), p(2)], [p(first), p(first + 1)]);
            let along = |h: usize| {
                hx[(h, 0)] * px[0]
                    + hx[(h, 1)] * px[1]
                    + hx[(h, 2)] * px[2]
                    + hf[(h, 0)] * pf[0]
                    + hf[(h, 1)] * pf[1]
            };
            let (a, b) = (along(0), along(1));
            [a / l00, (b - l10 * a / l00) / l11]
        }));
        let shift = |w: &[f64; 2]| w[0] * whitened[0] + w[1] * whitened[1];
        if let [x, y, turn, lines @ ..] = gain.as_slice() {
            self.pose = Pose2::new(
                self.pose.x() + shift(x),
                self.pose.y() + shift(y),
                self.pose.heading() + shift(turn),
            );
            for (entry, w) in self.landmarks.iter_mut().zip(lines.chunks_exact(2)) {
                if let [alpha, r] = w {
                    entry.line = [wrap(entry.line[0] + shift(alpha)), entry.line[1] + shift(r)];
                }
            }
        }
        self.cov.subtract_rank2(gain);
        self.extend(landmark, seen);
    }

    /// Counts a sighting and widens the known part of the wall.
    fn extend(&mut self, landmark: usize, seen: &LineFeature) {
        let (pose, scans) = (self.pose, self.scans);
        if let Some(entry) = self.landmarks.get_mut(landmark) {
            let tangent = entry.tangent();
            for end in seen.ends {
                let along = tangent.dot(&(pose * end).coords);
                entry.extent = [entry.extent[0].min(along), entry.extent[1].max(along)];
            }
            entry.sightings += 1;
            entry.last_seen = scans;
        }
    }

    /// Step 4.
    fn augment(&mut self, seen: &LineFeature) -> LandmarkId {
        let oriented = self.oriented(seen);
        let at = match self.config.consistency {
            Consistency::Plain => self.pose.position(),
            Consistency::FirstEstimates => self.predicted,
        };
        let (line, by_pose, by_seen) = place(&self.pose, [oriented.alpha, oriented.r], at);
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
        self.cov.push_row(alpha_row);
        self.cov.push_row(r_row);
        let id = LandmarkId(self.next_id);
        self.next_id += 1;
        self.landmarks.push(Entry {
            id,
            line,
            first_alpha: line[0],
            extent: [f64::INFINITY, f64::NEG_INFINITY],
            sightings: 0,
            last_seen: 0,
        });
        self.extend(self.landmarks.len() - 1, seen);
        id
    }

    /// Step 5.
    fn forget(&mut self, report: &mut UpdateReport) {
        for index in (0..self.landmarks.len()).rev() {
            let entry = &self.landmarks[index];
            if entry.sightings < self.config.confirm_sightings
                && self.scans - entry.last_seen > self.config.patience
            {
                report.forgotten.push(entry.id);
                self.landmarks.remove(index);
                self.cov.remove_pair(POSE + 2 * index);
            }
        }
    }
}

impl Entry {
    fn tangent(&self) -> Vector2<f64> {
        let (sin, cos) = sin_cos(self.line[0]);
        Vector2::new(-sin, cos)
    }

    fn ends(&self) -> [Point2<f64>; 2] {
        let tangent = self.tangent();
        let foot = Vector2::new(tangent.y, -tangent.x) * self.line[1];
        self.extent
            .map(|along| Point2::from(foot + tangent * along))
    }
}

impl UpdateReport {
    fn reject(&mut self, feature: usize, reason: Rejection) {
        self.rejected.push(Rejected { feature, reason });
    }
}

/// Lines with the fewest candidates first, then those with the most points: the first match corrects the pose by which
/// the others are judged.
fn order(features: &[LineFeature], scratch: &mut Scratch) {
    let pairs = &scratch.pairs;
    let rank = |&feature: &usize| {
        let candidates = pairs.iter().filter(|pair| pair.0 == feature).count();
        let points = features.get(feature).map_or(0, |f| f.n_points);
        (candidates, std::cmp::Reverse(points))
    };
    scratch.order.clear();
    scratch.order.extend(0..features.len());
    scratch.order.sort_by_cached_key(rank);
}

fn check_odometry(odometry: &Odometry) -> Result<(), EkfError> {
    let error = |what| {
        Err(EkfError::Odometry {
            from: odometry.from.seconds(),
            to: odometry.to.seconds(),
            what,
        })
    };
    let motion = &odometry.motion;
    if !(motion.x() + motion.y() + motion.heading()).is_finite() {
        return error("the motion is not finite");
    }
    if !odometry.cov.iter().all(|v| v.is_finite()) {
        return error("the covariance is not finite");
    }
    if odometry.cov.diagonal().iter().any(|&v| v < 0.0) {
        return error("a variance is negative");
    }
    Ok(())
}

fn check_feature(index: usize, feature: &LineFeature) -> Result<(), EkfError> {
    let error = |what| {
        Err(EkfError::Feature {
            feature: index,
            what,
        })
    };
    let numbers = [feature.line.alpha(), feature.line.r()];
    let ends = feature.ends.iter().flat_map(|end| end.iter().copied());
    if !numbers.into_iter().chain(ends).all(f64::is_finite) {
        return error("alpha, r or an end is not finite");
    }
    let c = &feature.cov;
    let determinant = c[(0, 0)] * c[(1, 1)] - c[(0, 1)] * c[(1, 0)];
    if !(c[(0, 0)] > 0.0 && determinant > 0.0 && determinant.is_finite()) {
        return error("the covariance of (alpha, r) is not finite and positive definite");
    }
    Ok(())
}

#[cfg(test)]
mod tests;

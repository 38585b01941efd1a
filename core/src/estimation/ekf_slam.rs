//! In: odometry, and the lines of each scan. Out: the robot's pose and the walls, with one covariance over all of it.
//!
//! The state is (x, y, θ, α₁, r₁, α₂, r₂, …) in the map frame, which starts at the robot's first pose. Each line is oriented:
//! its normal points from the side it was seen from into the wall, and r is signed (`association::gate`). r counts from an anchor,
//! a fixed point in the middle of where the wall was first seen. Counted from the origin of the map, as the source has it, an
//! error of α is a shift of the wall by distance times error, to first order only: ½ · 10 m · (0.05 rad)² is 1 cm that no
//! covariance knows of, more than the wall is uncertain.
//!
//! 1. **Predict**: the pose moves by the odometry; only P_xx and P_xf change. O(n), TDK 2016 eq. (3.18)-(3.20).
//! 2. **In order of time**: a turning lidar sees each wall at another instant, and tracks slip between two instants of one
//!    sweep by more than the walls are uncertain. So odometry is kept back until the scan comes; each line is taken back to
//!    the robot frame of its own instant, the filter predicts up to there, and updates. Straightening the whole scan to its
//!    end by odometry and treating its lines as seen there would use the odometry's error twice, and believe it once.
//! 3. **Associate and update**: the landmarks that the line may be ([`choose`]); then Z from a 5x5 block, gain O(n), and
//!    P -= (P Hᵀ) Z⁻¹ (P Hᵀ)ᵀ as one symmetric rank-2 update of the triangle, re-linearised for each match (TDK 2016 §3.2
//!    says why).
//! 4. **Augment** with lines that are far from everything known: block rows by eq. (3.31), (3.32).
//! 5. **Forget** lines that were not seen again soon: their rows and columns are deleted, which is the marginal of a Gaussian.
//!
//! Consistency: an EKF that takes its Jacobians at ever new estimates believes to learn its absolute heading, which nothing
//! measures (Huang, Mourikis & Roumeliotis 2010, "Observability-based rules for designing consistent EKF SLAM
//! estimators"). [`Consistency::FirstEstimates`] takes them at the first ones. It is the default because it measures better:
//! the pose's NEES (3 is honest) over 8 seeds of errands was 2.3 against 4.4 in `doors`, 3.8 against 6.8 in `office`, 4.7 against
//! 5.6 in `loop`, with half the error. Letting the first estimates follow for some sightings gave that up again. What was left came
//! from lines of poor direction; without them (`LineConfig::max_alpha_sigma`) it is 2.2, 2.5 and 2.5.

use nalgebra::{Matrix2, Matrix2x3, Matrix3, Point2, Vector2};

use super::line_model::{Linearisation, observe, place};
use super::triangle::SymmetricMatrix;
use crate::association::{
    AssociationConfig, Candidate, Choice, ExpectedLine, Innovation, OrientedLine, choose,
};
use crate::features::LineFeature;
use crate::geom::{Line, Pose2, PoseEstimate, sin_cos, symmetrize, wrap};
use crate::robot::{Odometry, Scan, Stamp};

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

impl EkfConfig {
    /// For a sensor that scans on command and sees little: every sighting counts, nothing is forgotten soon.
    ///
    /// Between two scans of such a robot the heading drifts by degrees, not by tenths, and lines are short: what the
    /// first order leaves out grows with both. With 5 mrad and 4 mm for it the mean NEES of the pose (3 is honest) over 40 runs each
    /// of errands and explorations of `arena` is 2.7 and 2.5; with the default figures for it 3.4 and 3.7.
    #[must_use]
    pub fn short_range() -> Self {
        Self {
            confirm_sightings: 2,
            patience: 200,
            alpha_sigma: 0.005,
            r_sigma: 0.004,
            ..Self::default()
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
    /// It lies across the seam of the sweep: its parts were seen a whole sweep apart, and the robot moved meanwhile.
    Seam,
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

/// When the beams of a scan were taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SweepTiming {
    /// The instant whose robot frame the lines stand in.
    pub stamp: Stamp,
    /// Seconds from the last beam to `stamp`: scans arrive a little late.
    pub lag: f64,
    /// Seconds from the first beam to the last; 0 where all were taken at once or the robot stood still.
    pub seconds: f64,
    /// Number of beams.
    pub n_beams: usize,
}

impl SweepTiming {
    /// The timing of `scan`, whose lines stand in the robot frame at `stamp`, at the last beam or later.
    #[must_use]
    pub fn at(stamp: Stamp, scan: &Scan) -> Self {
        Self {
            stamp,
            lag: stamp.since(scan.stamp).max(0.0),
            ..Self::of(scan)
        }
    }

    /// The timing of `scan`, whose lines stand in the robot frame at its last beam.
    #[must_use]
    pub fn of(scan: &Scan) -> Self {
        Self {
            stamp: scan.stamp,
            lag: 0.0,
            seconds: scan.sweep,
            n_beams: scan.len(),
        }
    }

    /// All beams at once.
    #[must_use]
    pub fn at_once(stamp: Stamp) -> Self {
        Self {
            stamp,
            lag: 0.0,
            seconds: 0.0,
            n_beams: 0,
        }
    }

    /// Seconds from a beam to `stamp`.
    fn age(&self, beam: f64) -> f64 {
        let last = self.n_beams.saturating_sub(1);
        if last == 0 {
            return self.lag;
        }
        self.lag + self.seconds * (1.0 - beam / last as f64).clamp(0.0, 1.0)
    }

    /// Seconds from the middle of a line to `stamp`.
    fn age_of(&self, feature: &LineFeature) -> f64 {
        self.age(0.5 * (feature.first_beam + feature.last_beam) as f64)
    }
}

/// A landmark's place in the state is `POSE + 2 * index`.
#[derive(Clone, Debug, PartialEq)]
struct Entry {
    id: LandmarkId,
    /// Where r counts from, map frame; never moves.
    anchor: Point2<f64>,
    /// (α, r), r signed.
    line: [f64; 2],
    /// α at the first sighting.
    first_alpha: f64,
    /// From where to where it was seen, m along (-sin α, cos α) from the anchor's foot on the line.
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
    /// Odometry since the time of `pose`, kept back for the next scan, and the estimate at its end.
    pending: Vec<Odometry>,
    ahead: PoseEstimate,
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
    order: Vec<usize>,
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
            pending: vec![],
            ahead: PoseEstimate::exact(Pose2::identity()),
            landmarks: vec![],
            cov: SymmetricMatrix::zeros(POSE),
            next_id: 0,
            scans: 0,
            scratch: Scratch::default(),
        }
    }

    /// The pose in the map frame, at the end of the last odometry.
    #[must_use]
    pub fn estimate(&self) -> PoseEstimate {
        self.ahead
    }

    /// All landmarks in the order of the state, those not yet confirmed too.
    pub fn landmarks(&self) -> impl Iterator<Item = Landmark> + '_ {
        self.landmarks.iter().enumerate().map(|(index, entry)| {
            let (line, cov) = entry.in_map(&self.block(POSE + 2 * index));
            Landmark {
                id: entry.id,
                line,
                cov,
                ends: entry.ends(),
                sightings: entry.sightings,
                is_confirmed: entry.sightings >= self.config.confirm_sightings,
            }
        })
    }

    /// The covariance of the whole state (x, y, θ, α₁, r₁, …) at the last scan, landmarks in the order of
    /// [`Self::landmarks`], r signed and counted from each landmark's anchor.
    #[must_use]
    pub fn covariance(&self) -> &SymmetricMatrix {
        &self.cov
    }

    /// Takes in a motion; [`Self::estimate`] follows at once, the filter when the next scan comes.
    ///
    /// # Errors   [`EkfError::Odometry`]; then nothing has changed.
    pub fn predict(&mut self, odometry: &Odometry) -> Result<(), EkfError> {
        check_odometry(odometry)?;
        self.pending.push(*odometry);
        self.ahead = moved_by(&self.ahead, odometry);
        Ok(())
    }

    /// Step 1: moves the state by `odometry`.
    ///
    /// # Source   TDK 2016 eq. (3.1)-(3.4), (3.18)-(3.20).
    fn advance(&mut self, odometry: &Odometry) {
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
    }

    /// Step 2: moves the state by the pending odometry up to `time` (seconds); an odometry that goes past it is split.
    fn advance_to(&mut self, time: f64) {
        let mut used = 0;
        while let Some(&next) = self.pending.get(used) {
            let (from, to) = (next.from.seconds(), next.to.seconds());
            // Stamps have a grain of a microsecond.
            if to > time + 1e-6 {
                let part = if to > from {
                    (time - from) / (to - from)
                } else {
                    0.0
                };
                if part > 1e-3 {
                    let (first, rest) = split(&next, part);
                    self.advance(&first);
                    if let Some(pending) = self.pending.get_mut(used) {
                        *pending = rest;
                    }
                }
                break;
            }
            self.advance(&next);
            used += 1;
        }
        self.pending.drain(..used);
    }

    /// The motion from the time of the state to `time`, by the pending odometry: what a scan straightened to `time` has
    /// been moved by.
    fn motion_until(&self, time: f64) -> Odometry {
        let mut whole = Odometry::standing(Stamp(0));
        for next in &self.pending {
            let (from, to) = (next.from.seconds(), next.to.seconds());
            if to <= time + 1e-6 {
                whole = whole.then(next);
            } else {
                let part = if to > from {
                    (time - from) / (to - from)
                } else {
                    0.0
                };
                if part > 1e-3 {
                    whole = whole.then(&split(next, part).0);
                }
                break;
            }
        }
        whole
    }

    /// Steps 1 to 5: takes in the lines of one scan, in the robot frame at `sweep.stamp`.
    ///
    /// # Errors   [`EkfError::Feature`] for the first line whose numbers cannot be used; then nothing has changed.
    pub fn update(
        &mut self,
        features: &[LineFeature],
        sweep: &SweepTiming,
    ) -> Result<UpdateReport, EkfError> {
        for (index, feature) in features.iter().enumerate() {
            check_feature(index, feature)?;
        }
        self.scans += 1;
        let mut report = UpdateReport::default();
        let mut scratch = std::mem::take(&mut self.scratch);
        let end = sweep.stamp.seconds();
        let moved = self.motion_until(end).motion != Pose2::identity();
        order(features, sweep, &mut scratch.order);
        for &index in &scratch.order {
            let Some(feature) = features.get(index) else {
                continue;
            };
            if moved && sweep.seconds > 0.0 && feature.first_beam > feature.last_beam {
                report.reject(index, Rejection::Seam);
                continue;
            }
            self.advance_to(end - sweep.age_of(feature));
            let rest = self.motion_until(end);
            let feature = as_seen(feature, &rest, sweep);
            self.take_in(
                index,
                &feature,
                &mut scratch.candidates,
                &mut scratch.gain,
                &mut report,
            );
        }
        self.advance_to(end);
        self.scratch = scratch;
        self.forget(&mut report);
        self.ahead = PoseEstimate {
            pose: self.pose,
            cov: self.pose_cov(),
        };
        for odometry in &self.pending {
            self.ahead = moved_by(&self.ahead, odometry);
        }
        Ok(report)
    }

    /// Steps 3 and 4 for one line, in the robot frame of the state.
    fn take_in(
        &mut self,
        index: usize,
        seen: &LineFeature,
        candidates: &mut Vec<Candidate>,
        gain: &mut Vec<[f64; 2]>,
        report: &mut UpdateReport,
    ) {
        candidates.clear();
        candidates.extend((0..self.landmarks.len()).filter_map(|l| self.candidate(l, seen)));
        let scans = self.scans;
        match choose(candidates, &self.config.association) {
            Choice::Match(found) if self.landmarks[found.index].last_seen == scans => {
                report.reject(index, Rejection::Taken);
            }
            Choice::Match(found) => {
                self.correct(found.index, seen, gain);
                report.nis += found.d2;
                report.matches.push(Match {
                    feature: index,
                    landmark: self.landmarks[found.index].id,
                    d2: found.d2,
                });
            }
            Choice::Ambiguous => report.reject(index, Rejection::Ambiguous),
            Choice::Near => report.reject(index, Rejection::OutsideGate),
            Choice::New => {
                let id = self.augment(seen);
                report.added.push((index, id));
            }
        }
    }

    fn pose_cov(&self) -> Matrix3<f64> {
        Matrix3::from_fn(|row, column| self.cov.get(row, column))
    }

    fn block(&self, first: usize) -> Matrix2<f64> {
        Matrix2::from_fn(|row, column| self.cov.get(first + row, first + column))
    }

    fn candidate(&self, landmark: usize, seen: &LineFeature) -> Option<Candidate> {
        let entry = self.landmarks.get(landmark)?;
        // Most landmarks are out of the question by their direction alone.
        let turn = wrap(entry.line[0] - self.pose.heading() - OrientedLine::of(seen).alpha);
        if turn.abs() > 0.8 {
            return None;
        }
        let expected = self.expect(landmark);
        let innovation = self.innovation(&expected, seen)?;
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
                robot: self.pose.position() - entry.anchor.coords,
                alpha: entry.line[0],
            },
            Consistency::FirstEstimates => Linearisation {
                robot: self.predicted - entry.anchor.coords,
                alpha: entry.first_alpha,
            },
        };
        let (z, by_pose, by_line) =
            observe(&from_anchor(&self.pose, &entry.anchor), entry.line, &at);
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
                let along = tangent.dot(&(pose * end - entry.anchor));
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
        self.cov.push_row(alpha_row);
        self.cov.push_row(r_row);
        let id = LandmarkId(self.next_id);
        self.next_id += 1;
        self.landmarks.push(Entry {
            id,
            anchor,
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
        let foot = self.anchor + Vector2::new(tangent.y, -tangent.x) * self.line[1];
        self.extent.map(|along| foot + tangent * along)
    }

    /// The line and its covariance with r counted from the origin of the map, r ≥ 0.
    fn in_map(&self, cov: &Matrix2<f64>) -> (Line, Matrix2<f64>) {
        let tangent = self.tangent();
        let normal = Vector2::new(tangent.y, -tangent.x);
        let r = self.line[1] + normal.dot(&self.anchor.coords);
        let sign = if r < 0.0 { -1.0 } else { 1.0 };
        let jacobian = Matrix2::new(1.0, 0.0, sign * tangent.dot(&self.anchor.coords), sign);
        let mut cov = jacobian * cov * jacobian.transpose();
        symmetrize(&mut cov);
        (Line::new(self.line[0], r), cov)
    }
}

impl UpdateReport {
    fn reject(&mut self, feature: usize, reason: Rejection) {
        self.rejected.push(Rejected { feature, reason });
    }
}

/// The pose with its position counted from `anchor`.
fn from_anchor(pose: &Pose2, anchor: &Point2<f64>) -> Pose2 {
    let from = pose.position() - anchor;
    Pose2::new(from.x, from.y, pose.heading())
}

/// Indices of the lines in the order in which they were seen; those seen at once, the longest first.
fn order(features: &[LineFeature], sweep: &SweepTiming, order: &mut Vec<usize>) {
    let key = |&index: &usize| {
        features
            .get(index)
            .map_or((0.0, 0), |f| (sweep.age_of(f), f.n_points))
    };
    order.clear();
    order.extend(0..features.len());
    order.sort_by(|a, b| {
        let (a, b) = (key(a), key(b));
        b.0.total_cmp(&a.0).then(b.1.cmp(&a.1))
    });
}

/// Takes a line from the end of the sweep back by `rest`, to the robot frame in which it was seen, and widens its covariance
/// by what the odometry may err while the beams pass over it.
fn as_seen(feature: &LineFeature, rest: &Odometry, sweep: &SweepTiming) -> LineFeature {
    let (line, by_line) = feature.line.transformed(&rest.motion);
    let age = sweep.age_of(feature);
    let span = sweep.age(feature.first_beam as f64) - sweep.age(feature.last_beam as f64);
    let mut cov = by_line * feature.cov * by_line.transpose();
    if age > 0.0 && span > 0.0 {
        // Random walks from the middle beam to either end, half of the span each; a shift moves the line by less than
        // a quarter of what it adds up to.
        let part = span / age;
        let mut shift = rest.cov * (0.25 * part);
        shift.fill_row(2, 0.0);
        shift.fill_column(2, 0.0);
        let normal = line.normal();
        let by_pose = Matrix2x3::new(0.0, 0.0, -1.0, -normal.x, -normal.y, 0.0);
        cov += by_pose * shift * by_pose.transpose();
        for by_heading in feature.by_heading {
            let by_heading = by_line * by_heading;
            cov += by_heading * by_heading.transpose() * (0.5 * part * rest.cov[(2, 2)]);
        }
    }
    let mixed = 0.5 * (cov[(0, 1)] + cov[(1, 0)]);
    (cov[(0, 1)], cov[(1, 0)]) = (mixed, mixed);
    // The origin moves from one end of the sweep to the other; whether it changes sides shows in the sign of r.
    let same_way = line
        .normal()
        .dot(&rest.motion.rotate(feature.line.normal()))
        > 0.0;
    LineFeature {
        line,
        cov,
        ends: feature.ends.map(|end| rest.motion * end),
        seen_from_origin_side: feature.seen_from_origin_side == same_way,
        ..*feature
    }
}

/// The first `part` of a motion, and what follows it; the variance grows with the way.
fn split(odometry: &Odometry, part: f64) -> (Odometry, Odometry) {
    let first = odometry.motion.fraction(part);
    let seconds = odometry.to.since(odometry.from);
    let middle = Stamp::from_seconds(odometry.from.seconds() + part * seconds);
    (
        Odometry {
            to: middle,
            motion: first,
            cov: odometry.cov * part,
            ..*odometry
        },
        Odometry {
            from: middle,
            motion: first.inverse() * odometry.motion,
            cov: odometry.cov * (1.0 - part),
            ..*odometry
        },
    )
}

/// A pose moved by odometry, to first order.
fn moved_by(estimate: &PoseEstimate, odometry: &Odometry) -> PoseEstimate {
    let pose = estimate.pose * odometry.motion;
    let step = pose.position() - estimate.pose.position();
    let (cos, sin) = estimate.pose.cos_sin();
    let by_pose = Matrix3::new(1.0, 0.0, -step.y, 0.0, 1.0, step.x, 0.0, 0.0, 1.0);
    let by_motion = Matrix3::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0);
    let mut cov = by_pose * estimate.cov * by_pose.transpose()
        + by_motion * odometry.cov * by_motion.transpose();
    symmetrize(&mut cov);
    PoseEstimate { pose, cov }
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

//! In: odometry, and the lines of each scan, or its points, or both ([`LandmarkKinds`]). Out: the
//! robot's pose, the walls and the points, with one covariance over all of it.
//!
//! With lines, the state is (x, y, θ, κ, s, α₁, r₁, α₂, r₂, …) in the map frame, which starts at
//! the robot's first pose; κ and s are the systematic errors of the odometry (`robot_state`). Each
//! line is oriented: its normal points from the side it was seen from into the wall, and r is
//! signed (`association::gate`). r counts from an anchor, a fixed point in the middle of where the
//! wall was first seen. If it counted from the origin of the map, as in the paper, an error of α
//! would shift the wall by distance times error, to first order only: the remainder ½ · 10 m ·
//! (0.05 rad)² is 1 cm that no covariance accounts for, more than the uncertainty of the wall.
//! Points are two rows more, x and y in the map frame ([`point`]).
//!
//! 1. **Predict**: the pose moves by the odometry; only P_xx and P_xf change. O(n), TDK 2016 eq.
//!    (3.18)-(3.20).
//! 2. **In order of time**: a turning lidar sees each wall at a different instant, and tracks slip
//!    between two instants of one sweep by more than the walls are uncertain. So odometry is held
//!    back until the scan comes; each line is moved back to the robot frame of its own instant, and
//!    the filter predicts up to there, then updates. De-skewing the whole scan to its end by
//!    odometry and treating its lines as seen there would use the odometry's error twice but count
//!    it once.
//! 3. **Associate and update**: the landmarks that the line may be ([`choose`]); then Z from a 5x5
//!    block, gain O(n), and P -= (P Hᵀ) Z⁻¹ (P Hᵀ)ᵀ as one symmetric rank-2 update of the triangle,
//!    re-linearised for each match (TDK 2016 §3.2 says why).
//! 4. **Augment** with lines that are far from everything known: block rows by eq. (3.31), (3.32).
//! 5. **Merge** landmarks that are surely one wall: parts of it first seen far apart, or a wall
//!    seen again before a loop closed.
//! 6. **Forget** lines that were not seen again soon: their rows and columns are deleted, which
//!    leaves the marginal of a Gaussian.
//!
//! Consistency: an EKF whose Jacobians are taken at ever new estimates believes that it learns its
//! absolute heading, which nothing measures (Huang, Mourikis & Roumeliotis 2010,
//! "Observability-based rules for designing consistent EKF SLAM estimators").
//! [`Consistency::FirstEstimates`] takes them at the first ones. A robot that lost its heading by
//! 3° and then drives in circles past the same six walls never knows it to better than 3°. The
//! filter with first estimates says so (3.1°; NEES of the heading 0.89, 1 is honest); with the
//! newest ones it claims 1.4° (6.8). If the heading is known to tenths of a degree, as on tours
//! with a lidar, the two hardly differ. Measured by
//! `cargo run --release -p slamlab-core --example report -- ekf-consistency`.

mod config;
mod correlations;
mod input;
mod joint;
mod landmark;
mod merge;
mod point;
mod point_model;
mod report;
mod robot_state;
mod shared;
mod sighting;
mod sweep;
#[cfg(test)]
mod tests;

use nalgebra::{Matrix2, Matrix3, Matrix5, Point2};

pub(super) use self::input::check_feature;
use self::input::check_point;
use self::joint::JointScratch;
use self::landmark::Entry;
use self::point::{PointEntry, by_index, heading_variance, is_landmark};
use self::robot_state::{POSE, ROBOT};
use self::shared::SharedBeams;
use self::sweep::{Turn, Which, as_seen, order, point_as_seen};
use super::covariance::Covariance;
use super::triangle::SymmetricMatrix;
use crate::association::{AssociationMethod, Candidate, Choice, Paired, choose, choose_paired};
use crate::features::{LineFeature, PointFeature};
use crate::geom::{Pose2, PoseEstimate};
use crate::robot::Odometry;

pub use self::config::{Consistency, EkfConfig, LandmarkKinds, MergeConfig};
pub use self::correlations::Correlations;
pub use self::input::EkfError;
pub use self::landmark::{Landmark, LandmarkId};
pub use self::point::PointLandmark;
pub use self::report::{
    Considered, Decision, Explanation, Fix, Gate, Match, Merged, Rejection, UpdateReport,
};
pub use self::robot_state::{OdometryErrors, RobotState};
pub use self::sweep::SweepTiming;

/// The report keeps this many candidates of each line.
const REPORTED: usize = 8;
/// The report leaves out candidates that are farther away than the gate for new walls by this
/// factor; they explain nothing.
const REPORTED_GATES: f64 = 4.0;

/// EKF-SLAM over lines and points.
#[derive(Clone, Debug)]
pub struct EkfSlam {
    config: EkfConfig,
    pose: Pose2,
    errors: OdometryErrors,
    /// The position at which the Jacobians of this scan are evaluated.
    predicted: Point2<f64>,
    /// Odometry since the time of `pose`, held back for the next scan, and the estimate at its end.
    pending: Vec<Odometry>,
    ahead: RobotState,
    landmarks: Vec<Entry>,
    points: Vec<PointEntry>,
    cov: Covariance,
    next_id: u32,
    scans: u32,
    report: UpdateReport,
    // Buffers kept between updates.
    /// P Hᵀ L⁻ᵀ, two columns.
    gain: [Vec<f64>; 2],
    order: Vec<Turn>,
    shared: SharedBeams,
    candidates: Vec<Candidate>,
    joint: JointScratch,
}

impl EkfSlam {
    /// A filter at the origin of an empty map.
    ///
    /// # Errors   As [`EkfConfig::validate`].
    pub fn new(config: EkfConfig) -> Result<Self, EkfError> {
        config.validate()?;
        let ahead = RobotState::new(&config.odometry_prior);
        Ok(Self {
            config,
            pose: ahead.pose,
            errors: ahead.errors,
            predicted: Point2::origin(),
            pending: vec![],
            ahead,
            landmarks: vec![],
            points: vec![],
            cov: Covariance::new(&ahead.cov),
            next_id: 0,
            scans: 0,
            report: UpdateReport::default(),
            gain: Default::default(),
            order: vec![],
            shared: SharedBeams::default(),
            candidates: vec![],
            joint: JointScratch::default(),
        })
    }

    /// Sets other settings from the next scan on; the prior of the odometry errors is in the state
    /// already.
    pub fn reconfigure(&mut self, config: EkfConfig) {
        self.config = config;
    }

    /// The pose in the map frame, at the end of the last odometry.
    #[must_use]
    pub fn estimate(&self) -> PoseEstimate {
        self.ahead.estimate()
    }

    /// The systematic errors of the odometry, as known now.
    #[must_use]
    pub fn odometry_errors(&self) -> OdometryErrors {
        self.errors
    }

    /// Standard deviations of [`Self::odometry_errors`].
    #[must_use]
    pub fn odometry_error_sigmas(&self) -> OdometryErrors {
        let sigma = |row: usize| self.cov.get(row, row).max(0.0).sqrt();
        OdometryErrors {
            curvature: sigma(POSE),
            turn_scale: sigma(POSE + 1),
        }
    }

    /// All walls in the order of the state, including those not yet confirmed.
    pub fn landmarks(&self) -> impl Iterator<Item = Landmark> + '_ {
        self.landmarks.iter().map(|entry| {
            let (line, cov) = entry.in_map(&self.block(entry.row));
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

    /// The covariance of the whole state (x, y, θ, κ, s, α₁, r₁, …) at the last scan, walls and
    /// points in the order of their names, r signed and counted from each wall's anchor.
    #[must_use]
    pub fn covariance(&self) -> &SymmetricMatrix {
        self.cov.settled()
    }

    /// What the last scan did, and why.
    #[must_use]
    pub fn report(&self) -> &UpdateReport {
        &self.report
    }

    /// Takes in a motion; [`Self::estimate`] is updated at once, the filter when the next scan
    /// comes.
    ///
    /// # Errors   [`EkfError::Odometry`]; the filter is then unchanged.
    pub fn predict(&mut self, odometry: &Odometry) -> Result<(), EkfError> {
        odometry.validate()?;
        self.pending.push(*odometry);
        self.ahead = self.ahead.moved_by(odometry);
        Ok(())
    }

    /// Steps 1 to 6: takes in the lines of one scan, in the robot frame at `sweep.stamp`.
    ///
    /// # Errors   [`EkfError::Feature`] for the first line whose numbers cannot be used; the filter
    /// is then unchanged.
    pub fn update(
        &mut self,
        features: &[LineFeature],
        sweep: &SweepTiming,
    ) -> Result<&UpdateReport, EkfError> {
        self.update_with_points(features, &[], sweep)
    }

    /// The same with the points of the scan in addition to its lines. A setting selects which of
    /// the two are taken in ([`EkfConfig::landmarks`]); of the points, corners and circles.
    ///
    /// # Errors   [`EkfError::Feature`], [`EkfError::Point`] for the first line or point whose
    /// numbers cannot be used; the filter is then unchanged.
    pub fn update_with_points(
        &mut self,
        lines: &[LineFeature],
        points: &[PointFeature],
        sweep: &SweepTiming,
    ) -> Result<&UpdateReport, EkfError> {
        for (index, feature) in lines.iter().enumerate() {
            check_feature(index, feature)?;
        }
        for (index, point) in points.iter().enumerate() {
            check_point(index, point)?;
        }
        let kinds = self.config.landmarks;
        let lines = if kinds.has_lines() { lines } else { &[] };
        let points = if kinds.has_points() { points } else { &[] };
        self.scans += 1;
        self.report.clear();
        let end = sweep.stamp.seconds();
        let moved = self.motion_until(end).motion != Pose2::identity();
        order(lines, points, sweep, &mut self.order);
        self.shared.find(lines, points);
        self.joint.paired.clear();
        if self.config.association.method == AssociationMethod::Joint
            && let Some(first) = self.order.first()
        {
            self.advance_to(end - sweep.age_of(first.beams));
            let mut joint = std::mem::take(&mut self.joint);
            self.pair_jointly(lines, points, sweep, &mut joint);
            self.joint = joint;
        }
        for at in 0..self.order.len() {
            let turn = self.order[at];
            let is_on_seam = moved && sweep.seconds > 0.0 && turn.beams[0] > turn.beams[1];
            let seconds = end - sweep.age_of(turn.beams);
            match turn.which {
                Which::Line(index) if is_on_seam => {
                    self.conclude(index, Decision::Rejected(Rejection::Seam));
                }
                Which::Point(index) if is_on_seam => {
                    self.conclude_point(index, Decision::Rejected(Rejection::Seam));
                }
                Which::Line(index) => self.meet_line(index, &lines[index], seconds, sweep),
                Which::Point(index) => {
                    let paired = self.joint.paired.get(lines.len() + index).copied();
                    self.meet_point(index, &points[index], paired, seconds, sweep);
                }
            }
        }
        self.advance_to(end);
        self.merge_all();
        self.merge_points();
        self.forget();
        self.cov.settle();
        self.ahead = RobotState {
            pose: self.pose,
            errors: self.errors,
            cov: self.robot_cov(),
        };
        for odometry in &self.pending {
            self.ahead = self.ahead.moved_by(odometry);
        }
        Ok(&self.report)
    }

    /// Steps 2 to 4 for a line that was seen at `seconds`.
    fn meet_line(&mut self, index: usize, line: &LineFeature, seconds: f64, sweep: &SweepTiming) {
        self.advance_to(seconds);
        let rest = self.motion_until(sweep.stamp.seconds());
        let mut line = as_seen(line, &rest, sweep);
        if self.shared.has_line(index) {
            line.cov /= 1.0 - self.config.shared_part;
        }
        let before = self.pose;
        if let Decision::Matched(_) = self.take_in(index, &line) {
            let own = line.cov[(0, 0)] + self.config.alpha_sigma * self.config.alpha_sigma;
            self.fix(seconds, before, own);
        }
    }

    /// Steps 2 to 4 for a point that was seen at `seconds`.
    fn meet_point(
        &mut self,
        index: usize,
        point: &PointFeature,
        paired: Option<Paired>,
        seconds: f64,
        sweep: &SweepTiming,
    ) {
        if !is_landmark(&point.kind) {
            return;
        }
        let (shared, part) = (self.shared.point(index), self.config.shared_part);
        if shared.is_on_line && part <= 0.0 {
            self.conclude_point(index, Decision::Rejected(Rejection::OnAWall));
            return;
        }
        self.advance_to(seconds);
        let rest = self.motion_until(sweep.stamp.seconds());
        let mut point = point_as_seen(point, &rest, sweep);
        point.cov *= 1.0 + shared.others as f64;
        if shared.is_on_line {
            point.cov /= part;
        }
        let before = self.pose;
        if let Decision::Matched(_) = self.take_in_point(index, &point, paired)
            && let Some(own) = heading_variance(&self.point_cov(&point), point.position)
        {
            self.fix(seconds, before, own);
        }
    }

    fn fix(&mut self, seconds: f64, before: Pose2, heading_variance: f64) {
        self.report.fixes.push(Fix {
            seconds,
            before,
            after: self.pose,
            heading_variance,
        });
    }

    /// Steps 3 and 4 for line number `index`, in the robot frame of the state.
    fn take_in(&mut self, index: usize, seen: &LineFeature) -> Decision {
        self.candidates.clear();
        for landmark in 0..self.landmarks.len() {
            if let Some((candidate, considered)) = self.compare(landmark, seen) {
                self.candidates.push(candidate);
                self.report.of_lines.considered.push(considered);
            }
        }
        let (candidates, config) = (&self.candidates, &self.config.association);
        let choice = match self.joint.paired.get(index) {
            Some(paired) => {
                let place = |row| self.landmarks.iter().position(|entry| entry.row == row);
                choose_paired(candidates, by_index(*paired, place), config)
            }
            None => choose(candidates, config),
        };
        let decision = match choice {
            Choice::Match(found) => self.recognise(index, &found, seen),
            Choice::Ambiguous => Decision::Rejected(Rejection::Ambiguous),
            Choice::NearMiss => Decision::Rejected(Rejection::OutsideGate),
            Choice::New => {
                let id = self.augment(seen);
                self.report.added.push((index, id));
                Decision::Added(id)
            }
        };
        self.conclude(index, decision);
        decision
    }

    /// Step 3 for a line whose landmark has been found.
    fn recognise(&mut self, feature: usize, found: &Candidate, seen: &LineFeature) -> Decision {
        if self.is_taken(found.index, seen) {
            return Decision::Rejected(Rejection::Taken);
        }
        if !self.correct(found.index, seen) {
            return Decision::Rejected(Rejection::Singular);
        }
        let landmark = self.landmarks[found.index].id;
        self.report.nis += found.d2;
        self.report.matches.push(Match {
            feature,
            landmark,
            d2: found.d2,
        });
        Decision::Matched(landmark)
    }

    fn conclude(&mut self, feature: usize, decision: Decision) {
        let far = self.reported_far();
        let explained = &mut self.report.of_lines;
        explained.conclude(feature, decision, REPORTED, far);
    }

    fn reported_far(&self) -> f64 {
        REPORTED_GATES * self.config.association.new_gate
    }

    /// The robot position at which Jacobians are evaluated.
    fn linearised_at(&self) -> Point2<f64> {
        match self.config.consistency {
            Consistency::Plain => self.pose.position(),
            Consistency::FirstEstimates => self.predicted,
        }
    }

    /// The direction of a landmark at which Jacobians are evaluated.
    fn linearised_alpha(&self, landmark: &Entry) -> f64 {
        match self.config.consistency {
            Consistency::Plain => landmark.line[0],
            Consistency::FirstEstimates => landmark.first_alpha,
        }
    }

    fn pose_cov(&self) -> Matrix3<f64> {
        Matrix3::from_fn(|row, column| self.cov.get(row, column))
    }

    fn robot_cov(&self) -> Matrix5<f64> {
        Matrix5::from_fn(|row, column| self.cov.get(row, column))
    }

    fn block(&self, first: usize) -> Matrix2<f64> {
        Matrix2::from_fn(|row, column| self.cov.get(first + row, first + column))
    }
}

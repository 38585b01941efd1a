//! In: odometry, the lines of each scan, and a prior map of lines. Out: the robot's pose in that
//! map, with covariance.
//!
//! 1. **Predict**: pose and covariance move by the odometry, whose systematic errors are states
//!    like the pose (`ekf_slam::robot_state`; TDK 2016 eq. (3.1)-(3.4)).
//! 2. **Associate**: each line against the map, as the SLAM filter does it (`association`).
//! 3. **Update**: one match at a time, re-linearised after each (TDK 2016 §3.2).
//!
//! The map is taken as exact, and all lines of a scan as seen at the instant of the last odometry.
//! For a scan that takes its time while the robot moves, straighten it first (`points`).

use nalgebra::{Matrix2x3, Matrix2x5, Point2, SMatrix};

use super::ekf_slam::{EkfError, OdometryErrors, RobotState, check_feature};
use super::line_model::{Linearisation, observe};
use crate::association::{
    AssociationConfig, Candidate, Choice, ExpectedLine, Innovation, OrientedLine, choose,
};
use crate::features::LineFeature;
use crate::geom::{Pose2, PoseEstimate, Segment, symmetrize};
use crate::robot::Odometry;

/// The ends of a wall are as wide as so many standard deviations of the robot's position, as
/// [`super::EkfConfig::along_sigmas`] of the SLAM filter.
const ALONG_SIGMAS: f64 = 3.0;

/// One face of a wall of the prior map, map frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PriorLine {
    /// Direction of the normal from the free side into the wall, rad.
    pub alpha: f64,
    /// Signed distance of the line from the origin along that normal, m.
    pub r: f64,
    /// Where the face begins and ends.
    pub ends: [Point2<f64>; 2],
}

impl PriorLine {
    /// The face of `segment` that faces the left of the way from `a` to `b`; `None` for one
    /// without length.
    #[must_use]
    pub fn left_face(segment: &Segment) -> Option<Self> {
        let along = segment.vector();
        if !(along.norm() > 0.0 && along.norm().is_finite()) {
            return None;
        }
        // Into the wall is to the right of the way.
        let alpha = libm::atan2(-along.x, along.y);
        let normal = nalgebra::Vector2::new(along.y, -along.x) / along.norm();
        Some(Self {
            alpha,
            r: normal.dot(&segment.a.coords),
            ends: [segment.a, segment.b],
        })
    }

    /// Both faces of all walls, moved into the map.
    #[must_use]
    pub fn of_walls(walls: &[Segment], map_from_world: &Pose2) -> Vec<Self> {
        let moved = |w: &Segment| Segment::new(*map_from_world * w.a, *map_from_world * w.b);
        walls
            .iter()
            .flat_map(|wall| Self::both_faces(&moved(wall)))
            .collect()
    }

    /// Both faces of a thin wall.
    #[must_use]
    pub fn both_faces(segment: &Segment) -> Vec<Self> {
        let back = Segment::new(segment.b, segment.a);
        [segment, &back]
            .into_iter()
            .filter_map(Self::left_face)
            .collect()
    }
}

/// Finds a robot in a prior map of lines.
#[derive(Clone, Debug)]
pub struct LineLocaliser {
    map: Vec<PriorLine>,
    association: AssociationConfig,
    state: RobotState,
}

impl LineLocaliser {
    /// A robot that is at `start`, map frame, with odometry as good as `prior` says (standard
    /// deviations; 0 for one without systematic errors).
    ///
    /// # Errors   [`EkfError`], or [`EkfError::Bounds`] where start or prior are no
    /// numbers.
    pub fn new(
        map: Vec<PriorLine>,
        start: &PoseEstimate,
        prior: &OdometryErrors,
        association: AssociationConfig,
    ) -> Result<Self, EkfError> {
        association.validate()?;
        Ok(Self {
            map,
            association,
            state: RobotState::starting(start, prior)?,
        })
    }

    /// The pose in the map.
    #[must_use]
    pub fn estimate(&self) -> PoseEstimate {
        self.state.estimate()
    }

    /// Step 1.
    ///
    /// # Errors   [`EkfError::Odometry`]; then nothing has changed.
    pub fn predict(&mut self, odometry: &Odometry) -> Result<(), EkfError> {
        self.state.predict(odometry)
    }

    /// Steps 2 and 3: takes in the lines of one scan, robot frame; returns those that were found in
    /// the map, each with the index of its line there.
    ///
    /// # Errors   [`EkfError::Feature`] for the first line whose numbers cannot be used; then
    /// nothing has changed.
    pub fn update(&mut self, features: &[LineFeature]) -> Result<Vec<(usize, usize)>, EkfError> {
        for (index, feature) in features.iter().enumerate() {
            check_feature(index, feature)?;
        }
        let mut matches = vec![];
        for (feature, seen) in features.iter().enumerate() {
            let candidates: Vec<Candidate> = (0..self.map.len())
                .filter_map(|line| self.candidate(line, seen))
                .collect();
            if let Choice::Match(found) = choose(&candidates, &self.association)
                && self.correct(found.index, seen)
            {
                matches.push((feature, found.index));
            }
        }
        Ok(matches)
    }

    fn candidate(&self, index: usize, seen: &LineFeature) -> Option<Candidate> {
        let (expected, _) = self.expect(self.map.get(index)?);
        let innovation = expected.innovation(&OrientedLine::of(seen))?;
        let along = self.state.cov[(0, 0)].max(self.state.cov[(1, 1)]).sqrt();
        let gap = expected.gap(seen) - ALONG_SIGMAS * along;
        Some(Candidate {
            index,
            d2: innovation.d2,
            gap,
            is_beyond: gap > self.association.max_gap,
            is_confirmed: true,
            expected: [expected.alpha, expected.r],
        })
    }

    /// Eq. (3.5) and (3.6) of the source: ẑ and H_x.
    fn expect(&self, known: &PriorLine) -> (ExpectedLine, Matrix2x3<f64>) {
        let pose = &self.state.pose;
        let at = Linearisation {
            robot: pose.position(),
            alpha: known.alpha,
        };
        let (z, by_pose, _) = observe(pose, [known.alpha, known.r], &at);
        let robot_from_map: Pose2 = pose.inverse();
        let expected = ExpectedLine {
            alpha: z.x,
            r: z.y,
            cov: by_pose * self.state.estimate().cov * by_pose.transpose(),
            ends: known.ends.map(|end| robot_from_map * end),
        };
        (expected, by_pose)
    }

    /// Step 3, in Joseph's form. `false`, and nothing done, where Z is not positive definite.
    fn correct(&mut self, index: usize, seen: &LineFeature) -> bool {
        let Some(known) = self.map.get(index) else {
            return false;
        };
        let (expected, by_pose) = self.expect(known);
        let seen = OrientedLine::of(seen);
        let Some(Innovation { v, cov: z, .. }) = expected.innovation(&seen) else {
            return false;
        };
        let Some(z) = z.cholesky() else {
            return false;
        };
        let mut h = Matrix2x5::zeros();
        h.fixed_view_mut::<2, 3>(0, 0).copy_from(&by_pose);
        let cov = self.state.cov;
        let gain = z.solve(&(h * cov)).transpose();
        let shift = gain * v;
        let rest = SMatrix::<f64, 5, 5>::identity() - gain * h;
        self.state.cov = rest * cov * rest.transpose() + gain * seen.cov * gain.transpose();
        symmetrize(&mut self.state.cov);
        let pose = &self.state.pose;
        self.state.pose = Pose2::new(
            pose.x() + shift[0],
            pose.y() + shift[1],
            pose.heading() + shift[2],
        );
        self.state.errors.curvature += shift[3];
        self.state.errors.turn_scale += shift[4];
        true
    }
}

#[cfg(test)]
mod tests;

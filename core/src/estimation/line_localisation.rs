//! In: the state that odometry predicts, the lines of each scan, and a prior map of lines. Out: the
//! state corrected by that map.
//!
//! 1. **Predict**: pose and covariance move by the odometry, whose systematic errors are states
//!    like the pose ([`RobotState::predict`]; TDK 2016 eq. (3.1)-(3.4)).
//! 2. **Associate**: each line against the map, as the SLAM filter does it (`association`).
//! 3. **Update**: one match at a time, re-linearised after each (TDK 2016 §3.2).
//!
//! The map is treated as exact, and all lines of a scan as seen at the instant of the last
//! odometry. If a scan takes time while the robot moves, de-skew it first (`points`).

use nalgebra::{Matrix2x3, Matrix2x5, Point2, SMatrix};

use super::ekf_slam::{EkfError, RobotState, check_feature};
use super::line_model::{Linearisation, observe};
use crate::association::{
    AssociationConfig, Candidate, Choice, ExpectedLine, Innovation, OrientedLine, choose, gap,
};
use crate::features::LineFeature;
use crate::geom::{Length, Segment, symmetrize};

/// The ends of a wall are uncertain by this many standard deviations of the robot's position, as in
/// [`super::EkfConfig::along_sigmas`] of the SLAM filter.
const ALONG_SIGMAS: f64 = 3.0;

/// One face of a wall of the prior map, map frame.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Face {
    /// Direction of the normal from the free side into the wall, rad.
    alpha: f64,
    /// Signed distance of the line from the origin along that normal, m.
    r: f64,
    ends: [Point2<f64>; 2],
}

impl Face {
    /// The face of `segment` that is visible from the left of the direction from `a` to `b`; `None`
    /// if its length is zero.
    fn left_of(segment: &Segment) -> Option<Self> {
        let along = segment.vector();
        if !(along.length() > 0.0 && along.length().is_finite()) {
            return None;
        }
        // The wall's interior is to the right of that direction.
        let normal = nalgebra::Vector2::new(along.y, -along.x) / along.length();
        Some(Self {
            alpha: libm::atan2(-along.x, along.y),
            r: normal.dot(&segment.a.coords),
            ends: [segment.a, segment.b],
        })
    }
}

/// Localises a robot in a prior map of lines.
#[derive(Clone, Debug)]
pub struct LineLocaliser {
    map: Vec<Face>,
    association: AssociationConfig,
}

impl LineLocaliser {
    /// In a map whose `faces` have free space to the left of the direction from `a` to `b`; those
    /// of zero length are left out.
    ///
    /// # Errors   [`EkfError::Bounds`] if a figure is out of range.
    pub fn new(faces: &[Segment], association: AssociationConfig) -> Result<Self, EkfError> {
        association.validate()?;
        Ok(Self {
            map: faces.iter().filter_map(Face::left_of).collect(),
            association,
        })
    }

    /// Steps 2 and 3: corrects `state` by the lines of one scan, robot frame; returns those that
    /// were found in the map, each with the index of its line there.
    ///
    /// # Errors   [`EkfError::Feature`] for the first line whose numbers cannot be used; the state
    /// is then unchanged.
    pub fn update(
        &self,
        state: &mut RobotState,
        features: &[LineFeature],
    ) -> Result<Vec<(usize, usize)>, EkfError> {
        for (index, feature) in features.iter().enumerate() {
            check_feature(index, feature)?;
        }
        let mut matches = vec![];
        for (feature, seen) in features.iter().enumerate() {
            let candidates: Vec<Candidate> = (self.map.iter().enumerate())
                .filter_map(|(index, known)| self.candidate(state, index, known, seen))
                .collect();
            if let Choice::Match(found) = choose(&candidates, &self.association)
                && correct(state, &self.map[found.index], seen)
            {
                matches.push((feature, found.index));
            }
        }
        Ok(matches)
    }

    fn candidate(
        &self,
        state: &RobotState,
        index: usize,
        known: &Face,
        seen: &LineFeature,
    ) -> Option<Candidate> {
        let (expected, _) = expect(state, known);
        let innovation = expected.innovation(&OrientedLine::of(seen))?;
        let along = state.cov[(0, 0)].max(state.cov[(1, 1)]).sqrt();
        let gap = gap(expected.ends, seen) - ALONG_SIGMAS * along;
        Some(Candidate {
            index,
            d2: innovation.d2,
            gap,
            is_beyond: gap > self.association.max_gap,
            is_confirmed: true,
            expected: [expected.alpha, expected.r],
        })
    }
}

/// Eq. (3.5) and (3.6) of the source: ẑ and H_x.
fn expect(state: &RobotState, known: &Face) -> (ExpectedLine, Matrix2x3<f64>) {
    let pose = &state.pose;
    let at = Linearisation {
        robot: pose.position(),
        alpha: known.alpha,
    };
    let (z, by_pose, _) = observe(pose, [known.alpha, known.r], &at);
    let robot_from_map = pose.inverse();
    let expected = ExpectedLine {
        alpha: z.x,
        r: z.y,
        cov: by_pose * state.estimate().cov * by_pose.transpose(),
        ends: known.ends.map(|end| robot_from_map * end),
    };
    (expected, by_pose)
}

/// Step 3, in Joseph's form. Returns `false` and changes nothing if Z is not positive definite.
fn correct(state: &mut RobotState, known: &Face, seen: &LineFeature) -> bool {
    let (expected, by_pose) = expect(state, known);
    let seen = OrientedLine::of(seen);
    let Some(Innovation { v, cov: z, .. }) = expected.innovation(&seen) else {
        return false;
    };
    let Some(z) = z.cholesky() else {
        return false;
    };
    let mut h = Matrix2x5::zeros();
    h.fixed_view_mut::<2, 3>(0, 0).copy_from(&by_pose);
    let gain = z.solve(&(h * state.cov)).transpose();
    let shift = gain * v;
    let rest = SMatrix::<f64, 5, 5>::identity() - gain * h;
    state.cov = rest * state.cov * rest.transpose() + gain * seen.cov * gain.transpose();
    symmetrize(&mut state.cov);
    state.pose = state.pose.plus(&shift.fixed_rows::<3>(0).into_owned());
    state.errors.curvature += shift[3];
    state.errors.turn_scale += shift[4];
    true
}

#[cfg(test)]
mod tests;

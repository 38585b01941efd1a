//! In: an odometry reading, and what is known of the systematic errors of this robot's odometry.
//! Out: the motion without these errors, with its Jacobians.
//!
//! A worn track, a soft tyre, a floor on which the tracks turn wider than on another: such errors
//! are the same from one metre to the next, unlike white noise. A filter that knows only white
//! noise believes after a lap that they have averaged out, but they have added up. So they are
//! states, constant and with a prior (Larsen et al. 1998; Martinelli et al. 2007, "Simultaneous
//! localization and odometry self calibration"): the walls calibrate the odometry.
//!
//! 1. The two that matter (Borenstein & Feng 1996): unequal tracks bend a straight drive by κ,
//!    rad/m; a wrong track width stretches each turn by s. A robot whose reading says Δs and Δθ has
//!    in truth turned Δθ + δ with δ = κ Δs + s Δθ.
//! 2. On an arc the chord turns by half as much as the heading (TDK 2016 eq. (2.6)), so the step t
//!    becomes R(δ/2) t.
//!
//! Both need only the reading itself, not the tracks' distances: a recorded log is enough.

use nalgebra::{Matrix3, Matrix5, Point2, SMatrix};

use super::EkfError;
use crate::bounds::{FINITE, check};
use crate::geom::{Pose2, PoseEstimate, symmetrize};
use crate::robot::Odometry;

/// States of the pose.
pub(super) const POSE: usize = 3;
/// States of the robot: (x, y, θ, κ, s). Index of the first landmark's α.
pub(super) const ROBOT: usize = 5;

/// Systematic errors of the odometry, as the filter sees them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OdometryErrors {
    /// κ: turn per metre of a drive that the odometry reports as straight, rad/m, positive to the
    /// left.
    pub curvature: f64,
    /// s: the fraction by which a turn is larger than the odometry reports.
    pub turn_scale: f64,
}

/// Pose and systematic errors with their covariance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RobotState {
    /// The pose in the map.
    pub pose: Pose2,
    /// What is known of the odometry's errors.
    pub errors: OdometryErrors,
    /// Covariance of (x, y, θ, κ, s).
    pub cov: Matrix5<f64>,
}

/// One step of the robot.
pub(super) struct Step {
    /// The pose after it.
    pub(super) pose: Pose2,
    /// The rows of F for the pose.
    pub(super) by_robot: SMatrix<f64, POSE, ROBOT>,
    /// Variance that the step adds to the pose.
    pub(super) added: Matrix3<f64>,
}

impl Step {
    /// Moves `pose` by `odometry`, Jacobians taken with the robot at `from`.
    ///
    /// # Source   TDK 2016 eq. (3.1)-(3.4); the columns of κ and s as the module says.
    pub(super) fn new(
        pose: &Pose2,
        errors: &OdometryErrors,
        odometry: &Odometry,
        from: Point2<f64>,
    ) -> Self {
        let read = &odometry.motion;
        let turn = read.heading();
        let half = Pose2::new(0.0, 0.0, 0.5 * turn);
        let (cos, sin) = half.cos_sin();
        let way = cos * read.x() + sin * read.y();
        let error = errors.curvature * way + errors.turn_scale * turn;
        let shift = Pose2::new(0.0, 0.0, 0.5 * error).rotate(read.position().coords);
        let motion = Pose2::new(shift.x, shift.y, turn + error);
        let moved = *pose * motion;
        let by_motion = pose.rotation();
        // The effect of δ: the step rotates by half of it.
        let chord = pose.rotate(shift);
        let (sideways_x, sideways_y) = (-0.5 * chord.y, 0.5 * chord.x);
        let step = moved.position() - from;
        #[rustfmt::skip]
        let by_robot = SMatrix::<f64, POSE, ROBOT>::new(
            1.0, 0.0, -step.y, sideways_x * way, sideways_x * turn,
            0.0, 1.0,  step.x, sideways_y * way, sideways_y * turn,
            0.0, 0.0,     1.0,              way,              turn,
        );
        Self {
            pose: moved,
            by_robot,
            added: by_motion * odometry.cov * by_motion.transpose(),
        }
    }

    /// F P Fᵀ + Q for the robot's own block.
    pub(super) fn covariance(&self, cov: &Matrix5<f64>) -> Matrix5<f64> {
        let mut f = Matrix5::identity();
        f.fixed_view_mut::<POSE, ROBOT>(0, 0)
            .copy_from(&self.by_robot);
        let mut moved = f * cov * f.transpose();
        let mut pose = moved.fixed_view_mut::<POSE, POSE>(0, 0);
        pose += self.added;
        symmetrize(&mut moved);
        moved
    }
}

impl RobotState {
    /// At the origin, which is exact, with the prior knowledge of the odometry as standard
    /// deviations.
    pub(in crate::estimation) fn new(prior: &OdometryErrors) -> Self {
        let mut cov = Matrix5::zeros();
        cov[(3, 3)] = prior.curvature * prior.curvature;
        cov[(4, 4)] = prior.turn_scale * prior.turn_scale;
        Self {
            pose: Pose2::identity(),
            errors: OdometryErrors::default(),
            cov,
        }
    }

    /// At `start`, map frame, with the odometry errors given by `prior` (standard deviations; 0 for
    /// odometry without systematic errors).
    ///
    /// # Errors   [`EkfError::Bounds`] where start or prior are no numbers.
    pub fn starting(start: &PoseEstimate, prior: &OdometryErrors) -> Result<Self, EkfError> {
        let at = &start.pose;
        check(&[
            ("start.pose", at.x() + at.y() + at.heading(), FINITE),
            ("start.cov", start.cov.sum(), FINITE),
            ("prior.curvature", prior.curvature, FINITE),
            ("prior.turn_scale", prior.turn_scale, FINITE),
        ])?;
        let mut state = Self::new(prior);
        state.pose = start.pose;
        let mut pose = state.cov.fixed_view_mut::<POSE, POSE>(0, 0);
        pose.copy_from(&start.cov);
        Ok(state)
    }

    /// Moves by odometry.
    ///
    /// # Errors   [`EkfError::Odometry`]; then nothing has changed.
    pub fn predict(&mut self, odometry: &Odometry) -> Result<(), EkfError> {
        odometry.validate()?;
        *self = self.moved_by(odometry);
        Ok(())
    }

    /// The state moved by odometry, to first order.
    pub(in crate::estimation) fn moved_by(&self, odometry: &Odometry) -> Self {
        let step = Step::new(&self.pose, &self.errors, odometry, self.pose.position());
        Self {
            pose: step.pose,
            errors: self.errors,
            cov: step.covariance(&self.cov),
        }
    }

    /// The pose with its covariance.
    #[must_use]
    pub fn estimate(&self) -> PoseEstimate {
        PoseEstimate {
            pose: self.pose,
            cov: self.cov.fixed_view::<POSE, POSE>(0, 0).into_owned(),
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::geom::Length;
    use crate::geom::wrap;
    use crate::robot::{Stamp, Tracks};

    fn reading(motion: Pose2) -> Odometry {
        Odometry {
            from: Stamp(0),
            to: Stamp(10_000),
            motion,
            cov: Matrix3::zeros(),
        }
    }

    #[test]
    fn worn_tracks_are_these_two_errors() {
        // Tracks that run 1 % short and long, and turn as if they were 4 % further apart; read
        // every centimetre.
        let (b, mismatch, wider) = (0.2, 0.02, 0.04);
        let errors = OdometryErrors {
            curvature: mismatch / (b * (1.0 + wider)),
            turn_scale: 1.0 / (1.0 + wider) - 1.0,
        };
        let (mut truth, mut corrected) = (Pose2::identity(), Pose2::identity());
        for i in 0..600 {
            let bend = 0.004 * f64::from(i % 3 - 1) + 0.001;
            let read = Tracks {
                left: 0.01 - bend,
                right: 0.01 + bend,
            };
            let ran = Tracks {
                left: read.left * (1.0 - 0.5 * mismatch),
                right: read.right * (1.0 + 0.5 * mismatch),
            };
            truth = truth * ran.motion(b * (1.0 + wider));
            let step = reading(read.motion(b));
            corrected = Step::new(&corrected, &errors, &step, Point2::origin()).pose;
        }
        let way_off = (truth.position() - corrected.position()).length();
        // Of 6 m and several turns; the remainder is that unequal tracks also go slightly further
        // in a turn.
        assert!(way_off < 3e-3, "{way_off}");
        assert!(wrap(truth.heading() - corrected.heading()).abs() < 1e-9);
    }

    proptest! {
        #[test]
        fn jacobian_matches_central_differences(
            state in prop::array::uniform5(-1.5..1.5_f64), motion in prop::array::uniform3(-1.0..1.0_f64),
        ) {
            let odometry = reading(Pose2::new(motion[0], motion[1], motion[2]));
            let after = |s: [f64; 5]| {
                let pose = Pose2::new(s[0], s[1], s[2]);
                let errors = OdometryErrors { curvature: s[3], turn_scale: s[4] };
                Step::new(&pose, &errors, &odometry, pose.position())
            };
            let h = 1e-6;
            for axis in 0..ROBOT {
                let nudged = |h: f64| { let mut s = state; s[axis] += h; after(s).pose };
                let (plus, minus) = (nudged(h), nudged(-h));
                let numeric = [
                    (plus.x() - minus.x()) / (2.0 * h),
                    (plus.y() - minus.y()) / (2.0 * h),
                    wrap(plus.heading() - minus.heading()) / (2.0 * h),
                ];
                for (row, n) in numeric.iter().enumerate() {
                    prop_assert!((n - after(state).by_robot[(row, axis)]).abs() < 1e-6);
                }
            }
        }
    }
}

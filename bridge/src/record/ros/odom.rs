//! The odometry, added up: where it alone puts the robot, and how fast the robot goes.

use nalgebra::Matrix3;
use slamlab_core::robot::{Odometry, Stamp};

/// Adds up the odometry.
#[derive(Debug)]
pub(crate) struct Odom {
    summed: Odometry,
}

/// What the odometry says after a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Moved {
    /// From the beginning until now, with the covariance that has added up.
    pub(crate) summed: Odometry,
    /// Forward, to the left (m/s) and turning (rad/s), over the last step; 0 of a step that took no
    /// time.
    pub(crate) speeds: [f64; 3],
    pub(crate) speeds_cov: Matrix3<f64>,
}

impl Default for Odom {
    fn default() -> Self {
        Self {
            summed: Odometry::standing(Stamp(0)),
        }
    }
}

impl Odom {
    pub(crate) fn moved(&mut self, step: &Odometry) -> Moved {
        self.summed = self.summed.then(step);
        let seconds = step.to.since(step.from);
        let rate = if seconds > 0.0 { 1.0 / seconds } else { 0.0 };
        let motion = &step.motion;
        Moved {
            summed: self.summed,
            speeds: [motion.x(), motion.y(), motion.heading()].map(|way| way * rate),
            speeds_cov: step.cov * (rate * rate),
        }
    }
}

#[cfg(test)]
mod tests {
    use slamlab_core::geom::Pose2;

    use super::*;

    #[test]
    fn steps_add_up_and_the_speed_is_that_of_the_last() {
        let step = |from, to, motion| Odometry {
            from: Stamp(from),
            to: Stamp(to),
            motion,
            cov: Matrix3::identity(),
        };
        let mut odom = Odom::default();
        let turned = Pose2::new(1.0, 0.0, std::f64::consts::FRAC_PI_2);
        let _ = odom.moved(&step(0, 1_000_000, turned));
        let moved = odom.moved(&step(1_000_000, 1_500_000, Pose2::new(0.5, 0.0, 0.0)));
        let at = moved.summed.motion;
        assert!((at.x() - 1.0).abs() < 1e-12 && (at.y() - 0.5).abs() < 1e-12);
        assert_eq!(moved.speeds, [1.0, 0.0, 0.0]);
        assert_eq!(moved.speeds_cov, 4.0 * Matrix3::identity());
        let still = odom.moved(&step(1_500_000, 1_500_000, Pose2::identity()));
        assert_eq!(still.speeds, [0.0; 3]);
    }
}

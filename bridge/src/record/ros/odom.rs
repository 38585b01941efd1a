//! The accumulated odometry: the pose by odometry alone, and the robot's speed.

use nalgebra::Matrix3;
use slamlab_core::geom::{Pose2, PoseEstimate};
use slamlab_core::robot::{Odometry, Stamp};
use slamlab_core::wire::CarriedPose;
use slamlab_core::wire::message::PoseBody;

/// Accumulates the odometry, and places it in the bridge's map if the bridge maps.
#[derive(Debug)]
pub(crate) struct Odom {
    summed: Odometry,
    carried: CarriedPose,
    /// A pose was received from the mapper, and not taken yet.
    is_told: bool,
}

/// The odometry after a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Moved {
    /// From the beginning until now, with the accumulated covariance.
    pub(crate) summed: Odometry,
    /// Speed forward, to the left (m/s) and turning (rad/s), over the last step; 0 if the step took
    /// no time.
    pub(crate) speeds: [f64; 3],
    pub(crate) speeds_cov: Matrix3<f64>,
}

impl Default for Odom {
    fn default() -> Self {
        Self {
            summed: Odometry::standing(Stamp(0)),
            carried: CarriedPose::default(),
            is_told: false,
        }
    }
}

impl Odom {
    pub(crate) fn moved(&mut self, step: &Odometry) -> Moved {
        self.summed = self.summed.then(step);
        self.carried.odometry(step);
        let seconds = step.to.since(step.from);
        let rate = if seconds > 0.0 { 1.0 / seconds } else { 0.0 };
        let motion = &step.motion;
        Moved {
            summed: self.summed,
            speeds: [motion.x(), motion.y(), motion.heading()].map(|way| way * rate),
            speeds_cov: step.cov * (rate * rate),
        }
    }

    pub(crate) fn tell(&mut self, pose: &PoseBody) {
        self.carried.tell(pose);
        self.is_told = true;
    }

    /// The robot's present pose in the bridge's map, and `odom_from_robot`; once for each pose
    /// received.
    pub(crate) fn localised(&mut self) -> Option<(PoseEstimate, Pose2)> {
        let now = self.carried.now().filter(|_| self.is_told)?;
        self.is_told = false;
        Some((now, self.summed.motion))
    }
}

#[cfg(test)]
mod tests {
    use slamlab_core::wire::message::PoseState;

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

    #[test]
    fn the_map_lies_where_the_pose_was_told_whatever_the_odometry_says_since() {
        let step = |from: u64| Odometry {
            from: Stamp(from),
            to: Stamp(from + 100_000),
            motion: Pose2::new(0.1, 0.0, 0.0),
            cov: Matrix3::zeros(),
        };
        let mut odom = Odom::default();
        let told = PoseEstimate::exact(Pose2::new(5.0, 1.0, std::f64::consts::FRAC_PI_2));
        odom.tell(&PoseBody::new(200_000, &told, PoseState::Localised));
        let _ = odom.moved(&step(0));
        assert!(odom.localised().is_none());
        let _ = odom.moved(&step(100_000));
        let (now, odom_from_robot) = odom.localised().unwrap();
        let map_from_odom = now.pose * odom_from_robot.inverse();
        assert!(odom.localised().is_none(), "it was taken");
        odom.tell(&PoseBody::new(200_000, &told, PoseState::Localised));
        let _ = odom.moved(&step(200_000));
        let (now, odom_from_robot) = odom.localised().unwrap();
        let again = now.pose * odom_from_robot.inverse();
        assert!((now.pose.y() - 1.1).abs() < 1e-12);
        assert!(map_from_odom.minus(&again).norm() < 1e-12);
    }
}

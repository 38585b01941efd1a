//! Carries a pose that a bridge reported for a recent instant on to now, by the odometry since.
//!
//! In: odometry as it arrives, and the poses that the bridge reports. Out: where the robot is now
//! in the bridge's map. A bridge that maps takes some time for each scan, so its poses usually lag
//! behind the odometry; a pose that is ahead waits for the odometry.

use super::message::{PoseBody, PoseState};
use crate::geom::PoseEstimate;
use crate::points::MotionHistory;
use crate::robot::{Odometry, Stamp};

/// A pose reported longer ago is of no use, s.
const LONGEST: f64 = 5.0;

/// See the module.
#[derive(Clone, Debug)]
pub struct CarriedPose {
    history: MotionHistory,
    begun: Option<Stamp>,
    told: Option<(Stamp, PoseEstimate)>,
}

impl Default for CarriedPose {
    fn default() -> Self {
        Self {
            history: MotionHistory::new(LONGEST),
            begun: None,
            told: None,
        }
    }
}

impl CarriedPose {
    /// Takes a motion with the robot's stamps. If the robot's clock restarts, the robot may be
    /// elsewhere, so the pose reported before is dropped.
    pub fn odometry(&mut self, step: &Odometry) {
        if self.history.now().is_some_and(|now| step.from < now) {
            *self = Self::default();
        }
        self.begun.get_or_insert(step.from);
        self.history.push(step);
    }

    /// Takes a pose; one that is unknown, lost or not finite ends the one before.
    pub fn tell(&mut self, body: &PoseBody) {
        let is_known = !matches!(body.state, PoseState::Unknown | PoseState::Lost);
        let estimate = body.estimate().filter(|_| is_known);
        self.told = estimate.map(|estimate| (Stamp(body.stamp), estimate));
    }

    /// Mean speeds (m/s, rad/s) over the last `span` seconds of odometry.
    #[must_use]
    pub fn speeds(&self, span: f64) -> (f64, f64) {
        self.history.speeds(span)
    }

    /// [`Self::now`], unless the pose reported is older than `longest` seconds.
    #[must_use]
    pub fn fresh(&self, longest: f64) -> Option<PoseEstimate> {
        let (then, _) = self.told?;
        let now = self.history.now()?;
        self.now().filter(|_| now.since(then) <= longest)
    }

    /// `map_from_robot` now, with the covariance that was reported; `None` if none was reported
    /// lately, or only one of an instant that the odometry has not reached yet.
    #[must_use]
    pub fn now(&self) -> Option<PoseEstimate> {
        let (then, told) = self.told?;
        let (begun, now) = (self.begun?, self.history.now()?);
        if then < begun || then > now || now.since(then) > LONGEST {
            return None;
        }
        let since = self.history.since([then]);
        let now_from_then = since.first()?.pose;
        Some(PoseEstimate {
            pose: told.pose * now_from_then.inverse(),
            cov: told.cov,
        })
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Matrix3;

    use super::*;
    use crate::geom::Pose2;

    fn step(from: u64, ahead: f64) -> Odometry {
        Odometry {
            from: Stamp(from),
            to: Stamp(from + 100_000),
            motion: Pose2::new(ahead, 0.0, 0.0),
            cov: Matrix3::zeros(),
        }
    }

    fn told(stamp: u64, state: PoseState) -> PoseBody {
        let pose = Pose2::new(1.0, 2.0, std::f64::consts::FRAC_PI_2);
        let estimate = PoseEstimate::exact(pose);
        PoseBody::new(stamp, &estimate, state)
    }

    fn at(carried: &CarriedPose) -> Option<[f64; 2]> {
        carried.now().map(|now| [now.pose.x(), now.pose.y()])
    }

    #[test]
    fn a_pose_goes_on_by_the_odometry_since_and_waits_for_what_it_is_ahead_of() {
        let mut carried = CarriedPose::default();
        carried.tell(&told(150_000, PoseState::Localised));
        assert_eq!(at(&carried), None);
        carried.odometry(&step(0, 0.1));
        assert_eq!(at(&carried), None, "not there yet");
        carried.odometry(&step(100_000, 0.1));
        carried.odometry(&step(200_000, 0.2));
        // Half of the second step, and the third: 0.25 m ahead, which is along y.
        let [x, y] = at(&carried).unwrap();
        assert!(
            (x - 1.0).abs() < 1e-12 && (y - 2.25).abs() < 1e-12,
            "{x} {y}"
        );
    }

    #[test]
    fn what_is_not_believed_too_old_or_of_another_life_is_no_pose() {
        let mut carried = CarriedPose::default();
        carried.odometry(&step(1_000_000, 0.1));
        carried.tell(&told(1_000_000, PoseState::Unplaced));
        assert!(carried.now().is_some());
        carried.tell(&told(900_000, PoseState::Localised));
        assert!(carried.now().is_none(), "nobody knows the way since");
        carried.tell(&told(1_000_000, PoseState::Lost));
        assert!(carried.now().is_none());
        carried.tell(&told(1_000_000, PoseState::Localised));
        carried.odometry(&step(0, 0.1));
        assert!(carried.now().is_none(), "the robot was reset");
        carried.tell(&told(50_000, PoseState::Localised));
        for at in 1..60 {
            assert_eq!(carried.now().is_some(), at < 51, "{at}");
            carried.odometry(&step(at * 100_000, 0.1));
        }
    }
}

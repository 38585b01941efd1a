//! Decides whether the robot knows where it is.
//!
//! In: the covariance of the pose in the map around it, at each tick. Out: an errand that ends as
//! lost.
//!
//! A filter that matches nothing goes on by odometry, and its covariance grows. The covariance of
//! the estimate itself also grows when all is well, on a long way out from the map's origin. But
//! the pilot plans through the map around the robot, and within a submap the pose may be as certain
//! as ever. A pilot that ignores the covariance plans from a place where the robot is not, through
//! a map that was drawn around places where it never was. When driving by hand people may know
//! better, so only errands end. They do not end with a method that searches for the robot in a
//! known map, because it finds the robot by driving; nor with odometry alone, which is chosen to
//! show its drift.

use nalgebra::Matrix3;

use super::{Failure, Mode, Pilot, Situation};
use crate::robot::Stamp;

/// Time since when the pose has been too uncertain.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Doubt {
    since: Option<Stamp>,
}

impl Pilot {
    /// Ends the errand of a lost robot.
    pub(super) fn doubt_pose(&mut self, now: &Situation) {
        let sigma = sigma_of(&now.known_in_map);
        // NaN counts as uncertain, too.
        if sigma <= self.config.lost_sigma || now.drives_unsure {
            self.doubt.since = None;
            return;
        }
        let since = *self.doubt.since.get_or_insert(now.stamp);
        let seconds = now.stamp.since(since);
        let is_over = self.mode == Mode::Manual || self.status.is_over();
        if !is_over && seconds >= self.config.lost_after {
            self.give_up_errand(Failure::Lost { sigma, seconds });
        }
    }
}

/// Standard deviation of the position in its most uncertain direction, m.
fn sigma_of(cov: &Matrix3<f64>) -> f64 {
    let place = cov.fixed_view::<2, 2>(0, 0).into_owned();
    place.symmetric_eigenvalues().max().sqrt()
}

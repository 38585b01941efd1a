//! Whether the robot knows where it is.
//!
//! In: how well the place is known in the map around it, at each tick. Out: an errand that ends as
//! lost.
//!
//! A filter that matches nothing goes on by odometry, and says so: its covariance grows. That of
//! the estimate itself also grows where all is well, on a long way out from where the map began;
//! what is planned through is the map around, and of a submap the robot may be as sure as ever. A
//! pilot that does not listen plans from a place where the robot is not, through a map that is
//! drawn around places where it never was. By hand people may know better, so only errands end;
//! and none of a method that looks for the robot in a known map, for it finds it by the way that
//! it drives, nor of odometry alone, which is chosen to see how it drifts.

use nalgebra::Matrix3;

use super::{Failure, Mode, Pilot, Situation};
use crate::robot::Stamp;

/// Since when the place has been too unsure.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Doubt {
    since: Option<Stamp>,
}

impl Pilot {
    /// Ends an errand whose robot is lost.
    pub(super) fn doubt_pose(&mut self, now: &Situation) {
        let sigma = sigma_of(&now.known_in_map);
        // No number is unsure, too.
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

/// Standard deviation of the place in the direction where it is least sure, m.
fn sigma_of(cov: &Matrix3<f64>) -> f64 {
    let place = cov.fixed_view::<2, 2>(0, 0).into_owned();
    place.symmetric_eigenvalues().max().sqrt()
}

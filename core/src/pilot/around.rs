//! Leaving the way for people who stand or walk in it.

use nalgebra::Point2;

use super::{Pilot, Situation};
use crate::control::{Avoidance, Underway, choose_in_window};
use crate::plan::Path;

/// How far ahead on its way the robot looks for where to go, m.
const AHEAD: f64 = 1.0;

impl Pilot {
    /// The speeds that the follower wishes; or, where somebody walks about and it is to go around them, those of the dynamic window.
    /// Without an admissible pair the wish stays, for safe mode to limit.
    pub(super) fn around_people(&self, wish: (f64, f64), now: &Situation) -> (f64, f64) {
        let turns_on_spot = wish.0 <= 0.0;
        if self.config.avoidance == Avoidance::KeepsToWay || now.walkers.is_empty() || turns_on_spot
        {
            return wish;
        }
        let (Some(points), Some(follower)) = (now.points, &self.errand.follower) else {
            return wish;
        };
        let here = now.estimate.pose;
        let Some(aim) = point_along(&follower.remaining(here.position()), AHEAD) else {
            return wish;
        };
        let underway = Underway {
            told: self.told,
            runs: now.speeds,
            since_scan: now.motion_since_scan,
            scan_age: now.stamp.since(points.stamp),
        };
        let configs = (&self.config.safe, &self.config.window);
        let aim = here.inverse() * aim;
        choose_in_window(aim, points, &underway, &self.model, configs).unwrap_or(wish)
    }
}

/// The point so far along a path, or its end; `None` of an empty one.
fn point_along(path: &Path, way: f64) -> Option<Point2<f64>> {
    let mut left = way;
    for leg in path.legs() {
        let length = leg.length();
        if length >= left {
            return Some(leg.a + leg.vector() * (left / length.max(1e-9)));
        }
        left -= length;
    }
    path.points.last().copied()
}

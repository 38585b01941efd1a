//! In: what the filter learnt about the pose at some instants of a sweep, and the odometry between.
//! Out: where the robot was at each beam, and how uncertain its heading was there.
//!
//! The tracks of a robot that drives straight on slip by more than a degree within one sweep of
//! 0.18 s: 20 cm at 8 m. If odometry alone places the beams, every wall seen from afar is smeared.
//! The filter corrects the pose several times in a sweep; the beams in between have to share in
//! that.
//!
//! 1. Headings relative to the walls are followed by a scalar filter: the variance L grows by that
//!    of the odometry, and shrinks to L R / (L + R) at each fix, where R is the variance of the
//!    line's direction. (The filter's own covariance cannot be used for this: it includes the error
//!    that pose and walls have in common, which smears nothing.)
//! 2. Backwards, as in Rauch, Tung & Striebel (1965), "Maximum likelihood estimates of linear
//!    dynamic systems": at an instant before a fix the pose takes the fraction L(t) / L(fix) of the
//!    changes by this fix and all later ones.
//! 3. Positions take the same fraction: over one sweep they drift by millimetres, and because of
//!    the heading.
//!
//! Beams after the last fix have odometry alone: their variance grows to the end of the sweep, and
//! continues to grow if no line is recognised in the next ones.

#[cfg(test)]
mod tests;

use nalgebra::Vector3;

use super::ekf_slam::Fix;
use crate::geom::Pose2;
use crate::points::{MotionHistory, MovedSince};
use crate::robot::{Scan, Stamp};

/// Where the robot was when a beam was taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BeamPose {
    /// `robot_now_from_robot_then`.
    pub robot_from_then: Pose2,
    /// Variance of its heading relative to the walls, rad².
    pub heading_variance: f64,
}

/// Tracks the heading's uncertainty from sweep to sweep.
#[derive(Clone, Debug, Default)]
pub struct SweepSmoother {
    /// The end of the odometry when the last scan came, and L at that time.
    last: Option<(Stamp, f64)>,
}

/// A fix, as it passes through the steps.
#[derive(Clone, Copy, Debug)]
struct Knot {
    fix: Fix,
    since: MovedSince,
    /// L before and after the fix.
    prior: f64,
    posterior: f64,
    /// The changes by this fix and all later ones in the pose before it, (x, y, θ) in the map
    /// frame, and L after them.
    change: Vector3<f64>,
    smoothed: f64,
}

impl SweepSmoother {
    /// Poses of all beams of `scan`, in their order. `beams` is the motion since each of them,
    /// `history` ends now, and `fixes` are those of this scan in the order of time.
    pub fn smooth(
        &mut self,
        scan: &Scan,
        beams: &[MovedSince],
        fixes: &[Fix],
        history: &MotionHistory,
    ) -> Vec<BeamPose> {
        let Some(first) = beams.first() else {
            return vec![];
        };
        let start = self.start(first, history);
        let knots = knots(&start, fixes, history);
        let carried = knots.last().map_or(start, |k| (k.since, k.posterior));
        let at_end = carried.1 + carried.0.heading_variance;
        self.last = history.now().map(|now| (now, at_end));
        let sweep = Sweep {
            now_from_map: knots.last().map(|k| k.since.pose * k.fix.after.inverse()),
            start,
            knots,
        };
        let placed = beams.iter().enumerate();
        placed
            .map(|(beam, moved)| sweep.place(scan.taken_at(beam).seconds(), moved))
            .collect()
    }

    /// L when the last scan came, and the motion since then; before the very first scan nothing was
    /// drawn that could disagree.
    fn start(&self, first: &MovedSince, history: &MotionHistory) -> (MovedSince, f64) {
        let Some((stamp, variance)) = self.last else {
            return (*first, 0.0);
        };
        let since = history.since([stamp]);
        (since.first().copied().unwrap_or_default(), variance)
    }
}

/// Steps 1 and 2 for the fixes.
fn knots(start: &(MovedSince, f64), fixes: &[Fix], history: &MotionHistory) -> Vec<Knot> {
    let times = fixes.iter().map(|f| Stamp::from_seconds(f.seconds));
    let (mut from, mut variance) = *start;
    let mut knots = vec![];
    for (fix, since) in fixes.iter().zip(history.since(times)) {
        let prior = variance + variance_between(&from, &since);
        let both = prior + fix.heading_variance;
        let posterior = if both > 0.0 {
            prior * fix.heading_variance / both
        } else {
            0.0
        };
        knots.push(Knot {
            fix: *fix,
            since,
            prior,
            posterior,
            change: fix.after.minus(&fix.before),
            smoothed: posterior,
        });
        (from, variance) = (since, posterior);
    }
    let mut later: Option<Knot> = None;
    for knot in knots.iter_mut().rev() {
        if let Some(next) = &later {
            let (change, smoothed) = next.passed_back(knot.posterior);
            knot.change += change;
            knot.smoothed = smoothed;
        }
        later = Some(*knot);
    }
    knots
}

/// All data of one sweep.
struct Sweep {
    now_from_map: Option<Pose2>,
    start: (MovedSince, f64),
    knots: Vec<Knot>,
}

impl Sweep {
    fn place(&self, seconds: f64, moved: &MovedSince) -> BeamPose {
        let at = self.knots.partition_point(|k| k.fix.seconds <= seconds);
        let earlier = at.checked_sub(1).and_then(|i| self.knots.get(i));
        let (from, variance) = earlier.map_or(self.start, |k| (k.since, k.posterior));
        let variance = variance + variance_between(&from, moved);
        let (Some(next), Some(now_from_map)) = (self.knots.get(at), &self.now_from_map) else {
            return BeamPose {
                robot_from_then: moved.pose,
                heading_variance: variance,
            };
        };
        let (change, heading_variance) = next.passed_back(variance.min(next.prior));
        let by_odometry = next.fix.before * next.since.pose.inverse() * moved.pose;
        BeamPose {
            robot_from_then: *now_from_map * by_odometry.plus(&change),
            heading_variance,
        }
    }
}

impl Knot {
    /// Step 2: the changes by this fix and the later ones at an instant before it at which L is
    /// `variance`, and the remaining L.
    fn passed_back(&self, variance: f64) -> (Vector3<f64>, f64) {
        let part = if self.prior > 0.0 {
            variance / self.prior
        } else {
            1.0
        };
        let left = variance + part * part * (self.smoothed - self.prior);
        (self.change * part, left.max(0.0))
    }
}

/// Variance of the heading accumulated by odometry between two instants.
fn variance_between(from: &MovedSince, to: &MovedSince) -> f64 {
    (from.heading_variance - to.heading_variance).max(0.0)
}

//! Steps 1 and 2: the state moves by odometry, as far as the instant at which a line was seen.

use nalgebra::Matrix3;

use super::{Consistency, EkfSlam, POSE};
use crate::geom::{PoseEstimate, symmetrize};
use crate::robot::{Odometry, Stamp};

impl EkfSlam {
    /// Step 1: moves the state by `odometry`.
    ///
    /// # Source   TDK 2016 eq. (3.1)-(3.4), (3.18)-(3.20).
    pub(super) fn advance(&mut self, odometry: &Odometry) {
        let moved = self.pose * odometry.motion;
        let from = match self.config.consistency {
            Consistency::Plain => self.pose.position(),
            Consistency::FirstEstimates => self.predicted,
        };
        // F_x is the identity but for the two elements that turn the step.
        let step = moved.position() - from;
        let f = [-step.y, step.x];
        let (cos, sin) = self.pose.cos_sin();
        let by_motion = Matrix3::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0);
        let added = by_motion * odometry.cov * by_motion.transpose();
        let by_pose = Matrix3::new(1.0, 0.0, f[0], 0.0, 1.0, f[1], 0.0, 0.0, 1.0);
        let pose_cov = by_pose * self.pose_cov() * by_pose.transpose() + added;
        for row in 0..POSE {
            for column in 0..=row {
                let value = 0.5 * (pose_cov[(row, column)] + pose_cov[(column, row)]);
                self.cov.set(row, column, value);
            }
        }
        for row in self.cov.rows_mut(POSE) {
            if let [x, y, turn, ..] = row {
                *x += f[0] * *turn;
                *y += f[1] * *turn;
            }
        }
        self.pose = moved;
        self.predicted = moved.position();
    }

    /// Step 2: moves the state by the pending odometry up to `time` (seconds); an odometry that goes past it is split.
    pub(super) fn advance_to(&mut self, time: f64) {
        let mut used = 0;
        while let Some(&next) = self.pending.get(used) {
            let (from, to) = (next.from.seconds(), next.to.seconds());
            // Stamps have a grain of a microsecond.
            if to > time + 1e-6 {
                let part = if to > from {
                    (time - from) / (to - from)
                } else {
                    0.0
                };
                if part > 1e-3 {
                    let (first, rest) = split(&next, part);
                    self.advance(&first);
                    if let Some(pending) = self.pending.get_mut(used) {
                        *pending = rest;
                    }
                }
                break;
            }
            self.advance(&next);
            used += 1;
        }
        self.pending.drain(..used);
    }

    /// The motion from the time of the state to `time`, by the pending odometry: what a scan straightened to `time` has
    /// been moved by.
    pub(super) fn motion_until(&self, time: f64) -> Odometry {
        let mut whole = Odometry::standing(Stamp(0));
        for next in &self.pending {
            let (from, to) = (next.from.seconds(), next.to.seconds());
            if to <= time + 1e-6 {
                whole = whole.then(next);
            } else {
                let part = if to > from {
                    (time - from) / (to - from)
                } else {
                    0.0
                };
                if part > 1e-3 {
                    whole = whole.then(&split(next, part).0);
                }
                break;
            }
        }
        whole
    }
}

/// The first `part` of a motion, and what follows it; the variance grows with the way.
fn split(odometry: &Odometry, part: f64) -> (Odometry, Odometry) {
    let first = odometry.motion.fraction(part);
    let seconds = odometry.to.since(odometry.from);
    let middle = Stamp::from_seconds(odometry.from.seconds() + part * seconds);
    (
        Odometry {
            to: middle,
            motion: first,
            cov: odometry.cov * part,
            ..*odometry
        },
        Odometry {
            from: middle,
            motion: first.inverse() * odometry.motion,
            cov: odometry.cov * (1.0 - part),
            ..*odometry
        },
    )
}

/// A pose moved by odometry, to first order.
pub(super) fn moved_by(estimate: &PoseEstimate, odometry: &Odometry) -> PoseEstimate {
    let pose = estimate.pose * odometry.motion;
    let step = pose.position() - estimate.pose.position();
    let (cos, sin) = estimate.pose.cos_sin();
    let by_pose = Matrix3::new(1.0, 0.0, -step.y, 0.0, 1.0, step.x, 0.0, 0.0, 1.0);
    let by_motion = Matrix3::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0);
    let mut cov = by_pose * estimate.cov * by_pose.transpose()
        + by_motion * odometry.cov * by_motion.transpose();
    symmetrize(&mut cov);
    PoseEstimate { pose, cov }
}

//! Notices when a robot that should move does not.

use crate::geom::{Length, Pose2, wrap};
use crate::robot::Stamp;

/// Remembers where the robot last made progress, and when.
#[derive(Clone, Copy, Debug, Default)]
pub struct ProgressWatch {
    anchor: Option<(Stamp, Pose2)>,
}

/// Motion below which there is no progress, m and rad.
const MOVED: f64 = 0.04;
const TURNED: f64 = 0.3;

impl ProgressWatch {
    /// Starts again: the robot got another command.
    pub fn reset(&mut self) {
        self.anchor = None;
    }

    /// Seconds without progress.
    pub fn idle_for(&mut self, stamp: Stamp, pose: &Pose2) -> f64 {
        let (since, anchor) = *self.anchor.get_or_insert((stamp, *pose));
        let moved = (pose.position() - anchor.position()).length() > MOVED;
        let turned = wrap(pose.heading() - anchor.heading()).abs() > TURNED;
        if moved || turned {
            self.anchor = Some((stamp, *pose));
            return 0.0;
        }
        stamp.since(since)
    }
}

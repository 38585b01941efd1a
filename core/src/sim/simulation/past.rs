//! What was, up to two seconds ago: counts and truth at the stamp of a reading.

use super::{STEP_MICROS, Simulation};
use crate::geom::Pose2;
use crate::robot::Stamp;

/// Steps that are remembered for readings at an earlier stamp: two seconds.
const REMEMBERED: usize = 400;

/// The end of a step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Moment {
    pub(super) ticks: [i64; 2],
    pub(super) truth: Pose2,
}

impl Simulation {
    /// Encoder counts at an earlier stamp (that of a scan, say), up to two seconds back; in between steps the nearest
    /// count of a straight line.
    #[must_use]
    pub fn ticks_at(&self, stamp: Stamp) -> Option<[i64; 2]> {
        let (before, after, part) = self.moments_around(stamp)?;
        let at = |i: i64, j: i64| i + ((j - i) as f64 * part).round() as i64;
        let ([left, right], [next_left, next_right]) = (before.ticks, after.ticks);
        Some([at(left, next_left), at(right, next_right)])
    }

    /// Where the robot really was at an earlier stamp, up to two seconds back: `world_from_robot`.
    #[must_use]
    pub fn truth_at(&self, stamp: Stamp) -> Option<Pose2> {
        let (before, after, part) = self.moments_around(stamp)?;
        Some(before.truth * before.truth.delta_to(&after.truth).fraction(part))
    }

    pub(super) fn remember(&mut self) {
        if self.memory.len() == REMEMBERED {
            self.memory.pop_front();
        }
        self.memory.push_back(Moment {
            ticks: self.ticks(),
            truth: self.body.pose(),
        });
    }

    /// The remembered steps before and after `stamp`, and how far it is from the one to the other.
    fn moments_around(&self, stamp: Stamp) -> Option<(Moment, Moment, f64)> {
        let oldest = self.steps - (self.memory.len() as u64 - 1);
        let before = (stamp.0 / STEP_MICROS).checked_sub(oldest)? as usize;
        let part = (stamp.0 % STEP_MICROS) as f64 / STEP_MICROS as f64;
        let first = *self.memory.get(before)?;
        let second = if part > 0.0 {
            *self.memory.get(before + 1)?
        } else {
            first
        };
        Some((first, second, part))
    }
}

//! In: the odometry of the last moments. Out: where the robot was, relative to its current pose, at
//! any instant of them.
//!
//! A scan of a turning sensor takes a good part of a second, and arrives a little after its last
//! beam. Between two odometry readings constant speed and turn rate are assumed; over a whole sweep
//! this would not hold: a robot that starts to turn at 6 rad/s² while a sweep of 0.18 s runs is
//! 1.4° off in the middle of it.

use std::collections::VecDeque;

use crate::geom::Pose2;
use crate::robot::{Odometry, Scan, Stamp};

/// The robot's motion over the last moments, from odometry.
#[derive(Clone, Debug)]
pub struct MotionHistory {
    span: f64,
    /// Newest last; each covers the time `from..to`.
    steps: VecDeque<Odometry>,
}

impl MotionHistory {
    /// An empty history that remembers at least `span` seconds.
    #[must_use]
    pub fn new(span: f64) -> Self {
        Self {
            span,
            steps: VecDeque::new(),
        }
    }

    /// Takes the next odometry reading. Readings come in order of time.
    pub fn push(&mut self, odometry: &Odometry) {
        self.steps.push_back(*odometry);
        while self
            .steps
            .front()
            .is_some_and(|first| odometry.to.since(first.to) > self.span)
        {
            self.steps.pop_front();
        }
    }

    /// End of the newest reading; `None` before the first one.
    #[must_use]
    pub fn now(&self) -> Option<Stamp> {
        self.steps.back().map(|last| last.to)
    }

    /// Mean speeds (m/s, rad/s) over the last `span` seconds of odometry; 0 before the first
    /// reading.
    #[must_use]
    pub fn speeds(&self, span: f64) -> (f64, f64) {
        let Some(now) = self.now() else {
            return (0.0, 0.0);
        };
        let newest = self.steps.iter().rev();
        let recent = newest.take_while(|step| now.since(step.to) < span);
        let (way, turn, time) = recent.fold((0.0, 0.0, 0.0), |(way, turn, time), step| {
            let (motion, took) = (&step.motion, step.to.since(step.from));
            (way + motion.x(), turn + motion.heading(), time + took)
        });
        if time > 0.0 {
            (way / time, turn / time)
        } else {
            (0.0, 0.0)
        }
    }

    /// The motion since each beam of `scan` was taken, as [`Self::since`].
    #[must_use]
    pub fn since_beams(&self, scan: &Scan) -> Vec<MovedSince> {
        self.since((0..scan.len()).map(|beam| scan.taken_at(beam)))
    }

    /// The motion from each of the given instants to now, for instants in any order.
    ///
    /// Instants before the oldest reading get the motion since its start, instants after the newest
    /// one get none: nothing is known there, so standing still is assumed.
    #[must_use]
    pub fn since(&self, instants: impl IntoIterator<Item = Stamp>) -> Vec<MovedSince> {
        // From the end of each step to now, from the newest back.
        let mut from_ends = Vec::with_capacity(self.steps.len());
        let mut behind = MovedSince::default();
        for step in self.steps.iter().rev() {
            from_ends.push(behind);
            behind = behind.back_over(&step.motion.inverse(), step.cov[(2, 2)]);
        }
        from_ends.reverse();
        let moved = |instant: Stamp| {
            let at = self.steps.partition_point(|step| step.to < instant);
            let (Some(step), Some(from_end)) = (self.steps.get(at), from_ends.get(at)) else {
                return MovedSince::default();
            };
            let duration = step.to.since(step.from);
            let left = if duration > 0.0 {
                (step.to.since(instant) / duration).clamp(0.0, 1.0)
            } else {
                0.0
            };
            from_end.back_over(
                &step.motion.inverse().fraction(left),
                left * step.cov[(2, 2)],
            )
        };
        // Many sensors take all beams at the same instant.
        let mut last: Option<(Stamp, MovedSince)> = None;
        let moved_or_last = |instant: Stamp| {
            let same = last.filter(|(at, _)| *at == instant);
            let (_, since) = same.unwrap_or_else(|| (instant, moved(instant)));
            last = Some((instant, since));
            since
        };
        instants.into_iter().map(moved_or_last).collect()
    }
}

/// The motion from an instant to now, by odometry.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MovedSince {
    /// `robot_now_from_robot_then`.
    pub pose: Pose2,
    /// Variance of the heading that odometry accumulated meanwhile, rad².
    pub heading_variance: f64,
}

impl MovedSince {
    /// The motion from an earlier instant: `back` is the motion back over the time in between,
    /// whose heading has the given variance.
    fn back_over(&self, back: &Pose2, heading_variance: f64) -> Self {
        Self {
            pose: self.pose * *back,
            heading_variance: self.heading_variance + heading_variance,
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Matrix3;

    use super::*;

    fn history() -> MotionHistory {
        let mut history = MotionHistory::new(1.0);
        // 0.1 m ahead in each 100 ms, then a turn of 0.2 rad in each.
        for (i, motion) in [
            (0, (0.1, 0.0)),
            (1, (0.1, 0.0)),
            (2, (0.0, 0.2)),
            (3, (0.0, 0.2)),
        ] {
            history.push(&Odometry {
                from: Stamp(i * 100_000),
                to: Stamp((i + 1) * 100_000),
                motion: Pose2::new(motion.0, 0.0, motion.1),
                cov: Matrix3::zeros(),
            });
        }
        history
    }

    #[test]
    fn poses_between_readings_lie_on_the_way() {
        let history = history();
        let since = history.since([0, 50_000, 200_000, 250_000, 400_000].map(Stamp));
        let poses: Vec<_> = since.iter().map(|moved| moved.pose).collect();
        // (now_from_then)⁻¹ * now_from_start = then_from_start: the robot's motion up to that
        // instant.
        let start = poses[0];
        let done: Vec<_> = poses
            .iter()
            .map(|p| p.delta_to(&start).inverse())
            .map(|p| (p.x(), p.heading()))
            .collect();
        for (done, expect) in
            done.iter()
                .zip([(0.0, 0.0), (0.05, 0.0), (0.2, 0.0), (0.2, 0.1), (0.2, 0.4)])
        {
            assert!(
                (done.0 - expect.0).abs() < 1e-12 && (done.1 - expect.1).abs() < 1e-12,
                "{done:?} {expect:?}"
            );
        }
    }

    #[test]
    fn beams_of_one_instant_moved_alike_and_others_in_between_do_not_matter() {
        let history = history();
        let instants = [50_000, 50_000, 250_000, 50_000, 250_000, 250_000].map(Stamp);
        let alone = instants.map(|instant| history.since([instant])[0]);
        assert_eq!(history.since(instants), alone);
    }

    #[test]
    fn speeds_are_those_of_the_last_readings() {
        let history = history();
        let (forward, turn) = history.speeds(0.15);
        assert!(forward == 0.0 && (turn - 2.0).abs() < 1e-12, "{turn}");
        // At least the newest reading counts.
        assert!((history.speeds(0.01).1 - 2.0).abs() < 1e-12);
        let (forward, turn) = history.speeds(1.0);
        assert!((forward - 0.5).abs() < 1e-12 && (turn - 1.0).abs() < 1e-12);
        assert_eq!(MotionHistory::new(1.0).speeds(1.0), (0.0, 0.0));
    }

    #[test]
    fn variance_gathers_over_the_way_that_is_left() {
        let mut history = MotionHistory::new(1.0);
        for (i, variance) in [(0, 0.5), (1, 0.0), (2, 0.25)] {
            let mut cov = Matrix3::zeros();
            cov[(2, 2)] = variance;
            history.push(&Odometry {
                from: Stamp(i * 100_000),
                to: Stamp((i + 1) * 100_000),
                motion: Pose2::identity(),
                cov,
            });
        }
        let since = history.since([0, 40_000, 150_000, 220_000, 300_000, 900_000].map(Stamp));
        for (since, expect) in since.iter().zip([0.75, 0.55, 0.25, 0.2, 0.0, 0.0]) {
            assert!((since.heading_variance - expect).abs() < 1e-12, "{since:?}");
        }
    }

    #[test]
    fn outside_of_what_is_remembered_it_stands_still() {
        let history = history();
        let nothing = [MovedSince::default()];
        assert_eq!(history.since([Stamp(900_000)]), nothing);
        assert_eq!(MotionHistory::new(1.0).since([Stamp(5)]), nothing);
        let mut long = MotionHistory::new(0.15);
        for step in &history.steps {
            long.push(step);
        }
        assert_eq!(long.steps.len(), 2);
        assert_eq!(long.since([Stamp(0)]), long.since([Stamp(200_000)]));
    }
}

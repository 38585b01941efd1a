//! Whether a leg, a turn or a sweep is still under way, told from what the robot reports: the wire does not say so.

use crate::robot::{Command, Odometry, Scan, Stamp};

/// A robot that stands for so long has come to rest, µs.
const REST: u64 = 250_000;
/// Motion below is standing, m/s and rad/s.
const STANDING: (f64, f64) = (0.005, 0.02);
/// A command that has not shown in the motion after so long never will, s.
const SLOW_START: f64 = 1.0;
/// No sweep takes longer, s.
const LONGEST_SWEEP: f64 = 15.0;

/// A command that takes its time.
#[derive(Clone, Debug)]
pub(super) struct Progress {
    command: Command,
    begun: Stamp,
    /// Stands for so long, µs.
    rests: u64,
    /// Way or turn so far, m or rad.
    done: f64,
    is_over: bool,
}

impl Progress {
    /// Of a command given at `now`; `None` for those that are done at once.
    pub(super) fn of(command: Command, now: Stamp) -> Option<Self> {
        let takes_time = matches!(
            command,
            Command::Forward(_) | Command::Turn(_) | Command::Scan
        );
        takes_time.then_some(Self {
            command,
            begun: now,
            rests: 0,
            done: 0.0,
            is_over: false,
        })
    }

    pub(super) fn odometry(&mut self, odometry: &Odometry) {
        let seconds = odometry.to.since(odometry.from);
        if seconds <= 0.0 {
            return;
        }
        let (way, turn) = (odometry.motion.x().abs(), odometry.motion.heading().abs());
        let stands = way < STANDING.0 * seconds && turn < STANDING.1 * seconds;
        let micros = odometry.to.0 - odometry.from.0;
        self.rests = if stands { self.rests + micros } else { 0 };
        let elapsed = odometry.to.since(self.begun);
        match self.command {
            Command::Forward(wish) => {
                self.done += way;
                self.is_over |= self.has_ended(wish.abs(), elapsed);
            }
            Command::Turn(wish) => {
                self.done += turn;
                self.is_over |= self.has_ended(wish.abs(), elapsed);
            }
            _ => self.is_over |= elapsed > LONGEST_SWEEP,
        }
    }

    fn has_ended(&self, wish: f64, elapsed: f64) -> bool {
        self.rests >= REST && (self.done > 0.5 * wish || elapsed > SLOW_START)
    }

    pub(super) fn scan(&mut self, scan: &Scan) {
        self.is_over |= self.command == Command::Scan && scan.stamp > self.begun;
    }

    pub(super) fn is_over(&self) -> bool {
        self.is_over
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Pose2;
    use nalgebra::Matrix3;

    /// 50 ms of motion.
    fn step(at: &mut u64, way: f64, turn: f64) -> Odometry {
        let from = Stamp(*at);
        *at += 50_000;
        Odometry {
            from,
            to: Stamp(*at),
            motion: Pose2::new(way, 0.0, turn),
            cov: Matrix3::zeros(),
        }
    }

    #[test]
    fn a_leg_is_over_when_the_robot_has_come_to_rest() {
        let (mut at, mut steps) = (0, 0);
        let mut progress = Progress::of(Command::Forward(0.2), Stamp(0)).unwrap();
        // It starts late, drives, and stands.
        for way in [0.0; 6].into_iter().chain([0.01; 20]) {
            progress.odometry(&step(&mut at, way, 0.0));
            assert!(!progress.is_over(), "at {at} us");
        }
        while !progress.is_over() && steps < 100 {
            progress.odometry(&step(&mut at, 0.0, 0.0));
            steps += 1;
        }
        assert_eq!(steps, 5);
    }

    #[test]
    fn a_command_that_the_robot_never_obeys_is_over_after_a_second() {
        let (mut at, mut steps) = (0, 0);
        let mut progress = Progress::of(Command::Turn(1.0), Stamp(0)).unwrap();
        while !progress.is_over() && steps < 100 {
            progress.odometry(&step(&mut at, 0.0, 0.0));
            steps += 1;
        }
        assert_eq!(steps, 21);
    }

    #[test]
    fn speeds_and_stops_take_no_time() {
        let velocity = Command::Velocity {
            forward: 0.1,
            turn: 0.0,
        };
        assert!(Progress::of(velocity, Stamp(0)).is_none());
        assert!(Progress::of(Command::Stop, Stamp(0)).is_none());
    }
}

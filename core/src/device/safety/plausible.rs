//! Reasons to disarm in the robot's own readings.
//!
//! In: orders to the robot, and its readings. Out: the reason why it must not go on, if there is
//! one.
//!
//! 1. A bumper that is newly pressed. One that stays pressed does not count: the robot must be able
//!    to back off.
//! 2. A battery that stays below its limit for 2 s; a dip under load does not count.
//! 3. Silence: no odometry for half a second.
//! 4. Encoders against command, over windows of a fifth of a second: ordered to run, the robot
//!    stands for 1.5 s (stall); ordered to stand, it still runs after 1 s (runaway). Legs and turns
//!    of a given length end by themselves and are not judged.

use std::time::Duration;

use crate::geom::Length;
use crate::robot::{Command, Odometry};
use crate::wire::message::DisarmReason;

use crate::device::source::Order;

/// A battery below this is nearly empty, V: 1.0 V for each of the RP6's six cells.
const LOW_VOLTS: f32 = 6.0;
/// How long it must stay below.
const LOW_FOR: Duration = Duration::from_secs(2);
/// No odometry for this time is silence.
const SILENCE: Duration = Duration::from_millis(500);
/// Standing for this time, although ordered to run, is a stall.
const STALL: Duration = Duration::from_millis(1500);
/// Running after this time, although ordered to stand, is a runaway: from full speed the robot
/// needs half of it to stop.
const RUNAWAY: Duration = Duration::from_secs(1);
/// Slower than this counts as standing, m/s and rad/s.
const STANDING: (f64, f64) = (0.02, 0.1);
/// Speeds are means over at least this many seconds of odometry: a single reading holds only a few
/// encoder counts.
const WINDOW: f64 = 0.2;

/// Remembers orders and readings.
#[derive(Clone, Debug, Default)]
pub struct Plausible {
    ordered: Ordered,
    bumpers: [bool; 2],
    low_since: Option<Duration>,
    heard: Option<Duration>,
    window: Option<Odometry>,
    /// Since when the encoders have contradicted the command.
    odd_since: Option<Duration>,
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Ordered {
    #[default]
    Stand,
    Run,
    /// A leg, a turn, a sweep.
    Manoeuvre,
}

impl Plausible {
    /// Takes an order to the robot.
    pub fn ordered(&mut self, order: &Order) {
        let (least, least_turn) = STANDING;
        let ordered = match order {
            Order::Command(Command::Velocity { forward, turn }) => {
                // Running means twice the limits of standing; in between, nothing can be judged.
                let is_run = forward.abs() > 2.0 * least || turn.abs() > 2.0 * least_turn;
                let is_stand = *forward == 0.0 && *turn == 0.0;
                match (is_run, is_stand) {
                    (true, _) => Ordered::Run,
                    (_, true) => Ordered::Stand,
                    _ => Ordered::Manoeuvre,
                }
            }
            Order::Command(Command::Forward(_) | Command::Turn(_) | Command::Scan) => {
                Ordered::Manoeuvre
            }
            _ => Ordered::Stand,
        };
        if ordered != self.ordered {
            (self.ordered, self.odd_since) = (ordered, None);
        }
    }

    /// Takes a motion.
    pub fn odometry(&mut self, now: Duration, odometry: &Odometry) -> Option<DisarmReason> {
        self.heard = Some(now);
        let joined = match &self.window {
            Some(before) if before.to == odometry.from => before.then(odometry),
            _ => *odometry,
        };
        let seconds = joined.to.since(joined.from);
        if seconds < WINDOW {
            self.window = Some(joined);
            return None;
        }
        self.window = None;
        let speed = joined.motion.position().coords.length() / seconds;
        let turn = joined.motion.heading().abs() / seconds;
        self.judge(now, speed < STANDING.0 && turn < STANDING.1)
    }

    fn judge(&mut self, now: Duration, stands: bool) -> Option<DisarmReason> {
        let (is_odd, patience, reason) = match self.ordered {
            Ordered::Run => (stands, STALL, DisarmReason::Stall),
            Ordered::Stand => (!stands, RUNAWAY, DisarmReason::Runaway),
            Ordered::Manoeuvre => (false, Duration::ZERO, DisarmReason::Stall),
        };
        if !is_odd {
            self.odd_since = None;
            return None;
        }
        let since = *self.odd_since.get_or_insert(now);
        if now.saturating_sub(since) < patience {
            return None;
        }
        self.odd_since = None;
        Some(reason)
    }

    /// Takes the state of the bumpers.
    pub fn bumpers(&mut self, pressed: [bool; 2]) -> Option<DisarmReason> {
        let before = std::mem::replace(&mut self.bumpers, pressed);
        let begins = pressed
            .iter()
            .zip(before)
            .any(|(&now, before)| now && !before);
        begins.then_some(DisarmReason::Bumper)
    }

    /// Takes the battery voltage.
    pub fn battery(&mut self, now: Duration, volts: f32) -> Option<DisarmReason> {
        if volts >= LOW_VOLTS {
            self.low_since = None;
            return None;
        }
        let since = *self.low_since.get_or_insert(now);
        (now.saturating_sub(since) >= LOW_FOR).then_some(DisarmReason::Battery)
    }

    /// Whether the battery is nearly empty, and has been for long enough.
    #[must_use]
    pub fn is_empty(&self, now: Duration) -> bool {
        let since = self.low_since;
        since.is_some_and(|since| now.saturating_sub(since) >= LOW_FOR)
    }

    /// Whether the robot has been silent for too long; reported once, until it is heard again.
    pub fn silence(&mut self, now: Duration) -> Option<DisarmReason> {
        let heard = self.heard?;
        if now.saturating_sub(heard) < SILENCE {
            return None;
        }
        self.heard = None;
        Some(DisarmReason::Silence)
    }

    /// When the silence will have lasted too long, if no odometry arrives before.
    #[must_use]
    pub fn deadline(&self) -> Option<Duration> {
        self.heard.map(|heard| heard + SILENCE)
    }
}

#[cfg(test)]
mod tests {
    use crate::geom::Pose2;
    use crate::robot::Stamp;
    use nalgebra::Matrix3;

    use super::*;

    fn at(millis: u64) -> Duration {
        Duration::from_millis(millis)
    }

    /// Runs at `speed` from `from` to `to` (ms), 10 ms a reading; returns when and why the robot
    /// was first to be disarmed.
    fn run(
        plausible: &mut Plausible,
        speed: f64,
        from: u64,
        to: u64,
    ) -> Option<(u64, DisarmReason)> {
        (from..to).step_by(10).find_map(|t| {
            let odometry = Odometry {
                from: Stamp(t * 1000),
                to: Stamp((t + 10) * 1000),
                motion: Pose2::new(speed * 0.01, 0.0, 0.0),
                cov: Matrix3::zeros(),
            };
            let reason = plausible.odometry(at(t + 10), &odometry)?;
            Some((t + 10, reason))
        })
    }

    fn ordered(forward: f64) -> Plausible {
        let mut plausible = Plausible::default();
        plausible.ordered(&Order::Command(Command::Velocity { forward, turn: 0.0 }));
        plausible
    }

    #[test]
    fn a_robot_that_obeys_is_left_alone() {
        assert_eq!(run(&mut ordered(0.2), 0.2, 0, 10_000), None);
        assert_eq!(run(&mut ordered(0.0), 0.0, 0, 10_000), None);
        // Slows down for half a second after a stop.
        let mut stopped = ordered(0.0);
        assert_eq!(run(&mut stopped, 0.15, 0, 500), None);
        assert_eq!(run(&mut stopped, 0.0, 500, 10_000), None);
    }

    #[test]
    fn a_blocked_robot_is_a_stall_after_its_patience() {
        let (millis, reason) = run(&mut ordered(0.2), 0.0, 0, 10_000).unwrap();
        assert_eq!(reason, DisarmReason::Stall);
        assert!((1500..=2000).contains(&millis), "{millis}");
    }

    #[test]
    fn a_robot_that_runs_without_an_order_is_a_runaway() {
        let (millis, reason) = run(&mut ordered(0.0), 0.1, 0, 10_000).unwrap();
        assert_eq!(reason, DisarmReason::Runaway);
        assert!((1000..=1500).contains(&millis), "{millis}");
    }

    #[test]
    fn a_leg_is_not_judged() {
        let mut plausible = Plausible::default();
        plausible.ordered(&Order::Command(Command::Forward(1.0)));
        assert_eq!(run(&mut plausible, 0.0, 0, 5000), None);
        assert_eq!(run(&mut plausible, 0.3, 5000, 9000), None);
    }

    #[test]
    fn a_bumper_counts_when_it_begins_to_be_pressed() {
        let mut plausible = Plausible::default();
        let bumper = Some(DisarmReason::Bumper);
        for (pressed, expect) in [
            ([false, false], None),
            ([true, false], bumper),
            ([true, false], None),
            ([true, true], bumper),
            ([false, false], None),
            ([false, true], bumper),
        ] {
            assert_eq!(plausible.bumpers(pressed), expect, "{pressed:?}");
        }
    }

    #[test]
    fn a_battery_counts_as_empty_when_it_stays_so() {
        let mut plausible = Plausible::default();
        assert_eq!(plausible.battery(at(0), 5.5), None);
        assert_eq!(plausible.battery(at(1000), 6.5), None);
        assert_eq!(plausible.battery(at(1500), 5.9), None);
        assert_eq!(plausible.battery(at(3400), 5.9), None);
        assert_eq!(
            plausible.battery(at(3500), 5.9),
            Some(DisarmReason::Battery)
        );
    }

    #[test]
    fn silence_is_reported_once() {
        let mut plausible = ordered(0.0);
        assert_eq!(plausible.silence(at(9000)), None, "it never spoke");
        run(&mut plausible, 0.0, 0, 100);
        assert_eq!(plausible.deadline(), Some(at(600)));
        assert_eq!(plausible.silence(at(599)), None);
        assert_eq!(plausible.silence(at(600)), Some(DisarmReason::Silence));
        assert_eq!(plausible.silence(at(700)), None);
    }
}

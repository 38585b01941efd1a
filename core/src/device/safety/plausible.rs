//! What disarms in the robot's own readings.
//!
//! In: what the robot was told, and what it says. Out: the reason why it must not go on, where there is one.
//!
//! 1. A bumper that begins to be pressed. One that stays pressed does not count: the robot must be able to back off.
//! 2. A battery that stays below its limit for 2 s; a dip under load does not count.
//! 3. Silence: no odometry for half a second.
//! 4. Encoders against command, over windows of a fifth of a second: told to run, it stands for 1.5 s (stall); told to
//!    stand, it still runs after 1 s (runaway). Legs and turns of a given length end by themselves; they are not judged.

use std::time::Duration;

use crate::robot::{Command, Odometry};
use crate::wire::message::DisarmReason;

use crate::device::source::Order;

/// The limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlausibleConfig {
    /// A battery below it is nearly empty, V. Default 6.0: 1.0 V for each of the RP6's six cells.
    pub low_volts: f32,
    /// How long it must stay there. Default 2 s.
    pub low_for: Duration,
    /// No odometry for so long is silence. Default 500 ms.
    pub silence: Duration,
    /// Told to run and standing for so long is a stall. Default 1.5 s.
    pub stall: Duration,
    /// Told to stand and running after so long is a runaway. Default 1 s: from full speed it needs half of that.
    pub runaway: Duration,
    /// Slower than this is standing, m/s and rad/s. Default 0.02 and 0.1.
    pub standing: (f64, f64),
}

impl Default for PlausibleConfig {
    fn default() -> Self {
        Self {
            low_volts: 6.0,
            low_for: Duration::from_secs(2),
            silence: Duration::from_millis(500),
            stall: Duration::from_millis(1500),
            runaway: Duration::from_secs(1),
            standing: (0.02, 0.1),
        }
    }
}

/// Speeds are means over at least so many seconds of odometry: single readings are a few encoder counts.
const WINDOW: f64 = 0.2;

/// Remembers what was told and said.
#[derive(Clone, Debug)]
pub struct Plausible {
    config: PlausibleConfig,
    told: Told,
    bumpers: [bool; 2],
    low_since: Option<Duration>,
    heard: Option<Duration>,
    window: Option<Odometry>,
    /// Since when the encoders contradict the command.
    odd_since: Option<Duration>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Told {
    Stand,
    Run,
    /// A leg, a turn, a sweep.
    Errand,
}

impl Plausible {
    /// Before anything was told or said.
    #[must_use]
    pub fn new(config: PlausibleConfig) -> Self {
        Self {
            config,
            told: Told::Stand,
            bumpers: [false; 2],
            low_since: None,
            heard: None,
            window: None,
            odd_since: None,
        }
    }

    /// Takes what the robot was told.
    pub fn ordered(&mut self, order: &Order) {
        let (least, least_turn) = self.config.standing;
        let told = match order {
            Order::Command(Command::Velocity { forward, turn }) => {
                // Twice what counts as standing: in between, nothing can be said.
                let is_run = forward.abs() > 2.0 * least || turn.abs() > 2.0 * least_turn;
                let is_stand = *forward == 0.0 && *turn == 0.0;
                match (is_run, is_stand) {
                    (true, _) => Told::Run,
                    (_, true) => Told::Stand,
                    _ => Told::Errand,
                }
            }
            Order::Command(Command::Forward(_) | Command::Turn(_) | Command::Scan) => Told::Errand,
            _ => Told::Stand,
        };
        if told != self.told {
            (self.told, self.odd_since) = (told, None);
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
        let speed = joined.motion.position().coords.norm() / seconds;
        let turn = joined.motion.heading().abs() / seconds;
        self.judge(
            now,
            speed < self.config.standing.0 && turn < self.config.standing.1,
        )
    }

    fn judge(&mut self, now: Duration, stands: bool) -> Option<DisarmReason> {
        let (is_odd, patience, reason) = match self.told {
            Told::Run => (stands, self.config.stall, DisarmReason::Stall),
            Told::Stand => (!stands, self.config.runaway, DisarmReason::Runaway),
            Told::Errand => (false, Duration::ZERO, DisarmReason::Stall),
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

    /// Takes what the bumpers feel.
    pub fn bumpers(&mut self, pressed: [bool; 2]) -> Option<DisarmReason> {
        let before = std::mem::replace(&mut self.bumpers, pressed);
        let begins = pressed
            .iter()
            .zip(before)
            .any(|(&now, before)| now && !before);
        begins.then_some(DisarmReason::Bumper)
    }

    /// Takes the volts of the battery.
    pub fn battery(&mut self, now: Duration, volts: f32) -> Option<DisarmReason> {
        if volts >= self.config.low_volts {
            self.low_since = None;
            return None;
        }
        let since = *self.low_since.get_or_insert(now);
        (now.saturating_sub(since) >= self.config.low_for).then_some(DisarmReason::Battery)
    }

    /// Whether the robot has said too long nothing; once, until it speaks again.
    pub fn silence(&mut self, now: Duration) -> Option<DisarmReason> {
        let heard = self.heard?;
        if now.saturating_sub(heard) < self.config.silence {
            return None;
        }
        self.heard = None;
        Some(DisarmReason::Silence)
    }

    /// When the silence will have lasted too long, if nothing is said until then.
    #[must_use]
    pub fn deadline(&self) -> Option<Duration> {
        self.heard.map(|heard| heard + self.config.silence)
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

    /// Runs at `speed` from `from` to `to` (ms), 10 ms a reading; when and why it was to be disarmed first.
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

    fn told(forward: f64) -> Plausible {
        let mut plausible = Plausible::new(PlausibleConfig::default());
        plausible.ordered(&Order::Command(Command::Velocity { forward, turn: 0.0 }));
        plausible
    }

    #[test]
    fn a_robot_that_does_as_told_is_left_alone() {
        assert_eq!(run(&mut told(0.2), 0.2, 0, 10_000), None);
        assert_eq!(run(&mut told(0.0), 0.0, 0, 10_000), None);
        // Slows down for half a second after a stop.
        let mut stopped = told(0.0);
        assert_eq!(run(&mut stopped, 0.15, 0, 500), None);
        assert_eq!(run(&mut stopped, 0.0, 500, 10_000), None);
    }

    #[test]
    fn a_blocked_robot_is_a_stall_after_its_patience() {
        let (millis, reason) = run(&mut told(0.2), 0.0, 0, 10_000).unwrap();
        assert_eq!(reason, DisarmReason::Stall);
        assert!((1500..=2000).contains(&millis), "{millis}");
    }

    #[test]
    fn a_robot_that_runs_untold_is_a_runaway() {
        let (millis, reason) = run(&mut told(0.0), 0.1, 0, 10_000).unwrap();
        assert_eq!(reason, DisarmReason::Runaway);
        assert!((1000..=1500).contains(&millis), "{millis}");
    }

    #[test]
    fn a_leg_is_not_judged() {
        let mut plausible = Plausible::new(PlausibleConfig::default());
        plausible.ordered(&Order::Command(Command::Forward(1.0)));
        assert_eq!(run(&mut plausible, 0.0, 0, 5000), None);
        assert_eq!(run(&mut plausible, 0.3, 5000, 9000), None);
    }

    #[test]
    fn a_bumper_counts_when_it_begins_to_be_pressed() {
        let mut plausible = Plausible::new(PlausibleConfig::default());
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
        let mut plausible = Plausible::new(PlausibleConfig::default());
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
    fn silence_is_told_once() {
        let mut plausible = told(0.0);
        assert_eq!(plausible.silence(at(9000)), None, "it never spoke");
        run(&mut plausible, 0.0, 0, 100);
        assert_eq!(plausible.deadline(), Some(at(600)));
        assert_eq!(plausible.silence(at(599)), None);
        assert_eq!(plausible.silence(at(600)), Some(DisarmReason::Silence));
        assert_eq!(plausible.silence(at(700)), None);
    }
}

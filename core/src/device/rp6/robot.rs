//! An RP6 that answers: what is remembered of it until its link is lost.

use crate::robot::Stamp;
use crate::wire::ClockMap;
use crate::wire::rp6::{self, Hello, Odometer, Report, Telemetry};

use super::partial_scans::PartialScans;
use super::sweeps::Sweeps;

/// Pause in orders to move before one counts, if some arrived before the robot was up, s.
const CALM: f64 = 0.3;

/// Telemetry this long after a manoeuvre was acknowledged was measured after it began, s.
const BEGUN: f64 = 0.1;
/// A manoeuvre that does not show in the telemetry this long after its order never will, s.
const NEVER: f64 = 1.0;

/// A robot that answers.
#[derive(Debug)]
pub(super) struct Robot {
    pub(super) odometer: Odometer,
    pub(super) motion: Motion,
    /// Since when the robot is known to have received the manoeuvre.
    pub(super) manoeuvre_acknowledged: Option<Stamp>,
    /// Start of the pause in orders to move, and whether it has been long enough.
    pub(super) calm_since: Stamp,
    pub(super) is_calm: bool,
    pub(super) last_alive: Stamp,
    pub(super) last_reported: Stamp,
    pub(super) bumpers: [bool; 2],
    /// The last command that needs an acknowledgement, and when it was given.
    pub(super) asked: Option<(rp6::Command, Stamp)>,
    /// Time of the last telemetry by the robot's clock: wrapped and not.
    pub(super) time: (u32, Stamp),
    pub(super) clock: ClockMap,
    /// End of the last odometry on the bridge's clock.
    pub(super) last_end: Option<Stamp>,
    /// None if it has no rangers.
    pub(super) sweeps: Option<Sweeps>,
    pub(super) partial_scans: PartialScans,
}

/// What the robot was commanded to do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Motion {
    None,
    /// At a speed, ordered at this time.
    Speed(Stamp),
    /// A distance, an angle or a sweep, ordered at this time.
    Manoeuvre(Stamp),
}

impl Robot {
    /// A robot that just said hello; `ordered` is the time of the last order to move.
    pub(super) fn new(
        hello: &Hello,
        sweeps: Option<Sweeps>,
        now: Stamp,
        ordered: Option<Stamp>,
    ) -> Self {
        Self {
            odometer: Odometer::new(&hello.model()),
            motion: Motion::None,
            manoeuvre_acknowledged: None,
            calm_since: ordered.unwrap_or(now),
            is_calm: ordered.is_none_or(|at| now.since(at) >= CALM),
            last_alive: now,
            last_reported: Stamp(0),
            bumpers: [false; 2],
            asked: None,
            time: (0, Stamp(0)),
            clock: ClockMap::new(telemetry_delay()),
            last_end: None,
            sweeps,
            partial_scans: PartialScans::default(),
        }
    }

    /// Converts the robot's time `millis`, which is near that of its last telemetry and wraps after
    /// 49 days, to the bridge's clock.
    pub(super) fn host_time(&self, millis: u32) -> Option<Stamp> {
        let (of_telemetry, stamp) = self.time;
        let later = millis.wrapping_sub(of_telemetry).cast_signed();
        let stamp = Stamp(stamp.0.saturating_add_signed(1000 * i64::from(later)));
        self.clock.host_time(stamp)
    }

    /// Whether telemetry of a standing robot means that its manoeuvre is over.
    pub(super) fn may_be_done(&self, now: Stamp) -> bool {
        let is_long_ago = |since: Stamp, seconds| now.since(since) > seconds;
        match self.motion {
            Motion::Manoeuvre(given) => {
                self.manoeuvre_acknowledged
                    .is_some_and(|since| is_long_ago(since, BEGUN))
                    || is_long_ago(given, NEVER)
            }
            _ => false,
        }
    }

    /// Whether an order to move counts: it does not if it was being repeated all along while the
    /// robot came back.
    pub(super) fn may_move(&mut self, now: Stamp) -> bool {
        self.is_calm |= now.since(self.calm_since) >= CALM;
        if !self.is_calm {
            self.calm_since = now;
        }
        self.is_calm
    }
}

/// Seconds that a telemetry frame takes on the line: ten bits a byte.
fn telemetry_delay() -> f64 {
    let bytes = rp6::encode(0, &Report::Telemetry(Telemetry::default())).len();
    10.0 * bytes as f64 / f64::from(super::Rp6::BAUD_RATE)
}

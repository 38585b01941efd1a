//! Going home by itself: what a bridge that maps may do when the link to the driver is lost or the
//! battery gets low, if this was allowed beforehand.
//!
//! In: the bridge's reports on driver and robot, and the pose in its map. Out: the robot driven to
//! where it was armed, by the right that was given for it; or, in words, why it stays.
//!
//! 1. Home is where the robot stood when a driver armed it, if its pose was certain then.
//! 2. The link is lost if a driver's connection ends, or if the driver falls silent. A battery is
//!    low if it stays below its limit. Everything else that disarms is meant to stop the robot.
//! 3. The robot drives only through space known to be free, in safe mode, by the rules that bind
//!    every driver. Any doubt ends it: an uncertain pose, a path through unseen space, an obstacle,
//!    a robot that makes no progress. There is no second try until a driver has armed the robot
//!    again.
//! 4. A stop by anybody ends it, and so does a bumper: they disarm, and nothing here arms after
//!    that.

use nalgebra::Point2;

use super::{Live, Note, pose_state};
use crate::geom::{Length, PoseEstimate};
use crate::map::{CellState, Grid};
use crate::pilot::{Mode, Status};
use crate::plan::Path;
use crate::wire::message::{DisarmReason, PoseState, SafetyBody, Severity};

/// When a robot goes home by itself, and how sure it must be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HomingConfig {
    /// Whether it does when the link to its driver is lost. Default no: it holds.
    pub on_link_loss: bool,
    /// Whether it does when its battery gets low. Default no.
    pub on_low_battery: bool,
    /// A battery below it is low, V. Default 6.6: well above the 6.0 at which the bridge stops an
    /// RP6 whatever happens.
    pub low_volts: f32,
    /// Greatest standard deviation of the place, m. Default 0.3: about a robot's width.
    pub sigma: f64,
    /// Greatest standard deviation of the heading, rad. Default 0.2.
    pub turn_sigma: f64,
    /// A robot that came no further for so long gives up, s. Default 10.
    pub patience: f64,
    /// However far it is, it gives up after so long, s. Default 600.
    pub longest: f64,
}

impl Default for HomingConfig {
    fn default() -> Self {
        Self {
            on_link_loss: false,
            on_low_battery: false,
            low_volts: 6.6,
            sigma: 0.3,
            turn_sigma: 0.2,
            patience: 10.0,
            longest: 600.0,
        }
    }
}

/// Within this distance it is at home, m.
const AT_HOME: f64 = 0.3;
/// A battery must stay low for this long, µs; a dip under load does not count.
const LOW_FOR: u64 = 2_000_000;
/// The bridge answers within this time, µs, or does not allow the robot to be armed.
const ANSWER: u64 = 2_000_000;
/// A robot that moved less than this has made no progress, m.
const NO_FURTHER: f64 = 0.1;
/// Distance between the checked places of a path, m.
const STEP: f64 = 0.05;

/// Why it goes home.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Cause {
    LinkLoss,
    LowBattery,
}

impl Cause {
    fn words(self) -> &'static str {
        match self {
            Self::LinkLoss => "The link to the driver was lost",
            Self::LowBattery => "The battery is low",
        }
    }
}

/// Why it does not go home, or stops on the way.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
enum Doubt {
    #[error("nobody gave it a right to drive by itself, or that was taken away")]
    NoRight,
    #[error("its pose was not sure when it was armed, so that it does not know where home is")]
    NoHome,
    #[error("its pose is {}", .0.name())]
    Pose(PoseState),
    #[error("its pose is not sure: by {place:.2} m and {turn:.2} rad")]
    Unsure { place: f64, turn: f64 },
    #[error("the way leads through what it never saw")]
    Unseen,
    #[error("it finds no way: {0}")]
    NoWay(String),
    #[error("it comes no further: something is in the way")]
    Stands,
    #[error("it took too long")]
    TooLong,
    #[error("the bridge does not let it drive")]
    NotArmed,
    #[error("it was stopped ({0})")]
    Stopped(DisarmReason),
}

#[derive(Clone, Copy, Debug, Default)]
enum State {
    #[default]
    Idle,
    /// The lease has been requested.
    Asked { since: u64, cause: Cause },
    Under {
        since: u64,
        /// Where it was when it last made progress, and when.
        at: Point2<f64>,
        came: u64,
    },
}

/// See the module.
#[derive(Clone, Debug)]
pub struct Homing {
    pub(super) config: HomingConfig,
    home: Option<Point2<f64>>,
    /// Whether the robot was being moved by somebody else's commands at the last check.
    was_driven: bool,
    low_since: Option<u64>,
    /// Whether it was tried since a driver last armed the robot.
    is_spent: bool,
    state: State,
}

impl Homing {
    /// Begins to watch.
    #[must_use]
    pub fn new(config: HomingConfig) -> Self {
        Self {
            config,
            home: None,
            was_driven: false,
            low_since: None,
            is_spent: false,
            state: State::Idle,
        }
    }

    /// To be called every 50 ms, before [`Live::tick`]; returns a message for people.
    pub fn step(&mut self, now: u64, live: &mut Live) -> Option<Note> {
        let safety = live.client().safety().cloned()?;
        let cause = self.watch(now, &safety, live);
        match self.state {
            State::Idle => self.begin(now, cause?, live),
            State::Asked { since, cause } => self.asked(now, since, cause, &safety, live),
            State::Under { since, at, came } => self.under_way(now, [since, came], at, live),
        }
    }

    /// Whether there is a reason to go home; also remembers where home is.
    fn watch(&mut self, now: u64, safety: &SafetyBody, live: &Live) -> Option<Cause> {
        let is_own = safety.driver.is_some() && safety.driver == live.client().number();
        let is_driven = safety.armed && !is_own;
        let was_driven = std::mem::replace(&mut self.was_driven, is_driven);
        if is_driven && !was_driven {
            self.is_spent = false;
            let estimate = live.session().estimate();
            let is_sure = self.doubt_of(&estimate, live).is_none();
            self.home = is_sure.then(|| estimate.pose.position());
        }
        let is_low = live
            .battery
            .is_some_and(|volts| volts < self.config.low_volts);
        let since = is_low.then(|| self.low_since.unwrap_or(now));
        self.low_since = since.filter(|_| is_driven);
        let is_lost = was_driven
            && !safety.armed
            && matches!(
                safety.reason,
                DisarmReason::DriverGone | DisarmReason::LeaseExpired
            );
        let has_been_low = self.low_since.is_some_and(|since| now >= since + LOW_FOR);
        let cause = match () {
            () if self.is_spent => None,
            () if self.config.on_link_loss && is_lost => Some(Cause::LinkLoss),
            () if self.config.on_low_battery && has_been_low => Some(Cause::LowBattery),
            () => None,
        };
        self.is_spent |= cause.is_some();
        cause
    }

    fn begin(&mut self, now: u64, cause: Cause, live: &mut Live) -> Option<Note> {
        let estimate = live.session().estimate();
        let doubt = match self.home {
            _ if !live.client().may_drive() => Some(Doubt::NoRight),
            None => Some(Doubt::NoHome),
            Some(_) => self.doubt_of(&estimate, live),
        };
        if let Some(doubt) = doubt {
            let text = format!("{}, and the robot stays: {doubt}.", cause.words());
            return Some(note(Severity::Warning, text));
        }
        let home = self.home?;
        if (estimate.pose.position() - home).length() < AT_HOME {
            let text = format!(
                "{}; the robot is at home already, and stays.",
                cause.words()
            );
            return Some(note(Severity::Info, text));
        }
        live.take_lease(now, cause == Cause::LowBattery);
        self.state = State::Asked { since: now, cause };
        None
    }

    fn asked(
        &mut self,
        now: u64,
        since: u64,
        cause: Cause,
        safety: &SafetyBody,
        live: &mut Live,
    ) -> Option<Note> {
        if live.client().is_armed() {
            let Some(home) = self.home else {
                return self.give_up(now, &Doubt::NoHome, live);
            };
            live.set_mode(Mode::GoTo(home));
            let at = live.session().estimate().pose.position();
            self.state = State::Under {
                since: now,
                at,
                came: now,
            };
            let text = format!(
                "{}: the robot goes home, to where it was armed. Stop stops it.",
                cause.words()
            );
            return Some(note(Severity::Warning, text));
        }
        if matches!(
            safety.reason,
            DisarmReason::Stop | DisarmReason::EmergencyStop
        ) {
            return self.give_up(now, &Doubt::Stopped(safety.reason), live);
        }
        let is_late = now > since + ANSWER;
        is_late.then(|| self.give_up(now, &Doubt::NotArmed, live))?
    }

    fn under_way(
        &mut self,
        now: u64,
        [since, came]: [u64; 2],
        at: Point2<f64>,
        live: &mut Live,
    ) -> Option<Note> {
        if !live.client().is_armed() {
            let reason = live.client().safety().map(|safety| safety.reason);
            return self.give_up(now, &Doubt::Stopped(reason.unwrap_or_default()), live);
        }
        let estimate = live.session().estimate();
        let is_home = matches!(live.session().status(), Status::Finished(_));
        if is_home {
            live.release_lease(now);
            self.state = State::Idle;
            return Some(note(Severity::Info, "The robot is at home.".to_owned()));
        }
        let (here, micros) = (estimate.pose.position(), |seconds: f64| {
            (1e6 * seconds) as u64
        });
        let has_moved = (here - at).length() > NO_FURTHER;
        if has_moved {
            self.state = State::Under {
                since,
                at: here,
                came: now,
            };
        }
        let status = live.session().status();
        let doubt = self.doubt_of(&estimate, live).or_else(|| match status {
            Status::Failed(failure) => Some(Doubt::NoWay(failure.to_string())),
            _ if is_unseen(live) => Some(Doubt::Unseen),
            _ if now > since + micros(self.config.longest) => Some(Doubt::TooLong),
            _ if !has_moved && now > came + micros(self.config.patience) => Some(Doubt::Stands),
            _ => None,
        });
        doubt.and_then(|doubt| self.give_up(now, &doubt, live))
    }

    /// Stops the robot if it is armed, and gives the lease back.
    fn give_up(&mut self, now: u64, doubt: &Doubt, live: &mut Live) -> Option<Note> {
        if live.client().is_armed() {
            live.stop(now);
        }
        live.release_lease(now);
        let text = match std::mem::take(&mut self.state) {
            // Nobody was told that it would.
            State::Asked { cause, .. } => {
                format!("{}, and the robot stays: {doubt}.", cause.words())
            }
            State::Idle | State::Under { .. } => format!("The robot does not go home: {doubt}."),
        };
        Some(note(Severity::Warning, text))
    }

    /// The reason not to drive by this pose, if there is one.
    fn doubt_of(&self, estimate: &PoseEstimate, live: &Live) -> Option<Doubt> {
        let state = pose_state::of(live.session().slam());
        if state != PoseState::Localised {
            return Some(Doubt::Pose(state));
        }
        let variance = estimate.cov[(0, 0)].max(estimate.cov[(1, 1)]);
        let (place, turn) = (variance.sqrt(), estimate.cov[(2, 2)].sqrt());
        // A variance that is NaN does not make a certain pose either.
        let is_sure = place <= self.config.sigma && turn <= self.config.turn_sigma;
        (!is_sure).then_some(Doubt::Unsure { place, turn })
    }
}

fn note(severity: Severity, text: String) -> Note {
    Note { severity, text }
}

/// Whether the planned path leads through space that is not known to be free.
fn is_unseen(live: &Live) -> bool {
    let session = live.session();
    let route = session.pilot().route();
    route.is_some_and(|route| !is_known(&route.path, session.slam().grid()))
}

fn is_known(path: &Path, grid: &Grid) -> bool {
    path.legs().all(|leg| {
        let steps = (leg.length() / STEP).ceil().max(1.0);
        (0..=steps as u32).all(|step| {
            let at = leg.a + leg.vector() * (f64::from(step) / steps);
            grid.state(grid.cell_at(at)) != CellState::Unknown
        })
    })
}

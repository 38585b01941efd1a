//! The whole loop over a bridge: what robot and sensors say feeds [`crate::slam::Slam`], and what [`crate::pilot::Pilot`] decides goes back to the robot.
//!
//! ```text
//!   bridge ── messages ──> Client ── odometry, scans ──> Timeline ──> Slam ── estimate, grid ──> Pilot ──┐
//!          <── messages ──        <──────────────────────────── commands ──────────────────────────────┘
//! ```
//!
//! 1. The bridge's hello names the robot; estimate and map begin with it. A robot in a new connection goes on in the old map.
//! 2. [`Live::receive`] takes a message, [`Live::tick`] lets the pilot decide; both say what to send by
//!    [`Live::take_outgoing`]. Time is µs of the caller's clock.
//! 3. The pilot's commands go out only while this client has the lease and the robot is armed. Whatever disarms it also ends
//!    the pilot's errand: nothing goes on by itself when the robot is armed again.

mod shown;
mod state;
#[cfg(test)]
mod tests;

use crate::pilot::Mode;
use crate::robot::{Bumpers, ToldOdometry};
use crate::slam::{Method, PriorMap, SlamError};
use crate::twin::Twin;
use crate::wire::client::{Client, ClientError};
use crate::wire::message::{
    Device, FromBridge, RecordingBody, RefusalReason, RobotFigures, Severity,
};
use crate::wire::timeline::{Reading, explain_gap};
use state::State;

/// How often [`Live::tick`] is due: the pilot decides, and a command is told again, s.
pub const TICK_PERIOD: f64 = 0.05;

/// Something for a person to read.
#[derive(Clone, Debug, PartialEq)]
pub struct Note {
    /// How grave it is.
    pub severity: Severity,
    /// In a sentence.
    pub text: String,
}

/// What a session with a bridge begins with.
#[derive(Clone, Debug)]
pub struct LiveConfig {
    /// How others see this client.
    pub name: String,
    /// The right to drive; none to watch.
    pub token: Option<String>,
    /// How the pose is estimated.
    pub method: Method,
    /// The map that [`Method::PriorMap`] finds the robot in, placed by where the robot is when the bridge names it; without one the
    /// line filter draws its own.
    pub known: Option<PriorMap>,
    /// Of the planner's random numbers.
    pub seed: u64,
}

/// A robot behind a bridge that is mapped and driven from here.
#[derive(Debug)]
pub struct Live {
    config: LiveConfig,
    client: Client,
    /// Estimate and intention; begins anew with the bridge's hello.
    state: State,
    /// How often it did.
    begun: u32,
    notes: Vec<Note>,
    devices: Vec<Device>,
    recording: Option<RecordingBody>,
    battery: Option<f32>,
    dropped: u64,
    watchers: u16,
    /// Arm as soon as the lease is granted.
    wants_to_arm: bool,
}

impl Live {
    /// A session that has not heard anything yet.
    ///
    /// # Errors    [`SlamError`] naming the first setting out of range.
    pub fn new(config: LiveConfig) -> Result<Self, SlamError> {
        Ok(Self {
            client: Client::new(&config.name, config.token.as_deref()),
            state: State::new(&config, None)?,
            config,
            begun: 0,
            notes: vec![],
            devices: vec![],
            recording: None,
            battery: None,
            dropped: 0,
            watchers: 0,
            wants_to_arm: false,
        })
    }

    /// The connection ended and another begins: map and pose stay, the right to drive does not.
    pub fn reconnect(&mut self) {
        self.client = Client::new(&self.config.name, self.config.token.as_deref());
        self.end_errand();
    }

    /// Takes one binary message of the bridge that came at `now`.
    ///
    /// # Errors    [`ClientError`]: the connection is of no use any more; map and pose are kept.
    pub fn receive(&mut self, now: u64, bytes: &[u8]) -> Result<(), ClientError> {
        let was_armed = self.client.is_armed();
        let (header, message) = self.client.receive(now, bytes)?;
        self.take_in(now, header.micros, message);
        if was_armed && !self.client.is_armed() {
            self.end_errand();
        }
        Ok(())
    }

    fn take_in(&mut self, now: u64, arrived: u64, message: FromBridge) {
        match message {
            FromBridge::Hello(hello) => self.begin(hello.robot),
            FromBridge::Odometry(body) => match body.odometry() {
                Ok(odometry) => {
                    self.feed(|state| state.timeline.odometry(body.source, arrived, odometry))
                }
                Err(error) => self.note(Severity::Warning, error.to_string()),
            },
            FromBridge::Scan(body) => {
                let source = body.source;
                match body.scan() {
                    Ok(scan) => self.feed(|state| {
                        let has_robot = state.figures.is_some();
                        state.timeline.scan(source, arrived, scan, has_robot)
                    }),
                    Err(error) => self.note(Severity::Warning, error.to_string()),
                }
            }
            FromBridge::Bumpers(body) => {
                self.state.bumpers = Bumpers {
                    left: body.left,
                    right: body.right,
                };
            }
            FromBridge::Battery(body) => self.battery = Some(body.volts),
            FromBridge::Devices(devices) => self.devices = devices,
            FromBridge::Recording(recording) => self.recording = Some(recording),
            FromBridge::Heartbeat(beat) => {
                (self.dropped, self.watchers) = (beat.dropped, beat.clients);
            }
            FromBridge::Notice(event) => self.note(event.severity, event.text),
            FromBridge::Refused(reason) => self.refused(reason),
            FromBridge::Granted(_) if std::mem::take(&mut self.wants_to_arm) => {
                self.client.arm(now);
            }
            _ => (),
        }
    }

    /// Begins with this robot, or goes on with it.
    fn begin(&mut self, figures: Option<RobotFigures>) {
        if self.begun > 0 && self.state.figures == figures {
            return;
        }
        match State::new(&self.config, figures) {
            Ok(fresh) => {
                let told = self.state.told;
                self.state = State { told, ..fresh };
            }
            Err(error) => self.note(Severity::Error, error.to_string()),
        }
        self.begun += 1;
    }

    /// Hands on what the timeline lets through.
    fn feed(&mut self, through: impl FnOnce(&mut State) -> Vec<Reading>) {
        for reading in through(&mut self.state) {
            let taken = match reading {
                Reading::Odometry(odometry) => self.state.odometry(&odometry),
                Reading::Scan(scan) => self.state.scan(&scan),
                Reading::Gap { seconds } => {
                    self.state.drive.gap();
                    let text = explain_gap(seconds);
                    self.notes.push(Note {
                        severity: Severity::Warning,
                        text,
                    });
                    Ok(())
                }
            };
            if let Err(error) = taken {
                let text = format!("A reading was left out: {error}");
                self.notes.push(Note {
                    severity: Severity::Warning,
                    text,
                });
            }
        }
    }

    fn refused(&mut self, reason: RefusalReason) {
        self.wants_to_arm = false;
        let text = match reason {
            RefusalReason::NoRight => "Only whoever has the bridge's token may drive",
            RefusalReason::Held => "Somebody else drives; take over to stop the robot and drive it",
            RefusalReason::Emergency => "The emergency stop is latched; reset it first",
            RefusalReason::NoRobot => {
                "The robot's link is down: it cannot be armed, nor its emergency stop reset"
            }
            RefusalReason::TooOld | RefusalReason::FromTheFuture => {
                "A command came too late and was left out: the network is slow"
            }
            // The bridge has said by then why the lease or the arming ended.
            _ => return,
        };
        self.note(Severity::Warning, text.to_owned());
    }

    fn note(&mut self, severity: Severity, text: String) {
        self.notes.push(Note { severity, text });
    }

    /// Nothing is under way any more, an arming that waits for its lease neither: it would come after the Stop.
    fn end_errand(&mut self) {
        self.wants_to_arm = false;
        let state = &mut self.state;
        state.pilot.stop();
        state.is_told_to_stand = false;
        self.client.give_up_errand();
    }

    /// Due every [`TICK_PERIOD`]: heartbeats, and the pilot's decision where this client drives.
    ///
    /// # Errors    [`ClientError`]: the bridge is gone; map and pose are kept.
    pub fn tick(&mut self, now: u64) -> Result<(), ClientError> {
        self.client.tick(now)?;
        if !self.client.is_armed() {
            return Ok(());
        }
        if let Some(command) = self.state.decide(self.client.is_busy()) {
            self.client.drive(now, command.into());
        } else if self.client.is_busy() {
            self.client.hold(now);
        }
        Ok(())
    }

    /// Messages to send, in order; they are forgotten here.
    pub fn take_outgoing(&mut self) -> Vec<Vec<u8>> {
        self.client.take_outgoing()
    }

    /// What a person should read, in order; it is forgotten here.
    pub fn take_notes(&mut self) -> Vec<Note> {
        std::mem::take(&mut self.notes)
    }

    /// Asks for the right to drive, and arms the robot with it, but where its motors are cut off: then the right to undo that is wanted.
    /// With `force` also from somebody else.
    pub fn take_wheel(&mut self, now: u64, force: bool) {
        if self.client.has_lease() {
            self.client.arm(now);
        } else {
            let is_cut_off = self.client.safety().is_some_and(|s| s.emergency);
            self.wants_to_arm = !is_cut_off;
            self.client.take(now, force);
        }
    }

    /// Gives the right to drive back; the robot stops.
    pub fn leave_wheel(&mut self, now: u64) {
        self.end_errand();
        self.client.release(now);
    }

    /// Another errand for the robot. It moves while armed only.
    pub fn set_mode(&mut self, mode: Mode) {
        self.state.pilot.set_mode(mode);
        self.client.give_up_errand();
    }

    /// By hand, with these parts of the robot's highest speeds, -1 to 1.
    pub fn drive(&mut self, forward: f64, turn: f64) {
        let model = self.state.model;
        let (forward, turn) = (forward * model.max_speed, turn * model.max_turn_rate);
        self.state.pilot.drive(forward, turn);
        self.client.give_up_errand();
    }

    /// Stops the robot and disarms it, whoever drives it.
    pub fn stop(&mut self, now: u64) {
        self.end_errand();
        self.client.stop(now);
    }

    /// Cuts the motors off, whoever drives.
    pub fn emergency_stop(&mut self, now: u64) {
        self.end_errand();
        self.client.emergency_stop(now);
    }

    /// Unlatches the emergency stop; the robot stays disarmed.
    pub fn reset_emergency_stop(&mut self, now: u64) {
        self.client.reset_emergency_stop(now);
    }

    /// From here on the odometry is that of a robot of which so much is known; what is fitted stays what it counts.
    pub fn tell_odometry(&mut self, told: ToldOdometry) {
        self.state.told = told;
    }

    /// From here on a twin with these figures runs beside the robot; none: no longer.
    pub fn set_twin(&mut self, told: Option<ToldOdometry>) {
        let state = &mut self.state;
        let (width, at) = (state.model.track_width, state.slam.estimate().pose);
        state.twin = told.map(|told| Twin::new(told, width, at));
    }
}

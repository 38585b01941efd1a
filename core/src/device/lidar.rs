//! What all turning lidars have in common: one [`Device`] on top of what is specific to each
//! ([`LidarProtocol`]).
//!
//! In: bytes of a line and the time. Out: scans, states and faults, as [`Want`]s.
//!
//! 1. The protocol reads the bytes, starts the sensor up if it needs that, and passes on single
//!    readings (`Output::take`).
//! 2. Readings become whole turns ([`revolution`]). Only a whole turn sets the sensor's state to
//!    [`DeviceState::Sending`] and ends a fault.
//! 3. Silence for `SILENCE` is a fault, and so is no whole turn for `LONGEST_TURN`. The protocol
//!    says which one it is and what helps, in its own words.

pub mod revolution;

use std::fmt;

use crate::device::line::{Device, Want};
use crate::device::report::Report;
use crate::device::source::{Order, Profile, SourceEvent};
use crate::geom::Pose2;
use crate::robot::Stamp;
use crate::wire::Tally;
use crate::wire::message::{DeviceState, LinkState};

use revolution::{Figures, Revolutions, Sample};

/// Longest time without data, s. These sensors send some hundred pieces a second.
pub(super) const SILENCE: f64 = 1.0;
/// Longest time without a whole turn, s. The slowest of these sensors turns at 1 Hz, and a motor
/// needs about 2 s after power-on.
pub(super) const LONGEST_TURN: f64 = 3.0;

/// What is specific to a lidar: how it is started up, and what its bytes mean.
pub trait LidarProtocol: fmt::Debug + Send + 'static {
    /// Baud rate of its line.
    const BAUD_RATE: u32;

    /// Range and σ of the sensor, from its data sheet.
    const FIGURES: Figures;

    /// The line was opened: the protocol forgets all that it knew of the sensor.
    fn opened(&mut self, output: &mut Output, now: Stamp);

    /// Takes bytes as they arrive.
    fn receive(&mut self, bytes: &[u8], output: &mut Output, now: Stamp);

    /// Called with the current time, at least every 50 ms.
    fn tick(&mut self, output: &mut Output, now: Stamp);

    /// Stops the sensor, if it can be stopped: the line is about to be closed.
    fn close(&mut self, _output: &mut Output, _now: Stamp) {}

    /// Counts of the bytes since the line was opened.
    fn tally(&self) -> Tally;
}

/// A turning lidar at the other end of a line.
#[derive(Debug)]
pub struct Lidar<P> {
    name: String,
    protocol: P,
    output: Output,
}

impl<P: LidarProtocol> Lidar<P> {
    /// A lidar called `name`, as on the command line, mounted on the robot at this pose.
    #[must_use]
    pub fn new(name: impl Into<String>, protocol: P, robot_from_sensor: Pose2) -> Self {
        Self {
            name: name.into(),
            protocol,
            output: Output::new(P::FIGURES, robot_from_sensor),
        }
    }
}

impl<P: LidarProtocol> Device for Lidar<P> {
    fn profile(&self) -> Profile {
        Profile::of_sensor(&self.name)
    }

    fn baud_rate(&self) -> u32 {
        P::BAUD_RATE
    }

    fn opened(&mut self, now: Stamp) {
        self.output.opened(now);
        self.protocol.opened(&mut self.output, now);
    }

    fn receive(&mut self, bytes: &[u8], now: Stamp) {
        self.protocol.receive(bytes, &mut self.output, now);
    }

    fn order(&mut self, _: Order, _: Stamp) {
        // It is not a robot and takes no orders.
    }

    fn tick(&mut self, now: Stamp) {
        self.protocol.tick(&mut self.output, now);
        self.output.report.count(self.protocol.tally());
        self.output.report.link_now_and_then(now);
    }

    fn close(&mut self, now: Stamp) {
        self.protocol.close(&mut self.output, now);
    }

    fn broken(&mut self, why: String) {
        self.output.report.broken(why);
    }

    fn next_want(&mut self) -> Option<Want> {
        self.output.report.next_want()
    }
}

/// Output of a lidar: what it wants done, its state, and its turns.
#[derive(Debug)]
pub struct Output {
    revolutions: Revolutions,
    pub(super) report: Report,
    state: DeviceState,
    /// A warning that stays true while the sensor works.
    warning: String,
    /// When data last arrived.
    heard: Stamp,
    /// When the last whole turn ended, or waiting for one began.
    turned: Stamp,
}

impl Output {
    fn new(figures: Figures, robot_from_sensor: Pose2) -> Self {
        Self {
            revolutions: Revolutions::new(figures, robot_from_sensor),
            report: Report::default(),
            state: DeviceState::Waiting,
            warning: String::new(),
            heard: Stamp(0),
            turned: Stamp(0),
        }
    }

    /// Keeps the state last reported until there is a new one: otherwise a sensor in fault whose
    /// line is opened again and again would change state all the time.
    fn opened(&mut self, now: Stamp) {
        self.report.reopened();
        self.report.detail.clear();
        self.warning.clear();
        self.state = DeviceState::Waiting;
        self.report.change_link(LinkState::Opening);
        self.heard(now);
        self.watch(now);
    }

    /// The sensor works, but not as well as it should.
    pub(super) fn warn(&mut self, warning: String) {
        self.report.detail.clone_from(&warning);
        self.warning = warning;
        self.tell();
    }

    /// Changes the state.
    pub(super) fn enter(&mut self, state: DeviceState) {
        if self.state != state {
            self.state = state;
            self.tell();
        }
    }

    /// The sensor does not work; the fault names cause and cure.
    pub(super) fn fail(&mut self, fault: &dyn fmt::Display) {
        self.report.detail = fault.to_string();
        self.state = DeviceState::Fault;
        self.tell();
    }

    /// The sensor's state.
    pub(super) fn state(&self) -> DeviceState {
        self.state
    }

    /// Data arrived.
    pub(super) fn heard(&mut self, now: Stamp) {
        self.heard = now;
    }

    /// Starts waiting for a whole turn; parts of the turn before do not belong to it.
    pub(super) fn watch(&mut self, now: Stamp) {
        self.revolutions.restart();
        self.turned = now;
    }

    /// Whether no data has arrived for too long.
    pub(super) fn is_silent(&self, now: Stamp) -> bool {
        now.since(self.heard) > SILENCE
    }

    /// Whether no whole turn has arrived for too long.
    pub(super) fn does_not_turn(&self, now: Stamp) -> bool {
        now.since(self.turned) > LONGEST_TURN
    }

    /// Takes readings (angle in rad clockwise, range in m, quality) in the order in which they were
    /// taken, each `interval` seconds after the one before it, the last at `end` (s). Returns
    /// whether a turn ended with them.
    pub(super) fn take(
        &mut self,
        readings: impl ExactSizeIterator<Item = (f64, f64, Option<u8>)>,
        interval: f64,
        end: f64,
        now: Stamp,
    ) -> bool {
        let last = readings.len().saturating_sub(1);
        let mut has_turned = false;
        for (i, (angle, range, quality)) in readings.enumerate() {
            let sample = Sample {
                angle,
                range,
                quality,
                interval,
                stamp: Stamp::from_seconds(end - interval * (last - i) as f64),
            };
            let Some(scan) = self.revolutions.push(sample) else {
                continue;
            };
            has_turned = true;
            self.turned = now;
            self.report.detail.clone_from(&self.warning);
            self.enter(DeviceState::Sending);
            self.report.want(Want::Well);
            self.report.emit(SourceEvent::Scan(scan));
        }
        has_turned
    }

    fn tell(&mut self) {
        let link = match self.state {
            DeviceState::Connected | DeviceState::Measuring | DeviceState::Sending => LinkState::Up,
            DeviceState::Waiting | DeviceState::Fault => LinkState::Opening,
        };
        self.report.change(self.state, link);
    }
}

//! An RP6 as a source: its link ([`Link`]) on a line.
//!
//! 1. The link comes up disarmed, and the source arms it when an order to move arrives. An order
//!    that was already being repeated when the robot came back does not count: orders to move must
//!    first have paused for 0.3 seconds, before the robot came back or after.
//! 2. While the robot is under way, it gets a keep-alive ten times a second, for its own watchdog.
//!    The driver repeats speeds all the time; if none arrived for a quarter of a second, the source
//!    itself stops the robot.
//! 3. The robot's stamps are converted to the bridge's clock ([`crate::wire::ClockMap`]), which the
//!    scans of other devices use, too.
//! 4. Each sweep of its rangers becomes a scan, also on that clock. While the robot drives, it
//!    makes partial scans (`partial_scans`).
//! 5. An emergency stop is remembered while the robot does not answer, and given again when it
//!    comes back.

use crate::robot::{Command, Odometry, RobotModel, Scan, Stamp};
use crate::wire::message::{
    BatteryBody, BumpersBody, DeviceState, LinkState, RangerReading, RangersBody,
};
use crate::wire::rp6::Down;
use crate::wire::rp6::{self, Hello, Link, Phase, Ranger, Telemetry};

use crate::device::line::{Device, Want, Weight};
use crate::device::report::Report;
use crate::device::source::{Order, Profile, SourceEvent};

mod manoeuvre;
mod partial_scans;
mod robot;
mod sweeps;
#[cfg(test)]
mod tests;
pub mod words;

use robot::{Motion, Robot};
use sweeps::{Sweeps, Swept};

/// Interval of keep-alives, s.
const ALIVE: f64 = 0.1;
/// Seconds after which a speed that is not repeated is dropped and the robot stopped.
const FORGOTTEN: f64 = 0.25;
/// Interval of reports of what does not change, s.
const NOW_AND_THEN: f64 = 1.0;
/// Interval of telemetry, ms: half of the line's time.
const PERIOD_MILLIS: u16 = 20;

/// An RP6 at the other end of a line.
#[derive(Debug)]
pub struct Rp6 {
    name: String,
    link: Link,
    nonce: u8,
    report: Report,
    robot: Option<Robot>,
    /// When the last order to move arrived, whether or not a robot was there to take it.
    ordered: Option<Stamp>,
    /// Whether the boot loader was heard since the line was opened or the robot last answered.
    was_boot_loader: bool,
    is_cut_off: bool,
    /// As last reported.
    busy: Option<bool>,
}

impl Rp6 {
    /// Baud rate of its line.
    pub const BAUD_RATE: u32 = 38_400;

    /// A robot called `name`, as on the command line.
    #[must_use]
    pub fn new(name: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            link: Link::new(Stamp(0), 0),
            nonce: 0,
            report: Report::default(),
            robot: None,
            ordered: None,
            was_boot_loader: false,
            is_cut_off: false,
            busy: None,
        }
    }

    fn collect(&mut self, now: Stamp) {
        while let Some(event) = self.link.next_event() {
            match event {
                rp6::LinkEvent::Up(hello) => self.up(&hello, now),
                rp6::LinkEvent::Down(why) => self.down(why),
                rp6::LinkEvent::Telemetry(telemetry) => self.telemetry(&telemetry, now),
                rp6::LinkEvent::Ranger(ranger) => self.ranger(&ranger),
                rp6::LinkEvent::Acknowledged { command, .. } => self.acknowledged(command, now),
                rp6::LinkEvent::Dropped(command) => {
                    self.report
                        .note(Weight::Detail, format!("{command:?} given up"));
                }
            }
        }
        let output = self.link.take_output();
        if !output.is_empty() {
            self.report.write(output);
        }
        self.report_link(now);
    }

    fn up(&mut self, hello: &Hello, now: Stamp) {
        let [major, minor] = hello.firmware;
        self.report.model = format!("RP6, firmware {major}.{minor}");
        self.report.detail.clear();
        self.was_boot_loader = false;
        let sweeps = Sweeps::of(hello).unwrap_or_else(|error| {
            self.report
                .note(Weight::Error, format!("no scans of its rangers: {error}"));
            None
        });
        self.robot = Some(Robot::new(hello, sweeps, now, self.ordered));
        if self.is_cut_off {
            self.give(rp6::Command::EStop, now);
        }
        self.give(
            rp6::Command::SetRate {
                period_ms: PERIOD_MILLIS,
            },
            now,
        );
        self.report.want(Want::Well);
        self.state(DeviceState::Sending);
    }

    fn down(&mut self, why: Down) {
        self.robot = None;
        self.report_busy();
        self.report.detail = match why {
            Down::NobodyThere if self.was_boot_loader => words::NO_PROGRAM.into(),
            _ => words::cause_and_cure(why),
        };
        self.state(match why {
            Down::EmergencyShutdown | Down::NobodyThere | Down::OtherProtocol(_) => {
                DeviceState::Fault
            }
            _ => DeviceState::Waiting,
        });
    }

    fn telemetry(&mut self, telemetry: &Telemetry, now: Stamp) {
        let Some(robot) = &mut self.robot else {
            return;
        };
        let Some(odometry) = robot.odometer.update(telemetry) else {
            return;
        };
        robot.time = (telemetry.time_ms, odometry.to);
        robot.clock.observe(odometry.to, now);
        let Some(stamp) = robot.clock.host_time(odometry.to) else {
            return;
        };
        let odometry = Odometry {
            from: robot.last_end.unwrap_or(stamp),
            to: stamp,
            ..odometry
        };
        robot.last_end = Some(stamp);
        let sweeps = telemetry.state.sweeping() && !robot.partial_scans.moves;
        if robot.may_be_done(now) && !telemetry.state.moving() && !sweeps {
            robot.motion = Motion::None;
        }
        match odometry.validate() {
            Ok(()) => self.report.emit(SourceEvent::Odometry(odometry)),
            Err(error) => self.report.note(Weight::Warning, error.to_string()),
        }
        let (source, stamp) = (0, stamp.0);
        let is_due = now.since(robot.last_reported) >= NOW_AND_THEN;
        let state = telemetry.state;
        let [left, right] = [state.bumper_left(), state.bumper_right()];
        if std::mem::replace(&mut robot.bumpers, [left, right]) != [left, right] || is_due {
            self.report.emit(SourceEvent::Bumpers(BumpersBody {
                source,
                stamp,
                left,
                right,
            }));
        }
        if is_due {
            robot.last_reported = now;
            self.busy = None;
            let volts = telemetry.battery_volts() as f32;
            self.report.emit(SourceEvent::Battery(BatteryBody {
                source,
                stamp,
                volts,
            }));
        }
        self.fault(telemetry.fault);
        self.sweep(|sweeps| sweeps.telemetry(telemetry));
        self.continue_partial_scan(telemetry, now);
        // The end of a manoeuvre is reported after its scan.
        self.report_busy();
    }

    fn fault(&mut self, fault: rp6::Fault) {
        let detail = words::fault_and_cure(fault);
        if self.report.detail != detail {
            self.report.detail = detail.into();
            self.state(match fault {
                rp6::Fault::None => DeviceState::Sending,
                _ => DeviceState::Fault,
            });
        }
    }

    fn ranger(&mut self, ranger: &Ranger) {
        self.sweep(|sweeps| sweeps.reading(ranger));
        let stamp = self
            .robot
            .as_ref()
            .and_then(|robot| robot.host_time(ranger.time_ms));
        let Some(stamp) = stamp else {
            return;
        };
        let reading = RangerReading {
            index: ranger.index,
            servo: ranger.servo_angle() as f32,
            raw: ranger.adc,
        };
        self.report.emit(SourceEvent::Rangers(RangersBody {
            source: 0,
            stamp: stamp.0,
            readings: vec![reading],
        }));
    }

    /// Reports the sweep that `end` completes, if any.
    fn sweep(&mut self, end: impl FnOnce(&mut Sweeps) -> Option<Swept>) {
        let Some(robot) = &mut self.robot else {
            return;
        };
        let Some(swept) = robot.sweeps.as_mut().and_then(end) else {
            return;
        };
        let (mut scan, event): (Scan, fn(Scan) -> SourceEvent) = match swept {
            Swept::Scan(scan) => (scan, SourceEvent::Scan),
            Swept::PartialScan(scan) => (scan, SourceEvent::PartialScan),
        };
        let Some(stamp) = robot.host_time((scan.stamp.0 / 1000) as u32) else {
            return;
        };
        scan.stamp = stamp;
        match scan.validate() {
            Ok(()) => self.report.emit(event(scan)),
            Err(error) => self.report.note(Weight::Warning, error.to_string()),
        }
    }

    /// Gives a command to the link; if the link refuses it, the reason goes into the log.
    fn give(&mut self, command: rp6::Command, now: Stamp) {
        if command.is_reliable()
            && let Some(robot) = &mut self.robot
        {
            robot.asked = Some((command, now));
        }
        if let Err(error) = self.link.command(command, now) {
            self.report
                .note(Weight::Detail, format!("{command:?} not taken: {error}"));
        }
    }

    fn command(&mut self, command: &Command, now: Stamp) {
        let wire = match rp6::Command::try_from(command) {
            Ok(wire) => wire,
            Err(error) => {
                self.report
                    .note(Weight::Warning, format!("{error}; stopped"));
                rp6::Command::Stop
            }
        };
        if wire.moves() {
            self.ordered = Some(now);
        }
        let Some(robot) = &mut self.robot else {
            return;
        };
        if wire.moves() && !robot.may_move(now) {
            // If a manoeuvre were reported as over at once, it would be given again at once, and
            // orders would never pause.
            if !matches!(command, Command::Velocity { .. }) {
                (robot.motion, robot.manoeuvre_acknowledged) = (Motion::Manoeuvre(now), None);
            }
            return;
        }
        robot.motion = match command {
            _ if !wire.moves() && !matches!(wire, rp6::Command::Sweep { .. }) => Motion::None,
            Command::Velocity { .. } => Motion::Speed(now),
            _ => Motion::Manoeuvre(now),
        };
        robot.manoeuvre_acknowledged = None;
        robot.partial_scans.moves = wire.moves();
        if wire.moves() && !self.link.is_armed() && self.link.arm().is_err() {
            return;
        }
        self.give(wire, now);
    }

    fn state(&mut self, state: DeviceState) {
        let link = link_state(self.link.phase());
        self.report.change(state, link);
    }

    fn report_link(&mut self, now: Stamp) {
        self.report.count(self.link.tally());
        if self.link.phase() == Phase::BootLoader && !self.was_boot_loader {
            self.was_boot_loader = true;
            self.report.detail = words::BOOT_LOADER.into();
            self.state(DeviceState::Waiting);
        }
        let phase = link_state(self.link.phase());
        self.report.change_link(phase);
        self.report.link_now_and_then(now);
    }
}

impl Device for Rp6 {
    fn profile(&self) -> Profile {
        Profile {
            name: self.name.clone(),
            robot: Some(RobotModel::rp6()),
            takes_orders: true,
            scans_on_command: true,
        }
    }

    fn baud_rate(&self) -> u32 {
        Self::BAUD_RATE
    }

    fn opened(&mut self, now: Stamp) {
        // Orders that arrived without a line were forgotten: somebody may still be holding a key.
        self.ordered = Some(now);
        self.nonce = self.nonce.wrapping_add(16);
        self.link = Link::new(now, self.nonce);
        self.robot = None;
        self.was_boot_loader = false;
        self.report.reopened();
        self.report.detail.clear();
        self.state(DeviceState::Waiting);
    }

    fn receive(&mut self, bytes: &[u8], now: Stamp) {
        self.link.receive(bytes, now);
    }

    fn order(&mut self, order: Order, now: Stamp) {
        // What happened before the order is processed first: the robot may be gone.
        self.collect(now);
        match order {
            Order::Command(command) => self.command(&command, now),
            Order::EmergencyStop => {
                self.is_cut_off = true;
                if let Some(robot) = &mut self.robot {
                    robot.motion = Motion::None;
                }
                self.give(rp6::Command::EStop, now);
            }
            Order::ResetEmergencyStop => {
                self.is_cut_off = false;
                self.give(rp6::Command::Reset, now);
            }
        }
        self.busy = None;
        self.report_busy();
    }

    fn tick(&mut self, now: Stamp) {
        self.link.tick(now);
        self.collect(now);
        self.keep_alive(now);
        self.collect(now);
    }

    fn close(&mut self, now: Stamp) {
        self.give(rp6::Command::Stop, now);
        self.collect(now);
    }

    fn broken(&mut self, why: String) {
        self.robot = None;
        // The old link would count as up until it had been silent for long enough; an opened line
        // starts again anyway.
        self.link = Link::new(Stamp(0), self.nonce);
        self.report.broken(why);
    }

    fn next_want(&mut self) -> Option<Want> {
        self.report.next_want()
    }
}

fn link_state(phase: Phase) -> LinkState {
    match phase {
        Phase::Running => LinkState::Up,
        Phase::ResetNeeded => LinkState::ResetNeeded,
        Phase::Listening | Phase::BootLoader | Phase::Greeting => LinkState::Opening,
    }
}

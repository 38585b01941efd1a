//! An RP6 as a source: the link of `core` on a line.
//!
//! 1. The link comes up disarmed, and the source arms it when an order to move comes; but not one that was already being
//!    repeated when the robot came back: orders to move must have ceased for [`CALM`] seconds once.
//! 2. While the robot is under way, a sign of life goes to it ten times a second, for its own watchdog. Speeds are given
//!    anew all the time by whoever drives; where none came for [`FORGOTTEN`] seconds the source itself stops the robot.
//! 3. The robot's stamps are put on the bridge's clock ([`ClockMap`]), on which the scans of other devices are.
//! 4. An emergency stop is remembered while nobody answers, and given again to a robot that comes back.

use std::collections::VecDeque;
use std::time::Duration;

use slamlab_core::robot::{Command, Odometry, RobotModel, Stamp};
use slamlab_core::wire::message::{DeviceState, LinkState, RangerReading};
use slamlab_core::wire::rp6::{self, Hello, Link, LinkConfig, Odometer, Phase, Ranger, Telemetry};
use slamlab_core::wire::rp6::{Down, Report as Said};
use slamlab_core::wire::{ClockMap, Tally};

use super::device::{Device, Want};
use super::report::Report;
use crate::source::{Event, Order, Profile};

/// Seconds without an order to move before one counts, after the robot came up.
const CALM: f64 = 0.3;
/// Seconds between two signs of life.
const ALIVE: f64 = 0.1;
/// Seconds after which a speed that is not given anew is forgotten, and the robot stopped.
const FORGOTTEN: f64 = 0.5;
/// Seconds between two reports of what does not change.
const NOW_AND_THEN: f64 = 1.0;
/// From one telemetry to the next, ms: half of the line's time.
const PERIOD_MILLIS: u16 = 20;

/// An RP6 at the other end of a line.
#[derive(Debug)]
pub struct Rp6 {
    name: String,
    link: Link,
    nonce: u8,
    report: Report,
    robot: Option<Robot>,
    /// Whether the boot loader was heard since the line was opened or the robot last answered.
    was_boot_loader: bool,
    is_cut_off: bool,
    wants: VecDeque<Want>,
}

/// A robot that answers.
#[derive(Debug)]
struct Robot {
    odometer: Odometer,
    motion: Motion,
    /// Since when no order to move was refused, and whether that has been long enough.
    calm_since: Stamp,
    is_calm: bool,
    last_alive: Stamp,
    last_told: Stamp,
    bumpers: [bool; 2],
    /// The last command that is acknowledged, and when it was given.
    asked: Option<(rp6::Command, Stamp)>,
    /// Time of the last telemetry by the robot's clock: wrapped and not.
    time: (u32, Stamp),
    clock: ClockMap,
    /// End of the last odometry on the bridge's clock.
    last_end: Option<Stamp>,
}

/// What the robot was told to do.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Motion {
    None,
    /// At these speeds; given at this time.
    Speed(Stamp),
    /// Some way, angle or sweep; given at this time.
    Errand(Stamp),
}

impl Rp6 {
    /// Baud rate of its line.
    pub const BAUD_RATE: u32 = 38_400;

    /// A robot called `name`, as on the command line.
    #[must_use]
    pub fn new(name: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            link: Link::new(LinkConfig::default(), Stamp(0), 0),
            nonce: 0,
            report: Report::default(),
            robot: None,
            was_boot_loader: false,
            is_cut_off: false,
            wants: VecDeque::new(),
        }
    }

    fn collect(&mut self, now: Stamp) {
        while let Some(event) = self.link.next_event() {
            match event {
                rp6::Event::Up(hello) => self.up(&hello, now),
                rp6::Event::Down(why) => self.down(why),
                rp6::Event::Telemetry(telemetry) => self.telemetry(&telemetry, now),
                rp6::Event::Ranger(ranger) => self.ranger(&ranger),
                rp6::Event::Acknowledged { command, .. } => self.acknowledged(command, now),
                rp6::Event::Dropped(command) => {
                    tracing::debug!("{}: {command:?} given up", self.name)
                }
            }
        }
        let output = self.link.take_output();
        if !output.is_empty() {
            self.wants.push_back(Want::Write(output));
        }
        self.tell_link(now);
    }

    fn up(&mut self, hello: &Hello, now: Stamp) {
        let [major, minor] = hello.firmware;
        self.report.model = format!("RP6, firmware {major}.{minor}");
        self.report.detail.clear();
        self.was_boot_loader = false;
        self.robot = Some(Robot {
            odometer: Odometer::new(&hello.model()),
            motion: Motion::None,
            calm_since: now,
            is_calm: false,
            last_alive: now,
            last_told: Stamp(0),
            bumpers: [false; 2],
            asked: None,
            time: (0, Stamp(0)),
            clock: ClockMap::new(telemetry_delay()),
            last_end: None,
        });
        if self.is_cut_off {
            self.give(rp6::Command::EStop, now);
        }
        self.give(
            rp6::Command::SetRate {
                period_ms: PERIOD_MILLIS,
            },
            now,
        );
        self.wants.push_back(Want::Well);
        self.state(DeviceState::Sending);
    }

    fn down(&mut self, why: Down) {
        self.robot = None;
        self.report.detail = match why {
            Down::NobodyThere if self.was_boot_loader => {
                "the RP6's boot loader answers, but starts no program that does: flash slamlab's firmware".into()
            }
            _ => cause_and_cure(why),
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
        if let Motion::Errand(given) = robot.motion
            && now.since(given) > NOW_AND_THEN
            && !telemetry.state.moving()
            && !telemetry.state.sweeping()
        {
            robot.motion = Motion::None;
        }
        let [left, right] = [
            telemetry.state.bumper_left(),
            telemetry.state.bumper_right(),
        ];
        let is_due = now.since(robot.last_told) >= NOW_AND_THEN;
        let touches = (robot.bumpers != [left, right] || is_due).then_some(Event::Bumpers {
            stamp,
            left,
            right,
        });
        robot.bumpers = [left, right];
        let battery = is_due.then(|| Event::Battery {
            stamp,
            volts: telemetry.battery_volts() as f32,
        });
        if is_due {
            robot.last_told = now;
        }
        match odometry.validate() {
            Ok(()) => self.tell(Event::Odometry(odometry)),
            Err(error) => tracing::warn!("{}: {error}", self.name),
        }
        let events = touches.into_iter().chain(battery);
        self.wants.extend(events.map(Want::Tell));
        self.fault(telemetry.fault);
    }

    fn fault(&mut self, fault: rp6::Fault) {
        let detail = match fault {
            rp6::Fault::None => "",
            rp6::Fault::LeftEncoder => {
                "the left motor runs but its encoder is silent: track blocked, or cable off"
            }
            rp6::Fault::RightEncoder => {
                "the right motor runs but its encoder is silent: track blocked, or cable off"
            }
            rp6::Fault::Overcurrent => "a motor draws too much: something blocks the tracks",
            rp6::Fault::BatteryLow => "the battery is nearly empty: charge it",
            rp6::Fault::Other(_) => {
                "the robot reports a fault that this bridge does not know: update the bridge"
            }
        };
        if self.report.detail != detail {
            self.report.detail = detail.into();
            self.state(match fault {
                rp6::Fault::None => DeviceState::Sending,
                _ => DeviceState::Fault,
            });
        }
    }

    fn ranger(&mut self, ranger: &Ranger) {
        let Some(robot) = &self.robot else {
            return;
        };
        let (millis, stamp) = robot.time;
        // Readings lie a little before or after telemetry; the clock wraps after 49 days.
        let later = ranger.time_ms.wrapping_sub(millis).cast_signed();
        let stamp = Stamp(stamp.0.saturating_add_signed(1000 * i64::from(later)));
        let Some(stamp) = robot.clock.host_time(stamp) else {
            return;
        };
        let reading = RangerReading {
            index: ranger.index,
            servo: ranger.servo_angle() as f32,
            raw: ranger.adc,
        };
        self.tell(Event::Rangers {
            stamp,
            readings: vec![reading],
        });
    }

    fn acknowledged(&mut self, command: rp6::Command, now: Stamp) {
        let asked = self.robot.as_mut().and_then(|robot| robot.asked.take());
        if let Some((asked, given)) = asked
            && asked == command
        {
            self.report
                .set_round_trip(Duration::from_secs_f64(now.since(given).max(0.0)));
        }
    }

    /// Gives a command to the link; what it does not take has a reason that the log keeps.
    fn give(&mut self, command: rp6::Command, now: Stamp) {
        if command.is_reliable()
            && let Some(robot) = &mut self.robot
        {
            robot.asked = Some((command, now));
        }
        if let Err(error) = self.link.command(command, now) {
            tracing::debug!("{}: {command:?} not taken: {error}", self.name);
        }
    }

    fn command(&mut self, command: &Command, now: Stamp) {
        let wire = match rp6::Command::try_from(command) {
            Ok(wire) => wire,
            Err(error) => {
                tracing::warn!("{}: {error}; stopped", self.name);
                rp6::Command::Stop
            }
        };
        let Some(robot) = &mut self.robot else {
            return;
        };
        if wire.moves() && !robot.may_move(now) {
            return;
        }
        robot.motion = match command {
            _ if !wire.moves() && !matches!(wire, rp6::Command::Sweep { .. }) => Motion::None,
            Command::Velocity { .. } => Motion::Speed(now),
            _ => Motion::Errand(now),
        };
        if wire.moves() && !self.link.is_armed() && self.link.arm().is_err() {
            return;
        }
        self.give(wire, now);
    }

    /// Signs of life while under way, and a stop where the driver is gone.
    fn keep_alive(&mut self, now: Stamp) {
        let Some(robot) = &mut self.robot else {
            return;
        };
        match robot.motion {
            Motion::None => return,
            Motion::Speed(given) if now.since(given) > FORGOTTEN => {
                robot.motion = Motion::None;
                self.give(rp6::Command::Stop, now);
                return;
            }
            _ => (),
        }
        if now.since(robot.last_alive) >= ALIVE {
            robot.last_alive = now;
            self.give(rp6::Command::Alive, now);
        }
    }

    fn state(&mut self, state: DeviceState) {
        let link = link_state(self.link.phase());
        self.wants
            .extend(self.report.change(state, link).map(Want::Tell));
    }

    fn tell(&mut self, event: Event) {
        self.wants.push_back(Want::Tell(event));
    }

    fn tell_link(&mut self, now: Stamp) {
        let counters = self.link.counters();
        self.report.count(Tally {
            frames: counters.frames,
            rejected: counters.bad_stuffing
                + counters.bad_crc
                + counters.overlong
                + counters.unknown,
            discarded: counters.dropped_bytes,
            ..Tally::default()
        });
        if self.link.phase() == Phase::BootLoader && !self.was_boot_loader {
            self.was_boot_loader = true;
            self.report.detail = "the RP6's boot loader runs; its program is being started".into();
            self.state(DeviceState::Waiting);
        }
        let phase = link_state(self.link.phase());
        self.wants
            .extend(self.report.change_link(phase).map(Want::Tell));
        self.wants
            .extend(self.report.link_now_and_then(now).map(Want::Tell));
    }
}

impl Robot {
    /// Whether an order to move counts: not one that was being repeated all along while the robot came back.
    fn may_move(&mut self, now: Stamp) -> bool {
        self.is_calm |= now.since(self.calm_since) >= CALM;
        if !self.is_calm {
            self.calm_since = now;
        }
        self.is_calm
    }
}

impl Device for Rp6 {
    fn profile(&self) -> Profile {
        Profile {
            name: self.name.clone(),
            robot: Some(RobotModel::rp6()),
            scans_on_command: true,
        }
    }

    fn baud_rate(&self) -> u32 {
        Self::BAUD_RATE
    }

    fn opened(&mut self, now: Stamp) {
        self.nonce = self.nonce.wrapping_add(16);
        self.link = Link::new(LinkConfig::default(), now, self.nonce);
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
        // What came before the order counts before it: the robot may be gone.
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
        self.wants.clear();
        self.robot = None;
        self.report.detail = why;
        let events = self.report.change(DeviceState::Waiting, LinkState::Down);
        self.wants.extend(events.map(Want::Tell));
    }

    fn next_want(&mut self) -> Option<Want> {
        self.wants.pop_front()
    }
}

/// Seconds that a telemetry takes on the line: ten bits a byte.
fn telemetry_delay() -> f64 {
    let bytes = rp6::encode(0, &Said::Telemetry(Telemetry::default())).len();
    10.0 * bytes as f64 / f64::from(Rp6::BAUD_RATE)
}

fn link_state(phase: Phase) -> LinkState {
    match phase {
        Phase::Running => LinkState::Up,
        Phase::ResetNeeded => LinkState::ResetNeeded,
        Phase::Listening | Phase::BootLoader | Phase::Greeting => LinkState::Opening,
    }
}

/// What a broken link means to whoever stands beside the robot.
pub(crate) fn cause_and_cure(why: Down) -> String {
    match why {
        Down::Silence => "the RP6 fell silent: loose cable, or it was switched off".into(),
        Down::Unanswered => {
            "the RP6 does not acknowledge commands: its receive line (RX) is loose or noisy".into()
        }
        Down::Restarted => {
            "the RP6 started anew: reset, or its battery is weak; it is greeted again".into()
        }
        Down::EmergencyShutdown => {
            "the RP6 has shut down because a motor is blocked: free the tracks and press \
                                    its reset button; flash slamlab's firmware, which does not hang"
                .into()
        }
        Down::NobodyThere => {
            "nobody answers at 38400 baud: switch the RP6 on, start its program (START button), \
                              check TX and RX, and that slamlab's firmware is flashed"
                .into()
        }
        Down::OtherProtocol(version) => {
            format!(
                "the RP6 speaks version {version} of the protocol, the bridge another: flash the firmware of this bridge"
            )
        }
        Down::Closed => "the port is closed".into(),
    }
}

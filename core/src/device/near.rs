//! Robot, sensors and rules for one who drives in the same program: what the bridge is for many, without network and threads.
//!
//! In: bytes of the lines, messages of the one client ([`crate::wire::message::ToBridge`]), and the time. Out: what the devices want
//! done ([`Want`]), and messages for the client, the very ones of a bridge.
//!
//! 1. Devices stand at lines by number, in the order given; the first with a robot takes the orders.
//! 2. What devices say goes through [`RobotSide`] and [`Safety`], as in the bridge: disarmed at first, a watchdog on driving, plausibility,
//!    safe mode, and disarmed again with each line that was not up.
//! 3. The client is known: it may drive, and needs no token.
//!
//! Time is that of the caller, from any beginning; all devices are on it.

use std::collections::VecDeque;
use std::time::Duration;

use crate::robot::Stamp;
use crate::wire::message::{
    BridgeHeartbeat, BridgeHello, CHALLENGE_BYTES, Format, FromBridge, Header, ManoeuvreBody,
    MessageError, Notice, ProbeAnswer, RobotFigures, SCHEMA, SafetyBody, Severity, ToBridge,
    Watching, Welcome, decode, encode,
};

use crate::device::news::{Devices, explain};
use crate::device::robot_side::RobotSide;
use crate::device::safety::{Asked, Client, ClientId, Input, Output, Safety, SafetyConfig};
use crate::device::source::{self, Order, Profile, SourceEvent};
use crate::device::{Device, Want, Weight};

/// The one who drives.
const CLIENT: ClientId = 1;
const DRIVER: Client = Client {
    id: CLIENT,
    may_drive: true,
};
/// Between two heartbeats: its driving messages tell what it had seen.
const HEARTBEAT: Duration = Duration::from_millis(100);

/// Robot, sensors and rules for one client.
pub struct Near {
    devices: Vec<Box<dyn Device>>,
    /// Which lines are open: a device behind a closed one is not asked what it makes of the silence.
    is_open: Vec<bool>,
    /// What devices wanted before their newest order.
    waiting: Vec<VecDeque<Want>>,
    news: Devices,
    robot: RobotSide,
    safety: Safety,
    profiles: Vec<Profile>,
    now: Duration,
    sequence: u32,
    outgoing: Vec<Vec<u8>>,
    /// The client has said hello: before, nothing else is told.
    is_in: bool,
    next_heartbeat: Duration,
    name: String,
    /// Sequence of the message whose errand is under way.
    errand: Option<u32>,
    /// Whether the last order was an errand.
    gave_errand: bool,
}

impl Near {
    /// These devices, by the numbers of their lines; nothing is open yet.
    #[must_use]
    pub fn new(devices: Vec<Box<dyn Device>>) -> Self {
        let profiles: Vec<Profile> = devices.iter().map(|device| device.profile()).collect();
        Self {
            news: Devices::new(&profiles),
            robot: RobotSide::new(&profiles.iter()),
            safety: Safety::new(SafetyConfig::default()),
            is_open: vec![false; devices.len()],
            waiting: vec![VecDeque::new(); devices.len()],
            devices,
            profiles,
            now: Duration::ZERO,
            sequence: 0,
            outgoing: vec![],
            is_in: false,
            next_heartbeat: Duration::ZERO,
            name: String::new(),
            errand: None,
            gave_errand: false,
        }
    }

    /// Baud rate of a line; none where there is no such line.
    #[must_use]
    pub fn baud_rate(&self, line: usize) -> Option<u32> {
        self.devices.get(line).map(|device| device.baud_rate())
    }

    /// Says hello to the client, who begins or begins anew.
    pub fn begin(&mut self, now: Duration) {
        self.now = now;
        let robot = source::robot(self.profiles.iter()).and_then(|profile| profile.robot);
        let on_command = source::scans_on_command(self.profiles.iter());
        let config = SafetyConfig::default();
        self.is_in = false;
        self.say(&FromBridge::Hello(BridgeHello {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            schema: SCHEMA,
            challenge: [0; CHALLENGE_BYTES],
            watching: Watching::Anyone,
            robot: robot.map(|robot| RobotFigures::new(&robot, on_command)),
            watchdog_millis: config.watchdog.as_millis() as u16,
            lease_millis: config.lease.as_millis() as u16,
        }));
    }

    /// A line was opened.
    pub fn opened(&mut self, now: Duration, line: usize) {
        self.set_open(line, true);
        self.at(now, line, |device, stamp| device.opened(stamp));
    }

    /// Bytes that came on a line at `came`, which is before now where somebody was busy meanwhile: readings are dated by it.
    pub fn received(&mut self, now: Duration, came: Duration, line: usize, bytes: &[u8]) {
        self.at(now, line, |device, stamp| {
            device.receive(bytes, stamp_of(came.min(now)));
            device.tick(stamp);
        });
    }

    /// A line broke, or could not be opened; `why` says cause and cure.
    pub fn broken(&mut self, now: Duration, line: usize, why: &str) {
        self.set_open(line, false);
        self.at(now, line, |device, _| device.broken(why.to_owned()));
    }

    /// The lines are about to be closed: the robot is stopped by what the devices want next.
    pub fn close(&mut self, now: Duration) {
        self.now = now;
        self.rule(Input::Shutdown);
        let stamp = self.stamp();
        for device in &mut self.devices {
            device.close(stamp);
        }
    }

    /// Due some hundred times a second.
    pub fn tick(&mut self, now: Duration) {
        self.now = now;
        let stamp = self.stamp();
        for (device, _) in (self.devices.iter_mut().zip(&self.is_open)).filter(|(_, open)| **open) {
            device.tick(stamp);
        }
        self.rule(Input::Tick);
        if let Some(reason) = self.robot.silence(now)
            && self.safety.is_armed()
        {
            self.fault(reason);
        }
        if now >= self.next_heartbeat {
            self.next_heartbeat = now + HEARTBEAT;
            self.tell(&FromBridge::Heartbeat(BridgeHeartbeat {
                dropped: 0,
                clients: 1,
                robot_micros: self.robot.newest().0.0,
            }));
        }
    }

    /// What the device at a line wants done next with its line.
    pub fn next_want(&mut self, line: usize) -> Option<Want> {
        while let Some(want) = self.waiting_or_next(line) {
            match want {
                Want::Report(event) => self.event(line as u8, event),
                Want::Note(weight, text) => self.note(line, weight, &text),
                Want::Reopen => {
                    self.set_open(line, false);
                    return Some(Want::Reopen);
                }
                other => return Some(other),
            }
        }
        None
    }

    fn waiting_or_next(&mut self, line: usize) -> Option<Want> {
        let waiting = self.waiting.get_mut(line)?.pop_front();
        waiting.or_else(|| self.devices[line].next_want())
    }

    /// Takes a message of the client.
    ///
    /// # Errors    [`MessageError`] for what is none.
    pub fn hear(&mut self, now: Duration, bytes: &[u8]) -> Result<(), MessageError> {
        self.now = now;
        let (header, message) = decode::<ToBridge>(bytes, Format::Binary)?;
        match &message {
            ToBridge::Hello(hello) => {
                self.name.clone_from(&hello.name);
                self.welcome();
            }
            &ToBridge::Probe { token } => {
                let (stamp, came) = self.robot.newest();
                let micros = now.as_micros() as u64;
                self.tell(&FromBridge::Probe(ProbeAnswer {
                    token,
                    came_micros: micros,
                    robot_micros: stamp.0,
                    robot_came_micros: came.as_micros() as u64,
                }));
            }
            _ => self.ask(header, &message),
        }
        Ok(())
    }

    /// The person stops the robot, past the one who maps and may be busy; with `cut_off` the motors are cut off and stay so.
    pub fn stop(&mut self, now: Duration, cut_off: bool) {
        self.now = now;
        self.rule(Input::Asks(
            DRIVER,
            if cut_off {
                Asked::EmergencyStop
            } else {
                Asked::Stop
            },
        ));
    }

    /// Messages for the client, in order; they are forgotten here.
    pub fn take_outgoing(&mut self) -> Vec<Vec<u8>> {
        std::mem::take(&mut self.outgoing)
    }

    fn welcome(&mut self) {
        self.is_in = true;
        self.tell(&FromBridge::Welcome(Welcome {
            client: CLIENT,
            may_drive: true,
        }));
        self.tell(&FromBridge::Devices(self.news.all().to_vec()));
        self.tell(&FromBridge::Safety(self.state()));
    }

    fn ask(&mut self, header: Header, message: &ToBridge) {
        let Some(asked) = Asked::of(header, message) else {
            return;
        };
        self.gave_errand = false;
        self.rule(Input::Asks(DRIVER, asked));
        if matches!(message, ToBridge::Drive(body) if body.motion.is_manoeuvre()) {
            if self.gave_errand {
                self.errand_over();
                self.errand = Some(header.sequence);
                self.tell_errand(true);
            } else {
                // Refused: it is over, and the one under way goes on.
                let under_way = self.errand.replace(header.sequence);
                self.tell_errand(false);
                self.errand = under_way;
            }
        }
    }

    fn set_open(&mut self, line: usize, open: bool) {
        if let Some(is_open) = self.is_open.get_mut(line) {
            *is_open = open;
        }
    }

    fn at(&mut self, now: Duration, line: usize, does: impl FnOnce(&mut dyn Device, Stamp)) {
        self.now = now;
        let stamp = self.stamp();
        if let Some(device) = self.devices.get_mut(line) {
            does(device.as_mut(), stamp);
        }
    }

    fn event(&mut self, line: u8, event: SourceEvent) {
        let consequence = self.robot.event(self.now, line, &event);
        if let SourceEvent::Busy { busy, .. } = event {
            // What a device said of its rest before an order is forgotten when the order is given: this comes after it.
            if !busy && self.robot.source() == Some(usize::from(line)) {
                self.errand_over();
            }
            return;
        }
        if let Some(is_up) = consequence.link {
            if !is_up {
                self.errand_over();
            }
            self.rule(Input::Robot(is_up));
        }
        if let Some(reason) = consequence.fault
            && self.safety.is_armed()
        {
            self.fault(reason);
        }
        if let Some(command) = consequence.correction
            && self.safety.is_armed()
        {
            self.order(Order::Command(command));
        }
        if let Some(message) = self.news.message(line, event) {
            self.tell(&message);
        }
    }

    /// What does not go as it should stands in the page's log.
    fn note(&mut self, line: usize, weight: Weight, text: &str) {
        let severity = match weight {
            Weight::Detail | Weight::Info => return,
            Weight::Warning => Severity::Warning,
            Weight::Error => Severity::Error,
        };
        let text = format!("{}: {text}", self.profiles[line].name);
        self.tell(&FromBridge::Notice(Notice { severity, text }));
    }

    fn fault(&mut self, reason: crate::wire::message::DisarmReason) {
        self.rule(Input::Fault(reason));
        let (severity, text) = (Severity::Error, explain(reason).to_owned());
        self.tell(&FromBridge::Notice(Notice { severity, text }));
    }

    fn rule(&mut self, input: Input) {
        for output in self.safety.on(self.now, input) {
            match output {
                Output::Order(order) => {
                    let order = self.robot.limit(order);
                    self.order(order);
                }
                Output::Granted(_, lease) => self.tell(&FromBridge::Granted(lease)),
                Output::Refused(_, reason) => self.tell(&FromBridge::Refused(reason)),
                // Whoever drives is here: no connection to end.
                Output::Close(..) => (),
                Output::Changed => self.tell(&FromBridge::Safety(self.state())),
            }
        }
    }

    fn order(&mut self, order: Order) {
        self.robot.ordered(&order);
        let stamp = self.stamp();
        let line = self.robot.source();
        if let Some((line, device)) = line.and_then(|l| Some((l, self.devices.get_mut(l)?))) {
            let before = std::iter::from_fn(|| device.next_want());
            let is_rest =
                |want: &Want| matches!(want, Want::Report(SourceEvent::Busy { busy: false, .. }));
            self.waiting[line].extend(before);
            self.waiting[line].retain(|want| !is_rest(want));
            device.order(order, stamp);
            self.gave_errand = order.is_manoeuvre();
        }
    }

    fn state(&self) -> SafetyBody {
        let driver = self.safety.driver();
        SafetyBody {
            driver,
            driver_name: driver.map_or(String::new(), |_| self.name.clone()),
            armed: self.safety.is_armed(),
            emergency: self.safety.is_emergency(),
            reason: self.safety.reason(),
        }
    }

    fn errand_over(&mut self) {
        if self.errand.is_some() {
            self.tell_errand(false);
            self.errand = None;
        }
    }

    fn tell_errand(&mut self, busy: bool) {
        if let Some(sequence) = self.errand {
            self.tell(&FromBridge::Manoeuvre(ManoeuvreBody {
                client: CLIENT,
                sequence,
                busy,
            }));
        }
    }

    fn tell(&mut self, message: &FromBridge) {
        if self.is_in {
            self.say(message);
        }
    }

    fn say(&mut self, message: &FromBridge) {
        self.sequence += 1;
        let header = Header {
            sequence: self.sequence,
            micros: self.now.as_micros() as u64,
        };
        // One that could not be written leaves a gap in the sequence.
        self.outgoing
            .extend(encode(header, message, Format::Binary).ok());
    }

    fn stamp(&self) -> Stamp {
        stamp_of(self.now)
    }
}

fn stamp_of(time: Duration) -> Stamp {
    Stamp(time.as_micros() as u64)
}

impl std::fmt::Debug for Near {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Near")
            .field("profiles", &self.profiles)
            .field("now", &self.now)
            .finish_non_exhaustive()
    }
}

//! An RP6 with slamlab's firmware as seen on its serial line: boot loader, frames, watchdog and
//! latch, driving the simulated robot.
//!
//! The rules are those of `bridge/firmware`: a greeting resets the sequences and stops the robot; a
//! repeated or stale command is reported and not executed; 400 ms without a command stop the
//! motors; an emergency stop is latched, and its reset moves nothing.

use slamlab_core::geom::Pose2;
use slamlab_core::robot::{Command as Order, RobotModel};
use slamlab_core::sim::{SensorModel, SimError, Simulation, World};
use slamlab_core::wire::rp6::{
    BATTERY_ADC, Command, CommandResult, Decoder, Fault, Hello, PROTOCOL, Report, ResetCause,
    State, Telemetry, encode,
};

use super::{Carrier, Device};

/// Silence after which the firmware stops the motors, s.
const WATCHDOG: f64 = 0.4;
/// Time from power-on to the boot loader's `[READY]`, s.
const BOOT: f64 = 0.1;

/// The simulated robot.
#[derive(Clone, Debug)]
pub struct Rp6 {
    simulation: Simulation,
    /// Whether its boot loader speaks at power-on and waits for `s`.
    pub has_boot_loader: bool,
    /// Whether `s` starts a program.
    pub has_program: bool,
    /// The fault that it reports.
    pub fault: Fault,
    program: Program,
    decoder: Decoder<Command>,
    last_sequence: Option<u8>,
    is_latched: bool,
    is_silenced: bool,
    /// Seconds since power-on, since the last command, until the next telemetry.
    seconds: f64,
    since_command: f64,
    to_telemetry: f64,
    period: f64,
    sent: u8,
    said: Vec<u8>,
    /// Every command executed since power-on, each with the time since then, s.
    pub done: Vec<(f64, Command)>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Program {
    Booting,
    Waiting,
    Running,
    Hanging,
}

impl Rp6 {
    /// A robot at the start of a world.
    ///
    /// # Errors    The robot cannot stand there.
    pub fn new(world: World) -> Result<Self, SimError> {
        Ok(Self {
            simulation: Simulation::new(world, RobotModel::rp6(), SensorModel::lidar(), 1)?,
            has_boot_loader: false,
            has_program: true,
            fault: Fault::None,
            program: Program::Running,
            decoder: Decoder::default(),
            last_sequence: None,
            is_latched: false,
            is_silenced: false,
            seconds: 0.0,
            since_command: 0.0,
            to_telemetry: 0.0,
            period: 0.05,
            sent: 0,
            said: vec![],
            done: vec![],
        })
    }

    /// The robot in its world.
    #[must_use]
    pub fn simulation(&self) -> &Simulation {
        &self.simulation
    }

    /// Whether any command since power-on was to move.
    #[must_use]
    pub fn was_told_to_move(&self) -> bool {
        self.done.iter().any(|(_, command)| command.moves())
    }

    /// Whether its tracks turn.
    #[must_use]
    pub fn is_moving(&self) -> bool {
        let (forward, turn) = self.simulation.speeds();
        forward.abs() > 2e-3 || turn.abs() > 2e-2
    }

    /// The vendor's firmware detects a blocked motor: it reports that and never answers again.
    pub fn shut_down(&mut self) {
        self.simulation.command(Order::Stop);
        self.program = Program::Hanging;
        self.said.extend(b"\n### EMERGENCY SHUTDOWN! ###\n");
    }

    fn say(&mut self, report: &Report) {
        self.said.extend(encode(self.sent, report));
        self.sent = self.sent.wrapping_add(1);
    }

    fn hello(&mut self, nonce: u8) {
        let model = self.simulation.robot();
        let thousandths = |metres: f64| (metres * 1e3).round() as u16;
        let hello = Hello {
            protocol: PROTOCOL,
            firmware: [1, 0],
            nonce,
            cause: ResetCause::PowerOn,
            capabilities: 0b1_0100,
            length_mm: thousandths(model.length),
            width_mm: thousandths(model.width),
            track_width_mm: thousandths(model.track_width),
            count_nm: (model.metres_per_tick * 1e9).round() as u32,
            max_speed_mm_s: thousandths(model.max_speed),
            ranger_angles_mrad: vec![],
        };
        self.say(&Report::Hello(hello));
    }

    fn take(&mut self, sequence: u8, command: Command) {
        if let Command::Greet { nonce } = command {
            self.simulation.command(Order::Stop);
            self.last_sequence = None;
            self.hello(nonce);
            return;
        }
        let result = self.judge(sequence, command);
        if result == CommandResult::Done {
            self.done.push((self.seconds, command));
        }
        self.say(&Report::Ack {
            of: sequence,
            result,
        });
    }

    fn judge(&mut self, sequence: u8, command: Command) -> CommandResult {
        match self.last_sequence {
            Some(last) if sequence == last => return CommandResult::Repeated,
            Some(last) if sequence.wrapping_sub(last).cast_signed() < 0 => {
                return CommandResult::Stale;
            }
            _ => self.last_sequence = Some(sequence),
        }
        if self.is_latched && command.moves() {
            return CommandResult::Latched;
        }
        self.since_command = 0.0;
        self.is_silenced = false;
        let order = match command {
            Command::Velocity {
                forward_mm_s,
                turn_mrad_s,
            } => Order::Velocity {
                forward: 1e-3 * f64::from(forward_mm_s),
                turn: 1e-3 * f64::from(turn_mrad_s),
            },
            Command::Forward { way_um } => Order::Forward(1e-6 * f64::from(way_um)),
            Command::Turn { angle_urad } => Order::Turn(1e-6 * f64::from(angle_urad)),
            Command::Stop => Order::Stop,
            Command::EStop => {
                self.is_latched = true;
                Order::Stop
            }
            Command::Reset => {
                self.is_latched = false;
                Order::Stop
            }
            Command::SetRate { period_ms } => {
                self.period = 1e-3 * f64::from(period_ms.clamp(10, 500));
                return CommandResult::Done;
            }
            _ => return CommandResult::Done,
        };
        self.simulation.command(order);
        CommandResult::Done
    }

    fn telemetry(&mut self) {
        let [left, right] = self.simulation.ticks();
        let bumpers = self.simulation.bumpers();
        let bits = [
            bumpers.left,
            bumpers.right,
            self.is_moving() || self.simulation.is_busy(),
            false,
            self.is_latched,
            self.is_silenced,
        ];
        let state = bits
            .iter()
            .zip(0..)
            .fold(0, |state, (&bit, place)| state | u8::from(bit) << place);
        let telemetry = Telemetry {
            time_ms: (self.seconds * 1e3) as u32,
            counts: [left as i32, right as i32],
            battery_adc: BATTERY_ADC.counts(self.simulation.battery_volts()) as u16,
            state: State(state),
            fault: self.fault,
            ..Telemetry::default()
        };
        self.say(&Report::Telemetry(telemetry));
    }

    fn run(&mut self, seconds: f64) {
        self.simulation.advance(seconds);
        self.since_command += seconds;
        if self.since_command > WATCHDOG && !self.is_silenced {
            self.is_silenced = true;
            self.simulation.command(Order::Stop);
        }
        self.to_telemetry -= seconds;
        if self.to_telemetry <= 0.0 {
            self.to_telemetry = self.period;
            self.telemetry();
        }
    }
}

impl Carrier for Rp6 {
    fn pose(&self) -> Pose2 {
        self.simulation.truth()
    }

    fn seconds(&self) -> f64 {
        self.simulation.stamp().seconds()
    }
}

impl Device for Rp6 {
    fn baud_rate(&self) -> u32 {
        38_400
    }

    fn power_on(&mut self) {
        self.simulation.command(Order::Stop);
        self.decoder = Decoder::default();
        self.last_sequence = None;
        self.is_latched = false;
        (self.seconds, self.since_command) = (0.0, 0.0);
        self.said.clear();
        self.done.clear();
        if self.has_boot_loader {
            self.program = Program::Booting;
            self.said.extend(b"[RP6BOOT]\n");
        } else {
            self.program = Program::Running;
            self.hello(0);
        }
    }

    /// It has a battery of its own: its watchdog runs on, and nobody hears what it sends.
    fn unplugged(&mut self, seconds: f64) {
        let _ = self.advance(seconds);
    }

    fn receive(&mut self, bytes: &[u8]) {
        match self.program {
            Program::Running => {
                let frames: Vec<_> = self.decoder.push(bytes).collect();
                for frame in frames {
                    self.take(frame.sequence, frame.message);
                }
            }
            Program::Waiting if bytes.contains(&b's') && self.has_program => {
                self.program = Program::Running;
                self.hello(0);
            }
            _ => (),
        }
    }

    fn advance(&mut self, seconds: f64) -> Vec<u8> {
        self.seconds += seconds;
        match self.program {
            Program::Booting if self.seconds > BOOT => {
                self.program = Program::Waiting;
                self.said.extend(b"[READY]\n");
            }
            Program::Running => self.run(seconds),
            // The world goes on around a robot that is not running.
            _ => self.simulation.advance(seconds),
        }
        std::mem::take(&mut self.said)
    }
}

//! What the robot says, field by field as on the wire; the table of the parent module is the layout.
//!
//! In: kind and payload. Out: a report, or nothing where kind, length or a value is not of the table; and back.

use super::bytes::{Reader, put};
use super::message::Message;

/// Version of the protocol in [`Hello`].
pub const PROTOCOL: u8 = 1;
/// More rangers than this a [`Hello`] cannot name.
const MOST_RANGERS: u8 = 16;

/// What the robot says.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Report {
    /// Who it is: after its start, and when greeted.
    Hello(Hello),
    /// What became of a command.
    Ack {
        /// Sequence of the command.
        of: u8,
        /// What became of it.
        verdict: Verdict,
    },
    /// How it is.
    Telemetry(Telemetry),
    /// One reading of one ranger.
    Ranger(Ranger),
}

/// What became of a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Taken.
    Done,
    /// Had been taken already; not done again.
    Repeated,
    /// Older than the last one taken; not done.
    Stale,
    /// A figure outside of what the robot can do; not done.
    BadValue,
    /// The emergency stop is latched; not done.
    Latched,
    /// This firmware does not know the kind.
    UnknownKind,
}

/// Why the robot's controller started.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ResetCause {
    /// Power came on.
    PowerOn,
    /// The reset line: the button, or the serial adapter's RTS.
    External,
    /// The supply was too low for a moment: an empty battery or a blocked motor.
    BrownOut,
    /// The firmware hung and its watchdog bit.
    Watchdog,
    /// Something else.
    Other(u8),
}

/// What this firmware can do.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Capabilities(
    /// Bit 0: rangers, bit 1: servo, bit 2: bumpers, bit 3: motor currents, bit 4: battery.
    pub u8,
);

/// Who the robot is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Hello {
    /// Version of the protocol; see [`PROTOCOL`].
    pub protocol: u8,
    /// Version of the firmware: major, minor.
    pub firmware: [u8; 2],
    /// That of the greeting it answers; 0 right after a start.
    pub nonce: u8,
    /// Why it started.
    pub cause: ResetCause,
    /// What it can do.
    pub capabilities: Capabilities,
    /// Length of the board, mm.
    pub length_mm: u16,
    /// Width of the board, mm.
    pub width_mm: u16,
    /// Effective distance of the tracks when turning, mm.
    pub track_width_mm: u16,
    /// Way of a track for one count, nm.
    pub count_nm: u32,
    /// Highest speed, mm/s.
    pub max_speed_mm_s: u16,
    /// For each ranger its direction on the servo, mrad, counter-clockwise from where the servo points.
    pub ranger_angles_mrad: Vec<i16>,
}

/// How the robot is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Telemetry {
    /// Time since it started, ms; wraps after 49 days.
    pub time_ms: u32,
    /// Counts of the encoders since it started, left and right, signed by the direction driven.
    pub counts: [i32; 2],
    /// Speeds of the tracks, counts/s.
    pub speeds: [i16; 2],
    /// Currents of the motors, counts of the converter.
    pub currents_adc: [u16; 2],
    /// Battery, counts of the converter; see [`super::BATTERY_ADC`].
    pub battery_adc: u16,
    /// Bumpers and what is under way.
    pub state: State,
    /// What is wrong.
    pub fault: Fault,
}

/// Eight yes-or-no's of [`Telemetry`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct State(
    /// The bits, as in the table.
    pub u8,
);

/// What is wrong with the robot.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Fault {
    /// Nothing.
    #[default]
    None,
    /// The left motor is driven and its encoder counts nothing: blocked, or the cable is off.
    LeftEncoder,
    /// The same on the right.
    RightEncoder,
    /// A motor draws more than it should.
    Overcurrent,
    /// The battery is nearly empty.
    BatteryLow,
    /// One that only a newer firmware knows.
    Other(u8),
}

/// One reading of one ranger.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ranger {
    /// When it was taken, ms since the robot started.
    pub time_ms: u32,
    /// Where the servo stood, mrad, counter-clockwise from straight ahead.
    pub servo_mrad: i16,
    /// Which ranger, from 0.
    pub index: u8,
    /// What the converter read.
    pub adc: u16,
    /// Number of the sweep it belongs to; grows by one for each.
    pub sweep: u8,
}

impl Capabilities {
    /// It has rangers.
    pub const RANGERS: Self = Self(1);
    /// It has a servo.
    pub const SERVO: Self = Self(2);
    /// It has bumpers.
    pub const BUMPERS: Self = Self(4);
    /// It measures the motors' currents.
    pub const CURRENTS: Self = Self(8);
    /// It measures its battery.
    pub const BATTERY: Self = Self(16);

    /// Whether it has all that `other` has.
    #[must_use]
    pub fn has(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }
}

impl State {
    /// Left bumper pressed.
    #[must_use]
    pub fn bumper_left(self) -> bool {
        self.0 & 1 != 0
    }

    /// Right bumper pressed.
    #[must_use]
    pub fn bumper_right(self) -> bool {
        self.0 & 2 != 0
    }

    /// The tracks turn, or are to turn.
    #[must_use]
    pub fn moving(self) -> bool {
        self.0 & 4 != 0
    }

    /// A sweep is under way.
    #[must_use]
    pub fn sweeping(self) -> bool {
        self.0 & 8 != 0
    }

    /// The emergency stop is latched.
    #[must_use]
    pub fn latched(self) -> bool {
        self.0 & 16 != 0
    }

    /// The robot stopped by itself because no command came; the next one clears this.
    #[must_use]
    pub fn stopped_by_silence(self) -> bool {
        self.0 & 32 != 0
    }
}

impl Message for Report {
    const LONGEST_FRAME: usize = 64;

    fn kind(&self) -> u8 {
        match self {
            Self::Hello(_) => 0x81,
            Self::Ack { .. } => 0x82,
            Self::Telemetry(_) => 0x83,
            Self::Ranger(_) => 0x84,
        }
    }

    fn put_payload(&self, out: &mut Vec<u8>) {
        match self {
            Self::Hello(hello) => hello.put(out),
            Self::Ack { of, verdict } => put!(out, of, verdict.code()),
            Self::Telemetry(telemetry) => telemetry.put(out),
            Self::Ranger(r) => put!(out, r.time_ms, r.servo_mrad, r.index, r.adc, r.sweep),
        }
    }

    fn parse(kind: u8, payload: &[u8]) -> Option<Self> {
        let mut r = Reader::new(payload);
        let report = match kind {
            0x81 => Self::Hello(Hello::take(&mut r)?),
            0x82 => Self::Ack {
                of: r.u8()?,
                verdict: Verdict::from_code(r.u8()?)?,
            },
            0x83 => Self::Telemetry(Telemetry::take(&mut r)?),
            0x84 => Self::Ranger(Ranger {
                time_ms: r.u32()?,
                servo_mrad: r.i16()?,
                index: r.u8()?,
                adc: r.u16()?,
                sweep: r.u8()?,
            }),
            _ => return None,
        };
        r.end(report)
    }
}

impl Hello {
    fn put(&self, out: &mut Vec<u8>) {
        put!(out, self.protocol, self.firmware[0], self.firmware[1]);
        put!(out, self.nonce, self.cause.code(), self.capabilities.0);
        put!(out, self.length_mm, self.width_mm, self.track_width_mm);
        put!(out, self.count_nm, self.max_speed_mm_s);
        let rangers = self.ranger_angles_mrad.iter().take(MOST_RANGERS.into());
        put!(out, rangers.len() as u8);
        for angle in rangers {
            put!(out, angle);
        }
    }

    fn take(r: &mut Reader) -> Option<Self> {
        let mut hello = Self {
            protocol: r.u8()?,
            firmware: [r.u8()?, r.u8()?],
            nonce: r.u8()?,
            cause: ResetCause::from_code(r.u8()?),
            capabilities: Capabilities(r.u8()?),
            length_mm: r.u16()?,
            width_mm: r.u16()?,
            track_width_mm: r.u16()?,
            count_nm: r.u32()?,
            max_speed_mm_s: r.u16()?,
            ranger_angles_mrad: Vec::new(),
        };
        let rangers = r.u8().filter(|n| *n <= MOST_RANGERS)?;
        for _ in 0..rangers {
            hello.ranger_angles_mrad.push(r.i16()?);
        }
        Some(hello)
    }
}

impl Telemetry {
    fn put(&self, out: &mut Vec<u8>) {
        put!(out, self.time_ms, self.counts[0], self.counts[1]);
        put!(out, self.speeds[0], self.speeds[1]);
        put!(out, self.currents_adc[0], self.currents_adc[1]);
        put!(out, self.battery_adc, self.state.0, self.fault.code());
    }

    fn take(r: &mut Reader) -> Option<Self> {
        Some(Self {
            time_ms: r.u32()?,
            counts: [r.i32()?, r.i32()?],
            speeds: [r.i16()?, r.i16()?],
            currents_adc: [r.u16()?, r.u16()?],
            battery_adc: r.u16()?,
            state: State(r.u8()?),
            fault: Fault::from_code(r.u8()?),
        })
    }
}

impl Verdict {
    const ALL: [Self; 6] = [
        Self::Done,
        Self::Repeated,
        Self::Stale,
        Self::BadValue,
        Self::Latched,
        Self::UnknownKind,
    ];

    fn code(self) -> u8 {
        self as u8
    }

    fn from_code(code: u8) -> Option<Self> {
        Self::ALL.get(usize::from(code)).copied()
    }
}

impl ResetCause {
    fn code(self) -> u8 {
        match self {
            Self::PowerOn => 1,
            Self::External => 2,
            Self::BrownOut => 3,
            Self::Watchdog => 4,
            Self::Other(code) => code,
        }
    }

    fn from_code(code: u8) -> Self {
        match code {
            1 => Self::PowerOn,
            2 => Self::External,
            3 => Self::BrownOut,
            4 => Self::Watchdog,
            other => Self::Other(other),
        }
    }
}

impl Fault {
    fn code(self) -> u8 {
        match self {
            Self::None => 0,
            Self::LeftEncoder => 1,
            Self::RightEncoder => 2,
            Self::Overcurrent => 3,
            Self::BatteryLow => 4,
            Self::Other(code) => code,
        }
    }

    fn from_code(code: u8) -> Self {
        match code {
            0 => Self::None,
            1 => Self::LeftEncoder,
            2 => Self::RightEncoder,
            3 => Self::Overcurrent,
            4 => Self::BatteryLow,
            other => Self::Other(other),
        }
    }
}

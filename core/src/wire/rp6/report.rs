//! What the robot says, field by field as on the wire; the table of the parent module is the
//! layout.
//!
//! In: kind and payload. Out: a report, or nothing where kind, length or a value is not of the
//! table; and back.

use super::bytes::{Field, codes, fields, messages};
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
        result: CommandResult,
    },
    /// How it is.
    Telemetry(Telemetry),
    /// One reading of one ranger.
    Ranger(Ranger),
}

codes! {
    /// What became of a command.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum CommandResult {
        /// Taken.
        Done = 0,
        /// Had been taken already; not done again.
        Repeated = 1,
        /// Older than the last one taken; not done.
        Stale = 2,
        /// A figure outside of what the robot can do; not done.
        BadValue = 3,
        /// The emergency stop is latched; not done.
        Latched = 4,
        /// This firmware does not know the kind.
        UnknownKind = 5,
    }
}

codes! {
    /// Why the robot's controller started.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum ResetCause or Other {
        /// Power came on.
        PowerOn = 1,
        /// The reset line: the button, or the serial adapter's RTS.
        External = 2,
        /// The supply was too low for a moment: an empty battery or a blocked motor.
        BrownOut = 3,
        /// The firmware hung and its watchdog bit.
        Watchdog = 4,
    }
}

fields! {
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
        /// What it can do. Bit 0: rangers, bit 1: servo, bit 2: bumpers, bit 3: motor currents,
        /// bit 4: battery.
        pub capabilities: u8,
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
        /// For each ranger its direction on the servo, mrad, counter-clockwise from where the servo
        /// points.
        pub ranger_angles_mrad: Vec<i16>,
    }
}

fields! {
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
}

/// Eight yes-or-no's of [`Telemetry`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct State(
    /// The bits, as in the table.
    pub u8,
);

codes! {
    /// What is wrong with the robot.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub enum Fault or Other {
        /// Nothing.
        #[default]
        None = 0,
        /// The left motor is driven and its encoder counts nothing: blocked, or the cable is off.
        LeftEncoder = 1,
        /// The same on the right.
        RightEncoder = 2,
        /// A motor draws more than it should.
        Overcurrent = 3,
        /// The battery is nearly empty.
        BatteryLow = 4,
    }
}

fields! {
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

messages! {
    Report, at most 64;
    0x81 Hello(hello)
    0x82 Ack { of, result }
    0x83 Telemetry(telemetry)
    0x84 Ranger(ranger)
}

impl Field for State {
    fn put(&self, out: &mut Vec<u8>) {
        self.0.put(out);
    }

    fn take(payload: &mut &[u8]) -> Option<Self> {
        u8::take(payload).map(Self)
    }
}

/// The angles of the rangers, after their number.
impl Field for Vec<i16> {
    fn put(&self, out: &mut Vec<u8>) {
        let angles = self.iter().take(MOST_RANGERS.into());
        out.push(angles.len() as u8);
        angles.for_each(|angle| angle.put(out));
    }

    fn take(payload: &mut &[u8]) -> Option<Self> {
        let count = u8::take(payload).filter(|count| *count <= MOST_RANGERS)?;
        (0..count).map(|_| i16::take(payload)).collect()
    }
}

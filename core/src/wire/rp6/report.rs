//! The robot's reports, field by field as on the wire. The table of the parent module gives their
//! layout.
//!
//! In: kind and payload. Out: a report, or nothing if kind, length or a value is not in the table;
//! and back.

use super::bytes::{Field, codes, fields, messages};
use super::message::Message;

/// Version of the protocol in [`Hello`].
pub const PROTOCOL: u8 = 1;
/// Most rangers that a [`Hello`] can list.
const MOST_RANGERS: u8 = 16;

/// Messages of the robot.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Report {
    /// Its description of itself: after its start, and when greeted.
    Hello(Hello),
    /// The result of a command.
    Ack {
        /// Sequence of the command.
        of: u8,
        /// Its result.
        result: CommandResult,
    },
    /// The robot's state.
    Telemetry(Telemetry),
    /// One reading of one ranger.
    Ranger(Ranger),
}

codes! {
    /// The result of a command.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum CommandResult {
        /// Accepted.
        Done = 0,
        /// Already accepted before; not carried out again.
        Repeated = 1,
        /// Older than the last one accepted; not carried out.
        Stale = 2,
        /// A value outside of what the robot can do; not carried out.
        BadValue = 3,
        /// The emergency stop is latched; not carried out.
        Latched = 4,
        /// This firmware does not know the kind.
        UnknownKind = 5,
    }
}

codes! {
    /// Why the robot's controller started.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum ResetCause or Other {
        /// Power was switched on.
        PowerOn = 1,
        /// The reset line: the button, or the serial adapter's RTS.
        External = 2,
        /// The supply was too low for a moment: an empty battery or a blocked motor.
        BrownOut = 3,
        /// The firmware hung and its watchdog reset it.
        Watchdog = 4,
    }
}

fields! {
    /// The robot's description of itself.
    #[derive(Clone, Debug, PartialEq, Eq)]
    pub struct Hello {
        /// Version of the protocol; see [`PROTOCOL`].
        pub protocol: u8,
        /// Version of the firmware: major, minor.
        pub firmware: [u8; 2],
        /// The nonce of the greeting that it answers; 0 right after a start.
        pub nonce: u8,
        /// Cause of its start.
        pub cause: ResetCause,
        /// Its capabilities. Bit 0: rangers, bit 1: servo, bit 2: bumpers, bit 3: motor currents,
        /// bit 4: battery.
        pub capabilities: u8,
        /// Length of the board, mm.
        pub length_mm: u16,
        /// Width of the board, mm.
        pub width_mm: u16,
        /// Effective distance between the tracks when turning, mm.
        pub track_width_mm: u16,
        /// Distance that a track moves in one count, nm.
        pub count_nm: u32,
        /// Highest speed, mm/s.
        pub max_speed_mm_s: u16,
        /// For each ranger its direction on the servo, mrad, counter-clockwise from the servo's own
        /// direction.
        pub ranger_angles_mrad: Vec<i16>,
    }
}

fields! {
    /// The robot's state.
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
        /// Bumpers, and whether motion or sweep is under way.
        pub state: State,
        /// What is wrong.
        pub fault: Fault,
    }
}

/// Eight flags of [`Telemetry`].
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
        /// The left motor is driven and its encoder counts nothing: blocked, or its cable is off.
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
        /// Angle of the servo, mrad, counter-clockwise from straight ahead.
        pub servo_mrad: i16,
        /// Number of the ranger, from 0.
        pub index: u8,
        /// Count of the converter.
        pub adc: u16,
        /// Number of the sweep it belongs to; increases by one for each.
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

/// The angles of the rangers, preceded by their number.
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

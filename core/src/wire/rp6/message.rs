//! What both directions have in common, and the commands, field by field as on the wire. The table
//! of the parent module gives their layout.
//!
//! In: kind and payload. Out: a message, or nothing if kind, length or a value is not in the table;
//! and back.
//!
//! Units are those of the wire, named in each field: [`super::convert`](super) converts them to
//! metres and radians.

use super::bytes::{Field, messages};

/// What both directions have in common: a kind and a payload.
pub trait Message: Sized {
    /// Longest frame of this direction, markers included.
    const LONGEST_FRAME: usize;

    /// The byte that tells the kind of message.
    fn kind(&self) -> u8;

    /// Appends the payload.
    fn put_payload(&self, out: &mut Vec<u8>);

    /// The message of this kind and payload; `None` if the table of the protocol has none.
    fn parse(kind: u8, payload: &[u8]) -> Option<Self>;
}

/// Commands to the robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Command {
    /// Say hello; stand still, and forget the sequences seen.
    Greet {
        /// Returned in the [`Hello`](super::Hello); never 0, which the robot uses when it speaks
        /// first.
        nonce: u8,
    },
    /// Drive at these speeds until commanded otherwise.
    Velocity {
        /// Forward speed, mm/s.
        forward_mm_s: i16,
        /// Turn rate, mrad/s, counter-clockwise.
        turn_mrad_s: i16,
    },
    /// Drive straight.
    Forward {
        /// Distance, µm; negative drives back.
        way_um: i32,
    },
    /// Turn on the spot.
    Turn {
        /// The angle, µrad, counter-clockwise.
        angle_urad: i32,
    },
    /// Motors off at once; the next command that moves ends it.
    Stop,
    /// Motors off at once; stays so until [`Command::Reset`].
    EStop,
    /// Ends an emergency stop. The motion that it interrupted is not resumed.
    Reset,
    /// Points the servo.
    Servo {
        /// Where to, mrad, counter-clockwise from straight ahead.
        angle_mrad: i16,
    },
    /// Takes the rangers' readings at angles from one end to the other, once.
    Sweep {
        /// First angle, mrad.
        from_mrad: i16,
        /// Last angle, mrad.
        to_mrad: i16,
        /// Angle between two readings, mrad; more than 0, whatever the direction.
        step_mrad: i16,
    },
    /// How often telemetry is wanted.
    SetRate {
        /// Interval of telemetry, ms.
        period_ms: u16,
    },
    /// The driver is there and has nothing new to say.
    Alive,
}

impl Command {
    /// Whether it is resent until it is acknowledged. A stream of speeds repeats itself.
    #[must_use]
    pub fn is_reliable(&self) -> bool {
        !matches!(self, Self::Velocity { .. } | Self::Alive)
    }

    /// Whether it makes something move.
    #[must_use]
    pub fn moves(&self) -> bool {
        match self {
            Self::Velocity {
                forward_mm_s,
                turn_mrad_s,
            } => *forward_mm_s != 0 || *turn_mrad_s != 0,
            Self::Forward { .. } | Self::Turn { .. } => true,
            _ => false,
        }
    }

    /// Whether it is a sweep of one position: a look aside on the move.
    #[must_use]
    pub fn looks_aside(&self) -> bool {
        matches!(self, Self::Sweep { from_mrad, to_mrad, .. } if from_mrad == to_mrad)
    }
}

messages! {
    Command, at most super::frame::LONGEST_TO_ROBOT;
    0x01 Greet { nonce }
    0x02 Velocity { forward_mm_s, turn_mrad_s }
    0x03 Forward { way_um }
    0x04 Turn { angle_urad }
    0x05 Stop {}
    0x06 EStop {}
    0x07 Reset {}
    0x08 Servo { angle_mrad }
    0x09 Sweep { from_mrad, to_mrad, step_mrad }
    0x0A SetRate { period_ms }
    0x0B Alive {}
}

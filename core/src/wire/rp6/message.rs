//! What both directions have in common, and the commands, field by field as on the wire; the table
//! of the parent module is their layout.
//!
//! In: kind and payload. Out: a message, or nothing where kind, length or a value is not of the
//! table; and back.
//!
//! Units are those of the wire, named in each field: [`super::convert`](super) turns them into
//! metres and radians.

use super::bytes::{Field, messages};

/// What both directions have in common: a kind and a payload.
pub trait Message: Sized {
    /// Longest frame of this direction, markers included.
    const LONGEST_FRAME: usize;

    /// The byte that says which message it is.
    fn kind(&self) -> u8;

    /// Appends the payload.
    fn put_payload(&self, out: &mut Vec<u8>);

    /// The message of this kind and payload; `None` where the table of the protocol has no such.
    fn parse(kind: u8, payload: &[u8]) -> Option<Self>;
}

/// What the robot is asked to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Command {
    /// Say hello; stand, and forget which sequences were seen.
    Greet {
        /// Comes back in the [`Hello`](super::Hello); never 0, which a robot uses that speaks
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
        /// The way, µm; negative drives back.
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
    /// Ends an emergency stop. What was under way stays given up.
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
        /// Time from one to the next, ms.
        period_ms: u16,
    },
    /// The driver is there and has nothing new to say.
    Alive,
}

impl Command {
    /// Whether it is sent again until it is acknowledged. A stream of speeds is its own repetition.
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

//! What both directions have in common, and the commands, field by field as on the wire; the table of the parent module is
//! their layout.
//!
//! In: kind and payload. Out: a message, or nothing where kind, length or a value is not of the table; and back.
//!
//! Units are those of the wire, named in each field: [`super::convert`](super) turns them into metres and radians.

use super::bytes::{Reader, put};

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
        /// Comes back in the [`Hello`](super::Hello); never 0, which a robot uses that speaks first.
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
}

impl Message for Command {
    const LONGEST_FRAME: usize = super::frame::LONGEST_TO_ROBOT;

    fn kind(&self) -> u8 {
        match self {
            Self::Greet { .. } => 0x01,
            Self::Velocity { .. } => 0x02,
            Self::Forward { .. } => 0x03,
            Self::Turn { .. } => 0x04,
            Self::Stop => 0x05,
            Self::EStop => 0x06,
            Self::Reset => 0x07,
            Self::Servo { .. } => 0x08,
            Self::Sweep { .. } => 0x09,
            Self::SetRate { .. } => 0x0A,
            Self::Alive => 0x0B,
        }
    }

    fn put_payload(&self, out: &mut Vec<u8>) {
        match *self {
            Self::Greet { nonce } => put!(out, nonce),
            Self::Velocity {
                forward_mm_s,
                turn_mrad_s,
            } => put!(out, forward_mm_s, turn_mrad_s),
            Self::Forward { way_um } => put!(out, way_um),
            Self::Turn { angle_urad } => put!(out, angle_urad),
            Self::Servo { angle_mrad } => put!(out, angle_mrad),
            Self::Sweep {
                from_mrad,
                to_mrad,
                step_mrad,
            } => put!(out, from_mrad, to_mrad, step_mrad),
            Self::SetRate { period_ms } => put!(out, period_ms),
            Self::Stop | Self::EStop | Self::Reset | Self::Alive => (),
        }
    }

    fn parse(kind: u8, payload: &[u8]) -> Option<Self> {
        let mut r = Reader::new(payload);
        let command = match kind {
            0x01 => Self::Greet { nonce: r.u8()? },
            0x02 => Self::Velocity {
                forward_mm_s: r.i16()?,
                turn_mrad_s: r.i16()?,
            },
            0x03 => Self::Forward { way_um: r.i32()? },
            0x04 => Self::Turn {
                angle_urad: r.i32()?,
            },
            0x05 => Self::Stop,
            0x06 => Self::EStop,
            0x07 => Self::Reset,
            0x08 => Self::Servo {
                angle_mrad: r.i16()?,
            },
            0x09 => Self::Sweep {
                from_mrad: r.i16()?,
                to_mrad: r.i16()?,
                step_mrad: r.i16()?,
            },
            0x0A => Self::SetRate {
                period_ms: r.u16()?,
            },
            0x0B => Self::Alive,
            _ => return None,
        };
        r.end(command)
    }
}

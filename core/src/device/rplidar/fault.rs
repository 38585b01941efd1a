//! What can go wrong with an RPLIDAR: each fault with its cause and its cure.

use crate::wire::rplidar::request::Request;

/// Why the sensor does not work.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum RplidarFault {
    /// No byte arrived.
    #[error(
        "the lidar does not answer ({request:?}, 3 tries): no power, or TX and RX are swapped or loose; \
         check the cable and the 5 V supply"
    )]
    NoAnswer {
        /// The request.
        request: Request,
    },
    /// Bytes arrived, but no answer.
    #[error(
        "{bytes} bytes came, but no answer of an RPLIDAR to {request:?}: wrong baud rate or another device; \
         an A1 speaks at 115200 baud"
    )]
    NotUnderstood {
        /// The request.
        request: Request,
        /// Number of bytes that arrived.
        bytes: u64,
    },
    /// Its protection stop is active, even after a reset.
    #[error(
        "the lidar has stopped itself (health 2, error {error:#06x}), also after a reset: mostly weak power, a thin \
         cable or a blocked head; give it 5 V with 1 A, turn the head by hand, plug it in again; else it is broken"
    )]
    Protection {
        /// The maker's code.
        error: u16,
    },
    /// It answers, but sends no readings.
    #[error(
        "the lidar answers, but sends no readings: its motor does not turn (check DTR or the motor's 5 V)"
    )]
    NoReadings,
    /// It fell silent.
    #[error(
        "the lidar fell silent while measuring: loose cable or weak power; check plug and supply"
    )]
    Silent,
    /// Its angle does not advance.
    #[error(
        "the lidar sends readings but no whole turn: its head is blocked or its belt off; turn it by hand"
    )]
    DoesNotTurn,
    /// It restarted by itself.
    #[error(
        "the lidar restarted while measuring: its voltage drops; use a stronger supply or a shorter cable"
    )]
    LostPower,
}

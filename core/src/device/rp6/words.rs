//! Faults of an RP6, in sentences for a person beside it: each with its cure.

use crate::wire::rp6::{self, Down};

/// A boot loader, and nothing behind it.
pub const NO_PROGRAM: &str =
    "the RP6's boot loader answers, but starts no program that does: flash slamlab's firmware";
/// A boot loader, and perhaps something behind it.
pub const BOOT_LOADER: &str = "the RP6's boot loader runs; its program is being started";

/// What a broken link means for a person beside the robot.
#[must_use]
pub fn cause_and_cure(why: Down) -> String {
    match why {
        Down::Silence => "the RP6 fell silent: loose cable, or it was switched off".into(),
        Down::Unanswered => {
            "the RP6 does not acknowledge commands: its receive line (RX) is loose or noisy".into()
        }
        Down::Restarted => {
            "the RP6 restarted: reset, or its battery is weak; it is greeted again".into()
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

/// What a fault that the robot reports means; empty where there is none.
#[must_use]
pub fn fault_and_cure(fault: rp6::Fault) -> &'static str {
    match fault {
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
    }
}

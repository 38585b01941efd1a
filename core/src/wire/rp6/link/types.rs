//! What the owner of a link gets from it.

use super::super::{Command, CommandResult, Hello, Ranger, Telemetry};

/// The phase of the link.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Just opened: a boot loader may be about to speak.
    Listening,
    /// The boot loader runs.
    BootLoader,
    /// The robot is being greeted.
    Greeting,
    /// The robot answered; commands reach it.
    Running,
    /// Only a person at the robot can help: its program hangs, or it is off.
    ResetNeeded,
}

/// Why a link went down.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Down {
    /// Nothing arrived for too long.
    Silence,
    /// A command was not acknowledged, however often it was sent.
    Unanswered,
    /// The robot restarted.
    Restarted,
    /// The vendor's firmware shut down because a motor is blocked, and waits for a reset.
    EmergencyShutdown,
    /// Nobody answers the greetings.
    NobodyThere,
    /// The robot speaks another version of the protocol.
    OtherProtocol(u8),
    /// The port was closed.
    Closed,
}

/// Events for the owner of the link.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum LinkEvent {
    /// The robot is there, standing still; the link is disarmed.
    Up(Hello),
    /// The robot is no longer there; or it is now known why it cannot be reached.
    Down(Down),
    /// The robot reported the result of a command.
    Acknowledged {
        /// The command.
        command: Command,
        /// Its result.
        result: CommandResult,
    },
    /// A command was dropped: a stop overtook it, or the link went down.
    Dropped(Command),
    /// The robot's state.
    Telemetry(Telemetry),
    /// A reading of a ranger.
    Ranger(Ranger),
}

/// Why a command was not taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum LinkError {
    /// No robot answers now.
    #[error("the RP6 is not connected ({phase:?}); expected it to run")]
    NotRunning {
        /// The phase of the link.
        phase: Phase,
    },
    /// Motion needs arming first.
    #[error("the RP6 is disarmed; arm it before it may move")]
    Disarmed,
    /// Too many commands wait.
    #[error("{} commands wait for the RP6 already", super::LONGEST_QUEUE)]
    QueueFull,
}

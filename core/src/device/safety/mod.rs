//! Whether the robot may move, and by whom: the bridge's rules as a state machine, without clock,
//! socket or thread.
//!
//! In: what clients ask for, what is known of the robot, and the time ([`Input`]). Out: what to do
//! about it ([`Output`]).
//!
//! 1. One client at a time has the lease. Not used for 2 s, it ends. Taking it from another stops
//!    the robot first.
//! 2. Nothing moves before the client with the lease arms. Whatever goes wrong disarms:
//!    [`DisarmReason`] lists it.
//! 3. A driving message counts if its epoch is that of the lease, its sequence is higher than the
//!    one before, and what its sender had seen is recent. All others are refused, and change
//!    nothing.
//! 4. 200 ms after the last one the robot is stopped: with the time that the order takes, it has it
//!    within 250 ms.
//! 5. Anyone may stop. The emergency stop is latched until the client with the lease resets it,
//!    which moves nothing.
//!
//! Always: armed implies that somebody has the lease, that the robot's link is up, and that no
//! emergency stop is latched.
//!
//! [`plausible`] finds what disarms in the robot's own readings; [`crate::control::SafeMode`] keeps
//! commands off obstacles.

pub mod plausible;
mod rules;
#[cfg(test)]
mod tests;

use std::time::Duration;

use crate::wire::message::{DisarmReason, DriveBody, Header, Lease, RefusalReason, ToBridge};

use crate::device::source::Order;

/// Number of a connection, never used again.
pub type ClientId = u32;

/// The times of the rules.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SafetyConfig {
    /// The robot is stopped so long after the last driving message. Default 200 ms.
    pub watchdog: Duration,
    /// A lease ends so long after it was used last. Default 2 s.
    pub lease: Duration,
    /// What a sender had seen may never be older, whatever it allows itself. Default 500 ms.
    pub longest_ttl: Duration,
}

impl Default for SafetyConfig {
    fn default() -> Self {
        Self {
            watchdog: Duration::from_millis(200),
            lease: Duration::from_secs(2),
            longest_ttl: Duration::from_millis(500),
        }
    }
}

/// Who asks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Client {
    /// Number of its connection.
    pub id: ClientId,
    /// Whether it has shown the token.
    pub may_drive: bool,
}

/// What happens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Input {
    /// A client asks for something.
    Asks(Client, Asked),
    /// A client's connection ended.
    Gone(ClientId),
    /// The link to the robot came up (`true`) or went.
    Robot(bool),
    /// The robot's readings show that it must not go on.
    Fault(DisarmReason),
    /// The bridge ends.
    Shutdown,
    /// Time passed; due at [`Safety::deadline`].
    Tick,
}

/// What a client asks for; epochs are those of its lease.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Asked {
    /// The lease.
    Take {
        /// Also from its current holder.
        force: bool,
    },
    /// To keep it.
    Renew {
        /// Of the lease.
        epoch: u32,
    },
    /// To give it back.
    Release {
        /// Of the lease.
        epoch: u32,
    },
    /// That the robot may move.
    Arm {
        /// Of the lease.
        epoch: u32,
    },
    /// To move.
    Drive {
        /// Of the message.
        sequence: u32,
        /// The command.
        body: DriveBody,
    },
    /// To go on with what is under way.
    Hold {
        /// Of the message.
        sequence: u32,
        /// Of the lease.
        epoch: u32,
        /// Newest time of the bridge that the sender had seen.
        seen: Duration,
        /// How old that may be.
        ttl: Duration,
    },
    /// To stand still.
    Stop,
    /// To cut the motors off.
    EmergencyStop,
    /// To unlatch that.
    ResetEmergencyStop {
        /// Of the lease.
        epoch: u32,
    },
}

impl Asked {
    /// What a message asks for; none where it is not for the rules.
    #[must_use]
    pub fn of(header: Header, message: &ToBridge) -> Option<Self> {
        Some(match *message {
            ToBridge::Take { force } => Asked::Take { force },
            ToBridge::Renew { epoch } => Asked::Renew { epoch },
            ToBridge::Release { epoch } => Asked::Release { epoch },
            ToBridge::Arm { epoch } => Asked::Arm { epoch },
            ToBridge::Drive(body) => Asked::Drive {
                sequence: header.sequence,
                body,
            },
            ToBridge::Hold {
                epoch,
                seen,
                ttl_millis,
            } => Asked::Hold {
                sequence: header.sequence,
                epoch,
                seen: Duration::from_micros(seen),
                ttl: Duration::from_millis(ttl_millis.into()),
            },
            ToBridge::Stop => Asked::Stop,
            ToBridge::EmergencyStop => Asked::EmergencyStop,
            ToBridge::ResetEmergencyStop { epoch } => Asked::ResetEmergencyStop { epoch },
            // `non_exhaustive`: hello, heartbeat and probe are for others.
            _ => return None,
        })
    }
}

/// What to do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Output {
    /// Give the robot this order.
    Order(Order),
    /// Tell the client that it has the lease.
    Granted(ClientId, Lease),
    /// Tell the client why not.
    Refused(ClientId, RefusalReason),
    /// End the connection with this code.
    Close(ClientId, u16),
    /// Tell everyone the new state.
    Changed,
}

/// The state.
#[derive(Clone, Debug)]
pub struct Safety {
    config: SafetyConfig,
    holder: Option<Holder>,
    last_epoch: u32,
    is_robot_up: bool,
    is_armed: bool,
    is_emergency: bool,
    reason: DisarmReason,
    /// When the last driving message counted; none while the robot is to stand.
    driven: Option<Duration>,
}

/// Who has the lease.
#[derive(Clone, Copy, Debug)]
struct Holder {
    client: ClientId,
    epoch: u32,
    /// Sequence of its last driving message.
    sequence: u32,
    used: Duration,
}

impl Safety {
    /// Disarmed, and without a robot.
    #[must_use]
    pub fn new(config: SafetyConfig) -> Self {
        Self {
            config,
            holder: None,
            last_epoch: 0,
            is_robot_up: false,
            is_armed: false,
            is_emergency: false,
            reason: DisarmReason::Start,
            driven: None,
        }
    }

    /// Who has the lease.
    #[must_use]
    pub fn driver(&self) -> Option<ClientId> {
        self.holder.map(|holder| holder.client)
    }

    /// Whether driving messages are passed on.
    #[must_use]
    pub fn is_armed(&self) -> bool {
        self.is_armed
    }

    /// Whether the emergency stop is latched.
    #[must_use]
    pub fn is_emergency(&self) -> bool {
        self.is_emergency
    }

    /// Why the robot was disarmed last.
    #[must_use]
    pub fn reason(&self) -> DisarmReason {
        self.reason
    }

    /// When a [`Input::Tick`] is due; none while nothing can run out.
    #[must_use]
    pub fn deadline(&self) -> Option<Duration> {
        let watchdog = self.driven.map(|at| at + self.config.watchdog);
        let lease = self.holder.map(|holder| holder.used + self.config.lease);
        watchdog.into_iter().chain(lease).min()
    }

    /// Takes what happened at `now`, and says what to do, in order. `now` never runs backwards.
    pub fn on(&mut self, now: Duration, input: Input) -> Vec<Output> {
        let mut out = Vec::new();
        self.run_out(now, &mut out);
        match input {
            Input::Asks(client, asked) => self.asked(now, client, asked, &mut out),
            Input::Gone(client) if self.driver() == Some(client) => {
                self.end_lease(DisarmReason::DriverGone, &mut out);
            }
            Input::Gone(_) | Input::Tick => (),
            Input::Robot(is_up) => self.robot(is_up, &mut out),
            Input::Fault(DisarmReason::Runaway) => {
                self.emergency_stop(DisarmReason::Runaway, &mut out);
            }
            Input::Fault(reason) => self.disarm(reason, &mut out),
            Input::Shutdown => self.end_lease(DisarmReason::Shutdown, &mut out),
        }
        out
    }
}

//! Whether the robot may move, and on whose orders: the bridge's rules as a state machine, without
//! clock, socket or thread.
//!
//! In: requests of clients, the state of the robot, and the time ([`Input`]). Out: what to do
//! ([`Output`]).
//!
//! 1. One client at a time has the lease. It ends if it is not used for 2 s, or if the right of its
//!    holder is taken away. Taking it from another client stops the robot first; only an owner can
//!    take an owner's lease.
//! 2. Nothing moves before the client with the lease arms. Whatever goes wrong disarms:
//!    [`DisarmReason`] lists it.
//! 3. A driving message counts if its epoch is that of the lease, its sequence is higher than the
//!    one before, and the bridge time that its sender had seen is recent. All others are refused
//!    and change nothing.
//! 4. 200 ms after the last one the robot is stopped. Including the time that the order takes, the
//!    robot has it within 250 ms.
//! 5. Anyone may stop. The emergency stop is latched until the client with the lease resets it,
//!    which moves nothing. A stop that changes nothing, less than 100 ms after the last one, is
//!    ignored: a client that repeats it quickly keeps neither robot nor clients busy.
//!
//! Invariant: armed implies that a client has the lease, that the robot's link is up, and that no
//! emergency stop is latched.
//!
//! [`plausible`] finds reasons to disarm in the robot's own readings; [`crate::control::SafeMode`]
//! keeps commands away from obstacles.

pub mod plausible;
mod rules;
#[cfg(test)]
mod tests;

use std::time::Duration;

use crate::wire::message::{DisarmReason, Lease, RefusalReason, Role, ToBridge};

use crate::device::source::Order;

/// Number of a connection, never used again.
pub type ClientId = u32;

/// The robot is stopped this long after the last driving message.
pub(super) const WATCHDOG: Duration = Duration::from_millis(200);
/// A lease ends this long after it was last used.
pub(super) const LEASE: Duration = Duration::from_secs(2);
/// A stop that changes nothing is not repeated before this time has passed.
pub(super) const STOP_AGAIN: Duration = Duration::from_millis(100);
/// Greatest age of the bridge time that a sender had seen, whatever `ttl_millis` it gives.
const LONGEST_TTL: Duration = Duration::from_millis(500);

/// Who asks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Client {
    /// Number of its connection.
    pub id: ClientId,
    /// The role of the right that it has shown.
    pub role: Role,
}

/// Something that happens.
#[derive(Clone, Debug, PartialEq)]
pub enum Input {
    /// A client asks for something, by a message of this sequence.
    Asks(Client, u32, ToBridge),
    /// A client's connection ended.
    Gone(ClientId),
    /// A client's right was taken away.
    Revoked(ClientId),
    /// The link to the robot came up (`true`) or was lost.
    Robot(bool),
    /// The robot's readings show that it must not go on.
    Fault(DisarmReason),
    /// The bridge shuts down.
    Shutdown,
    /// Time passed; due at [`Safety::deadline`].
    Tick,
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
    /// Begin the bridge's own map anew, as this client asked.
    ResetMap(ClientId),
    /// From now on, the robot may be where this client said.
    SetGeofence(ClientId),
}

/// The state; at first disarmed, and without a robot.
#[derive(Clone, Debug, Default)]
pub struct Safety {
    holder: Option<Holder>,
    last_epoch: u32,
    is_robot_up: bool,
    is_armed: bool,
    is_emergency: bool,
    reason: DisarmReason,
    /// When the last driving message counted; none while the robot is to stand still.
    driven: Option<Duration>,
    /// When a client's stop was last given to a robot that has not been armed since.
    stopped: Option<Duration>,
    out: Vec<Output>,
}

/// Who has the lease.
#[derive(Clone, Copy, Debug)]
struct Holder {
    client: ClientId,
    role: Role,
    epoch: u32,
    /// Sequence of its last driving message.
    sequence: u32,
    used: Duration,
}

impl Safety {
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

    /// Why the robot was last disarmed.
    #[must_use]
    pub fn reason(&self) -> DisarmReason {
        self.reason
    }

    /// When an [`Input::Tick`] is due; none while nothing can expire.
    #[must_use]
    pub fn deadline(&self) -> Option<Duration> {
        let watchdog = self.driven.map(|at| at + WATCHDOG);
        let lease = self.holder.map(|holder| holder.used + LEASE);
        watchdog.into_iter().chain(lease).min()
    }

    /// Takes what happened at `now`; returns what to do, in order. `now` never runs backwards.
    pub fn on(&mut self, now: Duration, input: Input) -> Vec<Output> {
        self.run_out(now);
        match input {
            Input::Asks(client, sequence, message) => self.asked(now, client, sequence, &message),
            Input::Gone(client) if self.driver() == Some(client) => {
                self.end_lease(DisarmReason::DriverGone);
            }
            Input::Revoked(client) if self.driver() == Some(client) => {
                self.end_lease(DisarmReason::Revoked);
            }
            Input::Gone(_) | Input::Revoked(_) | Input::Tick => (),
            Input::Robot(is_up) => self.robot(is_up),
            Input::Fault(DisarmReason::Runaway) => self.emergency_stop(DisarmReason::Runaway),
            Input::Fault(reason) => self.disarm(reason),
            Input::Shutdown => self.end_lease(DisarmReason::Shutdown),
        }
        std::mem::take(&mut self.out)
    }
}

//! Manoeuvres: legs, turns and sweeps. The client that gave one learns when it is over, however it
//! ends.
//!
//! In: driving messages after the rules have judged them, and what the robot's source reports. Out:
//! [`ManoeuvreBody`].
//!
//! 1. A message that gives a manoeuvre leads to the order that the rules and safe mode make of it.
//!    If that order is a manoeuvre too, the manoeuvre has begun; otherwise its sender learns at
//!    once that it is over.
//! 2. The source reports whether its robot is busy, and after which order: only what it reports
//!    after the manoeuvre's own order counts.
//! 3. The manoeuvre also ends when the link is lost, and when another manoeuvre begins.

use crate::wire::message::{FromBridge, ManoeuvreBody};

use super::{Action, Hub};
use crate::device::safety::ClientId;

/// The manoeuvre under way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Manoeuvre {
    client: ClientId,
    sequence: u32,
    /// Number of its order.
    order: u64,
}

impl Manoeuvre {
    pub(super) fn message(self, busy: bool) -> FromBridge {
        FromBridge::Manoeuvre(ManoeuvreBody {
            client: self.client,
            sequence: self.sequence,
            busy,
        })
    }
}

impl Hub {
    /// A client gave a manoeuvre; `order` is the number of the robot's order, if that order is a
    /// manoeuvre too.
    pub(super) fn manoeuvre_given(&mut self, client: ClientId, sequence: u32, order: Option<u64>) {
        let manoeuvre = Manoeuvre {
            client,
            sequence,
            order: order.unwrap_or(0),
        };
        if order.is_none() {
            // A manoeuvre already under way goes on.
            return self.send(client, manoeuvre.message(false));
        }
        self.end_manoeuvre();
        self.manoeuvre = Some(manoeuvre);
        self.actions
            .push_back(Action::SendAll(manoeuvre.message(true)));
    }

    /// The robot's source reports whether it is busy.
    pub(super) fn robot_is_busy(&mut self, busy: bool, after: u64) {
        let is_over = |manoeuvre: Manoeuvre| !busy && after >= manoeuvre.order;
        if self.manoeuvre.is_some_and(is_over) {
            self.end_manoeuvre();
        }
    }

    /// Nothing is under way any more.
    pub(super) fn end_manoeuvre(&mut self) {
        if let Some(manoeuvre) = self.manoeuvre.take() {
            self.actions
                .push_back(Action::SendAll(manoeuvre.message(false)));
        }
    }
}

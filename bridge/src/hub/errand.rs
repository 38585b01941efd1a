//! Errands: ways, turns and sweeps, which take their time. Who gave one learns when it is over, whatever ends it.
//!
//! In: driving messages as the rules judged them, and what the robot's source says of being busy. Out: [`ManoeuvreBody`].
//!
//! 1. A message that gives an errand is followed by the order that the rules and safe mode made of it. Is that an errand too, it
//!    began; else it is told as over at once.
//! 2. The source says whether its robot is busy, and after which order it says so: what it says after the errand's counts.
//! 3. A link that goes ends the errand, and so does another errand.

use slamlab_core::wire::message::{FromBridge, ManoeuvreBody};

use super::Hub;
use crate::safety::ClientId;

/// The errand under way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Errand {
    client: ClientId,
    sequence: u32,
    /// Number of the order.
    order: u64,
}

impl Errand {
    fn body(self, busy: bool) -> FromBridge {
        FromBridge::Manoeuvre(ManoeuvreBody {
            client: self.client,
            sequence: self.sequence,
            busy,
        })
    }
}

impl Hub {
    /// A client gave an errand; `order` is what the robot was told, if it was an errand.
    pub(super) fn errand_given(&mut self, client: ClientId, sequence: u32, order: Option<u64>) {
        let errand = Errand {
            client,
            sequence,
            order: order.unwrap_or(0),
        };
        if order.is_none() {
            return self.tell(client, errand.body(false));
        }
        self.errand_over();
        self.errand = Some(errand);
        self.tell_all(errand.body(true));
    }

    /// The robot's source says whether it is busy.
    pub(super) fn busy(&mut self, busy: bool, after: u64) {
        let is_over = |errand: Errand| !busy && after >= errand.order;
        if self.errand.is_some_and(is_over) {
            self.errand_over();
        }
    }

    /// Nothing is under way any more.
    pub(super) fn errand_over(&mut self) {
        if let Some(errand) = self.errand.take() {
            self.tell_all(errand.body(false));
        }
    }

    /// What a client that comes now should know.
    pub(super) fn errand_now(&self) -> Option<FromBridge> {
        self.errand.map(|errand| errand.body(true))
    }
}

//! The other robots behind the router, for a page that shows them all.
//!
//! ```text
//!   router ── tokens, states, alerts of slamlab/* ──> gather ──> table ──> /fleet.json
//!          <── slamlab/NAME/stop ───────────────────────────────────────── /fleet/stop
//! ```
//!
//! 1. A robot has one slot, made by its liveliness token and by nothing else, so that whoever
//!    writes under foreign keys grows nothing ([`Table`]).
//! 2. The page asks for what changed since it asked last: what it gets is the newest, and nothing
//!    waits for a page that is slow.
//! 3. A stop needs no right, as everywhere; where watching needs the token here, so does this.
//! 4. Where robots are is told in each robot's own map. Two maps have a common frame only where
//!    both robots localise in copies of one saved map, which shows by the name of its file alone:
//!    the page draws together what has the same name, and says that it goes by the name.

mod gather;
mod serve;
mod table;

use std::sync::{Mutex, PoisonError};

use ::zenoh::Session;

pub(super) use gather::Gathering;
pub(crate) use serve::routes;
use table::Table;

/// What is known of all robots, and the way to them while there is one.
#[derive(Default)]
pub(crate) struct Fleet {
    table: Mutex<Table>,
    router: Mutex<Option<Session>>,
}

impl Fleet {
    fn with_table<T>(&self, with: impl FnOnce(&mut Table) -> T) -> T {
        with(&mut self.table.lock().unwrap_or_else(PoisonError::into_inner))
    }

    fn router(&self) -> Option<Session> {
        let router = self.router.lock().unwrap_or_else(PoisonError::into_inner);
        router.clone()
    }

    fn set_router(&self, session: Option<Session>) {
        *self.router.lock().unwrap_or_else(PoisonError::into_inner) = session;
    }
}

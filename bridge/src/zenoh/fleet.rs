//! The other robots behind the router, for a page that shows them all.
//!
//! ```text
//!   router ── tokens, states, alerts of slamlab/* ──> gather ──> table ──> /fleet.json
//!          <── slamlab/NAME/stop ───────────────────────────────────────── /fleet/stop
//! ```
//!
//! 1. A robot has one slot, made only by its liveliness token, so that writing under invented keys
//!    takes no memory ([`Table`]).
//! 2. The page asks for what changed since its last request: it gets the newest state, and nothing
//!    waits for a slow page.
//! 3. A stop needs no right, as everywhere; but if watching this bridge needs the token,
//!    `/fleet/stop` is refused as well.
//! 4. Each robot's pose is in its own map. Two maps share a frame only if both robots localise in
//!    copies of one saved map, which can be seen only by the name of its file: the page draws
//!    robots with the same name of map together, and says that it goes by that name.

mod gather;
mod serve;
mod table;

use std::sync::{Mutex, PoisonError};

use ::zenoh::Session;

pub(super) use gather::Gathering;
pub(crate) use serve::routes;
use table::Table;

/// What is known of all robots, and the session to reach them while there is one.
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

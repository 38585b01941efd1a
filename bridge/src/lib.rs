//! The bridge: serves the page to a browser on this machine or the same network, relays robot and
//! sensors to it, and keeps the robot safe when anything between the person and the motors fails.
//!
//! In comes a listening socket, a [`Config`] and a future that ends when the program should stop;
//! out go HTTP answers and WebSocket messages ([`slamlab_core::wire::message`]), and orders to the
//! robot.
//!
//! ```text
//!   sources ── events ──> hub ── messages ──> outboxes ──> connections ──> clients
//!           <── orders ──  │  <──────────── messages ───────────────
//!                       safety, recorder
//! ```
//!
//! 1. [`bind`] opens the socket; if the port is taken, its error says what to do.
//! 2. [`run`] starts the sources ([`source`]), each on a thread, and the hub, one task that owns
//!    all state.
//! 3. `accept` limits connections; `http` refuses requests whose `Host` is a foreign name
//!    ([`host`]), finds files, and adds the headers that restrict the page ([`headers`]);
//!    `connection` serves one client within its right ([`rights`]). `foxglove` and `rosbridge`
//!    speak the protocols of other tools, if enabled.
//! 4. [`safety`] holds the rules, separate from all this: whether the robot may move, and who may
//!    move it.
//! 5. [`serial`] holds the sources on serial ports; [`doctor`] says what is wrong with them.
//! 6. [`settings`] reads `bridge.toml`; [`tls`] holds the certificate; [`announce`] tells the
//!    network that the bridge is here.
//! 7. `audit` records who drove, who stopped the robot and who was refused.
//! 8. `mapping` runs the core's session on the hub's readings, if enabled.
//! 9. `storage` copies finished recordings to object storage, if enabled.
//! 10. [`zenoh`] makes the robot reachable through a router, if built in and enabled.
//! 11. [`record`] records all messages, so that nothing acknowledged is lost.
//!
//! The page is inside the program (`cargo xtask package`), or in a folder that is read at each
//! request: a rebuilt page then needs a reload, not a restart ([`Page`]).

mod accept;
mod access_log;
mod adapter;
pub mod address;
pub mod announce;
mod audit;
mod clock;
mod connection;
pub mod doctor;
mod embedded;
mod ending;
mod foxglove;
pub mod headers;
mod hexadecimal;
pub mod host;
mod http;
mod hub;
mod listen;
mod locked_file;
mod mapping;
mod metrics;
mod notify;
mod page;
mod places;
mod rate;
pub mod record;
mod replaced_file;
pub mod rights;
mod rosbridge;
pub mod secret_file;
pub mod serial;
mod serve;
pub mod settings;
mod shared;
mod socket;
pub mod source;
mod storage;
mod throttle;
pub mod tls;
pub mod token;
pub mod trust;
pub mod udp;
pub mod zenoh;

pub use slamlab_core::device::safety;

pub use clock::Clock;
pub use listen::{BindError, bind};
pub use mapping::{HomeConfig, MapConfig, MapError};
pub use page::{Page, PageError};
pub use serve::{Config, RunError, Serving, check, run, start};
pub use shared::Limits;
pub use storage::{PART_MIB, StorageConfig, StorageError};

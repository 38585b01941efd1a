//! The robot behind a Zenoh router: reached by whoever reaches that, from another network too.
//!
//! ```text
//!   hub ── messages ──> streams ──> router ──> whoever asked for them
//!       <── messages ── remote clients <── router <── clients
//! ```
//!
//! The bridge connects outward, as a client of a router ([`ZenohConfig::router`]). Where that is
//! absent or goes, it says so once, and tries again: robot and local page know nothing of it. All
//! payloads are the text of [`slamlab_core::wire::message`], as behind `?fmt=json`.
//!
//! | key, behind `slamlab/NAME/` | what |
//! |---|---|
//! | `alive/ID` | liveliness token of the robot; two of a name are found out, and the later waits (`namesake`) |
//! | `safety`, `alerts`, `devices`, `battery`, `odometry`, `scan`, `map`, `pose`, … | what the hub tells everybody, each kind at a key of its own (`streams`). A query of `slamlab/NAME/*` is answered by the last of each state |
//! | `page` | the address of the robot's page, for a query; of a bridge that listens on all addresses, that in the network of the router |
//! | `stop` | whatever is put there stops the robot, as Stop does for everyone; `slamlab/*/stop` stops all |
//! | `to/CLIENT`, `from/CLIENT` | the conversation of a client, with the rules of a WebSocket's (`remote`): hello, proof, lease, arming, driving |
//!
//! 1. What a slow link keeps waiting is the newest of each stream: depth 1. States, answers and
//!    alerts go before, on a lane of their own (`lane`), and what comes in waits for neither.
//! 2. Commands pass the same rules as everybody's, for a remote client is a client of the hub.
//! 3. Behind a router anybody may write under any key. So who may drive signs each message with a
//!    key that only token and bridge make ([`slamlab_core::wire::message::MessageKey`]); what is
//!    not signed by it counts as not said. Whom the router lets in at all, it must say itself: by
//!    the certificates of its clients.
//! 4. What all robots there say of themselves is gathered for the page of the fleet (`fleet`).
//! 5. Where `ros` is set, the same session is a node of ROS 2 (`ros`).
//!
//! It is built with the feature `zenoh` only.

#[cfg(not(feature = "zenoh"))]
mod absent;
mod config;

#[cfg(feature = "zenoh")]
mod fleet;
#[cfg(feature = "zenoh")]
mod keys;
#[cfg(feature = "zenoh")]
mod lane;
#[cfg(feature = "zenoh")]
mod link;
#[cfg(feature = "zenoh")]
mod namesake;
#[cfg(feature = "zenoh")]
mod remote;
#[cfg(feature = "zenoh")]
mod ros;
#[cfg(feature = "zenoh")]
mod router;
#[cfg(feature = "zenoh")]
mod streams;

#[cfg(not(feature = "zenoh"))]
pub(crate) use absent::{Ready, ready};
pub use config::{Endpoint, EndpointError, RosConfig, ZenohConfig, ZenohError};
#[cfg(feature = "zenoh")]
pub(crate) use fleet::{Fleet, routes};
#[cfg(feature = "zenoh")]
pub(crate) use link::{Ready, ready};

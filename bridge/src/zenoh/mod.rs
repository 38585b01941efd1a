//! Makes the robot reachable through a Zenoh router, also from other networks.
//!
//! ```text
//!   hub ── messages ──> streams ──> router ──> whoever asked for them
//!       <── messages ── remote clients <── router <── clients
//! ```
//!
//! The bridge connects outward, as a client of a router ([`ZenohConfig::router`]). If the router is
//! absent or disappears, the bridge reports it once and tries again; robot and local page are not
//! affected. All payloads are the text form of [`slamlab_core::wire::message`], as with
//! `?fmt=json`.
//!
//! | key, after `slamlab/NAME/` | what |
//! |---|---|
//! | `alive/ID` | liveliness token of the robot; two robots of one name are detected, and the later one waits (`namesake`) |
//! | `safety`, `alerts`, `devices`, `battery`, `odometry`, `scan`, `map`, `pose`, … | the hub's messages for everybody, each kind under its own key (`streams`). A query of `slamlab/NAME/*` is answered by the last of each state |
//! | `page` | the address of the robot's page, in answer to a query; if the bridge listens on all addresses, its address in the router's network |
//! | `stop` | anything put there stops the robot, as anyone's Stop does; `slamlab/*/stop` stops all |
//! | `to/CLIENT`, `from/CLIENT` | the conversation with a client, by the same rules as over a WebSocket (`remote`): hello, proof, lease, arming, driving |
//!
//! 1. On a slow link only the newest message of each stream waits: depth 1. States, answers and
//!    alerts go first, on a lane of their own (`lane`), and incoming messages wait for neither.
//! 2. Commands are subject to the same rules as all others, because a remote client is a client of
//!    the hub.
//! 3. Behind a router anybody may write under any key. So a client that may drive signs each
//!    message with a key that only the token's holder and the bridge can compute
//!    ([`slamlab_core::wire::message::MessageKey`]); messages without this signature are ignored.
//!    Only the router itself can decide whom it lets in: by the certificates of its clients.
//! 4. What all robots there report is gathered for the fleet page (`fleet`).
//! 5. If `ros` is set, the same session is a node of ROS 2 (`ros`).
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

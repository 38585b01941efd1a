//! The bridge over real sockets on this machine: who may do what, and that the robot stops.
#![cfg(not(target_family = "wasm"))] // opens sockets
#![allow(missing_docs)] // a test binary has no public interface
#![allow(clippy::unwrap_used)] // helpers of tests, which clippy does not count as tests

mod access;
mod adapters;
mod client;
mod driving;
mod failsafe;
mod geofence;
mod manoeuvre;
mod mapping;
mod recording;
mod rights;
#[allow(dead_code)] // `examples/bridge_report` uses the rest
mod rights_stand;
#[allow(dead_code)] // `examples/bridge_report` uses the rest
mod robot;
mod schema;
mod streams;

//! Tests with sockets, serial lines and files, in one program: each would be linked with core and bridge anew.
#![cfg(not(target_family = "wasm"))]
#![allow(missing_docs)] // a test binary has no public interface

mod bridge_http;
#[path = "bridge_ws/main.rs"]
mod bridge_ws;
mod by_hand;
mod doctor;
#[path = "fuzz/main.rs"]
mod fuzz;
mod near;
mod pilch_udp;
mod serial_lidar;
mod serial_rp6;

//! Tests with sockets, serial lines and files, in one program: separate ones would each have to be
//! linked with core and bridge.
#![cfg(not(target_family = "wasm"))]
#![allow(missing_docs)] // a test binary has no public interface

mod bridge_http;
#[path = "bridge_ws/main.rs"]
mod bridge_ws;
mod by_hand;
mod doctor;
#[path = "fuzz/main.rs"]
mod fuzz;
mod local_bridge;
mod pilch_udp;
mod serial_lidar;
mod serial_rp6;

#[test]
fn every_file_of_tests_belongs_to_a_program() {
    let lists = [
        include_str!("native.rs"),
        include_str!("runs.rs"),
        include_str!("../Cargo.toml"),
        include_str!("../../xtask/Cargo.toml"),
    ];
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests");
    for entry in std::fs::read_dir(folder).expect("the tests are there") {
        let path = entry.expect("the folder can be read").path();
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        let is_code = path.is_dir() || path.extension().is_some_and(|ending| ending == "rs");
        let named = [format!("mod {name};"), format!("\"{name}\"")];
        let is_listed = |list: &&str| named.iter().any(|named| list.contains(named));
        assert!(!is_code || lists.iter().any(is_listed), "{name}");
    }
}

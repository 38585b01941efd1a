//! Readers and writers of files, over byte slices. Opening and saving files is up to the caller.

pub mod building;
pub mod calibration;
pub mod carmen;
mod field_error;
pub mod firmware_header;
pub mod floor_plan;
pub mod g2o;
pub mod known_file;
mod left_out;
pub mod map_points;
pub mod map_server;
pub mod og_map;
pub mod point_list;
pub mod poses;
pub mod preset;
pub mod ranger_log;
pub mod relations;
pub mod revolution_log;
pub mod rooms;
pub mod ros;
pub mod rover_log;
mod rows;
pub mod slamlab;
pub mod smap;
mod text_log;
pub mod tum;
pub mod world;

pub use field_error::FieldError;
pub use left_out::{LeftOut, Tally};
pub use text_log::TextLogError;
pub(crate) use text_log::is_empty_or_comment;

/// Maps with more cells than this are refused: a square kilometre in cells of 10 cm.
const MOST_CELLS: usize = 100_000_000;

/// Recorded data for tests: a file in the data folder beside the repository, or in `SLAMLAB_DATA`
/// if that is set. `None` if it is absent; this is then noted for `cargo xtask test` in the file
/// that `SLAMLAB_SKIPPED` names.
#[cfg(test)]
#[expect(
    clippy::disallowed_methods,
    reason = "where recorded data lies is the machine's matter, and its tests read it"
)]
pub(crate) fn recorded(name: &str) -> Option<Vec<u8>> {
    use std::io::Write;

    let beside = concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/data");
    let folder = std::env::var("SLAMLAB_DATA").unwrap_or_else(|_| beside.into());
    let read = std::fs::read(format!("{folder}/{name}")).ok();
    if read.is_none() {
        let test = std::thread::current();
        let test = test.name().unwrap_or("a test");
        let skip = format!("{test}\trecorded data {name} is absent from {folder}");
        eprintln!("skipped: {skip}");
        if let Some(list) = std::env::var_os("SLAMLAB_SKIPPED") {
            let list = std::fs::OpenOptions::new()
                .append(true)
                .create(true)
                .open(list);
            list.and_then(|mut list| writeln!(list, "{skip}"))
                .expect("the list of skipped tests can be written");
        }
    }
    read
}

//! Readers and writers of files, over byte slices: opening and saving them is the caller's.

pub mod building;
pub mod calibration;
pub mod carmen;
pub mod firmware_header;
pub mod floor_plan;
pub mod map_server;
pub mod og_map;
pub mod preset;
pub mod relations;
pub mod rooms;
mod rows;
pub mod tum;
pub mod world;

pub use rows::RowError;

/// More cells than this are no map: a square kilometre in cells of 10 cm.
const MOST_CELLS: usize = 100_000_000;

/// Recorded data for tests: a file under the data folder beside the repository, or under `SLAMLAB_DATA` where that is
/// set. `None`, said plainly, where it is absent.
#[cfg(test)]
pub(crate) fn recorded(name: &str) -> Option<Vec<u8>> {
    let beside = concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/data");
    #[expect(
        clippy::disallowed_methods,
        reason = "where recorded data lies is the machine's matter"
    )]
    let folder = std::env::var("SLAMLAB_DATA").unwrap_or_else(|_| beside.into());
    #[expect(
        clippy::disallowed_methods,
        reason = "a test of recorded data reads it"
    )]
    let read = std::fs::read(format!("{folder}/{name}"));
    if read.is_err() {
        eprintln!("skipped: {folder}/{name} is absent");
    }
    read.ok()
}

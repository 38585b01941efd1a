//! Readers and writers of files, over byte slices: opening and saving them is the caller's.

pub mod carmen;
pub mod map_server;
pub mod relations;
pub mod tum;
pub mod world;

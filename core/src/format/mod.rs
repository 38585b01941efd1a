//! Files that others write and read: readers and writers over byte slices. Core does no I/O of its own.

pub mod carmen;
pub mod map_server;
pub mod relations;
pub mod tum;

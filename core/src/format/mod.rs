//! Readers and writers of files, over byte slices: opening and saving them is the caller's.

pub mod world;

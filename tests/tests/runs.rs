//! Whole runs, in one program: natively, and what must have the same bits in the browser there too.
#![allow(missing_docs)] // a test binary has no public interface

mod clockwise_lidar;
mod lessons;
mod same_bits;
mod same_run;
mod sim_loop;

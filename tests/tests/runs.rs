//! Whole runs, in one program: those that run only natively, and those that must also have the same
//! bits in the browser.
#![allow(missing_docs)] // a test binary has no public interface

mod clockwise_lidar;
mod lessons;
mod same_bits;
mod same_run;
mod sim_loop;

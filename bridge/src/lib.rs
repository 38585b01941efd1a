//! The bridge: serves the page to a browser on this machine or on the same network.
//!
//! In comes a listening socket, the folder of the built page and a future that ends when the program should stop;
//! out go HTTP answers.
//!
//! 1. [`bind`] opens the socket, and says in a sentence what to do when the port is taken.
//! 2. [`run`] refuses requests whose `Host` is a foreign name ([`host`]), finds the file, prefers its pre-compressed
//!    form, and adds the headers that fence the page in ([`headers`]).
//!
//! The folder is read at each request, so a rebuilt page needs a reload and not a restart.

pub mod doctor;
pub mod headers;
pub mod host;
mod listen;
pub mod serial;
mod serve;
pub mod source;

pub use listen::{BindError, bind};
pub use serve::{RunError, check_page, run};

//! The project's commands: from sources to a page that runs, and the proofs that it does.
//!
//! 1. [`wasm`] compiles `web` for wasm32 and makes the JavaScript bindings, in `www/pkg`.
//! 2. [`page`] installs the locked npm packages and bundles the page into `www/dist`.
//! 3. [`serve`] builds the bridge and becomes it.
//! 4. [`check`] and [`suites`] run every check and every test, and end with a table of what passed ([`report`]).
//!
//! [`tools`] finds the programs all this needs, and says how to install a missing one.

pub mod check;
pub mod firmware;
pub mod page;
pub mod report;
pub mod serve;
pub mod suites;
pub mod tools;
pub mod wasm;

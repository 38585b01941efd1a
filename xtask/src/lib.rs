//! The project's commands: from sources to a running page, and the checks that it works.
//!
//! 1. [`wasm`] compiles `web` for wasm32, makes the JavaScript bindings in `www/pkg`, and splits
//!    the module of runs in two: what a first visit runs, and the rest.
//! 2. [`page`] installs the locked npm packages and bundles the page into `www/dist`.
//! 3. [`serve`] builds the bridge and replaces itself by it.
//! 4. [`check`] and [`suites`] run every check and every test, and end with a table of what passed
//!    ([`report`]) and a list of what did not run ([`skips`]). [`setup`] installs what tests lack;
//!    [`rules`] checks the house rules.
//! 5. [`package`] makes the package for the robot's computer, [`dist`] the files for a web server,
//!    [`npm`] the package for programs of one's own.
//! 6. [`measure`] prints figures that the bridge promises, and whether they hold; [`browser_cost`]
//!    how much slower the core is in the browser; [`page_report`] what the page costs. [`results`]
//!    gathers all figures in `RESULTS.md`.
//!
//! [`tools`] finds the programs that all this needs, and says how to install a missing one.

pub mod browser_cost;
pub mod check;
pub mod dist;
pub mod firmware;
pub mod fleet_report;
pub mod measure;
pub mod npm;
#[cfg(unix)]
pub mod package;
pub mod page;
pub mod page_report;
pub mod report;
pub mod results;
pub mod rules;
pub mod serve;
pub mod setup;
pub mod skips;
pub mod suites;
pub mod tools;
pub mod wasm;

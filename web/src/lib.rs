//! Bindings of the core for the page.

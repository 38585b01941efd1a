//! The bridge: serves the page.

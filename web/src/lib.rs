//! Bindings of the core for the page.

use wasm_bindgen::prelude::wasm_bindgen;

/// The version of the core inside the module.
#[wasm_bindgen]
#[must_use]
pub fn version() -> String {
    env!("CARGO_PKG_VERSION").to_owned()
}

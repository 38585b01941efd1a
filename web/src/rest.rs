//! The rest of the module: what a first visit does not run is split off, and loaded on demand
//! (`xtask/src/bin/split-module`).

use wasm_bindgen::prelude::*;

#[wasm_bindgen]
extern "C" {
    #[wasm_bindgen(js_name = loadRest)]
    fn ask_for_rest();
}

/// Loads the rest by the worker's own `loadRest`, and returns when it is loaded. Code that needs
/// the rest calls this by itself.
#[wasm_bindgen]
pub fn load_rest() {
    ask_for_rest();
}

//! Prints what an update of the line filter costs in the browser. It measures and judges nothing,
//! so it is run only where it is asked for by name: by `cargo xtask report browser-cost`.
#![cfg(target_family = "wasm")]
#![allow(missing_docs, clippy::unwrap_used)] // a test binary has no public interface, and failing is its trade

use js_sys::{Function, Reflect};
use slamlab_tests::update_cost::update_ms;
use wasm_bindgen_test::{console_log, wasm_bindgen_test};

wasm_bindgen_test::wasm_bindgen_test_configure!(run_in_dedicated_worker);

#[wasm_bindgen_test]
fn update_cost() {
    let ms = update_ms(now_ms).unwrap();
    console_log!("update_ms {ms:?}");
}

/// `performance.now()`, which counts finer than `Date.now()`.
fn now_ms() -> f64 {
    let performance = Reflect::get(&js_sys::global(), &"performance".into()).unwrap();
    let now: Function = Reflect::get(&performance, &"now".into()).unwrap().into();
    now.call0(&performance).unwrap().as_f64().unwrap()
}

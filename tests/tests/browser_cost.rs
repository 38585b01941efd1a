//! Prints the cost of filter, registration and scan matching in the browser, the latter also on the
//! log beside this package's manifest, if there is one. It judges nothing, and is only run when it
//! is named: by `cargo xtask report browser-cost`.
#![cfg(target_family = "wasm")]
#![allow(missing_docs, clippy::unwrap_used)] // a test binary has no public interface, and failing is its trade

use js_sys::{Function, Reflect, Uint8Array};
use slamlab_tests::browser_cost::costs;
use wasm_bindgen_test::{console_log, wasm_bindgen_test};

wasm_bindgen_test::wasm_bindgen_test_configure!(run_in_dedicated_worker);

#[wasm_bindgen_test]
fn browser_cost() {
    for line in costs(now_ms, log().as_deref()).unwrap() {
        console_log!("{line}");
    }
}

/// `performance.now()`, which has a finer resolution than `Date.now()`.
fn now_ms() -> f64 {
    let performance = Reflect::get(&js_sys::global(), &"performance".into()).unwrap();
    let now: Function = Reflect::get(&performance, &"now".into()).unwrap().into();
    now.call0(&performance).unwrap().as_f64().unwrap()
}

/// The log that xtask has put where the test's server finds it.
fn log() -> Option<Vec<u8>> {
    let read = "(() => {
        const request = new XMLHttpRequest();
        request.open('GET', `${self.location.origin}/browser_cost.log.tmp`, false);
        request.responseType = 'arraybuffer';
        request.send();
        return request.status === 200 ? new Uint8Array(request.response) : null;
    })()";
    let read = js_sys::eval(read).unwrap();
    (!read.is_null()).then(|| Uint8Array::new(&read).to_vec())
}

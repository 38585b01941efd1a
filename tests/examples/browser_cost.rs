//! Prints what the line filter and scan matching cost natively; `cargo xtask report browser-cost`
//! compares it with the browser.

#[cfg(not(target_family = "wasm"))]
fn main() -> Result<(), slamlab_tests::browser_cost::CostError> {
    let begin = std::time::Instant::now();
    for line in slamlab_tests::browser_cost::costs(|| 1e3 * begin.elapsed().as_secs_f64())? {
        println!("{line}");
    }
    Ok(())
}

/// The browser's side is a test, because the test runner drives the browser.
#[cfg(target_family = "wasm")]
fn main() {}

//! Prints what an update of the line filter costs natively; `cargo xtask report browser-cost`
//! compares it with the browser.

#[cfg(not(target_family = "wasm"))]
fn main() -> Result<(), slamlab_core::estimation::EkfError> {
    let begin = std::time::Instant::now();
    let ms = slamlab_tests::update_cost::update_ms(|| 1e3 * begin.elapsed().as_secs_f64())?;
    println!("update_ms {ms:?}");
    Ok(())
}

/// The browser's side is a test, because the test runner drives the browser.
#[cfg(target_family = "wasm")]
fn main() {}

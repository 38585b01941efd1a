//! Prints the native cost of filter, registration and scan matching, the latter also on a log if
//! one is given; `cargo xtask report browser-cost` compares it with the browser.

#[cfg(not(target_family = "wasm"))]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let log = std::env::args_os().nth(1).map(std::fs::read).transpose()?;
    let begin = std::time::Instant::now();
    let now_ms = || 1e3 * begin.elapsed().as_secs_f64();
    for line in slamlab_tests::browser_cost::costs(now_ms, log.as_deref())? {
        println!("{line}");
    }
    Ok(())
}

/// In the browser this is a test, because the test runner drives the browser.
#[cfg(target_family = "wasm")]
fn main() {}

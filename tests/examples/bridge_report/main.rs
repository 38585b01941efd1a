//! Measures the bridge over real sockets on this machine, prints JSON, and exits with 0 only if all of it holds.
//!
//! `cargo run --release -p slamlab-tests --example bridge_report -- faults|latency|access`
#![cfg(not(target_family = "wasm"))] // opens sockets
#![allow(missing_docs, clippy::unwrap_used)] // a harness: failing is how it reports

// The tests' own robot and client, of which each report uses a part.
#[allow(dead_code)]
#[path = "../../tests/bridge_ws/client.rs"]
mod client;
#[allow(dead_code)]
#[path = "../../tests/bridge_ws/robot.rs"]
mod robot;

mod access;
mod faults;
mod latency;

use std::process::ExitCode;
use std::time::Duration;

use serde_json::Value;

#[tokio::main]
async fn main() -> ExitCode {
    let name = std::env::args().nth(1).unwrap_or_default();
    let (holds, report) = match name.as_str() {
        "faults" => faults::report().await,
        "latency" => latency::report().await,
        "access" => access::report().await,
        _ => {
            eprintln!("expected one of: faults, latency, access");
            return ExitCode::FAILURE;
        }
    };
    let whole = serde_json::json!({ "report": name, "holds": holds, "figures": report });
    println!("{}", serde_json::to_string_pretty(&whole).unwrap());
    if holds {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    }
}

/// Median, 99th percentile and worst, ms.
fn spread(mut all: Vec<Duration>) -> Value {
    all.sort_unstable();
    let millis = |part: f64| {
        let at = ((all.len() - 1) as f64 * part).round() as usize;
        (all[at].as_secs_f64() * 1e5).round() / 100.0
    };
    serde_json::json!({
        "count": all.len(), "median_ms": millis(0.5), "p99_ms": millis(0.99), "worst_ms": millis(1.0),
    })
}

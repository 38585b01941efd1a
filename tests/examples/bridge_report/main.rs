//! Measures the bridge over real sockets on this machine, prints JSON, and exits with 0 only if
//! everything holds.
//!
//! `cargo run --release -p slamlab-tests --example bridge_report -- faults [TRIALS]|line-faults
//! [TRIALS [FAULT...]]|latency|access [MINUTES]|soak [MINUTES]`
//!
//! `faults`, `latency` and `soak` use a router and a bucket that die and come back if the programs
//! of [`torn`] are named: `cargo xtask report soak --torn`.
#![cfg(not(target_family = "wasm"))] // opens sockets
#![allow(missing_docs, clippy::unwrap_used)] // a harness: failing is how it reports

// The tests' own robot and client; each report uses a part of them.
#[allow(dead_code)]
#[path = "../../tests/bridge_ws/client.rs"]
mod client;
#[allow(dead_code)]
#[path = "../../tests/bridge_ws/rights_stand.rs"]
mod rights_stand;
#[allow(dead_code)]
#[path = "../../tests/bridge_ws/robot.rs"]
mod robot;

#[path = "../router_report/started.rs"]
mod started;
#[allow(dead_code)]
#[path = "../router_report/web.rs"]
mod web;

mod access;
#[cfg(target_os = "linux")]
mod bridge_process;
mod crowding;
#[cfg(target_os = "linux")]
mod disk;
mod door;
#[cfg(target_os = "linux")]
mod edge;
mod faults;
#[cfg(target_os = "linux")]
mod flood;
#[cfg(target_os = "linux")]
mod hostile;
mod latency;
#[cfg(target_os = "linux")]
mod line_faults;
mod named;
#[cfg(target_os = "linux")]
mod soak;
#[cfg(target_os = "linux")]
mod soak_device;
#[cfg(target_os = "linux")]
mod stand;
mod torn;
#[cfg(target_os = "linux")]
mod trend;
mod words;

use std::process::ExitCode;
use std::sync::Arc;
use std::time::Duration;

use serde_json::Value;

#[tokio::main]
async fn main() -> ExitCode {
    let name = std::env::args().nth(1).unwrap_or_default();
    let torn = match name.as_str() {
        "faults" | "line-faults" | "latency" | "soak" => torn::Torn::start().await,
        _ => None,
    };
    let (mut holds, mut report) = match name.as_str() {
        "faults" => all_faults(number(100.0) as usize, torn.as_ref()).await,
        "latency" => latency::report(torn.as_ref()).await,
        "access" => access::report(number(5.0)).await,
        #[cfg(target_os = "linux")]
        "hostile" => {
            let address = std::env::args().nth(2).and_then(|word| word.parse().ok());
            let count = std::env::args().nth(3).and_then(|word| word.parse().ok());
            hostile::run(address.expect("an address"), count.expect("how many")).await;
            return ExitCode::SUCCESS;
        }
        #[cfg(target_os = "linux")]
        "line-faults" => line_faults::report(number(100.0) as usize, &names(), torn.as_ref())
            .await
            .expect("SLAMLAB_BRIDGE and SLAMLAB_RP6_SIM name the programs"),
        #[cfg(target_os = "linux")]
        "soak" => soak::report(number(30.0), torn.as_deref()).await,
        _ => {
            eprintln!(
                "expected one of: faults [TRIALS], line-faults [TRIALS [FAULT...]], latency, access [MINUTES], soak [MINUTES]"
            );
            return ExitCode::FAILURE;
        }
    };
    if let Some(torn) = torn {
        holds &= torn.was_torn();
        report["router_and_bucket_torn_away"] = torn.figures();
    }
    let whole = serde_json::json!({ "report": name, "holds": holds, "figures": report });
    println!("{}", serde_json::to_string_pretty(&whole).unwrap());
    if holds {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    }
}

/// At the registers of the real firmware, if its simulator is named, and at the robot's source.
async fn all_faults(trials: usize, torn: Option<&Arc<torn::Torn>>) -> (bool, Value) {
    let at_the_source = faults::report(trials, torn).await;
    #[cfg(target_os = "linux")]
    if let Some(at_the_registers) = line_faults::report(trials, &[], torn).await {
        return (
            at_the_source.0 && at_the_registers.0,
            serde_json::json!({ "at_the_registers": at_the_registers.1, "at_the_source": at_the_source.1 }),
        );
    }
    at_the_source
}

fn number(default: f64) -> f64 {
    let second = std::env::args().nth(2);
    second.map_or(default, |number| number.parse().unwrap())
}

/// The arguments after the number.
#[cfg(target_os = "linux")]
fn names() -> Vec<String> {
    std::env::args().skip(3).collect()
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

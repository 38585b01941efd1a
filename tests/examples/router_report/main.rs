//! Three bridges and a Zenoh router, each in a separate process, and clients behind the router:
//! prints JSON, and exits with 0 only if everything holds.
//!
//! `cargo xtask report router`; `cargo xtask report fleet`: the same robots as the page of the
//! fleet shows them, and a hundred simulated ones. Or with the programs already built:
//! `SLAMLAB_BRIDGE=… cargo run -p slamlab-tests --features zenoh --example router_report`
#![cfg(not(target_family = "wasm"))] // opens sockets
#![allow(missing_docs, clippy::unwrap_used)] // a harness: failing is how it reports

// The tests' own client over a WebSocket, of which this uses a part.
#[allow(dead_code)]
#[path = "../../tests/bridge_ws/client.rs"]
mod client;

mod drive;
mod driver;
mod fleet;
mod lost;
mod many;
mod process;
mod remote;
mod slow;
mod started;
mod trust;
mod web;
mod words;

use std::process::ExitCode;
use std::time::Duration;

use serde_json::{Value, json};

#[tokio::main]
async fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    if let [word, config] = words.as_slice()
        && word == "router"
    {
        process::be_router(config).await;
        return ExitCode::SUCCESS;
    }
    if let [word, endpoint, count] = words.as_slice()
        && word == "robots"
    {
        many::be_robots(endpoint, count.parse().unwrap()).await;
        return ExitCode::SUCCESS;
    }
    if let [word, endpoint, robot, token] = words.as_slice()
        && word == "driver"
    {
        driver::be_driver(endpoint, robot, token).await;
        return ExitCode::SUCCESS;
    }
    let holds = match words.as_slice() {
        [word] if word == "fleet" => fleet_holds().await,
        [] => router_holds().await,
        other => panic!("{other:?}: expected nothing, or `fleet`"),
    };
    match holds {
        true => ExitCode::SUCCESS,
        false => ExitCode::FAILURE,
    }
}

async fn router_holds() -> bool {
    let figures = [
        ("driven_and_stopped", drive::report().await),
        ("router_killed", lost::report().await),
        ("slow_link", slow::report().await),
        ("certificates", trust::report().await),
        ("words", words::report().await),
    ];
    print("router", figures)
}

async fn fleet_holds() -> bool {
    let figures = [
        ("three_bridges", fleet::report().await),
        ("driven_and_stopped", drive::report().await),
        ("simulated_robots", many::report().await),
    ];
    print("fleet", figures)
}

/// Prints the report; returns whether everything holds.
fn print<const N: usize>(report: &str, all: [(&str, (bool, Value)); N]) -> bool {
    let mut figures = serde_json::Map::new();
    let mut holds = true;
    for (name, (one_holds, figure)) in all {
        holds &= one_holds;
        figures.insert(
            name.to_owned(),
            json!({ "holds": one_holds, "figures": figure }),
        );
    }
    let whole = json!({ "report": report, "holds": holds, "figures": figures });
    println!("{}", serde_json::to_string_pretty(&whole).unwrap());
    holds
}

fn millis(duration: Duration) -> f64 {
    (duration.as_secs_f64() * 1e5).round() / 100.0
}

/// The value below which this part of all values lies, ms.
fn part(all: &[Duration], part: f64) -> f64 {
    let mut sorted = all.to_vec();
    sorted.sort_unstable();
    let at = (sorted.len().saturating_sub(1) as f64 * part).round() as usize;
    sorted.get(at).map_or(f64::INFINITY, |one| millis(*one))
}

fn spread(all: &[Duration]) -> Value {
    json!({
        "count": all.len(), "median_ms": part(all, 0.5), "p99_ms": part(all, 0.99), "worst_ms": part(all, 1.0),
    })
}

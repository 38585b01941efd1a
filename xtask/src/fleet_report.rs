//! `router` and `fleet`: robots at a Zenoh router, and the page that shows them all.
//!
//! Separate from the other reports because what they measure is built with a feature that takes
//! minutes to compile, in the profile of the tests, which have already compiled most of the rest.
//!
//! | part of `fleet` | by |
//! |---|---|
//! | bridges, simulated robots, cost of a robot | `tests/examples/router_report` |
//! | the page of one of three bridges: seen, stopped, missed | `tests/page/fleet_router.measure.ts` |
//! | frames per second with a hundred robots | `tests/page/fleet.measure.ts` |

use std::path::Path;
use std::process::{Command, Stdio};

use anyhow::{Context, Result, bail};
use serde_json::{Value, json};

use crate::wasm::Profile;
use crate::{page, page_report, tools};

const PROGRAMS: &str = "build --profile test --quiet --package slamlab-bridge --package slamlab-tests \
                        --features slamlab-bridge/zenoh,slamlab-tests/zenoh --bin slamlab-bridge --example router_report";

/// Robots at a router, without a page.
///
/// # Errors
/// If something does not compile, or a figure does not hold.
pub fn router() -> Result<()> {
    tools::run_cargo(PROGRAMS)?;
    tools::run(&mut reporter(&tools::built("debug/slamlab-bridge")))
}

/// All parts of `fleet`, as one JSON object; if one fails, the next is still measured.
///
/// # Errors
/// If something cannot be built, or a figure does not hold.
pub fn report() -> Result<()> {
    let bridge = page::build_with_bridge(Profile::Release, PROGRAMS)?;
    let mut parts = serde_json::Map::new();
    parts.insert("bridges".into(), of_bridges(&bridge)?);
    for (name, file) in [
        ("page_of_three_bridges", "fleet_router.measure.ts"),
        ("pictures_of_many_robots", "fleet.measure.ts"),
    ] {
        let part = of_page(name, file, &bridge).unwrap_or_else(|error| {
            let why = format!("{error:#}");
            json!({ "holds": false, "error": why })
        });
        parts.insert(name.into(), part);
    }
    let failed: Vec<String> = parts
        .iter()
        .filter(|(_, part)| part["holds"] != true)
        .map(|(name, _)| name.clone())
        .collect();
    let whole = json!({ "report": "fleet", "holds": failed.is_empty(), "figures": parts });
    println!("{whole:#}");
    if !failed.is_empty() {
        bail!("it does not hold: {}", failed.join(", "));
    }
    Ok(())
}

fn reporter(bridge: &Path) -> Command {
    let mut command = Command::new(tools::built("debug/examples/router_report"));
    command.env("SLAMLAB_BRIDGE", bridge);
    command
}

/// The program exits with failure if something does not hold; its output says what.
fn of_bridges(bridge: &Path) -> Result<Value> {
    let mut command = reporter(bridge);
    let output = command.arg("fleet").stderr(Stdio::inherit()).output();
    let output = output.context("cannot start the report of the fleet")?;
    serde_json::from_slice(&output.stdout).with_context(|| {
        format!(
            "the report of the fleet ended without figures ({})",
            output.status
        )
    })
}

fn of_page(name: &str, file: &str, bridge: &Path) -> Result<Value> {
    let router = tools::built("debug/examples/router_report");
    let router = router.to_str().context("a path that is no text")?;
    let settings = [("SLAMLAB_ROUTER", router)];
    let (figures, judged) = page_report::figures(name, file, bridge, &settings)?;
    let mut figures: Value =
        serde_json::from_str(&figures).with_context(|| format!("{file} left no JSON"))?;
    // A test may fail for something other than its figures, such as what the page logs.
    if let Err(error) = judged {
        figures["holds"] = false.into();
        figures["error"] = format!("{error:#}").into();
    }
    Ok(figures)
}

//! Measures what is promised of page and bridge: figures as JSON, and whether they hold.

use std::process::Command;

use anyhow::{Result, bail};
use clap::{Args, ValueEnum};

use crate::{browser_cost, firmware, fleet_report, page_report, tools};

/// What to measure, and for how long.
#[derive(Debug, Args)]
pub struct Measurement {
    /// What to measure
    #[arg(value_enum)]
    promise: Promise,
    /// How long to soak (30), to fuzz each decoder (10), to flood the bridge (5), or to run the
    /// page at top speed (2)
    #[arg(long)]
    minutes: Option<f64>,
    /// How often each fault is tried
    #[arg(long, default_value_t = 100)]
    trials: usize,
    /// Measure faults, latency or soak of bridges at a Zenoh router and with a bucket for their
    /// recordings, both of which die and come back all the time
    #[arg(long)]
    torn: bool,
}

/// What can be measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Promise {
    /// From a fault to motors without voltage, by the registers of the real firmware, and to the
    /// order to stop
    Faults,
    /// From the robot to a client, alone and beside 50 watchers
    Latency,
    /// Who is refused, and how; and that a flood of hostile clients keeps nobody from driving,
    /// watching and stopping
    Access,
    /// An hour of recording through a link that breaks 20 times: every piece that counts as stored
    /// is in the bucket of a real S3-compatible server, byte for byte
    Upload,
    /// Three robots at a Zenoh router: one driven through it and stopped by others, the router
    /// killed and started again, certificates that are foreign, settings that cannot be
    Router,
    /// Three bridges that see and stop each other through a router, by their pages too; 10, 30 and
    /// 100 simulated robots, whose states are at most a second old, all stop, and are drawn 30
    /// times a second
    Fleet,
    /// Nothing grows: 24 simulated hours of a device, and a bridge in real time
    Soak,
    /// No decoder crashes on changed input
    Fuzz,
    /// An update of the line filter, a registration and a scan of scan matching in headless
    /// Chromium take at most 1.5 times as long as natively
    BrowserCost,
    /// The page in headless Chromium: weight of a first visit, first picture, map, pictures, long
    /// tasks, input to picture, memory, and a large map
    Page,
    /// The page in headless Chromium has time for 60 pictures a second while a recorded building
    /// plays at 50 times its speed
    PageFrames,
}

const TORN: &str = "build --profile test --quiet --package slamlab-bridge --package slamlab-tests --package slamlab-storage-report \
                    --features slamlab-bridge/zenoh,slamlab-bridge/storage,slamlab-tests/zenoh --bin slamlab-bridge \
                    --bin slamlab-storage-report --example router_report --example bridge_report";

/// Measures it; the bridge over sockets of this machine.
///
/// # Errors
/// If a figure does not hold.
pub fn measure(what: &Measurement) -> Result<()> {
    let can_be_torn = matches!(
        what.promise,
        Promise::Faults | Promise::Latency | Promise::Soak
    );
    if what.torn && !can_be_torn {
        bail!("--torn goes with faults, latency and soak");
    }
    let minutes = |default: f64| what.minutes.unwrap_or(default).to_string();
    let (example, words) = match what.promise {
        Promise::BrowserCost => return browser_cost::report(),
        Promise::Page => return page_report::report(&minutes(2.0)),
        Promise::PageFrames => return page_report::frames(),
        // In a package of its own, because its dependencies take minutes to compile.
        Promise::Upload => {
            return tools::run_cargo("run --release --quiet --package slamlab-storage-report");
        }
        Promise::Router => return fleet_report::router(),
        Promise::Fleet => return fleet_report::report(),
        Promise::Fuzz => ("fuzz", vec![minutes(10.0)]),
        Promise::Soak => ("bridge_report", vec!["soak".to_owned(), minutes(30.0)]),
        Promise::Access => ("bridge_report", vec!["access".to_owned(), minutes(5.0)]),
        Promise::Latency => ("bridge_report", vec!["latency".to_owned()]),
        Promise::Faults => {
            let words = vec!["faults".to_owned(), what.trials.to_string()];
            ("bridge_report", words)
        }
    };
    let mut measurer = match what.torn {
        true => torn(example)?,
        false => whole(example)?,
    };
    if matches!(what.promise, Promise::Faults | Promise::Latency) {
        match firmware::build_simulator()? {
            Some(robot) => _ = measurer.env("SLAMLAB_RP6_SIM", robot),
            // Latency is also measured from an encoder's edge, but only if the simulator is there.
            None if what.promise == Promise::Latency => (),
            None => bail!("the faults are measured at the registers of the real firmware"),
        }
    }
    tools::run(measurer.args(words))
}

/// The measuring program, without its arguments. Some reports need the bridge in a separate
/// process.
fn whole(example: &str) -> Result<Command> {
    tools::run_cargo("build --release --quiet --package slamlab-bridge")?;
    let run = "run --release --quiet --package slamlab-tests --example";
    let mut cargo = tools::cargo();
    cargo
        .env("SLAMLAB_BRIDGE", tools::built("release/slamlab-bridge"))
        .args(run.split(' '))
        .args([example, "--"]);
    Ok(cargo)
}

/// The same with a router and a bucket that die, in the profile of the tests, as for `router`:
/// Zenoh and the store's dependencies take minutes to compile.
fn torn(example: &str) -> Result<Command> {
    tools::run_cargo(TORN)?;
    let mut measurer = Command::new(tools::built(&format!("debug/examples/{example}")));
    measurer
        .env("SLAMLAB_BRIDGE", tools::built("debug/slamlab-bridge"))
        .env(
            "SLAMLAB_ROUTER",
            tools::built("debug/examples/router_report"),
        )
        .env(
            "SLAMLAB_STORE",
            tools::built("debug/slamlab-storage-report"),
        );
    Ok(measurer)
}

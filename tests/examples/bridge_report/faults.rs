//! Time from a fault to the stop order at the robot, many times with random timing.

use std::sync::Arc;
use std::time::{Duration, Instant};

use serde_json::{Map, Value};
use slamlab_core::wire::message::ToBridge;

use crate::client::Bridge;
use crate::robot::{Memory, with_robot};
use crate::torn::Torn;

const LIMIT: Duration = Duration::from_millis(250);

/// What breaks.
#[derive(Clone, Copy, Debug)]
enum Fault {
    DriverKilled,
    NetworkSwallowsAll,
    CablePulled,
    TakenOver,
    WatcherStops,
    BridgeTerminated,
}

const ALL: [Fault; 6] = [
    Fault::DriverKilled,
    Fault::NetworkSwallowsAll,
    Fault::CablePulled,
    Fault::TakenOver,
    Fault::WatcherStops,
    Fault::BridgeTerminated,
];

pub(crate) async fn report(trials: usize, torn: Option<&Arc<Torn>>) -> (bool, Value) {
    let mut figures = Map::new();
    let mut holds = true;
    let mut numbers = slamlab_tests::numbers();
    for fault in ALL {
        let mut took = Vec::new();
        while took.len() < trials {
            // Eight robots at a time, because a trial is mostly waiting.
            let delays: Vec<f64> = numbers.by_ref().take(8.min(trials - took.len())).collect();
            let trials = delays.into_iter().map(|delay| {
                let delay = Duration::from_secs_f64(0.1 + 0.2 * delay);
                tokio::spawn(trial(fault, delay, torn.cloned()))
            });
            for trial in trials.collect::<Vec<_>>() {
                took.push(trial.await.unwrap());
            }
        }
        holds &= took.iter().all(|took| *took < LIMIT);
        figures.insert(format!("{fault:?}"), crate::spread(took));
    }
    figures.insert("limit_ms".into(), (LIMIT.as_millis() as u64).into());
    (holds, figures.into())
}

async fn trial(fault: Fault, delay: Duration, torn: Option<Arc<Torn>>) -> Duration {
    let (mut config, memory) = with_robot();
    if let Some(torn) = &torn {
        config = torn.on(config);
    }
    let bridge = Bridge::start(config).await;
    if let Some(torn) = &torn {
        torn.settle(bridge.address).await;
    }
    let mut other = bridge.driver().await;
    let mut driver = bridge.armed().await;
    driver.drive_for(delay, 0.2).await;
    let from = Instant::now();
    match fault {
        Fault::DriverKilled => drop(driver),
        Fault::NetworkSwallowsAll => return stopped(&memory, from, bridge).await,
        Fault::CablePulled => memory.cut(true),
        Fault::TakenOver => other.say(ToBridge::Take { force: true }).await,
        Fault::WatcherStops => other.say(ToBridge::Stop).await,
        Fault::BridgeTerminated => {
            bridge.stop().await;
            return memory.stopped_after(from).await;
        }
    }
    stopped(&memory, from, bridge).await
}

async fn stopped(memory: &Memory, from: Instant, bridge: Bridge) -> Duration {
    let took = memory.stopped_after(from).await;
    bridge.stop().await;
    took
}

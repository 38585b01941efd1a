//! From the robot's thread to a client in the same process, over a socket of this machine: 200
//! readings a second and the scans of a lidar, in three cases: alone, beside 50 watchers, and the
//! same with a bridge that maps. Delays, and messages a second to all clients. Then what 50
//! watchers cost a bridge in a separate process, which simulates its robot and records: part of one
//! core, and its private memory. And from an encoder's edge: [`crate::edge`].

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use slamlab_bridge::MapConfig;
use slamlab_core::wire::message::{FromBridge, ToBridge};

#[cfg(target_os = "linux")]
use crate::bridge_process::BridgeProcess;
use crate::client::{Bridge, Came, Client};
use crate::robot::with_robot;
use crate::torn::Torn;
use crate::web;

const MEASURED: Duration = Duration::from_secs(10);
const MEDIAN_MS: f64 = 10.0;
const P99_MS: f64 = 25.0;
const RELAYED: f64 = 10_000.0;
const WATCHERS: usize = 50;

pub(crate) async fn report(torn: Option<&Arc<Torn>>) -> (bool, Value) {
    let edge = edge(torn.cloned()).await;
    let torn = torn.map(Arc::as_ref);
    let alone = measure(0, None, torn).await;
    let crowded = measure(WATCHERS, None, torn).await;
    let mapping = measure(WATCHERS, Some(MapConfig::default()), torn).await;
    let relayed = crowded["messages_a_second"].as_f64();
    let is_in_time = is_below(&alone) && is_below(&crowded) && is_below(&mapping);
    let of_it = &edge["of_it_bridge"];
    let is_in_time = is_in_time && is_below(of_it);
    let holds = is_in_time && relayed.is_some_and(|relayed| relayed >= RELAYED);
    let figures = json!({
        "cost_of_50_watchers": cost(torn).await, "encoder_edge_to_client": edge,
        "robot_to_client_alone": alone, "robot_to_client_beside_50_watchers": crowded,
        "the_same_of_a_bridge_that_maps": mapping,
        "limits_ms": { "median": MEDIAN_MS, "p99": P99_MS }, "least_messages_a_second": RELAYED,
    });
    (holds, figures)
}

fn is_below(figures: &Value) -> bool {
    let below = |name: &str, limit| figures[name].as_f64().is_some_and(|ms| ms < limit);
    below("median_ms", MEDIAN_MS) && below("p99_ms", P99_MS)
}

/// `null` if the simulator of the firmware is not named: what was not measured does not hold.
async fn edge(torn: Option<Arc<Torn>>) -> Value {
    #[cfg(target_os = "linux")]
    if let Some(figures) = crate::edge::measure(torn).await {
        return figures;
    }
    Value::Null
}

async fn measure(watchers: usize, map: Option<MapConfig>, torn: Option<&Torn>) -> Value {
    let (mut config, memory) = with_robot();
    let is_mapping = map.is_some();
    config.map = map;
    if let Some(torn) = torn {
        config = torn.on(config);
    }
    let bridge = Bridge::start(config).await;
    if let Some(torn) = torn {
        torn.settle(bridge.address).await;
    }
    let (mut others, received) = (Vec::new(), Arc::new(AtomicU64::new(0)));
    for _ in 0..watchers {
        others.push(tokio::spawn(watch(
            bridge.watcher().await,
            received.clone(),
        )));
    }
    let mut client = bridge.watcher().await;
    received.store(0, Ordering::Relaxed);
    let (start, mut said) = (Instant::now(), Instant::now());
    let mut took = Vec::new();
    while start.elapsed() < MEASURED {
        if said.elapsed() > Duration::from_secs(1) {
            said = Instant::now();
            client.say(ToBridge::Heartbeat).await;
        }
        if let Came::Message(FromBridge::Odometry(body)) = client.next().await
            && let Some(sent) = memory.sent(body.to)
        {
            took.push(sent.elapsed());
        }
    }
    let rate = (received.load(Ordering::Relaxed) + took.len() as u64) as f64
        / start.elapsed().as_secs_f64();
    if is_mapping {
        let (status, body) = web::ask(bridge.address, "GET", "/map.yaml", None).await;
        assert_eq!(status, 200, "{body}");
    }
    bridge.stop().await;
    for other in others {
        other.await.unwrap();
    }
    let mut figures = crate::spread(took);
    figures["messages_a_second"] = json!(rate.round());
    figures
}

/// Reads and counts all messages to the end.
async fn watch(mut watcher: Client, received: Arc<AtomicU64>) {
    let mut beat = tokio::time::interval(Duration::from_secs(1));
    loop {
        tokio::select! {
            _ = beat.tick() => watcher.say(ToBridge::Heartbeat).await,
            came = watcher.next() => match came {
                Came::Message(_) => _ = received.fetch_add(1, Ordering::Relaxed),
                _ => return,
            },
        }
    }
}

/// `null` if there is no bridge in a separate process, or no `/proc`.
async fn cost(torn: Option<&Torn>) -> Value {
    #[cfg(target_os = "linux")]
    if let Ok(program) = std::env::var("SLAMLAB_BRIDGE") {
        let folder = tempfile::tempdir().unwrap();
        let recording = folder.path().join("a.mcap");
        let source = "sim:arena,lidar";
        let bridge = BridgeProcess::start(&program, source, folder.path(), recording, torn).await;
        let received = Arc::new(AtomicU64::new(0));
        let mut watchers = Vec::new();
        for _ in 0..WATCHERS {
            let mut watcher = Client::connect(bridge.address, "").await;
            watcher.enter(None).await;
            watchers.push(tokio::spawn(watch(watcher, received.clone())));
        }
        let before = (bridge.processor_seconds(), received.load(Ordering::Relaxed));
        let start = Instant::now();
        tokio::time::sleep(MEASURED).await;
        let seconds = start.elapsed().as_secs_f64();
        let figures = json!({
            "part_of_a_core": (bridge.processor_seconds() - before.0) / seconds,
            "messages_a_second": ((received.load(Ordering::Relaxed) - before.1) as f64 / seconds).round(),
            "anonymous_kb": bridge.anonymous_kb(),
        });
        bridge.kill().await;
        return figures;
    }
    Value::Null
}

//! From the robot's thread to a client in the same process, over a socket of this machine: 200 readings a second and the
//! scans of a lidar, alone and beside 50 watchers.

use std::time::{Duration, Instant};

use serde_json::{Value, json};
use slamlab_core::wire::message::{FromBridge, ToBridge};

use crate::client::{Bridge, Came};
use crate::robot::with_robot;

const MEASURED: Duration = Duration::from_secs(10);
const MEDIAN_MS: f64 = 10.0;
const P99_MS: f64 = 25.0;

pub(crate) async fn report() -> (bool, Value) {
    let alone = measure(0).await;
    let crowded = measure(50).await;
    let holds = [&alone, &crowded].iter().all(|figures| {
        let below = |name: &str, limit| figures[name].as_f64().is_some_and(|ms| ms < limit);
        below("median_ms", MEDIAN_MS) && below("p99_ms", P99_MS)
    });
    let figures = json!({
        "robot_to_client_alone": alone, "robot_to_client_beside_50_watchers": crowded,
        "limits_ms": { "median": MEDIAN_MS, "p99": P99_MS },
    });
    (holds, figures)
}

async fn measure(watchers: usize) -> Value {
    let (config, memory) = with_robot();
    let bridge = Bridge::start(config).await;
    let mut others = Vec::new();
    for _ in 0..watchers {
        let mut watcher = bridge.watcher().await;
        others.push(tokio::spawn(async move {
            let mut beat = tokio::time::interval(Duration::from_secs(1));
            loop {
                tokio::select! {
                    _ = beat.tick() => watcher.say(ToBridge::Heartbeat).await,
                    came = watcher.next() => if !matches!(came, Came::Message(_)) { return },
                }
            }
        }));
    }
    let mut client = bridge.watcher().await;
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
    bridge.stop().await;
    for other in others {
        other.await.unwrap();
    }
    crate::spread(took)
}

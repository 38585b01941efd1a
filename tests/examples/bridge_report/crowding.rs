//! What a watcher without the token can do to others, case by case: each was possible once.

use std::time::{Duration, Instant};

use serde_json::{Map, Value, json};
use slamlab_bridge::{Config, Limits};
use slamlab_core::wire::message::{FromBridge, ToBridge, Watching};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::time::timeout;

use crate::client::{Bridge, Came, Client, limits, stream_from};
use crate::robot::{is_stop, with_robot};

const SOON: Duration = Duration::from_secs(5);

/// Each case, and whether all hold.
pub(crate) async fn report() -> (bool, Map<String, Value>) {
    let mut cases = Map::new();
    cases.insert("390 stops in one burst".into(), burst().await);
    cases.insert("299 watchers, then the owner".into(), crowd().await);
    cases.insert("figures of a private bridge".into(), private().await);
    let holds = cases.values().all(|case| case["holds"] == true);
    (holds, cases)
}

/// Driver and honest watcher stay connected, and the robot gets at most ten orders a second.
async fn burst() -> Value {
    let (config, memory) = with_robot();
    let bridge = Bridge::start(config).await;
    let mut honest = bridge.watcher().await;
    let mut driver = bridge.armed().await;
    let mut hostile = bridge.watcher().await;
    memory.forget();
    let begun = Instant::now();
    for _ in 0..390 {
        hostile.say(ToBridge::Stop).await;
    }
    let first = memory.stopped_after(begun).await;
    tokio::time::sleep(Duration::from_millis(500)).await;
    let orders = memory.orders();
    let stops = orders.iter().filter(|(_, order)| is_stop(order)).count();
    let stayed = [answers(&mut honest).await, answers(&mut driver).await];
    bridge.stop().await;
    let most = 1 + (begun.elapsed().as_millis() / 100) as usize;
    json!({
        "holds": stayed == [true; 2] && stops <= most,
        "watcher_stays": stayed[0], "driver_stays": stayed[1],
        "first_stop_ms": first.as_secs_f64() * 1e3, "orders_to_stop": stops,
    })
}

/// Whether its connection still works.
async fn answers(client: &mut Client) -> bool {
    client.say(ToBridge::Probe { token: 1 }).await;
    let answer = async {
        loop {
            match client.next().await {
                Came::Message(FromBridge::Probe(_)) => return true,
                Came::Message(_) => (),
                Came::Closed(_) | Came::Lost => return false,
            }
        }
    };
    timeout(SOON, answer).await.unwrap_or(false)
}

/// Watchers from as many addresses as it takes; and as many connections that never say anything.
async fn crowd() -> Value {
    let (config, memory) = with_robot();
    let limits = Limits {
        // None of them sends anything more.
        heartbeat: Duration::from_secs(3600),
        ..limits()
    };
    let bridge = Bridge::start(Config { limits, ..config }).await;
    let mut open = vec![];
    for number in 0..299_u32 {
        let last = 2 + (number % 5) as u8;
        if let Ok(mut client) = timeout(SOON, Client::connect_from(bridge.address, last)).await {
            let hello = client.hello(None);
            client.say(hello).await;
            open.push(client);
        }
    }
    let mut idle = vec![];
    for number in 0..150 {
        idle.push(stream_from(bridge.address, 2 + number % 5).await);
    }
    let from = Instant::now();
    // A refused connection ends in a panic, so it runs in a task.
    let address = bridge.address;
    let token = bridge.token.clone();
    let owner = tokio::spawn(async move {
        let mut owner = Client::connect(address, "").await;
        let may_drive = owner.enter(Some(&token)).await;
        owner.say(ToBridge::Stop).await;
        (owner, may_drive)
    });
    let came_in = timeout(SOON, owner).await.is_ok_and(|came| came.is_ok());
    let stopped = timeout(SOON, memory.stopped_after(from)).await.ok();
    bridge.stop().await;
    json!({
        "holds": came_in && stopped.is_some(), "owner_came_in": came_in,
        "stopped_after_ms": stopped.map(|took| took.as_secs_f64() * 1e3),
    })
}

async fn private() -> Value {
    let (config, _) = with_robot();
    let bridge = Bridge::start(Config {
        watching: Some(Watching::Token),
        ..config
    })
    .await;
    let mut said = vec![];
    for path in ["/bridge.json", "/metrics"] {
        said.push(get(&bridge, path).await);
    }
    bridge.stop().await;
    let tells = |text: &String| text.contains("sources") || text.contains("slamlab_");
    json!({ "holds": !said.iter().any(tells), "said": said })
}

pub(crate) async fn get(bridge: &Bridge, path: &str) -> String {
    let mut stream = TcpStream::connect(bridge.address).await.unwrap();
    let host = bridge.address;
    let request = format!("GET {path} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n");
    stream.write_all(request.as_bytes()).await.unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).await.unwrap();
    let (_, body) = answer.split_once("\r\n\r\n").unwrap_or_default();
    body.to_owned()
}

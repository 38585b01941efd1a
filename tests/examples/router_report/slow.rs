//! A link to the router that is slower than the robot's data: what arrives is recent, and a stop
//! does not wait for it.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use slamlab_core::wire::message::{Format, FromBridge, ToBridge, decode};
use tokio::io::{AsyncReadExt, AsyncWriteExt, copy};
use tokio::net::{TcpSocket, TcpStream};
use tokio::time::sleep;

use crate::client::Client;
use crate::process::{Bridge, Router};
use crate::remote;
use crate::started::free_port;
use crate::{part, spread};

const NAME: &str = "emma";
/// Rate of the link from the bridge to the router, bytes a second; odometry and scans of the
/// simulated robot need several times as many.
const RATE: u64 = 30_000;
const TRIALS: usize = 10;
/// Maximum time from a stop at the router until the bridge has disarmed.
const STOP_MS: f64 = 100.0;
/// Maximum age of readings that arrive: what the system and Zenoh buffer at that rate, and no
/// growing queue.
const AGE_MS: f64 = 4000.0;

pub(crate) async fn report() -> (bool, Value) {
    let endpoint = format!("tcp/127.0.0.1:{}", free_port());
    let router = Router::start(&endpoint, &json!({})).await;
    let narrow = narrow(endpoint.trim_start_matches("tcp/").to_owned());
    let bridge = Bridge::start(&["--zenoh", &narrow, "--zenoh-name", NAME]).await;
    let session = remote::session(&endpoint, &json!({})).await;
    let found = remote::wait_for(&session, NAME, 1).await.is_some();
    let mut direct = Client::connect(bridge.address, "").await;
    direct.enter(Some(&bridge.token)).await;
    let (newest, bytes) = (Arc::new(AtomicU64::new(0)), Arc::new(AtomicU64::new(0)));
    let (seen, counted) = (Arc::clone(&newest), Arc::clone(&bytes));
    // All streams, because a bridge sends none that is not requested.
    let reading = session
        .declare_subscriber(format!("slamlab/{NAME}/*"))
        .callback(move |sample| {
            counted.fetch_add(sample.payload().len() as u64, Ordering::Relaxed);
            let read = decode::<FromBridge>(&sample.payload().to_bytes(), Format::Json);
            if let Ok((header, FromBridge::Odometry(_))) = read {
                seen.store(header.micros, Ordering::Relaxed);
            }
        })
        .await
        .unwrap();
    // Until every buffer that can fill up is full.
    look_for(&mut direct, Duration::from_secs(8)).await;
    let (mut stops, mut ages) = (vec![], vec![]);
    let (before, since) = (bytes.load(Ordering::Relaxed), Instant::now());
    for _ in 0..TRIALS {
        direct.take(true).await;
        direct.arm().await;
        look_for(&mut direct, Duration::from_millis(300)).await;
        let age = direct.seen.saturating_sub(newest.load(Ordering::Relaxed));
        ages.push(Duration::from_micros(age));
        let begun = Instant::now();
        session.put("slamlab/*/stop", "").await.unwrap();
        let is_disarmed =
            |message: &FromBridge| matches!(message, FromBridge::Safety(state) if !state.armed);
        direct
            .wait(|message| is_disarmed(message).then_some(()))
            .await;
        stops.push(begun.elapsed());
    }
    let came = bytes.load(Ordering::Relaxed) - before;
    let rate = (came as f64 / since.elapsed().as_secs_f64()).round();
    drop(reading);
    bridge.kill().await;
    router.kill().await;
    // Otherwise the link was not the bottleneck.
    let is_full = rate >= 0.6 * RATE as f64;
    let holds = found && is_full && part(&stops, 1.0) <= STOP_MS && part(&ages, 1.0) <= AGE_MS;
    let figures = json!({
        "bytes_a_second": RATE, "of_them_payload": rate, "from_stop_at_router_to_disarmed": spread(&stops),
        "age_of_odometry_at_router": spread(&ages), "limits": { "stop_ms": STOP_MS, "age_ms": AGE_MS },
    });
    (holds, figures)
}

/// Reads what arrives over the direct path, so its newest message is what the bridge sends now.
async fn look_for(direct: &mut Client, duration: Duration) {
    let (begun, mut beat) = (Instant::now(), Instant::now());
    while begun.elapsed() < duration {
        if beat.elapsed() > Duration::from_secs(1) {
            beat = Instant::now();
            direct.say(ToBridge::Heartbeat).await;
        }
        direct.next().await;
    }
}

/// A proxy to `router` that accepts [`RATE`] from whoever connects; returns its endpoint.
fn narrow(router: String) -> String {
    let socket = TcpSocket::new_v4().unwrap();
    // Inherited by accepted sockets: otherwise the system buffers much of what should wait.
    socket.set_recv_buffer_size(4096).unwrap();
    socket.bind(([127, 0, 0, 1], 0).into()).unwrap();
    let listener = socket.listen(4).unwrap();
    let endpoint = format!("tcp/{}", listener.local_addr().unwrap());
    tokio::spawn(async move {
        while let Ok((bridge, _)) = listener.accept().await {
            let Ok(router) = TcpStream::connect(&router).await else {
                continue;
            };
            let (mut from_bridge, mut to_bridge) = bridge.into_split();
            let (mut from_router, mut to_router) = router.into_split();
            tokio::spawn(async move { copy(&mut from_router, &mut to_bridge).await });
            tokio::spawn(async move {
                let mut bytes = [0; 1024];
                while let Ok(count @ 1..) = from_bridge.read(&mut bytes).await {
                    if to_router.write_all(&bytes[..count]).await.is_err() {
                        return;
                    }
                    sleep(Duration::from_micros(count as u64 * 1_000_000 / RATE)).await;
                }
            });
        }
    });
    endpoint
}

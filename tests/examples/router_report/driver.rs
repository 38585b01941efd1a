//! A driver in a separate process, for the tests of the page: takes one robot through the router by
//! a right, drives it to and fro until it is stopped, and prints what it was told.
//!
//! Out, one line each: `there` once it is connected; `driving` once the robot's odometry shows
//! motion; `{"reason": …, "told_at_ms": …}` (Unix time) when it is disarmed; `still` when the
//! odometry shows that it stands.

use std::time::{Duration, SystemTime, UNIX_EPOCH};

use serde_json::json;
use slamlab_core::wire::message::{Format, FromBridge, decode};
use tokio::sync::mpsc;
use tokio::time::{Instant, timeout, timeout_at};

use crate::remote::{self, Came, Remote};
use crate::started::NEVER;

/// Time between two orders.
const ORDER: Duration = Duration::from_millis(50);
/// It reverses after this time, because it is in a room.
const ONE_WAY: Duration = Duration::from_millis(1500);
const SPEED: f64 = 0.1;
/// Below this speed it counts as standing, m/s.
const STANDS: f64 = 1e-3;

/// Runs until the robot was stopped and stands.
pub(crate) async fn be_driver(endpoint: &str, robot: &str, token: &str) {
    let session = remote::session(endpoint, &json!({})).await;
    let (sender, mut speeds) = mpsc::unbounded_channel();
    let _listening = session
        .declare_subscriber(format!("slamlab/{robot}/odometry"))
        .callback(move |sample| {
            let read = decode(&sample.payload().to_bytes(), Format::Json);
            if let Ok((_, FromBridge::Odometry(step))) = read {
                let seconds = (step.to - step.from) as f64 / 1e6;
                let _ = sender.send(step.motion[0] / seconds);
            }
        })
        .await
        .unwrap();
    let number = u64::from(std::process::id());
    let mut driver = Remote::enter(&session, robot, number, Some(token)).await;
    println!("there");
    driver.take_and_arm().await;
    let (begun, mut has_moved) = (Instant::now(), false);
    while driver.safety.armed {
        let ways = begun.elapsed().as_millis() / ONE_WAY.as_millis();
        let forward = if ways.is_multiple_of(2) {
            SPEED
        } else {
            -SPEED
        };
        driver.drive(forward).await;
        while let Ok(speed) = speeds.try_recv() {
            if !has_moved && speed.abs() > SPEED / 2.0 {
                has_moved = true;
                println!("driving");
            }
        }
        let next = Instant::now() + ORDER;
        while driver.safety.armed
            && let Ok(came) = timeout_at(next, driver.next()).await
        {
            if !matches!(came, Some(Came::Message(_))) {
                panic!("it was shown out: {came:?}");
            }
        }
    }
    let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap();
    let told =
        json!({ "reason": driver.safety.reason.name(), "told_at_ms": now.as_millis() as u64 });
    println!("{told}");
    let stands = async { while speeds.recv().await.is_none_or(|speed| speed.abs() > STANDS) {} };
    timeout(NEVER, stands).await.expect("it goes on");
    println!("still");
}

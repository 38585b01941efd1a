//! The router is killed while a robot is driven through it, and started again: the robot stops as
//! on any lost link, is still served at its own address, and comes back to the router.

use std::time::{Duration, Instant};

use serde_json::{Value, json};
use slamlab_core::wire::message::{DisarmReason, FromBridge, ToBridge};
use tokio::time::sleep;

use crate::client::Client;
use crate::millis;
use crate::process::{Bridge, Router};
use crate::remote::{self, Remote};
use crate::started::free_port;

const NAME: &str = "doris";
const TRIALS: u64 = 5;
/// Maximum time from the router's end to a robot at rest: 200 ms without an order, and braking.
const STOPPED_MS: f64 = 1000.0;
/// Maximum time from the router's return to the robot's: pauses between attempts grow to 4 s, and
/// the name is then checked for duplicates.
const BACK_MS: f64 = 10_000.0;

pub(crate) async fn report() -> (bool, Value) {
    let endpoint = format!("tcp/127.0.0.1:{}", free_port());
    let bridge = Bridge::start(&["--zenoh", &endpoint, "--zenoh-name", NAME]).await;
    let (mut stopped, mut back, mut reasons) = (vec![], vec![], vec![]);
    for trial in 0..TRIALS {
        let router = Router::start(&endpoint, &json!({})).await;
        let begun = Instant::now();
        let session = remote::session(&endpoint, &json!({})).await;
        let came = remote::wait_for(&session, NAME, 1).await;
        back.push(came.map_or(f64::INFINITY, |_| millis(begun.elapsed())));
        let mut driver = Remote::enter(&session, NAME, trial + 1, Some(&bridge.token)).await;
        driver.take_and_arm().await;
        let mut watcher = Client::connect(bridge.address, "").await;
        watcher.enter(None).await;
        let begun = Instant::now();
        while begun.elapsed() < Duration::from_secs(1) {
            driver.drive(0.1).await;
            while driver.try_next().is_some() {}
            sleep(Duration::from_millis(50)).await;
        }
        wait_until(&mut watcher, |speed, _| speed > 0.05).await;
        router.kill().await;
        let killed = Instant::now();
        let mut still = None;
        let mut why = DisarmReason::Start;
        wait_until(&mut watcher, |speed, disarmed| {
            if speed.abs() < 1e-3 {
                still.get_or_insert(killed.elapsed());
            } else {
                still = None;
            }
            why = disarmed.unwrap_or(why);
            still.is_some() && disarmed.is_some()
        })
        .await;
        stopped.push(still.map_or(f64::INFINITY, millis));
        reasons.push(why.name());
        // Without a router no message can reach it any more.
        let _ = tokio::time::timeout(Duration::from_secs(1), async { session.close().await }).await;
    }
    let is_said = bridge.says("is lost: it is gone").await;
    bridge.kill().await;
    let worst = |all: &[f64]| all.iter().copied().fold(0.0, f64::max);
    let holds = is_said && worst(&stopped) <= STOPPED_MS && worst(&back) <= BACK_MS;
    let figures = json!({
        "trials": TRIALS, "from_kill_to_still_ms": stopped, "why": reasons,
        "from_router_to_robot_ms": back, "it_was_said": is_said,
        "limits": { "still_ms": STOPPED_MS, "back_ms": BACK_MS },
    });
    (holds, figures)
}

/// Reads until the speed (m/s) and the reason of a disarmed robot are as expected.
async fn wait_until(
    watcher: &mut Client,
    mut holds: impl FnMut(f64, Option<DisarmReason>) -> bool,
) {
    let (mut speed, mut disarmed) = (f64::NAN, None);
    let mut beat = Instant::now();
    watcher.say(ToBridge::Heartbeat).await;
    loop {
        if beat.elapsed() > Duration::from_secs(1) {
            beat = Instant::now();
            watcher.say(ToBridge::Heartbeat).await;
        }
        let found = watcher
            .wait(|message| match message {
                FromBridge::Odometry(body) => {
                    let seconds = (body.to - body.from) as f64 / 1e6;
                    speed = body.motion[0] / seconds;
                    Some(())
                }
                FromBridge::Safety(state) => {
                    disarmed = (!state.armed).then_some(state.reason);
                    Some(())
                }
                FromBridge::Heartbeat(_) => Some(()),
                _ => None,
            })
            .await;
        let () = found;
        if holds(speed, disarmed) {
            return;
        }
    }
}

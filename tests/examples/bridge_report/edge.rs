//! From the edge of an encoder to a client, with the real firmware on its line of 38400 baud.
//!
//! 1. The robot stands; the simulator is asked for the time of the next edge.
//! 2. A driver turns the robot. Three times are taken, all by the clock of this machine: by the
//!    simulator, the edge, and when the telemetry that reports it had left the chip; by the client,
//!    the first odometry that is not at rest.
//!
//! Firmware and line take up to a period of telemetry (20 ms) plus the time of its bytes; the rest,
//! the bridge's part, is judged. A trial without an answer counts as one of [`LONGEST`], unless the
//! simulator itself was kept waiting meanwhile; repeated trials are counted.

use std::sync::Arc;
use std::time::{Duration, SystemTime};

use serde_json::{Value, json};
use slamlab_core::robot::Command;
use slamlab_core::wire::message::{FromBridge, ToBridge};

use crate::client::{Came, Client};
use crate::stand::Stand;
use crate::torn::Torn;

const TRIALS: usize = 100;
/// Maximum waiting time of a trial.
const LONGEST: Duration = Duration::from_secs(2);
/// Real time that the simulated robot may lose in a trial, s.
const CALM: f64 = 0.01;

/// `None` if the programs are not named.
pub(crate) async fn measure(torn: Option<Arc<Torn>>) -> Option<Value> {
    let bridge = std::env::var("SLAMLAB_BRIDGE").ok()?;
    let robot = std::env::var("SLAMLAB_RP6_SIM").ok()?;
    let mut stand = Stand::start(&bridge, &robot, torn).await;
    let mut driver = stand.driver().await;
    let (mut whole, mut robots, mut bridges) = (Vec::new(), Vec::new(), Vec::new());
    let (mut repeated, mut unanswered) = (0, 0);
    // A slow machine may stop a robot; too many such trials are no measurement.
    for _ in 0..2 * TRIALS {
        if whole.len() == TRIALS {
            break;
        }
        rest(&mut driver).await;
        let before = stand.robot.ask("facts").await["lost"].as_f64();
        stand.robot.ask("edge").await;
        let came = first_motion(&mut driver).await;
        let facts = stand.robot.ask("facts").await;
        let instants = facts["edge"][0].as_f64().zip(facts["edge"][1].as_f64());
        let lost = facts["lost"].as_f64().zip(before);
        let is_calm = lost.is_some_and(|(after, before)| after - before < CALM);
        match (came, instants) {
            (Some(came), Some((edge, reported))) if edge <= reported && reported <= came => {
                whole.push(Duration::from_secs_f64(came - edge));
                robots.push(Duration::from_secs_f64(reported - edge));
                bridges.push(Duration::from_secs_f64(came - reported));
            }
            (None, _) if is_calm => {
                unanswered += 1;
                whole.push(LONGEST);
                bridges.push(LONGEST);
                driver = stand.driver().await;
            }
            _ => {
                repeated += 1;
                driver = stand.driver().await;
            }
        }
    }
    if whole.len() < TRIALS || robots.is_empty() {
        return Some(json!({
            "count": whole.len(), "wanted": TRIALS, "repeated": repeated, "unanswered": unanswered,
        }));
    }
    Some(json!({
        "repeated": repeated, "unanswered": unanswered,
        "edge_to_client": crate::spread(whole),
        "of_it_firmware_and_line": crate::spread(robots),
        "of_it_bridge": crate::spread(bridges),
    }))
}

/// Slows down and stands.
async fn rest(driver: &mut Client) {
    drive_until(driver, 0.0, Duration::from_millis(700), |_| false).await;
}

/// Unix time, s, at which the first odometry of the turning robot arrived.
async fn first_motion(driver: &mut Client) -> Option<f64> {
    let turns = |message: &FromBridge| matches!(message, FromBridge::Odometry(body) if body.motion != [0.0; 3]);
    let came = drive_until(driver, 0.6, LONGEST, turns).await?;
    let since = came.duration_since(SystemTime::UNIX_EPOCH).ok()?;
    Some(since.as_secs_f64())
}

/// Turns at 20 Hz until the searched event has come, or `time` is over.
async fn drive_until(
    driver: &mut Client,
    turn: f64,
    time: Duration,
    is_found: impl Fn(&FromBridge) -> bool,
) -> Option<SystemTime> {
    let mut ticks = tokio::time::interval(Duration::from_millis(50));
    let until = tokio::time::Instant::now() + time;
    let motion = Command::Velocity { forward: 0.0, turn };
    while tokio::time::Instant::now() < until {
        tokio::select! {
            _ = ticks.tick() => driver.say(ToBridge::Drive(driver.body(motion))).await,
            came = driver.next() => match came {
                Came::Message(message) if is_found(&message) => return Some(SystemTime::now()),
                Came::Message(_) => (),
                other => panic!("the driver was cut off: {other:?}"),
            },
        }
    }
    None
}

//! Faults with the real firmware at the other end: how long its motors still get voltage.
//!
//! 1. The bridge has to stop the robot within 250 ms, its frame's time on the line apart; where the bridge or the line is gone, the
//!    firmware alone within 400 ms. Both by the chip's registers and clock.
//! 2. After each, the robot must stand until somebody arms it.
//! 3. A trial in which the machine let the chip's clock run behind by more than `CALM` proves nothing, and is repeated.

use std::time::Duration;

use serde_json::{Map, Value, json};
use slamlab_core::wire::message::ToBridge;

use crate::stand::{Stand, turn};

const BRIDGE: f64 = 0.250;
const FIRMWARE: f64 = 0.400;
/// A stop on the line, and a period of the firmware's loop, s.
const LINE: f64 = 0.012;
const CALM: f64 = 0.02;

/// What breaks: its name, what is done to the robot's line, and who must stop it.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Fault {
    SerialCut,
    HalfFrame,
    Garbage115200,
    RobotReset,
    FlippedBitsAndDriverKilled,
    DriverKilled,
    NetworkSwallowsAll,
    TakenOver,
    BridgeKilled,
}

const ALL: [(Fault, f64); 9] = [
    (Fault::SerialCut, FIRMWARE),
    (Fault::HalfFrame, FIRMWARE),
    (Fault::Garbage115200, FIRMWARE),
    (Fault::RobotReset, FIRMWARE),
    (Fault::FlippedBitsAndDriverKilled, FIRMWARE),
    (Fault::DriverKilled, BRIDGE + LINE),
    (Fault::NetworkSwallowsAll, BRIDGE + LINE),
    (Fault::TakenOver, BRIDGE + LINE),
    (Fault::BridgeKilled, FIRMWARE),
];

/// `None` where the programs are not named.
pub(crate) async fn report(trials: usize) -> Option<(bool, Value)> {
    let bridge = std::env::var("SLAMLAB_BRIDGE").ok()?;
    let robot = std::env::var("SLAMLAB_RP6_SIM").ok()?;
    let mut stand = Stand::start(&bridge, &robot).await;
    let mut figures = Map::new();
    let mut holds = true;
    let mut numbers = slamlab_tests::numbers();
    for (fault, limit) in ALL {
        let (mut took, mut repeated) = (vec![], 0);
        while took.len() < trials {
            let delay = 0.2 * numbers.next().unwrap_or(0.5);
            match trial(&mut stand, fault, Duration::from_secs_f64(delay)).await {
                Some(seconds) => took.push(Duration::from_secs_f64(seconds)),
                None => repeated += 1,
            }
        }
        let is_in_time = took.iter().all(|took| took.as_secs_f64() <= limit);
        holds &= is_in_time;
        let mut figure = crate::spread(took);
        figure["limit_ms"] = json!(1e3 * limit);
        figure["holds"] = json!(is_in_time);
        figure["repeated"] = json!(repeated);
        eprintln!("{fault:?}: {figure}");
        figures.insert(format!("{fault:?}"), figure);
    }
    Some((holds, figures.into()))
}

/// Seconds of the chip until its registers were 0; `None` where the machine was too slow to say.
async fn trial(stand: &mut Stand, fault: Fault, delay: Duration) -> Option<f64> {
    let mut driver = stand.driver().await;
    let mut other = stand.watcher().await;
    turn(&mut driver, delay).await;
    let before = stand.robot.ask("facts").await["behind"].as_f64()?;
    if fault != Fault::RobotReset {
        stand.robot.ask("mark").await;
    }
    match fault {
        Fault::SerialCut => drop(stand.robot.ask("pull").await),
        Fault::HalfFrame => drop(stand.robot.ask("half").await),
        Fault::Garbage115200 => drop(stand.robot.ask("garble").await),
        Fault::RobotReset => drop(stand.robot.ask("reset").await),
        Fault::FlippedBitsAndDriverKilled => {
            stand.robot.ask("noise 0.001").await;
            drop(driver);
        }
        Fault::DriverKilled => drop(driver),
        // It neither reads nor writes any more, and its socket stays open.
        Fault::NetworkSwallowsAll => (),
        Fault::TakenOver => other.say(ToBridge::Stop).await,
        Fault::BridgeKilled => stand.kill_bridge().await,
    }
    let (took, behind) = stand.robot.stopped().await;
    let still_runs = took.is_none() && stand.robot.moves().await;
    assert!(!still_runs, "{fault:?}: its motors ran on for 10 s");
    stand.robot.ask("mend").await;
    stand.robot.ask("plug").await;
    assert!(
        !stand.robot.moves().await,
        "{fault:?}: it goes on by itself"
    );
    // None: a machine that was too slow had stopped it before the fault.
    took.filter(|_| behind - before < CALM)
}

//! Fifty hostile clients for some minutes: the driver's messages are answered in time, no honest
//! client is closed, a newcomer stops the robot, and memory does not grow.

use std::process::Stdio;
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use slamlab_core::wire::message::{FromBridge, ToBridge};
use tokio::process::{Child, Command};
use tokio::task::JoinHandle;
use tokio::time::sleep;

use crate::client::{Bridge, Came, Client};
use crate::robot::{Memory, with_robot};

const HOSTILE: usize = 50;
const HONEST: usize = 5;
/// Maximum 99th percentile of the driver's probes.
const DRIVER_P99: Duration = Duration::from_millis(20);
/// Maximum time from the connection of a newcomer to its stop order at the robot.
const STOP: Duration = Duration::from_millis(50);
/// How much memory may grow after the first fifth of the time, kB: that of a few sockets.
const GROWTH_KB: f64 = 8192.0;

pub(crate) async fn report(minutes: f64) -> (bool, Value) {
    let whole = Duration::from_secs_f64(60.0 * minutes);
    let (config, memory) = with_robot();
    let bridge = Bridge::start(config).await;
    let mut honest = vec![];
    for _ in 0..HONEST {
        honest.push(tokio::spawn(watch(bridge.watcher().await, whole)));
    }
    let driver = tokio::spawn(drive(bridge.driver().await, whole));
    let mut hostile = hostile_process(&bridge);
    let begun = Instant::now();
    let (mut stops, mut kilobytes) = (vec![], vec![]);
    while begun.elapsed() + Duration::from_secs(1) < whole {
        sleep(Duration::from_millis(500)).await;
        stops.push(newcomer(&bridge, &memory).await);
        memory.forget();
        kilobytes.push(anonymous_kb());
    }
    let is_running = hostile.try_wait().is_ok_and(|status| status.is_none());
    let driver = joined(driver).await;
    let mut stayed = 0;
    for watcher in honest {
        stayed += usize::from(joined(watcher).await.is_some());
    }
    let _ = hostile.kill().await;
    let turned_away = shown_out(&bridge).await;
    bridge.stop().await;

    let came = stops.iter().flatten().count();
    let worst = stops
        .iter()
        .flatten()
        .max()
        .copied()
        .unwrap_or(Duration::MAX);
    let settled = kilobytes.get(kilobytes.len() / 5..).unwrap_or_default();
    let grew = settled.last().unwrap_or(&0.0) - settled.first().unwrap_or(&0.0);
    let (armed, answers) = driver.clone().unwrap_or_default();
    let holds = is_running
        && answers.len() > 10
        && p99(&answers) <= DRIVER_P99
        && stayed == HONEST
        && came == stops.len()
        && worst <= STOP
        && grew <= GROWTH_KB;
    let figures = json!({
        "holds": holds, "minutes": minutes, "hostile_clients": HOSTILE,
        "hostile_still_at_it": is_running, "connections_of_theirs_that_were_ended": turned_away,
        "driver_stays": driver.is_some(), "driver_answer": spread_of(&answers), "driver_armed": armed,
        "honest_watchers": HONEST, "of_them_stayed": stayed,
        "newcomers": stops.len(), "newcomers_that_stopped": came,
        "stop_by_newcomer": spread_of(&stops.into_iter().flatten().collect::<Vec<_>>()),
        "memory_grew_kb": grew,
        "limits": { "driver_p99_ms": 20, "stop_ms": 50, "memory_kb": GROWTH_KB },
    });
    (holds, figures)
}

fn spread_of(all: &[Duration]) -> Value {
    match all.is_empty() {
        true => Value::Null,
        false => crate::spread(all.to_vec()),
    }
}

fn p99(all: &[Duration]) -> Duration {
    let mut sorted = all.to_vec();
    sorted.sort_unstable();
    let at = (sorted.len().saturating_sub(1) as f64 * 0.99).round() as usize;
    sorted.get(at).copied().unwrap_or(Duration::MAX)
}

/// The result of a client's task; none if its connection was closed.
async fn joined<T>(task: JoinHandle<Option<T>>) -> Option<T> {
    task.await.ok().flatten()
}

fn hostile_process(bridge: &Bridge) -> Child {
    let program = std::env::current_exe().unwrap();
    // In reality they would be other machines: their use of this one must not count for the bridge.
    Command::new("nice")
        .args(["-n", "19"])
        .arg(program)
        .args(["hostile", &bridge.address.to_string(), &HOSTILE.to_string()])
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .kill_on_drop(true)
        .spawn()
        .unwrap()
}

/// Drives as long as others let it, and measures ten times a second how long an answer takes;
/// returns how often it armed, and the times.
async fn drive(mut driver: Client, whole: Duration) -> Option<(u32, Vec<Duration>)> {
    driver.take(false).await;
    let epoch = driver.epoch;
    let begun = Instant::now();
    let mut ticks = tokio::time::interval(Duration::from_millis(100));
    let (mut armed, mut answers, mut asked) = (0, vec![], None);
    while begun.elapsed() < whole {
        tokio::select! {
            _ = ticks.tick() => {
                driver.say(ToBridge::Arm { epoch }).await;
                driver.drive(0.05, 0.0).await;
                if asked.is_none() {
                    asked = Some(Instant::now());
                    driver.say(ToBridge::Probe { token: 1 }).await;
                }
            }
            came = driver.next() => match came {
                Came::Message(FromBridge::Probe(_)) => answers.extend(asked.take().map(|at| at.elapsed())),
                Came::Message(FromBridge::Safety(state)) => armed += u32::from(state.armed),
                Came::Message(_) => (),
                Came::Closed(_) | Came::Lost => return None,
            }
        }
    }
    // An answer that never came counts with the time waited.
    answers.extend(
        asked
            .map(|at| at.elapsed())
            .filter(|took| *took > DRIVER_P99),
    );
    Some((armed, answers))
}

/// Watches to the end; none if it was closed.
async fn watch(mut watcher: Client, whole: Duration) -> Option<()> {
    let begun = Instant::now();
    let mut ticks = tokio::time::interval(Duration::from_secs(1));
    while begun.elapsed() < whole {
        tokio::select! {
            _ = ticks.tick() => watcher.say(ToBridge::Heartbeat).await,
            came = watcher.next() => match came {
                Came::Message(_) => (),
                Came::Closed(_) | Came::Lost => return None,
            }
        }
    }
    Some(())
}

/// A client without the token opens the page and stops the robot. Returns the time until the hub
/// has processed the stop, since messages of one client are processed in order; none if the client
/// was refused, or the robot was not stopped.
async fn newcomer(bridge: &Bridge, memory: &Memory) -> Option<Duration> {
    let from = Instant::now();
    let address = bridge.address;
    // A refused connection ends in a panic, so it runs in a task.
    let task = tokio::spawn(async move {
        let mut client = Client::connect(address, "").await;
        let hello = client.hello(None);
        client.say(hello).await;
        client.say(ToBridge::Stop).await;
        client.say(ToBridge::Probe { token: 1 }).await;
        let is_answer =
            |message: &FromBridge| matches!(message, FromBridge::Probe(_)).then_some(());
        client.wait(is_answer).await;
        from.elapsed()
    });
    let took = task.await.ok()?;
    // The robot's own thread takes the order a moment later.
    while !memory.stopped_since(from) && from.elapsed() < STOP {
        sleep(Duration::from_millis(1)).await;
    }
    // Its own order, or one less than 100 ms earlier that others caused.
    memory
        .stopped_since(from.checked_sub(Duration::from_millis(100))?)
        .then_some(took)
}

async fn shown_out(bridge: &Bridge) -> u64 {
    let text = crate::crowding::get(bridge, "/metrics").await;
    let lines = text.lines();
    let figure = |name: &str| {
        let mut lines = lines.clone().filter_map(|line| line.strip_prefix(name));
        lines
            .next()
            .and_then(|rest| rest.trim().parse().ok())
            .unwrap_or(0)
    };
    figure("slamlab_shown_out_total ")
}

/// Private memory of this process, which includes the bridge, kB, without what it shares with
/// files.
fn anonymous_kb() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = status
        .lines()
        .find_map(|line| line.strip_prefix("RssAnon:"));
    line.and_then(|rest| rest.split_whitespace().next()?.parse().ok())
        .unwrap()
}

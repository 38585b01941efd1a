//! Faults with the real firmware at the other end: how long its motors are still powered.
//!
//! 1. The bridge has to stop the robot within 250 ms, not counting its frame's time on the line; if
//!    the bridge or the line is gone, the firmware alone has to within 400 ms, not counting its
//!    last order's time on an intact line. Both are measured by the chip's registers and clock. A
//!    fault that must not stop the robot does not, and the robot still stops in time when its
//!    driver is gone.
//! 2. After each fault, the robot must stand until somebody arms it.
//! 3. Everything is recorded; what was acknowledged can be read after the disk was full, and after
//!    the bridge was killed.
//! 4. A trial in which the machine delayed the chip's clock by more than `CALM` proves nothing, and
//!    is repeated.
//! 5. A trial is mostly waiting: [`STANDS`] run in parallel, unless the fault itself is work.

use std::net::SocketAddr;
use std::sync::Arc;
use std::time::{Duration, Instant};

use serde_json::{Map, Value, json};
use slamlab_core::wire::message::{FromBridge, ToBridge};
use tokio::task::{JoinHandle, JoinSet};

use crate::client::{Came, Client};
use crate::stand::{Stand, turn};
use crate::torn::Torn;

const BRIDGE: f64 = 0.250;
const FIRMWARE: f64 = 0.400;
/// Time of a stop on the line, plus a period of the firmware's loop, s.
const LINE: f64 = 0.012;
const CALM: f64 = 0.02;
const STANDS: usize = 8;
/// Together with the watcher of each trial, the most that may watch.
const WATCHERS: u8 = 199;
/// A single address may not have as many.
const FROM_ONE_ADDRESS: u8 = 70;
/// Maximum time until a bridge has released the clients of an earlier trial, and lets new ones in.
const NEVER: Duration = Duration::from_secs(60);
/// Growth of a bridge's private memory over all faults that it survives that is still ignored, kB.
const LITTLE: f64 = 8192.0;

/// What breaks.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Fault {
    SerialCut,
    HalfFrame,
    FlippedBitsAndDriverKilled,
    Garbage115200,
    RobotReset,
    DriverKilled,
    NetworkSwallowsAll,
    BridgeKilled,
    DiskFull,
    ClockStepped,
    TwoDrivers,
    SlowWatcher,
    Watchers200,
    WatcherStops,
}

/// Each fault with the time limit of the part that must stop the robot.
const ALL: [(Fault, f64); 14] = [
    (Fault::SerialCut, FIRMWARE),
    (Fault::HalfFrame, FIRMWARE),
    (Fault::FlippedBitsAndDriverKilled, FIRMWARE),
    (Fault::Garbage115200, FIRMWARE),
    (Fault::RobotReset, FIRMWARE),
    (Fault::DriverKilled, BRIDGE + LINE),
    (Fault::NetworkSwallowsAll, BRIDGE + LINE),
    (Fault::BridgeKilled, FIRMWARE + LINE),
    (Fault::DiskFull, BRIDGE + LINE),
    (Fault::ClockStepped, BRIDGE + LINE),
    (Fault::TwoDrivers, BRIDGE + LINE),
    (Fault::SlowWatcher, BRIDGE + LINE),
    (Fault::Watchers200, BRIDGE + LINE),
    (Fault::WatcherStops, BRIDGE + LINE),
];

impl Fault {
    /// How many trials run in parallel; two hundred readers are work for the machine.
    fn at_once(self) -> usize {
        match self {
            Self::Watchers200 => 1,
            _ => STANDS,
        }
    }

    /// Whether each of its trials ends the bridge.
    fn ends_bridge(self) -> bool {
        self == Self::BridgeKilled || self.spoils()
    }

    /// Whether it breaks something around the bridge, which has to go on until it is killed.
    fn spoils(self) -> bool {
        matches!(self, Self::DiskFull | Self::ClockStepped)
    }
}

/// The results of the trials of a fault.
#[derive(Default)]
struct Tally {
    took: Vec<Duration>,
    repeated: usize,
    failures: Vec<String>,
    /// A bridge's private memory after each trial, kB.
    memory: Vec<f64>,
}

/// Only the named `faults`, all if none is named; `None` if the programs are not named.
pub(crate) async fn report(
    trials: usize,
    faults: &[String],
    torn: Option<&Arc<Torn>>,
) -> Option<(bool, Value)> {
    let bridge = std::env::var("SLAMLAB_BRIDGE").ok()?;
    let robot = std::env::var("SLAMLAB_RP6_SIM").ok()?;
    let mut stands = Vec::new();
    let (mut figures, mut holds) = (Map::new(), true);
    // Of bridges that live on from fault to fault, because a restarted one has more to upload.
    let (mut lives, mut life) = (Vec::new(), Vec::new());
    let mut numbers = slamlab_tests::numbers();
    let is_wanted = |(fault, _): &(Fault, f64)| {
        faults.is_empty() || faults.iter().any(|name| *name == format!("{fault:?}"))
    };
    for (fault, limit) in ALL.into_iter().filter(is_wanted) {
        // A robot that only waits is work for the machine, too.
        let at_once = fault.at_once().min(trials);
        stands.truncate(at_once);
        while stands.len() < at_once {
            stands.push(Stand::start(&bridge, &robot, torn.cloned()).await);
        }
        let tally = run(&mut stands, fault, &mut numbers, trials).await;
        let is_in_time = tally.took.iter().all(|took| took.as_secs_f64() <= limit);
        let is_whole = tally.took.len() == trials && tally.failures.is_empty();
        holds &= is_in_time && is_whole;
        let mut figure = match tally.took.is_empty() {
            true => json!({ "count": 0 }),
            false => crate::spread(tally.took),
        };
        figure["limit_ms"] = json!(1e3 * limit);
        figure["holds"] = json!(is_in_time && is_whole);
        figure["repeated"] = json!(tally.repeated);
        figure["failures"] = json!(tally.failures);
        let most = tally.memory.iter().copied().fold(0.0, f64::max);
        figure["bridge_anonymous_kb"] = json!(most);
        match fault.ends_bridge() {
            true => lives.push(std::mem::take(&mut life)),
            false => life.push(most),
        }
        eprintln!("{fault:?}: {figure}");
        figures.insert(format!("{fault:?}"), figure);
    }
    // 200 watchers take memory, which is not growth; they are judged by what is left after them.
    lives.push(life);
    let grown = |life: &Vec<f64>| Some(life.last()? - life.first()?);
    let is_bounded = lives.iter().filter_map(grown).all(|grown| grown < LITTLE);
    figures.insert("memory_is_bounded".into(), json!(is_bounded));
    Some((holds && is_bounded, figures.into()))
}

/// All trials of a fault, shared among the stands.
async fn run(
    stands: &mut Vec<Stand>,
    fault: Fault,
    numbers: &mut impl Iterator<Item = f64>,
    trials: usize,
) -> Tally {
    let at_once = stands.len();
    let mut busy: Vec<JoinHandle<(Stand, Tally)>> = Vec::new();
    for (number, stand) in stands.drain(..).enumerate() {
        let share = (trials + at_once - 1 - number) / at_once;
        let delays: Vec<f64> = numbers.by_ref().take(3 * share).collect();
        busy.push(tokio::spawn(alone(stand, fault, share, delays)));
    }
    let mut all = Tally::default();
    for stand in busy {
        let (stand, tally) = stand.await.unwrap();
        stands.push(stand);
        all.took.extend(tally.took);
        all.repeated += tally.repeated;
        all.failures.extend(tally.failures);
        all.memory.extend(tally.memory);
    }
    all
}

/// `share` trials at one stand, but no more than there are `delays`, each 0 to 1.
async fn alone(mut stand: Stand, fault: Fault, share: usize, delays: Vec<f64>) -> (Stand, Tally) {
    let mut tally = Tally::default();
    for delay in delays {
        if tally.took.len() + tally.failures.len() >= share {
            break;
        }
        let delay = Duration::from_secs_f64(0.1 + 0.2 * delay);
        let came = trial(&mut stand, fault, delay).await;
        // A bridge that a failed trial has spoilt cannot be used for the next.
        if fault.spoils() && !matches!(came, Ok(Some(_))) {
            tally.failures.extend(stand.kill_bridge(0).await.err());
        }
        match came {
            Ok(Some(seconds)) => tally.took.push(Duration::from_secs_f64(seconds)),
            Ok(None) => tally.repeated += 1,
            Err(failure) => tally.failures.push(failure),
        }
        tally.memory.extend(stand.anonymous_kb());
    }
    (stand, tally)
}

/// Time until the registers were 0, by the chip's clock, s; `None` if the machine was too slow to
/// tell.
async fn trial(stand: &mut Stand, fault: Fault, delay: Duration) -> Result<Option<f64>, String> {
    let mut driver = stand.driver().await;
    let mut other = stand.watcher().await;
    // They leave when the trial ends, however it ends.
    let _crowd = crowd(stand, fault).await;
    turn(&mut driver, delay).await;
    let report = prepare(stand, fault, &mut driver, &mut other).await;
    if !stand.robot.moves().await {
        // If the machine kept the driver waiting, that has stopped the robot; but if something is
        // already broken, the fault has.
        return match fault.spoils() {
            true => Err("it does not go on".into()),
            false => Ok(None),
        };
    }
    let before = stand.robot.ask("facts").await["behind"].as_f64();
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
        // It neither reads nor writes any more, and its socket stays open.
        Fault::NetworkSwallowsAll => (),
        Fault::TwoDrivers => {
            other = stand.other_driver().await;
            other.say(ToBridge::Take { force: true }).await;
        }
        Fault::WatcherStops => other.say(ToBridge::Stop).await,
        Fault::BridgeKilled => stand.kill_bridge(report).await?,
        _ => drop(driver),
    }
    let (took, behind) = stand.robot.stopped().await;
    if took.is_none() && stand.robot.moves().await {
        return Err("its motors ran on for 10 s".into());
    }
    stand.robot.ask("mend").await;
    stand.robot.ask("plug").await;
    if stand.robot.moves().await {
        return Err("it goes on by itself".into());
    }
    if fault.spoils() {
        stand.kill_bridge(report).await?;
    }
    // None if a machine that was too slow had stopped it before the fault.
    Ok(took.filter(|_| before.is_some_and(|before| behind - before < CALM)))
}

/// Breaks what is to be broken while the robot goes on; returns how many messages of the recording
/// were acknowledged by then.
async fn prepare(stand: &mut Stand, fault: Fault, driver: &mut Client, other: &mut Client) -> u64 {
    match fault {
        Fault::DiskFull => stand.bridge().fill_disk().await,
        Fault::ClockStepped => stand.bridge().step_clock(-3600),
        Fault::BridgeKilled => (),
        _ => return 0,
    }
    // It is reported within a second; meanwhile the robot is driven on.
    let is_full = fault == Fault::DiskFull;
    let report = other.wait(|message| match message {
        FromBridge::Recording(body) if body.fault.is_some() == is_full => Some(body.acknowledged),
        _ => None,
    });
    tokio::pin!(report);
    let report = loop {
        tokio::select! {
            report = &mut report => break report,
            () = turn(driver, Duration::from_millis(100)) => (),
        }
    };
    turn(driver, Duration::from_millis(100)).await;
    report
}

/// The other watchers, until they are dropped.
async fn crowd(stand: &Stand, fault: Fault) -> JoinSet<()> {
    let address = stand.bridge().address;
    let mut crowd = JoinSet::new();
    match fault {
        Fault::SlowWatcher => {
            let mut slow = Client::connect_narrow(address, 2048).await;
            slow.enter(None).await;
            // About 100 bytes each.
            crowd.spawn(watch(slow, Duration::from_millis(100)));
        }
        Fault::Watchers200 => {
            for number in 0..WATCHERS {
                let watcher = watcher_from(address, 2 + number / FROM_ONE_ADDRESS).await;
                crowd.spawn(watch(watcher, Duration::ZERO));
            }
        }
        _ => (),
    }
    crowd
}

/// A watcher from `127.0.0.LAST`, as soon as there is a place for it.
async fn watcher_from(address: SocketAddr, last: u8) -> Client {
    let until = Instant::now() + NEVER;
    loop {
        let mut client = Client::connect_from(address, last).await;
        let hello = client.hello(None);
        client.say(hello).await;
        loop {
            match client.next().await {
                Came::Message(FromBridge::Welcome(_)) => return client,
                Came::Message(_) => (),
                ended if Instant::now() > until => panic!("not let in: {ended:?}"),
                _ => break,
            }
        }
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
}

/// Keeps reading, with pauses.
async fn watch(mut client: Client, pause: Duration) {
    let mut said = Instant::now();
    loop {
        if said.elapsed() > Duration::from_secs(1) {
            said = Instant::now();
            client.say(ToBridge::Heartbeat).await;
        }
        if !matches!(client.next().await, Came::Message(_)) {
            return;
        }
        tokio::time::sleep(pause).await;
    }
}

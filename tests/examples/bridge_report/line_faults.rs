//! Faults with the real firmware at the other end: how long its motors still get voltage.
//!
//! 1. The bridge has to stop the robot within 250 ms, its frame's time on the line apart; where the
//!    bridge or the line is gone, the firmware alone within 400 ms, its last order's time on a
//!    whole line apart. Both by the chip's registers and clock. A fault that must not stop it does
//!    not, and the robot still stops in time when its driver is gone.
//! 2. After each, the robot must stand until somebody arms it.
//! 3. All is recorded; what was acknowledged can be read after the disk was full, and after the
//!    bridge was killed.
//! 4. A trial in which the machine let the chip's clock run behind by more than `CALM` proves
//!    nothing, and is repeated.
//! 5. Nearly all of a trial is waiting: [`STANDS`] run side by side, where the fault is no work.

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
/// A stop on the line, and a period of the firmware's loop, s.
const LINE: f64 = 0.012;
const CALM: f64 = 0.02;
const STANDS: usize = 8;
/// With the one that each trial has, as many as may watch.
const WATCHERS: u8 = 199;
/// From one address alone not so many may.
const FROM_ONE_ADDRESS: u8 = 70;
/// A bridge has let go of the clients of a trial before, and lets new ones in.
const NEVER: Duration = Duration::from_secs(60);
/// Growth of a bridge's own memory over all faults that it outlives that is none, kB.
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

/// With the limit of whoever must stop the robot.
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
    /// At so many stands side by side; two hundred readers are work for the machine.
    fn at_once(self) -> usize {
        match self {
            Self::Watchers200 => 1,
            _ => STANDS,
        }
    }

    /// Whether each of its trials is a bridge's last.
    fn ends_bridge(self) -> bool {
        self == Self::BridgeKilled || self.spoils()
    }

    /// Whether it breaks something around the bridge, which has to go on until it is killed.
    fn spoils(self) -> bool {
        matches!(self, Self::DiskFull | Self::ClockStepped)
    }
}

/// What came of the trials of a fault.
#[derive(Default)]
struct Tally {
    took: Vec<Duration>,
    repeated: usize,
    failures: Vec<String>,
    /// A bridge's own memory after each, kB.
    memory: Vec<f64>,
}

/// Those `faults` only whose names stand there, all if none does; `None` where the programs are not
/// named.
pub(crate) async fn report(
    trials: usize,
    faults: &[String],
    torn: Option<&Arc<Torn>>,
) -> Option<(bool, Value)> {
    let bridge = std::env::var("SLAMLAB_BRIDGE").ok()?;
    let robot = std::env::var("SLAMLAB_RP6_SIM").ok()?;
    let mut stands = Vec::new();
    let (mut figures, mut holds) = (Map::new(), true);
    // Of bridges that live on from fault to fault: one that is begun anew has more to upload.
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
    // 200 watchers have their price, which is no growth; they are judged by what is left after
    // them.
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

/// `share` trials at one stand; no more than there are `delays`, each 0 to 1.
async fn alone(mut stand: Stand, fault: Fault, share: usize, delays: Vec<f64>) -> (Stand, Tally) {
    let mut tally = Tally::default();
    for delay in delays {
        if tally.took.len() + tally.failures.len() >= share {
            break;
        }
        let delay = Duration::from_secs_f64(0.1 + 0.2 * delay);
        let came = trial(&mut stand, fault, delay).await;
        // A bridge that the trial spoilt before it broke off is no bridge for the next.
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

/// Seconds of the chip until its registers were 0; `None` where the machine was too slow to say.
async fn trial(stand: &mut Stand, fault: Fault, delay: Duration) -> Result<Option<f64>, String> {
    let mut driver = stand.driver().await;
    let mut other = stand.watcher().await;
    // They go at its end, however it ends.
    let _crowd = crowd(stand, fault).await;
    turn(&mut driver, delay).await;
    let report = prepare(stand, fault, &mut driver, &mut other).await;
    if !stand.robot.moves().await {
        // A machine that kept the driver waiting stopped it; but where something is broken already,
        // that did.
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
    // None: a machine that was too slow had stopped it before the fault.
    Ok(took.filter(|_| before.is_some_and(|before| behind - before < CALM)))
}

/// What breaks while the robot is to go on; how many messages of the recording were acknowledged by
/// then.
async fn prepare(stand: &mut Stand, fault: Fault, driver: &mut Client, other: &mut Client) -> u64 {
    match fault {
        Fault::DiskFull => stand.bridge().fill_disk().await,
        Fault::ClockStepped => stand.bridge().step_clock(-3600),
        Fault::BridgeKilled => (),
        _ => return 0,
    }
    // It is reported each second; meanwhile the robot is driven on.
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

/// Those who watch beside it, until they are dropped.
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

/// A watcher of `127.0.0.LAST`, as soon as there is a place for it.
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

/// Reads on, with pauses.
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

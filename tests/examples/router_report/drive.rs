//! Three robots at a router: one is driven by a right and stopped by others; how long that takes,
//! and whether any message of the safety path is lost.

use std::time::{Duration, Instant};

use serde_json::{Value, json};
use slamlab_core::wire::message::{DisarmReason, FromBridge, SafetyBody, ToBridge};
use tokio::task::JoinHandle;
use tokio::time::sleep;

use crate::client::{self, Client};
use crate::process::{Bridge, Router};
use crate::remote::{self, Came, Remote};
use crate::started::free_port;
use crate::{part, spread};

const NAMES: [&str; 3] = ["anna", "berta", "clara"];
/// How often the robot is driven and stopped.
const ROUNDS: usize = 20;
/// Driving time of each round.
const DRIVEN: Duration = Duration::from_millis(500);
/// Maximum delay that the path through the router may add to an answer.
const ADDED_P99_MS: f64 = 10.0;
/// Maximum time from a stop at the router until all are told.
const STOP_MS: f64 = 200.0;

pub(crate) async fn report() -> (bool, Value) {
    let endpoint = format!("tcp/127.0.0.1:{}", free_port());
    let mut bridges = vec![];
    for name in NAMES {
        bridges.push(Bridge::start(&["--zenoh", &endpoint, "--zenoh-name", name]).await);
    }
    // The router is started last: robots are served without it, and find it.
    let mut is_absent_said = true;
    for bridge in &bridges {
        is_absent_said &= bridge.says("no router answers at").await;
    }
    let router = Router::start(&endpoint, &json!({})).await;
    let session = remote::session(&router.endpoint, &json!({})).await;
    let found = remote::wait_for(&session, "*", NAMES.len()).await;

    let [anna, berta, clara] = bridges.try_into().ok().expect("there are three");
    let (_listening, mut at_router) = remote::safety(&session, NAMES[0]).await;
    let at_bridge = watch(anna.address);
    let mut driver = Remote::enter(&session, NAMES[0], 1, Some(&anna.token)).await;
    driver.take_and_arm().await;
    let mut direct = Client::connect(anna.address, "").await;
    direct.enter(None).await;
    let (mut through, mut straight, mut stops, mut moved) = (vec![], vec![], vec![], 0);
    for round in 0..ROUNDS {
        if round > 0 {
            driver.take_and_arm().await;
        }
        // Back and forth, because it is in a room.
        let forward = if round % 2 == 0 { 0.1 } else { -0.1 };
        let both = (&mut through, &mut straight);
        moved += usize::from(drive(&mut driver, &mut direct, both, forward).await);
        forge(&session, &driver).await;
        let stopper = remote::session(&router.endpoint, &json!({})).await;
        let begun = Instant::now();
        // In turns, as a client that enters for this purpose, and as any program that reaches the
        // router. It stays until it is done, because a disappearing token may overtake a message.
        let mut other = None;
        match round % 2 {
            0 => {
                let mut watcher = Remote::enter(&stopper, NAMES[0], 2, None).await;
                watcher.say(&ToBridge::Stop).await;
                other = Some(watcher);
            }
            _ => stopper.put("slamlab/*/stop", "").await.unwrap(),
        }
        stops.extend(wait_for_disarmed(&mut driver, begun, forward).await);
        drop(other);
        stopper.close().await.unwrap();
    }
    sleep(Duration::from_millis(500)).await;
    let told_at_bridge = end(at_bridge, &mut direct).await;
    let mut told_at_router = vec![];
    while let Ok(state) = at_router.try_recv() {
        told_at_router.push(state);
    }
    let lost = missing(&told_at_bridge, &told_at_router);
    let intruders = intruders(&session).await;
    let namesake = namesake(&session, &endpoint).await;
    for bridge in [anna, berta, clara] {
        bridge.kill().await;
    }
    router.kill().await;
    let added = part(&through, 0.99) - part(&straight, 0.99);
    let holds = is_absent_said
        && found.is_some()
        && moved == ROUNDS
        && stops.len() == ROUNDS
        && lost == 0
        && told_at_bridge.len() >= 2 * ROUNDS
        && added <= ADDED_P99_MS
        && part(&stops, 1.0) <= STOP_MS
        && intruders == [Some(4001), Some(4003)]
        && namesake;
    let figures = json!({
        "absent_router_was_said": is_absent_said, "robots_found_after_ms": found.map(crate::millis),
        "answer_through_router": spread(&through), "answer_over_websocket": spread(&straight),
        "added_p99_ms": (100.0 * added).round() / 100.0,
        "rounds": ROUNDS, "rounds_in_which_it_moved": moved, "from_stop_to_told": spread(&stops),
        "states_of_safety": told_at_bridge.len(), "of_them_lost_at_router": lost,
        "a_second_of_the_name_was_said_and_stays_away": namesake,
        "wrong_token_and_no_token_that_drives_are_shown_out_with": intruders,
        "limits": { "added_p99_ms": ADDED_P99_MS, "stop_ms": STOP_MS },
    });
    (holds, figures)
}

/// Drives, and meanwhile measures how long answers take on both paths; returns whether the robot
/// moved.
async fn drive(
    driver: &mut Remote,
    direct: &mut Client,
    (through, straight): (&mut Vec<Duration>, &mut Vec<Duration>),
    forward: f64,
) -> bool {
    let begun = Instant::now();
    let mut has_moved = false;
    while begun.elapsed() < DRIVEN {
        driver.drive(forward).await;
        let asked = Instant::now();
        driver.say(&ToBridge::Probe { token: 7 }).await;
        let is_answer = |message: &FromBridge| matches!(message, FromBridge::Probe(_));
        driver
            .wait(|message| is_answer(message).then_some(()))
            .await;
        through.push(asked.elapsed());
        let asked = Instant::now();
        direct.say(ToBridge::Probe { token: 7 }).await;
        direct
            .wait(|message| {
                if let FromBridge::Odometry(body) = message {
                    has_moved |= body.motion[0] * forward > 1e-5;
                }
                is_answer(message).then_some(())
            })
            .await;
        straight.push(asked.elapsed());
        // The direct path is asked less often than a watcher may speak.
        sleep(Duration::from_millis(60)).await;
    }
    has_moved
}

/// A stranger writes to the driver's key: it must neither end the lease nor the conversation.
async fn forge(session: &zenoh::Session, driver: &Remote) {
    let epoch = driver.epoch;
    for message in [ToBridge::Release { epoch }, ToBridge::EmergencyStop] {
        let payload = remote::written(1_000_000, &message);
        session.put(&driver.key, &payload).await.unwrap();
        let signed = session.put(&driver.key, &payload);
        signed.attachment(vec![7_u8; 32]).await.unwrap();
    }
    session.put(&driver.key, "no message").await.unwrap();
}

/// Drives on until it is told that the robot is disarmed; returns the time, if that stop was the
/// cause.
async fn wait_for_disarmed(driver: &mut Remote, begun: Instant, forward: f64) -> Option<Duration> {
    let mut driven = Instant::now();
    while driver.safety.armed {
        if let Some(Came::Closed(code)) = driver.try_next() {
            panic!("the driver was shown out: {code}");
        }
        if driven.elapsed() > Duration::from_millis(50) {
            driven = Instant::now();
            driver.drive(forward).await;
        }
        assert!(begun.elapsed() < crate::started::NEVER, "it never stopped");
        sleep(Duration::from_millis(1)).await;
    }
    (driver.safety.reason == DisarmReason::Stop).then(|| begun.elapsed())
}

/// Every safety state that the bridge itself reports, until the emergency stop that ends it.
fn watch(address: std::net::SocketAddr) -> JoinHandle<Vec<SafetyBody>> {
    tokio::spawn(async move {
        let mut watcher = Client::connect(address, "").await;
        watcher.enter(None).await;
        let mut states = vec![];
        let mut beat = Instant::now();
        loop {
            if beat.elapsed() > Duration::from_secs(1) {
                beat = Instant::now();
                watcher.say(ToBridge::Heartbeat).await;
            }
            if let client::Came::Message(FromBridge::Safety(state)) = watcher.next().await {
                let is_last = state.emergency;
                states.push(state);
                if is_last {
                    return states;
                }
            }
        }
    })
}

async fn end(watching: JoinHandle<Vec<SafetyBody>>, direct: &mut Client) -> Vec<SafetyBody> {
    direct.say(ToBridge::EmergencyStop).await;
    let states = watching.await.unwrap();
    sleep(Duration::from_millis(500)).await;
    states
}

/// How many of `all` are not in `told`, in their order. A newcomer is told the last earlier state
/// again, so the first may differ.
fn missing(all: &[SafetyBody], told: &[SafetyBody]) -> usize {
    let mut rest = told.iter();
    let is_missing = |state: &&SafetyBody| !rest.any(|one| one == *state);
    all.iter().skip(1).filter(is_missing).count()
}

/// A client with a wrong token, and one without that takes the lease: the codes with which they are
/// ended.
async fn intruders(session: &zenoh::Session) -> [Option<u64>; 2] {
    let mut wrong = Remote::connect(session, NAMES[1], 3).await;
    wrong.hello(Some("00112233445566778899aabbccddeeff")).await;
    let mut watcher = Remote::enter(session, NAMES[1], 4, None).await;
    watcher.say(&ToBridge::Take { force: true }).await;
    [wrong.end().await, watcher.end().await]
}

/// A fourth bridge with the first one's name: it reports that, and does not connect to the router.
async fn namesake(session: &zenoh::Session, endpoint: &str) -> bool {
    let second = Bridge::start(&["--zenoh", endpoint, "--zenoh-name", NAMES[0]]).await;
    let words = format!("is called {} already", NAMES[0]);
    let is_said = second.says(&words).await;
    let stays_away = remote::robots(session, NAMES[0]).await.len() == 1;
    second.kill().await;
    is_said && stays_away
}

//! A hundred simulated robots at a router, and what they cost the bridge whose page shows them;
//! from three such measurements, the cost per robot, and which limit is reached first with more
//! robots.
//!
//! A simulated robot has its own session, and sends what a bridge that maps sends: token, states, a
//! pose five times a second, a heartbeat each second. It drives in a circle until it is stopped.
//! Scans and odometry, which the fleet does not listen to, are left out.
//!
//! Zenoh is compiled here in the profile of the tests, without optimisation: the shipped program
//! needs less processor time, and as many bytes.

use std::f64::consts::TAU;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use slamlab_core::wire::message::{
    BatteryBody, BridgeHeartbeat, DisarmReason, Format, FromBridge, Header, MappingBody, PoseBody,
    PoseState, SafetyBody, encode,
};
use tokio::time::{interval, sleep};

use crate::process::{Bridge, Router, start_own};
use crate::started::{NEVER, free_port};
use crate::{remote, web};

/// Number of robots in each measurement.
const COUNTS: [usize; 3] = [10, 30, 100];
/// Number of robots in the fleet to extrapolate to.
const MANY: f64 = 10_000.0;
/// The resources available: cores for a bridge, bytes a second to a page (100 Mbit/s), MB for a
/// bridge; and slots, `MOST` of the bridge's table.
const CORES: f64 = 1.0;
const LINK: f64 = 12.5e6;
const MEMORY: f64 = 1000.0;
const SLOTS: f64 = 4096.0;
/// Duration of each measurement.
const WATCHED: Duration = Duration::from_secs(10);
/// Interval at which the page asks.
const ASK: Duration = Duration::from_millis(200);
/// Maximum age of any robot's pose, s.
const OLDEST: f64 = 1.0;
/// Interval between two poses of a robot.
const POSE: Duration = Duration::from_millis(200);
const MICROS: f64 = 1e6;
/// Clock ticks per second in `/proc/PID/stat`, on every Linux that this runs on.
const TICKS: f64 = 100.0;

/// Runs `count` robots, until it is killed.
pub(crate) async fn be_robots(endpoint: &str, count: usize) {
    let mut robots = vec![];
    for number in 0..count {
        robots.push(tokio::spawn(be_robot(endpoint.to_owned(), number, count)));
    }
    println!("there");
    for robot in robots {
        robot.await.unwrap();
    }
}

async fn be_robot(endpoint: String, number: usize, count: usize) {
    let session = remote::session(&endpoint, &json!({})).await;
    let key = move |name: &str| format!("slamlab/robot-{number:03}/{name}");
    let stopped = Arc::new(AtomicBool::new(false));
    let stops = Arc::clone(&stopped);
    let _stop = session
        .declare_subscriber(key("stop"))
        .callback(move |_| stops.store(true, Ordering::Relaxed))
        .await
        .unwrap();
    let answering = Arc::clone(&stopped);
    let _states = session
        .declare_queryable(key("*"))
        .callback(move |query| {
            use zenoh::Wait;
            let is_stopped = answering.load(Ordering::Relaxed);
            for (name, message) in [
                ("safety", safety(is_stopped)),
                ("mapping", mapping()),
                ("battery", battery()),
            ] {
                let key = key(name);
                let asked = zenoh::key_expr::KeyExpr::new(key.as_str()).unwrap();
                if query.key_expr().intersects(&asked) {
                    query.reply(&key, text(&message)).wait().unwrap();
                }
            }
        })
        .await
        .unwrap();
    let alive = key(&format!("alive/{}", session.zid()));
    let _token = session.liveliness().declare_token(alive).await.unwrap();
    // Side by side in rows, each on a circle of its own.
    let across = (count as f64).sqrt().ceil() as usize;
    let (x, y) = (
        (number % across) as f64 * 3.0,
        (number / across) as f64 * 3.0,
    );
    let (mut tick, mut way, mut told) = (interval(POSE), number as f64, false);
    for beat in 0_u64.. {
        tick.tick().await;
        let is_stopped = stopped.load(Ordering::Relaxed);
        if is_stopped != told {
            told = is_stopped;
            session
                .put(key("safety"), text(&safety(told)))
                .await
                .unwrap();
        }
        way += if is_stopped { 0.0 } else { 0.1 };
        let pose = FromBridge::Pose(PoseBody {
            stamp: beat,
            pose: [x + way.cos(), y + way.sin(), (way + TAU / 4.0) % TAU],
            cov: [0.0; 6],
            state: PoseState::Localised,
        });
        session.put(key("pose"), text(&pose)).await.unwrap();
        if beat % 5 == 0 {
            let beat = FromBridge::Heartbeat(BridgeHeartbeat {
                dropped: 0,
                clients: 1,
                robot_micros: beat,
            });
            session.put(key("heartbeat"), text(&beat)).await.unwrap();
        }
    }
}

fn safety(is_stopped: bool) -> FromBridge {
    FromBridge::Safety(SafetyBody {
        armed: !is_stopped,
        reason: DisarmReason::Stop,
        driver_name: "simulation".into(),
        ..SafetyBody::default()
    })
}

fn mapping() -> FromBridge {
    FromBridge::Mapping(MappingBody {
        file: "hall.slamlab".into(),
        ..MappingBody::default()
    })
}

fn battery() -> FromBridge {
    FromBridge::Battery(BatteryBody {
        source: 0,
        stamp: 0,
        volts: 7.4,
    })
}

fn text(message: &FromBridge) -> Vec<u8> {
    let header = Header {
        sequence: 0,
        micros: 0,
    };
    encode(header, message, Format::Json).unwrap()
}

pub(crate) async fn report() -> (bool, Value) {
    let (mut holds, mut figures) = (true, vec![]);
    for count in COUNTS {
        let (one_holds, figure) = measure(count).await;
        holds &= one_holds;
        figures.push(figure);
    }
    let cost = cost(&figures);
    (holds, json!({ "measured": figures, "cost": cost }))
}

/// The cost per robot, from straight lines through the measurements, and how many robots there is
/// room for.
fn cost(figures: &[Value]) -> Value {
    let mut room = vec![("slots_of_the_table", SLOTS)];
    let mut all = serde_json::Map::new();
    for (name, limit) in [
        ("cpu_of_the_bridge_share_of_a_core", CORES),
        ("bytes_a_second_to_a_page", LINK),
        ("memory_of_the_bridge_mb", MEMORY),
    ] {
        let number = |figure: &Value, key: &str| figure[key].as_f64().unwrap();
        let points = figures
            .iter()
            .map(|figure| (number(figure, "robots"), number(figure, name)));
        let Line { fixed, each, worst } = Line::through(&points.collect::<Vec<_>>());
        let most = ((limit - fixed) / each).floor();
        // If the cost does not grow, there is room for any number.
        if each > 0.0 {
            room.push((name, most));
        }
        let figure = json!({
            "fixed": fixed, "a_robot": each, "farthest_from_the_line": worst, "limit": limit,
            "robots_at_the_limit": most, "at_10000_robots": fixed + MANY * each,
        });
        all.insert(name.to_owned(), figure);
    }
    room.sort_by(|(_, a), (_, b)| a.total_cmp(b));
    let room = room.into_iter();
    let order: Vec<Value> = room.map(|(name, most)| json!([name, most])).collect();
    json!({ "of": all, "gives_way_at_so_many_robots": order })
}

/// A straight line by least squares.
struct Line {
    fixed: f64,
    each: f64,
    /// The greatest distance of a point from the line.
    worst: f64,
}

impl Line {
    fn through(points: &[(f64, f64)]) -> Self {
        let count = points.len() as f64;
        let mean = |pick: fn(&(f64, f64)) -> f64| points.iter().map(pick).sum::<f64>() / count;
        let (x, y) = (mean(|point| point.0), mean(|point| point.1));
        let (mut xy, mut xx) = (0.0, 0.0);
        for point in points {
            xy += (point.0 - x) * (point.1 - y);
            xx += (point.0 - x).powi(2);
        }
        let each = xy / xx;
        let fixed = y - each * x;
        let away = |(x, y): &(f64, f64)| (y - fixed - each * x).abs();
        let worst = points.iter().map(away).fold(0.0, f64::max);
        Self { fixed, each, worst }
    }
}

async fn measure(count: usize) -> (bool, Value) {
    let endpoint = format!("tcp/127.0.0.1:{}", free_port());
    let router = Router::start(&endpoint, &json!({})).await;
    let mut robots = start_own(&["robots", &endpoint, &count.to_string()]).await;
    let bridge = Bridge::start(&["--zenoh", &endpoint, "--zenoh-name", "watching"]).await;
    let begun = Instant::now();
    while poses(&web::fleet(bridge.address).await).len() < count && begun.elapsed() < NEVER {
        sleep(ASK).await;
    }
    let all_after = begun.elapsed();
    let (before, watched) = (cpu(bridge.id()), Instant::now());
    let (mut oldest, mut least, mut bytes, mut asked) = (0.0_f64, usize::MAX, 0, 0);
    let (mut revision, mut slowest) = (0, Duration::ZERO);
    let mut known = std::collections::BTreeMap::new();
    while watched.elapsed() < WATCHED {
        let question = Instant::now();
        let path = format!("/fleet.json?since={revision}");
        let (status, body) = web::ask(bridge.address, "GET", &path, None).await;
        assert_eq!(status, 200);
        let fleet: Value = serde_json::from_str(&body).unwrap();
        revision = fleet["revision"].as_u64().unwrap();
        known.extend(poses(&fleet));
        let now = fleet["now"].as_f64().unwrap();
        // The age on the page just before the next answer.
        let ages = known.values().map(|heard| (now - heard) / MICROS);
        slowest = slowest.max(question.elapsed());
        oldest = ages.fold(oldest, f64::max);
        least = least.min(known.len());
        bytes += body.len();
        asked += 1;
        sleep(ASK.saturating_sub(question.elapsed())).await;
    }
    let seconds = watched.elapsed().as_secs_f64();
    let cpu = (cpu(bridge.id()) - before) / seconds;
    let memory = memory_mb(bridge.id());
    let stop = Instant::now();
    let (status, _) = web::ask(bridge.address, "POST", "/fleet/stop", None).await;
    let mut armed = count;
    while armed > 0 && stop.elapsed() < NEVER {
        armed = armed_of(&web::fleet(bridge.address).await);
    }
    let stopped_after = stop.elapsed();
    robots.kill().await.unwrap();
    bridge.kill().await;
    router.kill().await;
    let oldest_on_page = oldest + ASK.max(slowest).as_secs_f64();
    let holds = least == count && oldest_on_page <= OLDEST && status == 202 && armed == 0;
    let figure = json!({
        "robots": count, "least_seen": least, "all_seen_after_ms": crate::millis(all_after),
        "oldest_pose_on_the_page_s": oldest_on_page, "slowest_answer_ms": crate::millis(slowest),
        "bytes_an_answer": bytes / asked.max(1), "bytes_a_second_to_a_page": bytes as f64 / seconds, "cpu_of_the_bridge_share_of_a_core": cpu,
        "memory_of_the_bridge_mb": memory, "still_armed_after_stop_all": armed,
        "all_seen_stopped_after_ms": crate::millis(stopped_after),
        "limits": { "oldest_s": OLDEST },
    });
    (holds, figure)
}

/// The time when the pose of each simulated robot was received, µs.
fn poses(fleet: &Value) -> Vec<(String, f64)> {
    let moved = fleet["moved"].as_array().unwrap().iter();
    let robots = web::here(fleet).into_iter().chain(moved);
    let posed = robots.filter(|robot| robot["pose"].is_array());
    posed
        .map(|robot| {
            let name = robot["name"].as_str().unwrap().to_owned();
            (name, robot["pose_heard"].as_f64().unwrap())
        })
        .collect()
}

fn armed_of(fleet: &Value) -> usize {
    let robots = web::here(fleet).into_iter();
    robots
        .filter(|robot| robot["safety"]["armed"] == true)
        .count()
}

/// Processor time so far, s.
fn cpu(process: u32) -> f64 {
    let stat = std::fs::read_to_string(format!("/proc/{process}/stat")).unwrap();
    let (_, fields) = stat.rsplit_once(')').unwrap();
    let ticks = fields.split_whitespace().skip(11).take(2);
    ticks.map(|n| n.parse::<f64>().unwrap()).sum::<f64>() / TICKS
}

fn memory_mb(process: u32) -> f64 {
    let status = std::fs::read_to_string(format!("/proc/{process}/status")).unwrap();
    let line = status.lines().find(|line| line.starts_with("VmRSS"));
    let kilobytes = line.and_then(|line| line.split_whitespace().nth(1));
    kilobytes.map_or(f64::NAN, |n| n.parse::<f64>().unwrap() / 1024.0)
}

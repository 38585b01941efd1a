//! Long runs: nothing grows.
//!
//! 1. [`device`]: 24 hours of an RP6 behind the bridge's own serial device, as fast as the machine
//!    can; neither has a clock.
//! 2. Meanwhile a bridge in a separate process for `--minutes`, with a simulated robot, a
//!    recording, a driver, watchers, and a client that comes and goes; every ten seconds its
//!    memory, handles, threads and delays.
//!
//! A figure grows if the line through its samples, without the first fifth, rises by more than 5 %
//! of the mean and more than chance (3 σ): see [`crate::trend`].

use std::process::Stdio;
use std::time::{Duration, Instant};

use serde_json::{Map, Value, json};
use slamlab_core::wire::message::{FromBridge, ToBridge};
use tokio::io::{AsyncBufReadExt, BufReader};
use tokio::process::{Child, Command};
use tokio::task::JoinHandle;

use crate::client::{Came, Client};
use crate::soak_device as device;
use crate::torn::{self, Torn};
use crate::trend::{self, Trend};

const LOOK: Duration = Duration::from_secs(10);
const HOURS: u32 = 24;

pub(crate) async fn report(minutes: f64, torn: Option<&Torn>) -> (bool, Value) {
    trend::check();
    let accelerated = tokio::task::spawn_blocking(|| {
        let report = device::run(HOURS);
        eprintln!("{HOURS} hours of a device: {}", report.1);
        report
    });
    let real = real(Duration::from_secs_f64(60.0 * minutes), torn).await;
    eprintln!("{minutes} minutes of a bridge: {}", real.1);
    let accelerated = accelerated.await.unwrap();
    (
        accelerated.0 && real.0,
        json!({ "accelerated_device": accelerated.1, "real_bridge": real.1 }),
    )
}

struct Process {
    child: Child,
    address: std::net::SocketAddr,
    token: String,
    folder: tempfile::TempDir,
}

async fn start(torn: Option<&Torn>) -> Process {
    let folder = tempfile::tempdir().unwrap();
    let program = std::env::var("SLAMLAB_BRIDGE").expect("SLAMLAB_BRIDGE names the program");
    let mut command = Command::new(program);
    command
        .args([
            "serve",
            "--port",
            "0",
            "--source",
            "sim:arena,lidar",
            "--page",
        ])
        .arg(concat!(env!("CARGO_MANIFEST_DIR"), "/../bridge/tests/page"))
        .arg("--token-file")
        .arg(folder.path().join("token"))
        .arg("--record")
        .stdout(Stdio::piped())
        .kill_on_drop(true);
    match torn {
        None => command.arg(folder.path().join("soak.mcap")),
        // Pieces so small that many are finished and stored meanwhile.
        Some(torn) => command
            .arg(recordings(&folder))
            .args(["--record-piece-mib", "1", "--config"])
            .arg(torn.settings(folder.path())),
    };
    let mut child = command.spawn().unwrap();
    let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
    let address = loop {
        let line = lines
            .next_line()
            .await
            .unwrap()
            .expect("it tells its address");
        let rest = line.split_once("http://").map(|(_, rest)| rest);
        if let Some(address) =
            rest.and_then(|rest| rest.split(['/', '#', ' ']).next()?.parse().ok())
        {
            break address;
        }
    };
    tokio::spawn(async move { while let Ok(Some(_)) = lines.next_line().await {} });
    let token = std::fs::read_to_string(folder.path().join("token")).unwrap();
    Process {
        child,
        address,
        token: token.trim().to_owned(),
        folder,
    }
}

/// The folder from which pieces are stored.
fn recordings(folder: &tempfile::TempDir) -> std::path::PathBuf {
    let recordings = folder.path().join("recordings");
    std::fs::create_dir_all(&recordings).unwrap();
    recordings
}

async fn real(time: Duration, torn: Option<&Torn>) -> (bool, Value) {
    let bridge = start(torn).await;
    if let Some(torn) = torn {
        torn.settle(bridge.address).await;
    }
    let began = Instant::now();
    let until = began + time;
    let address = bridge.address;
    let mut others: Vec<JoinHandle<()>> = (0..5)
        .map(|_| {
            tokio::spawn(async move { watch(Client::connect(address, "").await, until).await })
        })
        .collect();
    others.push(tokio::spawn(async move {
        watch(Client::connect(address, "?fmt=json").await, until).await;
    }));
    let token = bridge.token.clone();
    others.push(tokio::spawn(
        async move { drive(address, &token, until).await },
    ));
    others.push(tokio::spawn(
        async move { come_and_go(address, until).await },
    ));
    let mut samples: Vec<(f64, Sample)> = vec![];
    let mut prober = Client::connect(address, "").await;
    prober.enter(None).await;
    let pid = bridge.child.id().unwrap();
    while Instant::now() + LOOK < until {
        let delays = probe(&mut prober, Instant::now() + LOOK).await;
        let sample = Sample::take(pid, delays);
        samples.push((began.elapsed().as_secs_f64(), sample));
    }
    for other in others {
        other.await.unwrap();
    }
    let (mut holds, mut figures) = judge(&samples);
    let mut recorded = vec![bridge.folder.path().join("soak.mcap")];
    if let Some(torn) = torn {
        let recordings = recordings(&bridge.folder);
        let (is_mended, mended) = torn.mends(bridge.address, &recordings).await;
        holds &= is_mended;
        figures.insert("router_and_bucket_are_back".into(), mended);
        recorded = torn::pieces(&recordings);
    }
    let bytes = |file: &std::path::PathBuf| std::fs::metadata(file).unwrap().len();
    let recorded: u64 = recorded.iter().map(bytes).sum();
    figures.insert("minutes".into(), json!(time.as_secs_f64() / 60.0));
    figures.insert("samples".into(), json!(samples.len()));
    figures.insert("recorded_bytes".into(), json!(recorded));
    (holds, figures.into())
}

/// What is sampled.
struct Sample {
    anonymous_kb: f64,
    handles: f64,
    threads: f64,
    median_ms: f64,
    p99_ms: f64,
}

impl Sample {
    fn take(pid: u32, mut delays: Vec<f64>) -> Self {
        let status = std::fs::read_to_string(format!("/proc/{pid}/status")).unwrap();
        let number = |key: &str| {
            let line = status.lines().find_map(|line| line.strip_prefix(key));
            let word = line.and_then(|rest| rest.split_whitespace().next());
            word.and_then(|word| word.parse().ok()).unwrap()
        };
        delays.sort_by(f64::total_cmp);
        let at = |part: f64| delays[((delays.len() - 1) as f64 * part).round() as usize];
        Self {
            anonymous_kb: number("RssAnon:"),
            handles: std::fs::read_dir(format!("/proc/{pid}/fd"))
                .unwrap()
                .count() as f64,
            threads: number("Threads:"),
            median_ms: at(0.5),
            p99_ms: at(0.99),
        }
    }
}

type Pick = fn(&Sample) -> f64;

fn judge(samples: &[(f64, Sample)]) -> (bool, Map<String, Value>) {
    let settled = &samples[samples.len() / 5..];
    // The growth that is always ignored, in the figure's own unit.
    let rows: [(&str, Pick, f64); 5] = [
        ("anonymous_kb", |s| s.anonymous_kb, 1024.0),
        ("handles", |s| s.handles, 1.0),
        ("threads", |s| s.threads, 1.0),
        ("probe_median_ms", |s| s.median_ms, 0.5),
        ("probe_p99_ms", |s| s.p99_ms, 5.0),
    ];
    let mut figures = Map::new();
    let mut holds = true;
    for (name, pick, least) in rows {
        let values: Vec<(f64, f64)> = settled.iter().map(|(t, s)| (*t, pick(s))).collect();
        let Some(trend) = Trend::of(&values) else {
            return (false, figures);
        };
        holds &= !trend.grows(least);
        figures.insert(name.into(), trend.figures(least));
    }
    (holds, figures)
}

/// Measures ten times a second how long an answer takes, ms.
async fn probe(client: &mut Client, until: Instant) -> Vec<f64> {
    let began = Instant::now();
    let mut delays = vec![];
    let mut ticks = tokio::time::interval(Duration::from_millis(100));
    while Instant::now() < until {
        tokio::select! {
            _ = ticks.tick() => {
                let micros = began.elapsed().as_micros() as u64;
                client.say(ToBridge::Probe { token: micros }).await;
            }
            came = client.next() => match came {
                Came::Message(FromBridge::Probe(answer)) => {
                    delays.push(1e3 * (began.elapsed().as_secs_f64() - 1e-6 * answer.token as f64));
                }
                Came::Message(_) => (),
                other => panic!("the prober was cut off: {other:?}"),
            },
        }
    }
    delays
}

async fn watch(mut client: Client, until: Instant) {
    client.enter(None).await;
    let mut beat = tokio::time::interval(Duration::from_secs(1));
    while Instant::now() < until {
        tokio::select! {
            _ = beat.tick() => client.say(ToBridge::Heartbeat).await,
            came = client.next() => assert!(matches!(came, Came::Message(_)), "{came:?}"),
        }
    }
}

/// Drives in circles; arms again after anything that stops the robot.
async fn drive(address: std::net::SocketAddr, token: &str, until: Instant) {
    let mut client = Client::connect(address, "").await;
    assert!(client.enter(Some(token)).await);
    client.take(false).await;
    while Instant::now() < until {
        client.arm().await;
        client.drive_for(Duration::from_secs(5), 0.05).await;
    }
}

async fn come_and_go(address: std::net::SocketAddr, until: Instant) {
    while Instant::now() < until {
        let mut client = Client::connect(address, "").await;
        client.enter(None).await;
        tokio::time::sleep(Duration::from_millis(500)).await;
    }
}

//! A test stand: a bridge in a process of its own, and the real firmware in simavr on a pseudo-terminal in another.
//!
//! In: faults, at random instants while the robot turns on the spot. Out: how long its motors still got voltage, by the compare registers
//! of the chip and the chip's own clock.
//!
//! The programs are named by `SLAMLAB_BRIDGE` and `SLAMLAB_RP6_SIM`.

use std::net::SocketAddr;
use std::process::Stdio;
use std::time::{Duration, Instant};

use serde_json::Value;
use slamlab_core::wire::message::{FromBridge, Motion, ToBridge};
use tokio::io::{AsyncBufReadExt, AsyncWriteExt, BufReader, Lines};
use tokio::process::{Child, ChildStdin, ChildStdout, Command};

use crate::client::Client;

/// Whatever is waited for comes sooner, or never.
const NEVER: Duration = Duration::from_secs(60);

/// The robot.
pub(crate) struct Robot {
    _child: Child,
    asks: ChildStdin,
    answers: Lines<BufReader<ChildStdout>>,
    pub(crate) port: String,
}

impl Robot {
    pub(crate) async fn start(program: &str) -> Self {
        let mut child = Command::new(program)
            .arg("arena")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .kill_on_drop(true)
            .spawn()
            .unwrap();
        let mut answers = BufReader::new(child.stdout.take().unwrap()).lines();
        let first = answers
            .next_line()
            .await
            .unwrap()
            .expect("it tells its port");
        let ports: Value = serde_json::from_str(&first).unwrap();
        Self {
            asks: child.stdin.take().unwrap(),
            answers,
            port: ports["rp6"].as_str().unwrap().to_owned(),
            _child: child,
        }
    }

    pub(crate) async fn ask(&mut self, command: &str) -> Value {
        let line = format!("{command}\n");
        self.asks.write_all(line.as_bytes()).await.unwrap();
        let answer = self.answers.next_line().await.unwrap().expect("it answers");
        let answer: Value = serde_json::from_str(&answer).unwrap();
        assert!(answer.get("error").is_none(), "{command}: {answer}");
        answer
    }

    pub(crate) async fn moves(&mut self) -> bool {
        self.ask("facts").await["moves"].as_bool().unwrap()
    }

    /// Seconds that its motors still ran, chip's clock, and real seconds that the chip lost so far.
    pub(crate) async fn stopped(&mut self) -> (Option<f64>, f64) {
        let until = Instant::now() + Duration::from_secs(10);
        loop {
            let facts = self.ask("facts").await;
            assert_eq!(facts["fault"], Value::Null);
            let behind = facts["behind"].as_f64().unwrap();
            if let Some(seconds) = facts["stopped_after"].as_f64() {
                return (Some(seconds), behind);
            }
            if Instant::now() > until {
                return (None, behind);
            }
            tokio::time::sleep(Duration::from_millis(10)).await;
        }
    }
}

/// The bridge.
pub(crate) struct Stand {
    pub(crate) robot: Robot,
    program: String,
    folder: tempfile::TempDir,
    bridge: Option<Child>,
    address: SocketAddr,
}

impl Stand {
    pub(crate) async fn start(bridge: &str, robot: &str) -> Self {
        let mut stand = Self {
            robot: Robot::start(robot).await,
            program: bridge.to_owned(),
            folder: tempfile::tempdir().unwrap(),
            bridge: None,
            address: ([127, 0, 0, 1], 0).into(),
        };
        stand.start_bridge().await;
        stand
    }

    async fn start_bridge(&mut self) {
        let mut child = Command::new(&self.program)
            .args(["serve", "--port", "0", "--page"])
            .arg(concat!(env!("CARGO_MANIFEST_DIR"), "/../bridge/tests/page"))
            .arg("--source")
            .arg(format!("rp6:{}", self.robot.port))
            .arg("--token-file")
            .arg(self.folder.path().join("token"))
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .kill_on_drop(true)
            .spawn()
            .unwrap();
        let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
        self.address = loop {
            let line = lines
                .next_line()
                .await
                .unwrap()
                .expect("it tells its address");
            let rest = line.split_once("http://").map(|(_, rest)| rest);
            let address = rest.and_then(|rest| rest.split(['/', '#', ' ']).next()?.parse().ok());
            if let Some(address) = address {
                break address;
            }
        };
        tokio::spawn(async move { while let Ok(Some(_)) = lines.next_line().await {} });
        self.bridge = Some(child);
    }

    /// Nothing that a program could catch.
    pub(crate) async fn kill_bridge(&mut self) {
        if let Some(mut bridge) = self.bridge.take() {
            bridge.kill().await.unwrap();
        }
    }

    pub(crate) async fn watcher(&self) -> Client {
        let mut client = Client::connect(self.address, "").await;
        client.enter(None).await;
        client
    }

    /// A client that drives the robot, which turns on the spot.
    pub(crate) async fn driver(&mut self) -> Client {
        if self.bridge.is_none() {
            self.start_bridge().await;
        }
        let token = std::fs::read_to_string(self.folder.path().join("token")).unwrap();
        let mut client = Client::connect(self.address, "").await;
        assert!(client.enter(Some(token.trim())).await);
        client.take(true).await;
        let until = Instant::now() + NEVER;
        while Instant::now() < until {
            arm(&mut client).await;
            // A robot that has just come back wants a moment without orders.
            client.hold_for(Duration::from_millis(400)).await;
            turn(&mut client, Duration::from_millis(400)).await;
            if self.robot.moves().await {
                return client;
            }
        }
        panic!("the robot does not turn");
    }
}

/// Arms as soon as the robot's link is up; asking all the time would be more than the bridge hears.
async fn arm(client: &mut Client) {
    let epoch = client.epoch;
    loop {
        client.say(ToBridge::Arm { epoch }).await;
        let is_armed = client
            .wait(|message| match message {
                FromBridge::Safety(state) if state.armed => Some(true),
                FromBridge::Refused(_) => Some(false),
                _ => None,
            })
            .await;
        if is_armed {
            return;
        }
        tokio::time::sleep(Duration::from_millis(200)).await;
    }
}

/// Turns on the spot for a while.
pub(crate) async fn turn(client: &mut Client, time: Duration) {
    let until = Instant::now() + time;
    let motion = Motion::Velocity {
        forward: 0.0,
        turn: 0.6,
    };
    while Instant::now() < until {
        let body = client.body(motion);
        client.say(ToBridge::Drive(body)).await;
        client.hold_for(Duration::from_millis(50)).await;
    }
}

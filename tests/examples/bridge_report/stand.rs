//! A test stand: a bridge in one process, and the real firmware in simavr on a pseudo-terminal in
//! another.
//!
//! In: faults, at random instants while the robot turns on the spot. Out: how long its motors were
//! still powered, by the compare registers and the clock of the chip.
//!
//! The programs are named by `SLAMLAB_BRIDGE` and `SLAMLAB_RP6_SIM`.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use serde_json::Value;
use slamlab_core::robot;
use slamlab_core::wire::message::{FromBridge, ToBridge};
use slamlab_core::wire::recording::Recording;
use tokio::io::{AsyncBufReadExt, AsyncWriteExt, BufReader, Lines};
use tokio::process::{Child, ChildStdin, ChildStdout, Command};

use crate::bridge_process::BridgeProcess;
use crate::client::Client;
use crate::torn::Torn;

/// A timeout: whatever is awaited comes sooner or never.
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
            .stdin(std::process::Stdio::piped())
            .stdout(std::process::Stdio::piped())
            .stderr(std::process::Stdio::null())
            .kill_on_drop(true)
            .spawn()
            .unwrap();
        let mut answers = BufReader::new(child.stdout.take().unwrap()).lines();
        let first = answers.next_line().await.unwrap();
        let first = first.expect("it tells its port");
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

    /// Time that its motors still ran, by the chip's clock, s, and real time that the chip has lost
    /// so far, s.
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

/// Robot and bridge.
pub(crate) struct Stand {
    pub(crate) robot: Robot,
    program: String,
    folder: tempfile::TempDir,
    bridges: u32,
    bridge: Option<BridgeProcess>,
    torn: Option<Arc<Torn>>,
}

impl Stand {
    pub(crate) async fn start(bridge: &str, robot: &str, torn: Option<Arc<Torn>>) -> Self {
        Self {
            robot: Robot::start(robot).await,
            program: bridge.to_owned(),
            folder: tempfile::tempdir().unwrap(),
            bridges: 0,
            bridge: None,
            torn,
        }
    }

    async fn start_bridge(&mut self) {
        self.bridges += 1;
        let old = self.recording();
        let folder = self.folder.path();
        let recording = folder.join(format!("{}.mcap", self.bridges));
        let source = format!("rp6:{}", self.robot.port);
        let torn = self.torn.as_deref();
        let bridge = BridgeProcess::start(&self.program, &source, folder, recording, torn).await;
        if let Some(torn) = torn {
            torn.settle(bridge.address).await;
        }
        self.bridge = Some(bridge);
        // The files of bridges that have ended are no longer needed.
        let _ = old.map(std::fs::remove_file);
    }

    fn recording(&self) -> Option<PathBuf> {
        let last = self.bridges.checked_sub(1)?;
        Some(self.folder.path().join(format!("{last}.mcap")))
    }

    /// Private memory of the bridge, if one runs.
    pub(crate) fn anonymous_kb(&self) -> Option<f64> {
        self.bridge.as_ref().map(BridgeProcess::anonymous_kb)
    }

    pub(crate) fn bridge(&self) -> &BridgeProcess {
        self.bridge.as_ref().expect("a driver has started it")
    }

    /// A signal that no program can catch; afterwards the recording must hold all that was
    /// acknowledged.
    pub(crate) async fn kill_bridge(&mut self, acknowledged: u64) -> Result<(), String> {
        let Some(bridge) = self.bridge.take() else {
            return Ok(());
        };
        let path = bridge.recording.clone();
        bridge.kill().await;
        let bytes = std::fs::read(path).map_err(|error| error.to_string())?;
        let recording = Recording::parse(&bytes).map_err(|error| error.to_string())?;
        let readable = recording.messages().filter(Result::is_ok).count() as u64;
        if readable < acknowledged {
            return Err(format!(
                "{readable} messages can be read, {acknowledged} were acknowledged"
            ));
        }
        Ok(())
    }

    pub(crate) async fn watcher(&self) -> Client {
        let mut client = Client::connect(self.bridge().address, "").await;
        client.enter(None).await;
        client
    }

    /// A client that may drive.
    pub(crate) async fn other_driver(&self) -> Client {
        let token = std::fs::read_to_string(self.folder.path().join("token")).unwrap();
        let mut client = Client::connect(self.bridge().address, "").await;
        assert!(client.enter(Some(token.trim())).await);
        client
    }

    /// A client that drives the robot and turns it on the spot.
    pub(crate) async fn driver(&mut self) -> Client {
        if self.bridge.is_none() {
            self.start_bridge().await;
        }
        let mut client = self.other_driver().await;
        client.take(true).await;
        let until = Instant::now() + NEVER;
        while Instant::now() < until {
            arm(&mut client).await;
            // A robot that has just come back needs a moment without orders.
            client.hold_for(Duration::from_millis(400)).await;
            turn(&mut client, Duration::from_millis(400)).await;
            if self.robot.moves().await {
                return client;
            }
        }
        panic!("the robot does not turn");
    }
}

/// Arms as soon as the robot's link is up; asking continuously would exceed what the bridge
/// accepts.
async fn arm(client: &mut Client) {
    let epoch = client.epoch;
    let until = Instant::now() + NEVER;
    loop {
        client.say(ToBridge::Arm { epoch }).await;
        let refusal = client
            .wait(|message| match message {
                FromBridge::Safety(state) if state.armed => Some(None),
                FromBridge::Refused(why) => Some(Some(*why)),
                _ => None,
            })
            .await;
        let Some(refusal) = refusal else {
            return;
        };
        assert!(Instant::now() < until, "it cannot be armed: {refusal:?}");
        tokio::time::sleep(Duration::from_millis(200)).await;
    }
}

/// Turns on the spot for a while.
pub(crate) async fn turn(client: &mut Client, time: Duration) {
    let until = Instant::now() + time;
    let motion = robot::Command::Velocity {
        forward: 0.0,
        turn: 0.6,
    };
    while Instant::now() < until {
        let body = client.body(motion);
        client.say(ToBridge::Drive(body)).await;
        client.hold_for(Duration::from_millis(50)).await;
    }
}

//! A router and bridges, each in a separate process.

use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use serde_json::{Value, json};
use tempfile::TempDir;
use tokio::io::{AsyncBufReadExt, BufReader};
use tokio::process::{Child, Command};
use tokio::time::{Instant, sleep, timeout};

use crate::started::{self, NEVER};

/// Opens a session in router mode, as `zenohd` does, until it is killed.
pub(crate) async fn be_router(config: &str) {
    let _session = zenoh::open(self::config(&serde_json::from_str(config).unwrap()))
        .await
        .unwrap();
    println!("there");
    std::future::pending().await
}

/// Zenoh's settings, from an object with their paths as keys.
pub(crate) fn config(values: &Value) -> zenoh::Config {
    let mut config = zenoh::Config::default();
    for (key, value) in values.as_object().unwrap() {
        config.insert_json5(key, &value.to_string()).unwrap();
    }
    config
}

/// A router.
pub(crate) struct Router {
    child: Child,
    pub(crate) endpoint: String,
}

/// Starts this program once more in another role, and waits until it says that it is there; it is
/// ended when this is dropped.
pub(crate) async fn start_own(part: &[&str]) -> Child {
    started::start(std::env::current_exe().unwrap(), part).await
}

impl Router {
    /// At a port of its own, which it keeps when it is started again.
    pub(crate) async fn start(endpoint: &str, more: &Value) -> Self {
        let mut config = json!({
            "mode": "router",
            "listen/endpoints": [endpoint],
            "scouting/multicast/enabled": false,
        });
        for (key, value) in more.as_object().unwrap() {
            config[key] = value.clone();
        }
        Self {
            child: start_own(&["router", &config.to_string()]).await,
            endpoint: endpoint.to_owned(),
        }
    }

    /// SIGKILL.
    pub(crate) async fn kill(mut self) {
        self.child.kill().await.unwrap();
    }
}

/// A bridge with a simulated robot.
pub(crate) struct Bridge {
    child: Child,
    pub(crate) address: SocketAddr,
    pub(crate) token: String,
    said: Arc<Mutex<String>>,
    _folder: TempDir,
}

impl Bridge {
    pub(crate) async fn start(flags: &[&str]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let mut child = command(folder.path(), flags).spawn().unwrap();
        let said = Arc::new(Mutex::new(String::new()));
        let mut errors = BufReader::new(child.stderr.take().unwrap()).lines();
        let all = Arc::clone(&said);
        tokio::spawn(async move {
            while let Ok(Some(line)) = errors.next_line().await {
                all.lock().unwrap().push_str(&(line + "\n"));
            }
        });
        let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
        let line = timeout(NEVER, lines.next_line()).await.unwrap().unwrap();
        let line = line.unwrap_or_else(|| panic!("no address; {}", said.lock().unwrap()));
        let rest = line.split_once("http://").unwrap().1;
        let address = rest.split('/').next().unwrap().parse().unwrap();
        tokio::spawn(async move { while let Ok(Some(_)) = lines.next_line().await {} });
        let token = std::fs::read_to_string(folder.path().join("token")).unwrap();
        Self {
            child,
            address,
            token: token.trim().to_owned(),
            said,
            _folder: folder,
        }
    }

    /// Its log so far.
    pub(crate) fn said(&self) -> String {
        self.said.lock().unwrap().clone()
    }

    /// Whether these words appear in its log sooner or later.
    pub(crate) async fn says(&self, words: &str) -> bool {
        let until = Instant::now() + NEVER;
        while Instant::now() < until {
            if self.said().contains(words) {
                return true;
            }
            sleep(Duration::from_millis(20)).await;
        }
        eprintln!("expected {words:?} in:\n{}", self.said());
        false
    }

    /// Its process id.
    pub(crate) fn id(&self) -> u32 {
        self.child.id().expect("it was not waited for")
    }

    pub(crate) async fn kill(mut self) {
        self.child.kill().await.unwrap();
    }
}

/// The reason that a bridge gives if it does not start: its exit status and its only line.
pub(crate) async fn fails(flags: &[&str]) -> Option<String> {
    let folder = tempfile::tempdir().unwrap();
    let output = timeout(NEVER, command(folder.path(), flags).output()).await;
    let output = output.ok()?.unwrap();
    (!output.status.success()).then(|| String::from_utf8_lossy(&output.stderr).into_owned())
}

fn command(folder: &Path, flags: &[&str]) -> Command {
    let page: PathBuf = concat!(env!("CARGO_MANIFEST_DIR"), "/../bridge/tests/page").into();
    let program = std::env::var("SLAMLAB_BRIDGE").expect("SLAMLAB_BRIDGE names the program");
    let mut command = Command::new(program);
    command
        .args(["serve", "--port", "0", "--source", "sim:arena,lidar"])
        .arg("--page")
        .arg(page)
        .arg("--token-file")
        .arg(folder.join("token"))
        .args(flags)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .kill_on_drop(true);
    command
}

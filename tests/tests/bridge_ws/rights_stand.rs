//! A bridge whose rights are stored in files, and its audit log.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

use serde_json::Value;
use slamlab_bridge::record::Keep;
use slamlab_bridge::rights::{Files, Keys, Name, RightsFile};
use slamlab_bridge::token::Token;
use slamlab_bridge::{Config, Limits};
use slamlab_core::wire::message::{FromBridge, Role, Watching};
use tempfile::TempDir;
use tokio::time::{Instant, timeout};

use super::client::{Bridge, Came, Client};
use super::robot::{Memory, with_robot};

/// A timeout: whatever is awaited comes sooner or never.
const NEVER: Duration = Duration::from_secs(20);

/// A bridge whose rights are stored in files.
pub(crate) struct Stand {
    pub(crate) bridge: Bridge,
    pub(crate) memory: Memory,
    pub(crate) rights: RightsFile,
    pub(crate) folder: TempDir,
}

impl Stand {
    pub(crate) async fn start(watching: Watching) -> Self {
        Self::start_with(watching, Limits::default()).await
    }

    pub(crate) async fn start_with(watching: Watching, limits: Limits) -> Self {
        let folder = TempDir::new().unwrap();
        let token = folder.path().join("token");
        let owner = Token::load_or_create(&token).unwrap();
        let rights = RightsFile::at(folder.path().join("rights.toml"));
        let (config, memory) = with_robot();
        let config = Config {
            watching: Some(watching),
            rosbridge: true,
            limits,
            audit: Some((folder.path().join("audit"), Keep::default())),
            ..config
        };
        let keys = Keys::Files(Files {
            token,
            rights: rights.clone(),
        });
        let bridge = Bridge::start_with(config, keys, owner.reveal().to_owned()).await;
        Self {
            bridge,
            memory,
            rights,
            folder,
        }
    }

    pub(crate) fn add(&self, name: &str, role: Role) -> String {
        let noon = "2026-11-27T12:00:00Z".parse().unwrap();
        let token = self.rights.add(name.parse().unwrap(), role, noon).unwrap();
        token.reveal().to_owned()
    }

    pub(crate) fn revoke(&self, name: &str) {
        self.rights.revoke(&name.parse::<Name>().unwrap()).unwrap();
    }

    /// Enters with this token, as soon as the bridge knows it.
    pub(crate) async fn enter(&self, token: &str) -> Client {
        let until = Instant::now() + NEVER;
        loop {
            let mut client = self.bridge.connect().await;
            client.say(client.hello(Some(token))).await;
            if is_welcome(&mut client).await {
                return client;
            }
            assert!(Instant::now() < until, "the bridge never heard of it");
        }
    }

    /// Whether the token is accepted now.
    pub(crate) async fn is_good(&self, token: &str) -> bool {
        let mut client = self.bridge.connect().await;
        client.say(client.hello(Some(token))).await;
        is_welcome(&mut client).await
    }

    pub(crate) async fn stop(self) -> (Vec<Value>, TempDir) {
        self.bridge.stop().await;
        (audit(&self.folder.path().join("audit")), self.folder)
    }
}

/// The lines of the audit log.
fn audit(folder: &Path) -> Vec<Value> {
    let mut files: Vec<PathBuf> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    files.sort();
    let text: String = (files.iter().map(|file| fs::read_to_string(file).unwrap())).collect();
    let lines = text.lines().map(|line| serde_json::from_str(line).unwrap());
    lines.collect()
}

/// Whether it is let in; otherwise its connection ends.
async fn is_welcome(client: &mut Client) -> bool {
    loop {
        match client.next().await {
            Came::Message(FromBridge::Welcome(_)) => return true,
            Came::Message(_) => (),
            Came::Closed(_) | Came::Lost => return false,
        }
    }
}

/// Drives without a pause until the connection ends; returns the close code.
pub(crate) async fn drive_on(client: &mut Client) -> Option<u16> {
    let ends = async {
        loop {
            client.drive(0.1, 0.0).await;
            let next = Instant::now() + Duration::from_millis(30);
            while let Ok(came) = tokio::time::timeout_at(next, client.next()).await {
                match came {
                    Came::Message(_) => (),
                    Came::Closed(code) => return Some(code),
                    Came::Lost => return None,
                }
            }
        }
    };
    timeout(NEVER, ends).await.ok().flatten()
}

//! A router and a bucket that die and come back, again and again, while something else is measured:
//! what holds for a bridge without them must also hold for one whose robot is reached through that
//! router and whose recordings are stored in that bucket.
//!
//! | what | its life |
//! |---|---|
//! | Zenoh router, a process | killed every few seconds, and started again |
//! | S3-compatible server, a process | in turns, the server is killed or the bucket is removed |
//!
//! The programs are named by `SLAMLAB_ROUTER` (`router_report`) and `SLAMLAB_STORE`
//! (`slamlab-storage-report`). A part that is not named is absent, and its figures are null.

use std::io;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use slamlab_bridge::record::{Keep, MEBIBYTE};
use slamlab_bridge::zenoh::ZenohConfig;
use slamlab_bridge::{Config, StorageConfig};
use tempfile::TempDir;
use tokio::process::Child;
use tokio::sync::watch;
use tokio::task::JoinHandle;
use tokio::time::sleep;

use crate::started::{self, free_port};
use crate::web;

/// How long each is there, and then away.
const THERE: Duration = Duration::from_millis(5000);
const AWAY: Duration = Duration::from_millis(2500);
/// Time for a bridge to reach the router before it is measured: its pauses between attempts grow to
/// 4 s.
const COMES: Duration = Duration::from_secs(10);
/// Maximum time after the return of both until a bridge is at the router and has stored everything.
const MENDED: Duration = Duration::from_secs(120);
const BUCKET: &str = "drives";
const REGION: &str = "eu-central-1";
/// The same key as in `tests/storage`.
const KEY: (&str, &str) = ("slamlab", "a-secret-of-the-report");

/// Router and bucket, until this is dropped.
pub(crate) struct Torn {
    endpoint: String,
    store: Option<SocketAddr>,
    folder: TempDir,
    bridges: AtomicU64,
    deaths: Arc<Deaths>,
    /// Number of measured bridges, and of those that had found the router before the measurement.
    measured: [AtomicU64; 2],
    is_torn: watch::Sender<bool>,
    tearing: Vec<JoinHandle<()>>,
}

#[derive(Default)]
struct Deaths {
    router: AtomicU64,
    store: AtomicU64,
    bucket: AtomicU64,
}

impl Torn {
    /// Starts both, and their failures; `None` if no router is named.
    pub(crate) async fn start() -> Option<Arc<Self>> {
        let router = std::env::var("SLAMLAB_ROUTER").ok()?;
        let folder = tempfile::tempdir().unwrap();
        let buckets = folder.path().join("buckets");
        std::fs::create_dir_all(buckets.join(BUCKET)).unwrap();
        let endpoint = format!("tcp/127.0.0.1:{}", free_port());
        let config = json!({
            "mode": "router", "listen/endpoints": [endpoint], "scouting/multicast/enabled": false,
        });
        let router = Program(router, vec!["router".into(), config.to_string()]);
        let deaths = Arc::new(Deaths::default());
        let (is_torn, torn) = watch::channel(true);
        // Both are there before they are first used.
        let first = router.start().await;
        let dying = kill_router(router, first, Arc::clone(&deaths), torn.clone());
        let mut tearing = vec![tokio::spawn(dying)];
        let mut address = None;
        if let Ok(store) = std::env::var("SLAMLAB_STORE") {
            let port = free_port();
            let (serve, at) = (buckets.to_str().unwrap().to_owned(), port.to_string());
            let words = ["--serve", &serve, "--port", &at].map(str::to_owned);
            let store = Program(store, words.into());
            let first = store.start().await;
            let dying = kill_store(store, first, buckets, Arc::clone(&deaths), torn);
            tearing.push(tokio::spawn(dying));
            address = Some(([127, 0, 0, 1], port).into());
        }
        Some(Arc::new(Self {
            endpoint,
            store: address,
            folder,
            bridges: AtomicU64::new(0),
            deaths,
            measured: Default::default(),
            is_torn,
            tearing,
        }))
    }

    /// The same settings, with the router and with recordings in the bucket.
    pub(crate) fn on(&self, config: Config) -> Config {
        let name = self.name();
        let record = self.folder.path().join(&name);
        std::fs::create_dir(&record).unwrap();
        Config {
            zenoh: Some(ZenohConfig {
                router: self.endpoint.parse().unwrap(),
                name: name.parse().unwrap(),
                ca: None,
                identity: None,
                ros: None,
            }),
            storage: self.store.map(|store| StorageConfig {
                options: options(store)
                    .map(|(key, value)| (key.to_owned(), value))
                    .into(),
                ..StorageConfig::new(url(&name))
            }),
            record: Some(record),
            keep: Keep {
                piece_bytes: MEBIBYTE,
                ..Keep::default()
            },
            ..config
        }
    }

    /// Writes settings for a bridge in a separate process into a file in `folder`, including the
    /// name of its recordings in the bucket.
    pub(crate) fn settings(&self, folder: &Path) -> PathBuf {
        let name = self.name();
        let mut settings = json!({ "zenoh": { "router": self.endpoint, "name": name } });
        if let Some(store) = self.store {
            let options = options(store).map(|(key, value)| (key.to_owned(), value.into()));
            let options = Value::Object(options.into_iter().collect());
            settings["storage"] = json!({ "url": url(&name), "options": options });
        }
        let file = folder.join(format!("{name}.toml"));
        std::fs::write(&file, toml::to_string(&settings).unwrap()).unwrap();
        file
    }

    /// Waits until the bridge has found the router, for a limited time, and counts whether it has.
    pub(crate) async fn settle(&self, bridge: SocketAddr) {
        let begun = Instant::now();
        let mut is_there = false;
        while !is_there && begun.elapsed() < COMES {
            sleep(Duration::from_millis(50)).await;
            is_there = web::fleet(bridge).await["connected"] == true;
        }
        for (counter, counts) in self.measured.iter().zip([true, is_there]) {
            counter.fetch_add(u64::from(counts), Ordering::Relaxed);
        }
    }

    /// Lets both live on, and waits until the bridge is at the router and everything that it
    /// finished is in the bucket, byte for byte.
    pub(crate) async fn mends(&self, bridge: SocketAddr, recordings: &Path) -> (bool, Value) {
        self.is_torn.send_replace(false);
        let begun = Instant::now();
        let (mut is_back, mut is_stored) = (None, None);
        while begun.elapsed() < MENDED && (is_back.is_none() || is_stored.is_none()) {
            sleep(Duration::from_millis(200)).await;
            if web::fleet(bridge).await["connected"] == true {
                is_back.get_or_insert(begun.elapsed());
            }
            if self.store.is_none() || open_pieces(bridge).await == 0 {
                is_stored.get_or_insert(begun.elapsed());
            }
        }
        let (equal, all) = self.equal_pieces(recordings);
        // One is still being written.
        let are_equal = self.store.is_none() || equal > 0 && equal + 1 >= all;
        let holds = is_back.is_some() && is_stored.is_some() && are_equal;
        let seconds = |time: Option<Duration>| time.map(|time| time.as_secs_f64());
        let bucket = self.store.map(|_| {
            json!({ "all_stored_after_s": seconds(is_stored), "pieces": all, "equal_in_it": equal })
        });
        let figures = json!({ "back_at_the_router_after_s": seconds(is_back), "bucket": bucket });
        (holds, figures)
    }

    pub(crate) fn figures(&self) -> Value {
        let count = |counter: &AtomicU64| counter.load(Ordering::Relaxed);
        let store = self.store.map(|_| {
            let (killed, gone) = (count(&self.deaths.store), count(&self.deaths.bucket));
            json!({ "killed": killed, "bucket_gone": gone })
        });
        json!({
            "router_killed": count(&self.deaths.router), "store": store,
            "bridges_measured": count(&self.measured[0]),
            "of_them_at_the_router_when_it_began": count(&self.measured[1]),
        })
    }

    /// Whether router, server and bucket each failed at least once, and a measured bridge had found
    /// the router.
    pub(crate) fn was_torn(&self) -> bool {
        let has = |count: &AtomicU64| count.load(Ordering::Relaxed) > 0;
        let deaths = &self.deaths;
        let of_store = self.store.is_none() || has(&deaths.store) && has(&deaths.bucket);
        has(&deaths.router) && of_store && has(&self.measured[1])
    }

    /// The name of a robot that was not used before.
    fn name(&self) -> String {
        format!("robot-{}", self.bridges.fetch_add(1, Ordering::Relaxed))
    }

    /// Number of pieces of this folder that are equal in the bucket, and of all.
    fn equal_pieces(&self, recordings: &Path) -> (usize, usize) {
        let bucket = self.folder.path().join("buckets").join(BUCKET);
        let robots = std::fs::read_dir(bucket).unwrap().flatten();
        let stored: Vec<PathBuf> = robots.flat_map(|robot| pieces(&robot.path())).collect();
        let pieces = pieces(recordings);
        let stem = |path: &Path| path.file_stem().unwrap().to_str().unwrap().to_owned();
        let is_there = |piece: &&PathBuf| {
            let here = std::fs::read(piece).unwrap();
            // In the bucket, a name continues with a suffix that distinguishes it from those of
            // other robots.
            let mut copies = stored
                .iter()
                .filter(|copy| stem(copy).starts_with(&stem(piece)));
            copies.any(|copy| std::fs::read(copy).is_ok_and(|there| there == here))
        };
        (pieces.iter().filter(is_there).count(), pieces.len())
    }
}

impl Drop for Torn {
    fn drop(&mut self) {
        // With them their processes end.
        self.tearing.iter().for_each(JoinHandle::abort);
    }
}

fn url(name: &str) -> String {
    format!("s3://{BUCKET}/{name}")
}

fn options(store: SocketAddr) -> [(&'static str, String); 5] {
    [
        ("aws_endpoint", format!("http://{store}")),
        ("aws_allow_http", "true".to_owned()),
        ("aws_region", REGION.to_owned()),
        ("aws_access_key_id", KEY.0.to_owned()),
        ("aws_secret_access_key", KEY.1.to_owned()),
    ]
}

/// Recordings in a folder.
pub(crate) fn pieces(folder: &Path) -> Vec<PathBuf> {
    let all = std::fs::read_dir(folder).unwrap().flatten();
    let all = all.map(|entry| entry.path());
    all.filter(|path| path.extension().is_some_and(|ending| ending == "mcap"))
        .collect()
}

/// Finished recordings that are not stored yet.
async fn open_pieces(bridge: SocketAddr) -> usize {
    let (status, body) = web::ask(bridge, "GET", "/recordings.json", None).await;
    assert_eq!(status, 200, "{body}");
    let list: Value = serde_json::from_str(&body).unwrap();
    let all = list["recordings"].as_array().unwrap().iter();
    all.filter(|one| one["current"] != true && one["stored"] != true)
        .count()
}

async fn kill_router(
    program: Program,
    mut child: Child,
    deaths: Arc<Deaths>,
    mut is_torn: watch::Receiver<bool>,
) {
    loop {
        program.dies(&mut child, &deaths.router, &mut is_torn).await;
    }
}

/// In turns, kills the server and removes the bucket.
async fn kill_store(
    program: Program,
    mut child: Child,
    buckets: PathBuf,
    deaths: Arc<Deaths>,
    mut is_torn: watch::Receiver<bool>,
) {
    let (bucket, gone) = (buckets.join(BUCKET), buckets.with_file_name("gone"));
    loop {
        program.dies(&mut child, &deaths.store, &mut is_torn).await;
        lives(THERE, &mut is_torn).await;
        std::fs::rename(&bucket, &gone).unwrap();
        deaths.bucket.fetch_add(1, Ordering::Relaxed);
        sleep(AWAY).await;
        // A request in progress may have made the bucket anew: what it stored is kept.
        merge(&bucket, &gone).unwrap();
        std::fs::rename(&gone, &bucket).unwrap();
    }
}

/// Moves the content of a folder into another one, and removes it; does nothing if it is absent.
fn merge(from: &Path, into: &Path) -> io::Result<()> {
    if !from.is_dir() {
        return Ok(());
    }
    for entry in std::fs::read_dir(from)? {
        let entry = entry?;
        let there = into.join(entry.file_name());
        match entry.file_type()?.is_dir() && there.is_dir() {
            true => merge(&entry.path(), &there)?,
            false => std::fs::rename(entry.path(), there)?,
        }
    }
    std::fs::remove_dir(from)
}

/// Waits for this time, or for ever once the failures have ended.
async fn lives(time: Duration, is_torn: &mut watch::Receiver<bool>) {
    sleep(time).await;
    if is_torn.wait_for(|is_torn| *is_torn).await.is_err() {
        std::future::pending().await
    }
}

/// A program and its arguments.
struct Program(String, Vec<String>);

impl Program {
    async fn start(&self) -> Child {
        started::start(&self.0, &self.1).await
    }

    /// One cycle: it lives, dies, and comes back.
    async fn dies(&self, child: &mut Child, deaths: &AtomicU64, torn: &mut watch::Receiver<bool>) {
        lives(THERE, torn).await;
        child.kill().await.unwrap();
        deaths.fetch_add(1, Ordering::Relaxed);
        sleep(AWAY).await;
        *child = self.start().await;
    }
}

//! Uploads an hour's recording into a real S3-compatible server, through a link that breaks again
//! and again, and says in JSON what came of it.
//!
//! It exits 0 only if all holds: every piece that the bridge counts as stored is in the bucket,
//! byte for byte; the link broke as often as was asked; what was there already was not sent again;
//! the end of the program in the midst cost no more than a part; and what is wrong with a store is
//! said in words, while the bridge serves.
//!
//! The truth is the folder of the server: it is read as files, and compared with sums that were
//! taken before anything was sent.

mod link;
mod store;

use std::collections::BTreeMap;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};
use clap::Parser;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use slamlab_bridge::record::Keep;
use slamlab_bridge::source::SourceName;
use slamlab_bridge::{Config, StorageConfig};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;

use link::Link;
use store::{KEY, Refusal, Store};

const MIB: u64 = 1 << 20;
/// Smaller than by default, so that a break costs little of a report that takes minutes.
const PART_MIB: u64 = 5;
/// Whatever is waited for comes sooner, or never.
const NEVER: Duration = Duration::from_secs(900);
const BUCKET: &str = "drives";

/// Uploads recordings through a link that breaks.
#[derive(Parser)]
struct Flags {
    /// MiB of recording: an hour at 16 GB a day
    #[arg(long, default_value_t = 640)]
    mib: u64,
    /// How often the link breaks
    #[arg(long, default_value_t = 20)]
    breaks: u64,
    /// Serve the buckets in this folder at --port until the end, and report nothing
    #[arg(long, requires = "port")]
    serve: Option<PathBuf>,
    /// Where to serve them, on this machine
    #[arg(long, requires = "serve")]
    port: Option<u16>,
}

/// What came of it.
#[derive(Serialize)]
struct Report {
    holds: bool,
    pieces: usize,
    recording_mib: f64,
    stored: usize,
    equal: usize,
    breaks: u64,
    /// What passed the link towards the store, for each byte of the recording.
    sent_ratio: f64,
    seconds: f64,
    restarted: bool,
    handed_out_equal: bool,
    unknown_key: String,
    no_bucket: String,
    /// A full bucket, and one that the key may not write to: what was said of each, before the
    /// piece was stored after all.
    refusals: Vec<String>,
    failed: Vec<String>,
}

#[derive(Deserialize)]
struct List {
    fault: Option<String>,
    recordings: Vec<Listed>,
}

#[derive(Deserialize)]
struct Listed {
    name: String,
    here: bool,
    stored: bool,
    current: bool,
}

#[tokio::main]
async fn main() -> ExitCode {
    let flags = Flags::parse();
    if let (Some(folder), Some(port)) = (&flags.serve, flags.port) {
        return serve(folder, port).await;
    }
    match report(&flags).await {
        Ok(report) => {
            println!(
                "{}",
                serde_json::to_string_pretty(&report).unwrap_or_default()
            );
            match report.holds {
                true => ExitCode::SUCCESS,
                false => ExitCode::FAILURE,
            }
        }
        Err(error) => {
            eprintln!("{error:?}");
            ExitCode::FAILURE
        }
    }
}

/// For reports that start and kill a store.
async fn serve(folder: &Path, port: u16) -> ExitCode {
    match Store::start(folder, port).await {
        Ok(_) => {
            println!("there");
            std::future::pending().await
        }
        Err(error) => {
            eprintln!("{error:?}");
            ExitCode::FAILURE
        }
    }
}

/// A bridge with a simulated robot that records into a folder.
struct Bridge {
    address: SocketAddr,
    stop: tokio::sync::oneshot::Sender<()>,
    done: tokio::task::JoinHandle<Result<(), slamlab_bridge::RunError>>,
}

impl Bridge {
    async fn start(folder: &Path, storage: StorageConfig) -> Result<Self> {
        let source: SourceName = "sim:arena".parse()?;
        let config = Config {
            sources: vec![source.open(None)?],
            record: Some(folder.to_owned()),
            keep: Keep {
                all_bytes: 1 << 40,
                ..Keep::default()
            },
            storage: Some(storage),
            ..Config::default()
        };
        let listener = slamlab_bridge::bind(([127, 0, 0, 1], 0).into()).await?;
        let address = listener.local_addr()?;
        let (stop, stopped) = tokio::sync::oneshot::channel();
        let serving = slamlab_bridge::start(listener, config)?;
        let done = tokio::spawn(serving.until(async {
            // Dropped is stopped, too.
            let _ = stopped.await;
        }));
        Ok(Self {
            address,
            stop,
            done,
        })
    }

    async fn end(self) -> Result<()> {
        // It may have ended by itself.
        let _ = self.stop.send(());
        Ok(self.done.await??)
    }

    async fn list(&self) -> Result<List> {
        let body = get(self.address, "/recordings.json").await?;
        Ok(serde_json::from_slice(&body)?)
    }

    /// Waits until the list is as it should be.
    async fn until(&self, what: &str, is_so: impl Fn(&List) -> bool) -> Result<List> {
        let until = Instant::now() + NEVER;
        loop {
            let list = self.list().await?;
            if is_so(&list) {
                return Ok(list);
            }
            if Instant::now() > until {
                bail!("{what} never: {:?}", list.fault);
            }
            tokio::time::sleep(Duration::from_millis(100)).await;
        }
    }
}

async fn get(address: SocketAddr, path: &str) -> Result<Vec<u8>> {
    let mut stream = TcpStream::connect(address).await?;
    let request = format!("GET {path} HTTP/1.0\r\nHost: {address}\r\n\r\n");
    stream.write_all(request.as_bytes()).await?;
    let mut answer = vec![];
    stream.read_to_end(&mut answer).await?;
    let head = answer.windows(4).position(|four| four == b"\r\n\r\n");
    let body = answer.split_off(head.context("no answer of HTTP")? + 4);
    if !answer.starts_with(b"HTTP/1.0 200") && !answer.starts_with(b"HTTP/1.1 200") {
        bail!("{path}: {}", String::from_utf8_lossy(&answer));
    }
    let head = String::from_utf8_lossy(&answer).to_lowercase();
    let length = head.split_once("content-length: ");
    let length = length.and_then(|(_, behind)| behind.lines().next()?.trim().parse::<usize>().ok());
    if let Some(length) = length.filter(|length| *length != body.len()) {
        bail!("{path}: {} of {length} bytes", body.len());
    }
    Ok(body)
}

fn storage(store: SocketAddr, bucket: &str, secret: &str) -> StorageConfig {
    let options = [
        ("aws_endpoint", format!("http://{store}")),
        ("aws_allow_http", "true".to_owned()),
        ("aws_region", "eu-central-1".to_owned()),
        ("aws_access_key_id", KEY.0.to_owned()),
        ("aws_secret_access_key", secret.to_owned()),
    ];
    StorageConfig {
        options: options.map(|(key, value)| (key.to_owned(), value)).into(),
        part_mib: PART_MIB,
        ..StorageConfig::new(format!("s3://{bucket}/robot"))
    }
}

fn sum(bytes: &[u8]) -> String {
    let sum = Sha256::digest(bytes);
    sum.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// What a piece is called in the store, which may have those of other robots.
fn name_in_store(piece: &str, sum: &str) -> String {
    let stem = piece.strip_suffix(".mcap").unwrap_or(piece);
    format!("{stem}-{}.mcap", &sum[..16])
}

/// Finished pieces of so many MiB in all, as a bridge that had no link would have left them; their
/// sums. Their bytes are never alike: a part in the wrong place is seen.
fn make_pieces(folder: &Path, mib: u64) -> Result<BTreeMap<String, String>> {
    let mut sums = BTreeMap::new();
    let mut state = 0x2545_f491_4f6c_dd1d_u64;
    let mut left = mib * MIB;
    let mut hour = 0;
    while left > 0 {
        // Of an odd length: the last part is a short one.
        let bytes = left.min(64 * MIB + 4_321);
        let mut piece = Vec::with_capacity(bytes as usize + 8);
        while (piece.len() as u64) < bytes {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            piece.extend(state.to_le_bytes());
        }
        piece.truncate(bytes as usize);
        let name = format!(
            "slamlab-2026-01-{:02}T{:02}-00-00Z.mcap",
            1 + hour / 24,
            hour % 24
        );
        std::fs::write(folder.join(&name), &piece)?;
        sums.insert(name, sum(&piece));
        left -= bytes;
        hour += 1;
    }
    Ok(sums)
}

/// A store that refuses a piece, and then takes it: what the bridge said of it.
async fn refused(scene: &Path, store: &Store, refusal: Refusal) -> Result<String> {
    const PIECE: &str = "slamlab-2026-01-02T00-00-00Z.mcap";
    const BUCKET: &str = "refusing";
    let folder = tempfile::tempdir_in(scene)?;
    let bytes = format!("a piece that meets {refusal:?}");
    std::fs::write(folder.path().join(PIECE), &bytes)?;
    store.refuse(Some(refusal));
    let config = storage(store.address, BUCKET, KEY.1);
    let bridge = Bridge::start(folder.path(), config).await?;
    let list = bridge
        .until("a refusal", |list| list.fault.is_some())
        .await?;
    store.refuse(None);
    bridge
        .until("a store that takes it", |list| {
            let mut found = list.recordings.iter();
            list.fault.is_none() && found.any(|one| one.name == PIECE && one.stored)
        })
        .await?;
    bridge.end().await?;
    let bucket = scene.join("buckets").join(BUCKET).join("robot");
    let kept = bucket.join(name_in_store(PIECE, &sum(bytes.as_bytes())));
    let stored = std::fs::read(&kept).with_context(|| kept.display().to_string())?;
    if stored != bytes.as_bytes() {
        bail!("after {refusal:?} another piece is stored");
    }
    Ok(list.fault.unwrap_or_default())
}

async fn report(flags: &Flags) -> Result<Report> {
    let scene = tempfile::tempdir()?;
    let path = |name: &str| scene.path().join(name);
    for name in [
        "buckets",
        "buckets/drives",
        "buckets/refusing",
        "recordings",
        "other",
    ] {
        std::fs::create_dir(path(name))?;
    }
    let sums = make_pieces(&path("recordings"), flags.mib)?;
    let store = Store::start(&path("buckets"), 0).await?;
    let server = store.address;
    let mut failed = vec![];

    // What is wrong with a store is said, and the bridge serves.
    let fault = async |bucket: &str, secret: &str| -> Result<String> {
        let folder = path("other");
        std::fs::write(folder.join("slamlab-2026-01-01T00-00-00Z.mcap"), "a piece")?;
        let bridge = Bridge::start(&folder, storage(server, bucket, secret)).await?;
        let list = bridge.until("a fault", |list| list.fault.is_some()).await?;
        bridge.end().await?;
        Ok(list.fault.unwrap_or_default())
    };
    let unknown_key = fault(BUCKET, "another").await?;
    let no_bucket = fault("nowhere", KEY.1).await?;
    if !unknown_key.contains("s3://drives/robot") || !unknown_key.contains("key") {
        failed.push(format!("an unknown key is called: {unknown_key}"));
    }
    if !no_bucket.contains("s3://nowhere/robot") || !no_bucket.contains("is not there") {
        failed.push(format!("a missing bucket is called: {no_bucket}"));
    }

    let mut refusals = vec![];
    for (refusal, expected) in [
        (Refusal::FULL, "the bucket is full"),
        (Refusal::DENIED, "the store denies it"),
    ] {
        let told = refused(scene.path(), &store, refusal).await?;
        if !told.contains("s3://refusing/robot") || !told.contains(expected) {
            failed.push(format!("{refusal:?} is called: {told}"));
        }
        refusals.push(told);
    }

    let all: u64 = flags.mib * MIB;
    let (link, near) = Link::start(server, flags.breaks, all / (flags.breaks + 1)).await?;
    let begun = Instant::now();
    let config = || storage(near, BUCKET, KEY.1);
    let bridge = Bridge::start(&path("recordings"), config()).await?;
    let count = |list: &List| list.recordings.iter().filter(|one| one.stored).count();
    // In the midst of it the program ends, and begins again.
    let half = sums.len() / 2;
    bridge
        .until("half of it", |list| count(list) >= half)
        .await?;
    bridge.end().await?;
    let bridge = Bridge::start(&path("recordings"), config()).await?;
    let is_done = |list: &List| {
        let mut open = list.recordings.iter().filter(|one| !one.current);
        open.all(|one| one.stored)
    };
    let list = bridge.until("all of it", is_done).await?;
    let seconds = begun.elapsed().as_secs_f64();

    let bucket = path("buckets").join(BUCKET).join("robot");
    let in_bucket = |name: &str, of: &str| {
        std::fs::read(bucket.join(name_in_store(name, of))).map(|bytes| sum(&bytes))
    };
    let mut equal = 0;
    for one in list.recordings.iter().filter(|one| one.stored) {
        let expected = match sums.get(&one.name) {
            Some(known) => known.clone(),
            // Of this run: the piece itself, which nobody writes any more.
            None => sum(&std::fs::read(path("recordings").join(&one.name))?),
        };
        match in_bucket(&one.name, &expected) {
            Ok(found) if found == expected => equal += 1,
            other => failed.push(format!("{}: {other:?} in the bucket", one.name)),
        }
    }
    for name in sums.keys() {
        if !list
            .recordings
            .iter()
            .any(|one| one.name == *name && one.here && one.stored)
        {
            failed.push(format!("{name} is not stored"));
        }
    }
    // One that is no longer here is handed out from there.
    let (first, expected) = sums.first_key_value().context("no pieces")?;
    std::fs::remove_file(path("recordings").join(first))?;
    let there = format!("/recordings/{}", name_in_store(first, expected));
    // The link may break on the way: who received less than all of it knows that, and asks again.
    let mut handed = get(bridge.address, &there).await;
    if handed.is_err() {
        handed = get(bridge.address, &there).await;
    }
    let handed_out_equal = sum(&handed?) == *expected;
    if !handed_out_equal {
        failed.push(format!("{first} is handed out as another"));
    }
    bridge.end().await?;

    let breaks = link.breaks.load(Ordering::Relaxed);
    if breaks != flags.breaks {
        failed.push(format!("the link broke {breaks} times"));
    }
    // Each break costs a part, and each part that was under way at the end of the program, too;
    // heads and signatures are a hundredth.
    let allowed = 1.02 * all as f64 + ((2 * breaks + 2) * PART_MIB * MIB) as f64 + 64e6;
    let sent = link.bytes.load(Ordering::Relaxed) as f64;
    if sent > allowed {
        failed.push(format!("{sent} bytes were sent; at most {allowed} are due"));
    }
    Ok(Report {
        holds: failed.is_empty(),
        pieces: sums.len(),
        recording_mib: flags.mib as f64,
        stored: count(&list),
        equal,
        breaks,
        sent_ratio: sent / all as f64,
        seconds,
        restarted: true,
        handed_out_equal,
        unknown_key,
        no_bucket,
        refusals,
        failed,
    })
}

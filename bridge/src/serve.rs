//! The whole bridge: sources, hub, recorder and server, from start to stop.

use std::future::Future;
use std::io;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use slamlab_core::device;
use slamlab_core::wire::message::{
    About, CHALLENGE_BYTES, FromBridge, PROTOCOL, RobotFigures, SCHEMA, Watching,
};
use tokio::net::TcpListener;
use tokio::sync::{mpsc, watch};
use tokio::task::JoinHandle;

use crate::accept;
use crate::access_log::AccessLog;
use crate::audit::Audit;
use crate::clock::Clock;
use crate::http;
use crate::hub;
use crate::mapping::{self, MapConfig, MapError};
use crate::metrics::Metrics;
use crate::notify;
use crate::page::{Page, PageError};
use crate::record::pieces::Files;
use crate::record::{Keep, RecordError, Recorder};
use crate::rights::{self, Keys, KeysError};
use crate::shared::{Limits, Shared};
use crate::source::{self, Running, Source};
#[cfg(feature = "storage")]
use crate::storage;
use crate::storage::{StorageConfig, StorageError};
use crate::tls::Identity;
use crate::zenoh::{self, ZenohConfig, ZenohError};

/// How long open requests may take to end once shutdown begins.
const GRACE: Duration = Duration::from_secs(2);
/// Interval between checks that the certificate is still valid: the machine's addresses change.
const RENEWAL: Duration = Duration::from_secs(60);

/// What to serve.
#[derive(Default)]
pub struct Config {
    /// The page; without one, there is only the WebSocket.
    pub page: Option<Page>,
    /// Robots and sensors. The first with a robot takes the commands.
    pub sources: Vec<Box<dyn Source>>,
    /// Who may do what. Without any keys, nobody drives.
    pub keys: Keys,
    /// Whether watching needs a token.
    pub watching: Option<Watching>,
    /// Origins of other pages that may connect, exactly as a browser writes them:
    /// `https://lab.example`. The page that the bridge serves needs no entry.
    pub origins: Vec<String>,
    /// Names that the bridge answers to in addition to its own: of a reverse proxy, or in a VPN.
    pub hosts: Vec<String>,
    /// Whether Foxglove may watch, if watching needs no token.
    pub foxglove: bool,
    /// Whether clients of rosbridge may watch, and drive with the token.
    pub rosbridge: bool,
    /// Identity for TLS; without one, traffic is not encrypted.
    pub tls: Option<Identity>,
    /// Where to record to: a new file, or a folder that takes new ones.
    pub record: Option<PathBuf>,
    /// How long pieces in a folder are, and how much is kept.
    pub keep: Keep,
    /// Folder of the audit, and how much of it is kept.
    pub audit: Option<(PathBuf, Keep)>,
    /// Object storage for finished recordings.
    pub storage: Option<StorageConfig>,
    /// Whether and how the bridge maps what its robot sees.
    pub map: Option<MapConfig>,
    /// Whether and how the robot is reached through a router.
    pub zenoh: Option<ZenohConfig>,
    /// Limits of sockets, messages and times.
    pub limits: Limits,
}

/// Why the bridge does not serve, or serves no longer.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RunError {
    /// There is no page.
    #[error(transparent)]
    Page(#[from] PageError),
    /// There are more sources than their numbers can tell apart.
    #[error("{count} sources; expected at most 256")]
    Sources {
        /// How many there are.
        count: usize,
    },
    /// There are two robots, whose readings would be mixed.
    #[error(
        "{first} and {second} are two robots, and a bridge has one: start another bridge for the other"
    )]
    Robots {
        /// Name of the first.
        first: String,
        /// Name of the second.
        second: String,
    },
    /// A source got no thread.
    #[error("source {name} cannot start: {source}")]
    Start {
        /// Its name.
        name: String,
        /// What the system said.
        source: io::Error,
    },
    /// The rights cannot be read.
    #[error(transparent)]
    Keys(#[from] KeysError),
    /// The recording cannot begin.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// Recordings cannot be kept in object storage.
    #[error(transparent)]
    Storage(#[from] StorageError),
    /// Mapping cannot begin.
    #[error(transparent)]
    Map(#[from] MapError),
    /// The robot cannot be reached through the router.
    #[error(transparent)]
    Zenoh(#[from] ZenohError),
    /// The hub ended by itself. Without it only the robot can stop itself.
    #[error("the part that has the robot broke down: an error of this program; please report it")]
    Hub,
}

/// Serves on `listener` until `shutdown` ends; see [`start`] and [`Serving::until`].
///
/// # Errors    [`RunError`] at once if something in `config` cannot be used.
pub async fn run(
    listener: TcpListener,
    config: Config,
    shutdown: impl Future<Output = ()> + Send + 'static,
) -> Result<(), RunError> {
    start(listener, config)?.until(shutdown).await
}

/// A running bridge.
#[derive(Debug)]
#[must_use = "it serves until its end is waited for"]
pub struct Serving {
    stop: watch::Sender<bool>,
    hub: JoinHandle<()>,
    server: JoinHandle<()>,
}

/// A configuration whose possible faults have been checked.
struct Ready {
    robot: Option<RobotFigures>,
    map: Option<mapping::Ready>,
    zenoh: Option<zenoh::Ready>,
    #[cfg(feature = "storage")]
    storage: Option<storage::Ready>,
}

/// Checks everything except rights; nothing moves, and nothing is written.
fn ready(config: &Config) -> Result<Ready, RunError> {
    if let Some(page) = &config.page {
        page.check()?;
    }
    let profiles: Vec<_> = (config.sources.iter())
        .map(|source| source.profile())
        .collect();
    let mut robots = profiles.iter().filter(|profile| profile.robot.is_some());
    if let (Some(first), Some(second)) = (robots.next(), robots.next()) {
        let (first, second) = (first.name.clone(), second.name.clone());
        return Err(RunError::Robots { first, second });
    }
    let robot = source::robot_figures(&profiles.iter().collect::<Vec<_>>());
    let record = config.record.as_deref();
    record.map(Recorder::check).transpose()?;
    #[cfg(not(feature = "storage"))]
    if let Some(StorageConfig { url, .. }) = &config.storage {
        let url = url.clone();
        return Err(StorageError::NotBuilt { url }.into());
    }
    #[cfg(feature = "storage")]
    let storage = config.storage.as_ref();
    Ok(Ready {
        map: (config.map.as_ref())
            .map(|map| mapping::ready(map, robot.as_ref()))
            .transpose()?,
        robot,
        zenoh: config.zenoh.clone().map(zenoh::ready).transpose()?,
        #[cfg(feature = "storage")]
        storage: storage
            .map(|storage| storage::ready(storage, record))
            .transpose()?,
    })
}

/// Checks whether a bridge could serve with this configuration, except for its rights and its port.
/// Nothing moves, and nothing is written.
///
/// # Errors
/// [`RunError`], as from [`start`].
pub fn check(config: &Config) -> Result<(), RunError> {
    ready(config).map(drop)
}

/// Begins to serve on `listener`, on the current runtime.
///
/// # Errors    [`RunError`] if something in `config` cannot be used; then nothing was begun or
/// written.
pub fn start(listener: TcpListener, config: Config) -> Result<Serving, RunError> {
    let ready = ready(&config)?;
    let (robot, mut map, zenoh) = (ready.robot, ready.map, ready.zenoh);
    let rights = config.keys.read()?;
    if let Some(zenoh) = &zenoh {
        zenoh.check_rights(&rights)?;
    }
    if let Some(map) = &mut map {
        map.check_rights(&rights)?;
        map.lock()?;
    }
    let (rights_sender, rights) = watch::channel(Arc::new(rights));
    let clock = Clock::start();
    let metrics = Arc::new(Metrics::default());
    let log = Arc::new(AccessLog::new());
    // Lock both folders before either begins a file.
    let audit = (config.audit.as_ref()).map(|(folder, keep)| Files::audits(folder, *keep, clock));
    let audit = audit.transpose()?;
    let record = (config.record.as_deref())
        .map(|path| Files::recordings(path, config.keep, clock))
        .transpose()?;
    let audit = audit.map(Audit::start).transpose()?.map(Arc::new);
    let recorder = record.map(Recorder::start_in).transpose()?;
    let (hub, clients) = mpsc::channel(hub::MOST_WAITING);
    #[cfg(feature = "storage")]
    let (uploads, uploader) = (ready.storage.zip(recorder.as_ref()))
        .map(|(storage, recorder)| storage.start(recorder.current(), hub.clone()))
        .unzip();
    let (sender, events) = mpsc::channel(source::MOST_WAITING);
    let sources = start_all(config.sources, &sender)?;
    let about = about(&sources, robot.as_ref(), config.watching);
    // This hello only names the robot; its challenge is not used.
    let hello = device::hub::hello([0; CHALLENGE_BYTES], about.watching, robot.clone());
    if let Some(recorder) = &recorder {
        recorder.message(&FromBridge::Hello(hello.clone()), clock.now());
    }
    let mut task = hub::Task::new(hub::Parts {
        clock,
        sources,
        metrics: Arc::clone(&metrics),
        log: Arc::clone(&log),
        recorder,
        audit: audit.clone(),
        rights: rights.clone(),
    });
    let mapping = map.map(|map| task.map(map, hello, hub.clone()));
    let mapping = mapping.transpose()?;
    let shared = Arc::new(Shared {
        page: config.page,
        about,
        robot,
        rights,
        origins: config.origins,
        hosts: config.hosts.into(),
        foxglove: config.foxglove,
        rosbridge: config.rosbridge,
        is_tls: config.tls.is_some(),
        limits: config.limits,
        hub,
        clock,
        metrics,
        log,
        audit,
        mapping,
        #[cfg(feature = "zenoh")]
        fleet: zenoh.as_ref().map(|_| Arc::default()),
        #[cfg(feature = "zenoh")]
        listening: listener.local_addr().ok(),
        #[cfg(feature = "storage")]
        uploads,
    });
    let (stop, stopped) = watch::channel(false);
    let hub = tokio::spawn(task.run(events, clients, accept::until(stopped.clone())));
    tokio::spawn(rights::keep_up(config.keys, rights_sender));
    #[cfg(feature = "storage")]
    if let Some(uploader) = uploader {
        let stopped = accept::until(stopped.clone());
        tokio::spawn(async move {
            tokio::select! {
                () = uploader => (),
                () = stopped => (),
            }
        });
    }
    if let Some(identity) = config.tls.clone() {
        let stopped = accept::until(stopped.clone());
        tokio::spawn(async move {
            tokio::select! {
                () = renew(&identity) => (),
                () = stopped => (),
            }
        });
    }
    if let Some(zenoh) = zenoh {
        zenoh.start(Arc::clone(&shared), stopped.clone());
    }
    let server = tokio::spawn(accept::run(listener, config.tls, shared, stopped));
    notify::ready();
    Ok(Serving { stop, hub, server })
}

impl Serving {
    /// Serves until `shutdown` ends; then the robot is stopped, the recording finished, and open
    /// requests may end within two seconds.
    ///
    /// # Errors    [`RunError::Hub`]: then this ends at once, so that whoever started the bridge
    /// can restart it.
    pub async fn until(mut self, shutdown: impl Future<Output = ()>) -> Result<(), RunError> {
        let ended = tokio::select! {
            () = shutdown => None,
            ended = &mut self.hub => Some(ended),
        };
        notify::stopping();
        // If this fails, all receivers are already gone.
        let _ = self.stop.send(true);
        // The hub first: it controls the robot.
        let is_well = match ended {
            Some(_) => false,
            None => self.hub.await.is_ok(),
        };
        if tokio::time::timeout(GRACE, self.server).await.is_err() {
            tracing::warn!(
                "some requests were still open after {} s and were cut off",
                GRACE.as_secs()
            );
        }
        is_well.then_some(()).ok_or(RunError::Hub)
    }
}

/// Keeps the certificate valid while the bridge runs.
async fn renew(identity: &Identity) {
    loop {
        tokio::time::sleep(RENEWAL).await;
        match identity.renew() {
            Ok(true) => tracing::info!("a new certificate is shown from now on"),
            Ok(false) => (),
            Err(error) => tracing::warn!("the certificate is not made anew: {error}"),
        }
    }
}

fn start_all(
    sources: Vec<Box<dyn Source>>,
    events: &mpsc::Sender<(u8, source::SourceEvent)>,
) -> Result<Vec<Running>, RunError> {
    let count = sources.len();
    let start = |(number, source): (usize, Box<dyn Source>)| {
        let number = u8::try_from(number).map_err(|_| RunError::Sources { count })?;
        let name = source.profile().name;
        source::start(number, source, events.clone())
            .map_err(|source| RunError::Start { name, source })
    };
    sources.into_iter().enumerate().map(start).collect()
}

fn about(sources: &[Running], robot: Option<&RobotFigures>, watching: Option<Watching>) -> About {
    About {
        version: env!("CARGO_PKG_VERSION").to_owned(),
        protocol: PROTOCOL,
        schema: format!("{SCHEMA:016x}"),
        websocket: http::SOCKET_PATH.to_owned(),
        watching: watching.unwrap_or(Watching::Anyone),
        robot: robot.map(|robot| robot.preset.clone()),
        sources: sources
            .iter()
            .map(|source| source.profile.name.clone())
            .collect(),
    }
}

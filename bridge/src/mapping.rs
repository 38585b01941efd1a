//! Mapping without a page: the bridge itself runs the core's session beside the hub.
//!
//! ```text
//!   hub ── messages ──> outbox ──> mapper (a thread) ── pose, map, how it does ──> hub ──> clients
//!                                    └─ snapshots ──> keeper (a thread) ──> file
//! ```
//!
//! 1. The mapper is a client of the hub like a page, and maps by the same code
//!    ([`slamlab_core::live::Live`]). Its outbox is bounded and keeps the newest: while the mapper
//!    works on a scan, newer scans replace waiting ones, and nobody waits for the mapper.
//! 2. Its results are in one place ([`Shown`]), from which the hub informs all clients and HTTP
//!    serves files.
//! 3. The keeper packs and writes the map, so that the mapper never waits for a disk (`keeper`).
//! 4. The geofence, where the robot may be in the map, is kept in a file beside the map
//!    (`fence_file`); the hub's rules enforce it by the poses that the mapper estimates.
//! 5. If there is a map file at the start, the run goes on in it: from where the robot was left or,
//!    if the scans do not fit there, from wherever it localises itself.

mod fence_file;
mod file;
mod keeper;
mod mapper;
mod serve;
mod shown;

use std::collections::VecDeque;
use std::fs::File;
use std::io;
use std::path::PathBuf;
use std::sync::mpsc::{SyncSender, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use slamlab_core::estimation::Start;
use slamlab_core::format::map_server::OccupancyMap;
use slamlab_core::format::slamlab::SlamlabError;
use slamlab_core::live::{HomingConfig, Live, LiveConfig, LiveError};
use slamlab_core::robot::RobotModel;
use slamlab_core::settings::{Idle, Scope, SettingError, Settings, Source};
use slamlab_core::slam::{EarlierMap, Method, SlamError};
use slamlab_core::wire::message::{BridgeHello, RobotFigures, Role, ZoneBody};
use tokio::sync::{oneshot, watch};

use crate::clock::Clock;
use crate::hub::outbox::Outbox;
use crate::rights::{Name, Rights};
use file::MapFile;
use keeper::Keeper;
use mapper::Mapper;
pub(crate) use mapper::ToHub;
pub(crate) use serve::routes;
pub(crate) use shown::Shown;

/// Most requests that may wait for the mapper.
const MOST_ASKED: usize = 4;
/// Seed of the planner's random numbers.
const SEED: u64 = 1;
/// The mapper's name among the clients.
pub(crate) const NAME: &str = "bridge";

/// How the bridge maps.
#[derive(Clone, Debug, PartialEq)]
pub struct MapConfig {
    /// Where the map is kept (`.slamlab`); without a file, the map is lost when the program ends.
    pub file: Option<PathBuf>,
    /// How the pose is estimated. Default scan matching, the only method whose map can be kept.
    pub method: Method,
    /// Settings that differ from the defaults of the robot, by their keys.
    pub settings: Vec<(String, f64)>,
    /// Interval at which the map is written while it changes. Default 30 s.
    pub save_every: Duration,
    /// Whether the robot may go home by itself. Default no: it holds, whatever fails.
    pub home: Option<HomeConfig>,
}

/// When the robot goes home by itself, and by which right.
#[derive(Clone, Debug, PartialEq)]
pub struct HomeConfig {
    /// Name of a driver's right that was made for this; if it is taken away, the robot holds.
    pub right: Name,
    /// When it goes home, and how sure of its pose it must be.
    pub when: HomingConfig,
}

impl Default for MapConfig {
    fn default() -> Self {
        Self {
            file: None,
            method: Method::ScanMatching,
            settings: vec![],
            save_every: Duration::from_secs(30),
            home: None,
        }
    }
}

/// Why the bridge does not map.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MapError {
    /// The map of this method cannot be kept.
    #[error(
        "map file {}: only scan-matching goes on in a saved map, not {}; leave the file out, or the method", path.display(),
        method.name()
    )]
    Method {
        /// The file.
        path: PathBuf,
        /// The method.
        method: Method,
    },
    /// The method draws no map.
    #[error("map method {}: it finds a robot in a map that is given, and the bridge is to draw one", method.name())]
    NeedsMap {
        /// The method.
        method: Method,
    },
    /// A setting that does not exist, or is out of range.
    #[error("map setting: {0}")]
    Setting(#[from] SettingError),
    /// A setting that does nothing here.
    #[error("map setting: {0}")]
    Idle(Idle),
    /// The settings do not go together.
    #[error("map: {0}")]
    Live(#[from] LiveError),
    /// The system reported an error.
    #[error("map file {}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What it said.
        source: io::Error,
    },
    /// The file holds no map, or a damaged one; it is left as it is.
    #[error("map file {}: {source}; it is left as it is", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What is wrong with it, and where.
        source: SlamlabError,
    },
    /// The file is of another kind.
    #[error("map file {}: {found}; a .slamlab file was expected, and this one is left as it is", path.display())]
    Foreign {
        /// The file.
        path: PathBuf,
        /// What kind it is.
        found: String,
    },
    /// A run cannot go on in its map.
    #[error("map file {}: {source}; it is left as it is", path.display())]
    Restore {
        /// The file.
        path: PathBuf,
        /// Why not.
        source: SlamError,
    },
    /// The right by which the robot would go home does not exist, or may not drive.
    #[error(
        "failsafe right {right}: there is no right of that name that is good for driving; `slamlab-bridge token list` shows those that there are, `token add NAME --role driver` makes one"
    )]
    NoRight {
        /// Its name.
        right: Name,
    },
    /// The map's geofence cannot be read; without it the robot could go everywhere, so mapping does
    /// not start.
    #[error("geofence {}: {why}; mend it, or move it away to let the robot go everywhere", path.display())]
    Fence {
        /// The file.
        path: PathBuf,
        /// What is wrong with it, and where.
        why: String,
    },
    /// Another bridge keeps its map there; the two would overwrite each other.
    #[error("map file {}: another bridge keeps its map there; end that one, or name another file", path.display())]
    Taken {
        /// The file.
        path: PathBuf,
    },
    /// There is a geofence, but not the map in which it is drawn.
    #[error("map file {}: there is none, and a geofence beside it; put the map there, or move the geofence away: in another map it means nothing", path.display())]
    FenceAlone {
        /// The file.
        path: PathBuf,
    },
    /// The system gave no thread.
    #[error("mapping got no thread: {0}")]
    Thread(io::Error),
}

/// What others ask of the mapper.
#[derive(Debug)]
enum Asked {
    /// Begin anew; the map's file, if any, is moved aside.
    Reset,
    /// Keep this geofence beside the map.
    Fence(Vec<ZoneBody>),
    /// The map as it is now, as the bytes of a file.
    Pack(oneshot::Sender<Result<Vec<u8>, String>>),
}

/// Mapping that is ready to begin: everything that can be wrong with it has been checked.
#[derive(Debug)]
pub(crate) struct Ready {
    live: Live,
    keeper: Option<Keeper>,
    save_every: Duration,
    pub(crate) home: Option<HomeConfig>,
    /// Where the robot may be in the map.
    pub(crate) zones: Vec<ZoneBody>,
    path: Option<PathBuf>,
    lock: Option<File>,
}

/// A bridge's running mapping.
#[derive(Debug)]
pub(crate) struct Mapping {
    shown: watch::Receiver<Shown>,
    asked: SyncSender<Asked>,
    thread: Mutex<Option<JoinHandle<()>>>,
    /// Maps whose description was served: their images are requested next.
    described: Mutex<VecDeque<(u64, Arc<OccupancyMap>)>>,
    packed: serve::Packed,
    /// While it is open, no other bridge keeps a map in the same file.
    _lock: Option<File>,
}

/// Checks settings and file.
///
/// # Errors    [`MapError`]; then nothing was begun or written.
pub(crate) fn ready(config: &MapConfig, robot: Option<&RobotFigures>) -> Result<Ready, MapError> {
    let method = config.method;
    if method.needs_prior_map() {
        return Err(MapError::NeedsMap { method });
    }
    if let (Some(path), true) = (&config.file, method != Method::ScanMatching) {
        let path = path.clone();
        return Err(MapError::Method { path, method });
    }
    check_settings(config, robot)?;
    let mut live = Live::new(LiveConfig {
        name: NAME.to_owned(),
        token: None,
        method,
        prior_map: None,
        cycle: false,
        settings: config.settings.clone(),
        seed: SEED,
    })?;
    let (mut keeper, mut zones) = (None, vec![]);
    if let Some(path) = &config.file {
        let file = MapFile::new(path.clone());
        let mut times = vec![];
        let saved = file.read()?;
        zones = file.read_fence()?;
        if saved.is_none() && !zones.is_empty() {
            return Err(MapError::FenceAlone { path: path.clone() });
        }
        if let Some(experiment) = saved {
            times.clone_from(&experiment.map.times);
            let map = Arc::new(experiment.map);
            let start = Start::Left;
            live.go_on_in(EarlierMap { map, start })
                .map_err(|source| MapError::Restore {
                    path: path.clone(),
                    source,
                })?;
        }
        file.check_folder()?;
        keeper = Some(Keeper::start(file, config.settings.clone(), times)?);
    }
    Ok(Ready {
        live,
        keeper,
        save_every: config.save_every,
        home: config.home.clone(),
        zones,
        path: config.file.clone(),
        lock: None,
    })
}

/// A setting that has no effect is an error, as on every command line.
fn check_settings(config: &MapConfig, robot: Option<&RobotFigures>) -> Result<(), MapError> {
    let model = robot.and_then(RobotFigures::model);
    let model = model.unwrap_or_else(RobotModel::pioneer);
    let on_command = robot.is_some_and(|robot| robot.scans_on_command);
    let scope = Scope {
        source: Source::Live,
        method: config.method,
    };
    let changes = config.settings.iter().map(|(key, value)| (key, *value));
    let idle = Settings::of_robot(&model, on_command).take(&scope, changes)?;
    idle.into_iter()
        .next()
        .map_or(Ok(()), |idle| Err(MapError::Idle(idle)))
}

impl Ready {
    /// Takes the file for this bridge alone.
    ///
    /// # Errors    [`MapError::Taken`], [`MapError::Io`].
    pub(crate) fn lock(&mut self) -> Result<(), MapError> {
        self.lock = self.path.as_deref().map(file::lock).transpose()?;
        Ok(())
    }

    /// # Errors    [`MapError::NoRight`]: the right by which the robot goes home does not exist, or
    /// may not drive.
    pub(crate) fn check_rights(&self, rights: &Rights) -> Result<(), MapError> {
        let right = self.home.as_ref().map(|home| &home.right);
        let may_drive = |right| rights.role_of(right).is_some_and(Role::may_drive);
        match right {
            Some(right) if !may_drive(right) => Err(MapError::NoRight {
                right: right.clone(),
            }),
            _ => Ok(()),
        }
    }

    /// Begins to map what comes into `outbox`.
    ///
    /// # Errors    [`MapError::Thread`].
    pub(crate) fn start(
        mut self,
        hello: BridgeHello,
        outbox: Arc<Outbox>,
        to_hub: ToHub,
        clock: Clock,
    ) -> Result<Mapping, MapError> {
        let (sender, shown) = watch::channel(Shown::default());
        let (asked, asks) = sync_channel(MOST_ASKED);
        let lock = self.lock.take();
        let mapper = Mapper::new(self, outbox, to_hub, clock, sender, asks);
        let thread = std::thread::Builder::new()
            .name("map".into())
            .spawn(move || mapper.run(hello))
            .map_err(MapError::Thread)?;
        Ok(Mapping {
            shown,
            asked,
            thread: Mutex::new(Some(thread)),
            described: Mutex::default(),
            packed: serve::Packed::default(),
            _lock: lock,
        })
    }
}

impl Mapping {
    /// The results; they change with each scan.
    pub(crate) fn shown(&self) -> watch::Receiver<Shown> {
        self.shown.clone()
    }

    /// Asks for a new map; returns whether the mapper took the request.
    pub(crate) fn reset(&self) -> bool {
        self.asked.try_send(Asked::Reset).is_ok()
    }

    /// Asks for a geofence to be kept beside the map; returns whether the mapper took the request.
    pub(crate) fn keep_fence(&self, zones: Vec<ZoneBody>) -> bool {
        self.asked.try_send(Asked::Fence(zones)).is_ok()
    }

    /// Whether the mapper has ended by itself, which should never happen.
    pub(crate) fn is_broken(&self) -> bool {
        let thread = self.thread.lock().unwrap_or_else(PoisonError::into_inner);
        thread.as_ref().is_some_and(JoinHandle::is_finished)
    }

    /// Waits until the map is written. Its outbox must be closed before.
    pub(crate) fn finish(&self) {
        let mut thread = self.thread.lock().unwrap_or_else(PoisonError::into_inner);
        if thread.take().is_some_and(|thread| thread.join().is_err()) {
            tracing::error!("the mapper panicked");
        }
    }
}

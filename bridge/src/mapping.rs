//! Mapping without a page: the bridge itself runs the core's session beside the hub.
//!
//! ```text
//!   hub ── messages ──> outbox ──> mapper (a thread) ── pose, map, how it does ──> hub ──> clients
//!                                    └─ snapshots ──> keeper (a thread) ──> file
//! ```
//!
//! 1. The mapper is a client of the hub like a page, and maps by the same code
//!    ([`slamlab_core::live::Live`]). What waits for it is bounded, the newest first: while it is
//!    busy with a scan others take that one's place, and nobody waits for it.
//! 2. What it finds stands in one place ([`Shown`]) from which the hub tells all clients, and HTTP
//!    serves files.
//! 3. The keeper packs and writes the map, so that no disk keeps the mapper waiting (`keeper`).
//! 4. Where the robot may be in the map stands in a file beside it (`fence_file`); the hub's rules
//!    hold it to that, by the poses that the mapper finds.
//! 5. Where there is a file at the start, the run goes on in it: where the robot was left, or, if
//!    it does not see that there, wherever it finds itself.

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

/// What others ask of the mapper and wait for it, at most.
const MOST_ASKED: usize = 4;
/// Seed of the planner's random numbers.
const SEED: u64 = 1;
/// How the mapper is called among the clients.
pub(crate) const NAME: &str = "bridge";

/// How the bridge maps.
#[derive(Clone, Debug, PartialEq)]
pub struct MapConfig {
    /// Where the map is kept (`.slamlab`); without it, it is gone with the program.
    pub file: Option<PathBuf>,
    /// How the pose is estimated. Default scan matching, the only one whose map can be kept.
    pub method: Method,
    /// Settings that differ from the defaults of the robot, by their keys.
    pub settings: Vec<(String, f64)>,
    /// Between two times that the map is written, while it changes. Default 30 s.
    pub save_every: Duration,
    /// Whether the robot may go home by itself. Default no: it holds, whatever is lost.
    pub home: Option<HomeConfig>,
}

/// When the robot goes home by itself, and by which right.
#[derive(Clone, Debug, PartialEq)]
pub struct HomeConfig {
    /// Name of a driver's right that was given for this; taken away, the robot holds.
    pub right: Name,
    /// When, and how sure it must be.
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
    /// A method whose map cannot be kept.
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
    /// A method that draws no map.
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
    /// The system said no.
    #[error("map file {}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What it said.
        source: io::Error,
    },
    /// It holds no map, or a damaged one; it stays as it is.
    #[error("map file {}: {source}; it is left as it is", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What is wrong with it, and where.
        source: SlamlabError,
    },
    /// It holds another kind of thing.
    #[error("map file {}: {found}; a .slamlab file was expected, and this one is left as it is", path.display())]
    Foreign {
        /// The file.
        path: PathBuf,
        /// What it is.
        found: String,
    },
    /// Its map cannot be gone on in.
    #[error("map file {}: {source}; it is left as it is", path.display())]
    Restore {
        /// The file.
        path: PathBuf,
        /// Why not.
        source: SlamError,
    },
    /// Nobody gave the right by which the robot would go home.
    #[error(
        "failsafe right {right}: there is no right of that name that is good for driving; `slamlab-bridge token list` shows those that there are, `token add NAME --role driver` makes one"
    )]
    NoRight {
        /// Its name.
        right: Name,
    },
    /// Its geofence cannot be read, and the robot is not let go everywhere for that.
    #[error("geofence {}: {why}; mend it, or move it away to let the robot go everywhere", path.display())]
    Fence {
        /// The file.
        path: PathBuf,
        /// What is wrong with it, and where.
        why: String,
    },
    /// Two maps would take each other's place.
    #[error("map file {}: another bridge keeps its map there; end that one, or name another file", path.display())]
    Taken {
        /// The file.
        path: PathBuf,
    },
    /// It has a geofence, and not the map that that is drawn in.
    #[error("map file {}: there is none, and a geofence beside it; put the map there, or move the geofence away: in another map it means nothing", path.display())]
    FenceAlone {
        /// The file.
        path: PathBuf,
    },
    /// No thread could be had.
    #[error("mapping got no thread: {0}")]
    Thread(io::Error),
}

/// What others ask of the mapper.
#[derive(Debug)]
enum Asked {
    /// Begin anew; a file is moved aside.
    Reset,
    /// Keep this geofence beside the map.
    Fence(Vec<ZoneBody>),
    /// The map as it is now, as the bytes of a file.
    Pack(oneshot::Sender<Result<Vec<u8>, String>>),
}

/// Mapping that is ready to begin: everything that can be wrong with it was looked at.
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

/// A bridge's mapping under way.
#[derive(Debug)]
pub(crate) struct Mapping {
    shown: watch::Receiver<Shown>,
    asked: SyncSender<Asked>,
    thread: Mutex<Option<JoinHandle<()>>>,
    /// Maps whose description was handed out: their images are asked for next.
    described: Mutex<VecDeque<(u64, Arc<OccupancyMap>)>>,
    packed: serve::Packed,
    /// While it is open, no other bridge keeps a map in the same file.
    _lock: Option<File>,
}

/// Looks at settings and file.
///
/// # Errors    [`MapError`]; nothing was begun or written then.
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

/// A setting that has no effect is a slip, as it is on every command line.
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

    /// # Errors    [`MapError::NoRight`]: nobody may drive by the right by which the robot goes
    /// home.
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
    /// What was found; it changes with each scan.
    pub(crate) fn shown(&self) -> watch::Receiver<Shown> {
        self.shown.clone()
    }

    /// Has the map begin anew; whether the mapper will.
    pub(crate) fn reset(&self) -> bool {
        self.asked.try_send(Asked::Reset).is_ok()
    }

    /// Keeps a geofence beside the map; whether the mapper will see to it.
    pub(crate) fn keep_fence(&self, zones: Vec<ZoneBody>) -> bool {
        self.asked.try_send(Asked::Fence(zones)).is_ok()
    }

    /// Whether the mapper has ended by itself, which it never should.
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

//! Packs maps and writes the file, on a separate thread.
//!
//! In: snapshots of the map. Out: the file, or its bytes for a client that asked. At most one job
//! waits: a map that finds the keeper busy is written the next time.

use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use slamlab_core::estimation::SavedMap;
use slamlab_core::format::slamlab::{self, Experiment};
use slamlab_core::robot::Stamp;
use slamlab_core::slam::Method;
use slamlab_core::wire::message::ZoneBody;

use super::MapError;
use super::file::MapFile;

/// Interval between tries to write a geofence that could not be written.
const TRY_AGAIN: Duration = match cfg!(test) {
    true => Duration::from_millis(200),
    false => Duration::from_secs(5),
};

/// A job for the keeper.
enum Job {
    /// Write this map, made of this many scans.
    Save(SavedMap, u64),
    /// Keep these zones of a geofence.
    Fence(Vec<ZoneBody>),
    /// The map begins anew: keep the file under another name.
    MoveAside,
}

/// The state of the file.
#[derive(Clone, Debug, Default)]
pub(super) struct Kept {
    /// Number of scans of this run in the file.
    pub(super) scans: u64,
    /// Why the file is not up to date.
    pub(super) fault: Option<String>,
    /// Why the geofence would be lost after a restart.
    pub(super) fence_fault: Option<String>,
}

/// The keeper, as the mapper holds it.
#[derive(Debug)]
pub(super) struct Keeper {
    jobs: Option<SyncSender<Job>>,
    kept: Arc<Mutex<Kept>>,
    thread: Option<JoinHandle<()>>,
    /// Name of the file.
    pub(super) name: String,
    /// When scans of earlier runs were taken, to be written into the next file.
    pub(super) times: Vec<(Stamp, f64)>,
}

impl Keeper {
    /// Keeps maps in `file`; `times` are those already in it.
    ///
    /// # Errors    [`MapError::Thread`].
    pub(super) fn start(
        file: MapFile,
        settings: Vec<(String, f64)>,
        times: Vec<(Stamp, f64)>,
    ) -> Result<Self, MapError> {
        let (jobs, waiting) = sync_channel(1);
        let kept = Arc::default();
        let name = file.name();
        let shared = Arc::clone(&kept);
        let thread = std::thread::Builder::new()
            .name("keep-map".into())
            .spawn(move || run(&file, &settings, &waiting, &shared))
            .map_err(MapError::Thread)?;
        Ok(Self {
            jobs: Some(jobs),
            kept,
            thread: Some(thread),
            name,
            times,
        })
    }

    /// The state of the file.
    pub(super) fn kept(&self) -> Kept {
        lock(&self.kept).clone()
    }

    /// Writes a map made of `scans` scans; `false` if the keeper is busy with another.
    pub(super) fn save(&self, map: SavedMap, scans: u64) -> bool {
        let job = Job::Save(map, scans);
        (self.jobs.as_ref()).is_some_and(|jobs| jobs.try_send(job).is_ok())
    }

    /// Keeps a geofence. `map`, the map it was drawn in, is written first if the file is older.
    pub(super) fn fence(&self, map: Option<(SavedMap, u64)>, zones: Vec<ZoneBody>) {
        self.save_first(map);
        self.wait_for(Job::Fence(zones));
    }

    /// Moves the file aside, after writing the part of its map that is not in it yet.
    pub(super) fn move_aside(&mut self, map: Option<(SavedMap, u64)>) {
        self.save_first(map);
        self.times.clear();
        self.wait_for(Job::MoveAside);
    }

    /// Writes a last map, if there is one, and waits until everything is written.
    pub(super) fn finish(mut self, last: Option<(SavedMap, u64)>) -> Kept {
        self.save_first(last);
        self.jobs = None;
        if let Some(thread) = self.thread.take()
            && thread.join().is_err()
        {
            tracing::error!("the map's keeper panicked");
        }
        self.kept()
    }

    /// Writes a map, if there is one, before the next job.
    fn save_first(&self, map: Option<(SavedMap, u64)>) {
        if let Some((map, scans)) = map {
            self.wait_for(Job::Save(map, scans));
        }
    }

    /// Hands over a job that must not be left out: waits until the keeper takes it.
    fn wait_for(&self, job: Job) {
        if let Some(jobs) = &self.jobs
            && jobs.send(job).is_err()
        {
            tracing::error!("the map is kept no longer: its thread has ended");
        }
    }
}

fn lock(kept: &Mutex<Kept>) -> MutexGuard<'_, Kept> {
    kept.lock().unwrap_or_else(PoisonError::into_inner)
}

fn run(file: &MapFile, settings: &[(String, f64)], jobs: &Receiver<Job>, kept: &Mutex<Kept>) {
    // A geofence that is in force, but not yet written.
    let mut owed = None;
    loop {
        let job = match jobs.recv_timeout(TRY_AGAIN) {
            Ok(job) => job,
            Err(RecvTimeoutError::Timeout) => match owed.take() {
                Some(zones) => Job::Fence(zones),
                None => continue,
            },
            Err(RecvTimeoutError::Disconnected) => break,
        };
        match job {
            Job::Save(map, scans) => {
                let done = packed(file.title(), settings.to_vec(), map)
                    .and_then(|bytes| file.write(&bytes).map_err(|error| error.to_string()));
                let mut kept = lock(kept);
                match done {
                    Ok(()) => (kept.scans, kept.fault) = (scans, None),
                    Err(why) => {
                        let why = format!("{} is not written: {why}", file.path().display());
                        if kept.fault.as_ref() != Some(&why) {
                            tracing::error!("{why}");
                        }
                        kept.fault = Some(why);
                    }
                }
            }
            Job::Fence(zones) => {
                // Without its map it would mean nothing, and the bridge would refuse to start.
                let written = match zones.is_empty() || file.path().exists() {
                    true => file.write_fence(&zones).map_err(|error| error.to_string()),
                    false => Err("its map is not there yet".to_owned()),
                };
                let why = written.err().map(|error| {
                    format!(
                        "The geofence is in force, and would be gone after a restart: {} is not written: {error}",
                        file.fence().display()
                    )
                });
                owed = why.is_some().then_some(zones);
                lock(kept).fence_fault = why;
            }
            Job::MoveAside => {
                // The geofence goes with the map in which it was drawn.
                owed = None;
                let moved = file.move_aside();
                let mut kept = lock(kept);
                // A fault here means that the last part of the map was never written.
                let lost = std::mem::take(&mut *kept).fault;
                kept.fault = lost.map(|why| {
                    let why = format!("what was mapped last before it began anew is lost: {why}");
                    tracing::error!("{why}");
                    why
                });
                match moved {
                    Ok(Some(path)) => {
                        tracing::info!("the map before is in {} now", path.display());
                    }
                    Ok(None) => (),
                    Err(error) => {
                        let why =
                            format!("{} cannot be moved aside: {error}", file.path().display());
                        tracing::error!("{why}");
                        kept.fault = Some(why);
                    }
                }
            }
        }
    }
}

/// The bytes of a file.
pub(super) fn packed(
    title: String,
    settings: Vec<(String, f64)>,
    map: SavedMap,
) -> Result<Vec<u8>, String> {
    let experiment = Experiment {
        title,
        program: concat!("slamlab-bridge ", env!("CARGO_PKG_VERSION")).to_owned(),
        method: Method::ScanMatching.name().to_owned(),
        settings,
        map,
    };
    slamlab::write(&experiment).map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::time::Instant;

    use slamlab_core::wire::message::ZoneUse;

    use super::*;

    #[test]
    fn a_geofence_that_the_disk_did_not_take_is_written_once_it_does() {
        let folder = tempfile::TempDir::new().unwrap();
        let file = MapFile::new(folder.path().join("a.slamlab"));
        // No file can replace a folder that is not empty.
        let fence = file.fence();
        fs::create_dir_all(fence.join("in the way")).unwrap();
        let keeper = Keeper::start(file.clone(), vec![], vec![]).unwrap();
        let corners = vec![[0.0, 0.0], [4.0, 0.0], [4.0, 3.0]];
        let kind = ZoneUse::KeepIn;
        keeper.fence(None, vec![ZoneBody { kind, corners }]);
        let wait = |until: &dyn Fn(&Kept) -> bool| {
            let begun = Instant::now();
            while !until(&keeper.kept()) && begun.elapsed() < Duration::from_secs(20) {
                std::thread::sleep(Duration::from_millis(20));
            }
            keeper.kept()
        };
        let fault = wait(&|kept| kept.fence_fault.is_some()).fence_fault;
        let fault = fault.unwrap();
        assert!(fault.contains(fence.to_str().unwrap()), "{fault}");
        assert!(fault.contains("its map is not there yet"), "{fault}");
        fs::write(file.path(), "a map").unwrap();
        let by_system =
            |kept: &Kept| matches!(&kept.fence_fault, Some(why) if !why.contains("its map"));
        assert!(by_system(&wait(&by_system)), "{:?}", keeper.kept());
        fs::remove_dir_all(&fence).unwrap();
        assert_eq!(wait(&|kept| kept.fence_fault.is_none()).fence_fault, None);
        assert_eq!(file.read_fence().unwrap().len(), 1);
    }
}

//! The recorder's thread: takes waiting messages, writes them, acknowledges them.
//!
//! A piece that is long or old enough is finished, and the next begins with what its reader must
//! know: the bridge's hello, which names the robot, its devices, and the safety state. If a piece
//! cannot be written any more, a new one is tried now and then, because a full disk may get room
//! again.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use mcap::McapError;
use slamlab_core::wire::message::{FromBridge, RecordingBody};
use slamlab_core::wire::recording::{Recorded, Said};

use super::pieces::{Keep, Pieces};
use super::ros::{self, Topic};
use super::writer::Writer;

/// How often written messages are forced to the disk.
const FORCE: Duration = Duration::from_secs(1);
/// Interval between tries while the disk accepts no writes.
pub(super) const TRY_AGAIN: Duration = match cfg!(test) {
    true => Duration::from_millis(500),
    false => Duration::from_secs(5),
};
/// Most entries per write; they are acknowledged or lost together.
pub(super) const MOST_AT_ONCE: usize = 256;

/// The state of the recording; the hub reads it.
#[derive(Debug, Default)]
pub(super) struct Progress(Mutex<RecordingBody>);

impl Progress {
    pub(super) fn lock(&self) -> MutexGuard<'_, RecordingBody> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn acknowledge(&self, written: u64) {
        let mut body = self.lock();
        body.acknowledged += written;
        body.fault = None;
    }

    fn lose(&self, count: u64) {
        self.lock().lost += count;
    }

    /// Sets why nothing is being written, as a sentence for people: the hub logs it and tells all
    /// clients.
    fn fail(&self, why: String) {
        self.lock().fault = Some(why);
    }

    fn begin(&self, path: &Path) {
        let name = path.file_name().unwrap_or_default();
        self.lock().file = name.to_string_lossy().into();
    }
}

/// The state while a recording is written.
struct Recording<'a, P: Pieces> {
    pieces: P,
    keep: Keep,
    progress: &'a Progress,
    /// None while the disk accepts no writes.
    writer: Option<Writer<P::File>>,
    path: PathBuf,
    begun: Instant,
    /// A new piece is not tried before this.
    next_try: Instant,
    head: Head,
    odom: ros::Odom,
}

/// What the reader of a piece must know first: the newest message of each of these kinds.
#[derive(Default)]
struct Head {
    hello: Option<Recorded>,
    devices: Option<Recorded>,
    safety: Option<Recorded>,
}

impl Head {
    fn note(&mut self, entry: &Recorded) {
        let place = match &entry.said {
            Said::ByBridge(FromBridge::Hello(_)) => &mut self.hello,
            Said::ByBridge(FromBridge::Devices(_)) => &mut self.devices,
            Said::ByBridge(FromBridge::Safety(_)) => &mut self.safety,
            _ => return,
        };
        *place = Some(entry.clone());
    }

    /// These messages with the time of `first`, the first entry of a piece.
    fn at(&self, first: &Recorded) -> Vec<Recorded> {
        let all = [&self.hello, &self.devices, &self.safety];
        let known = all.into_iter().flatten();
        known
            .map(|entry| Recorded {
                nanos: first.nanos,
                header: first.header,
                said: entry.said.clone(),
            })
            .collect()
    }
}

/// Writes until nothing more can come: into `first`, at this path, then into further pieces.
pub(super) fn run<P: Pieces>(
    (first, path): (P::File, PathBuf),
    pieces: P,
    keep: Keep,
    waiting: &Receiver<Recorded>,
    progress: &Progress,
) {
    let now = Instant::now();
    let mut recording = Recording {
        pieces,
        keep,
        progress,
        writer: None,
        path,
        begun: now,
        next_try: now,
        head: Head::default(),
        odom: ros::Odom::default(),
    };
    recording.open(first);
    let mut forced = now;
    let mut batch = Vec::with_capacity(MOST_AT_ONCE);
    loop {
        let first = match waiting.recv_timeout(FORCE) {
            Ok(first) => Some(first),
            Err(RecvTimeoutError::Timeout) => None,
            Err(RecvTimeoutError::Disconnected) => break,
        };
        batch.clear();
        batch.extend(
            first
                .into_iter()
                .chain(waiting.try_iter())
                .take(MOST_AT_ONCE),
        );
        recording.write(&batch);
        if forced.elapsed() >= FORCE {
            forced = Instant::now();
            recording.force();
        }
    }
    recording.finish();
}

impl<P: Pieces> Recording<'_, P> {
    fn open(&mut self, file: P::File) {
        self.progress.begin(&self.path);
        self.begun = Instant::now();
        match Writer::new(file, Topic::HEARD, false) {
            Ok(mut writer) => {
                writer.odom = std::mem::take(&mut self.odom);
                self.writer = Some(writer);
            }
            Err(error) => self.failed(&error),
        }
    }

    fn write(&mut self, batch: &[Recorded]) {
        let Some(first) = batch.first() else { return };
        if self.is_due() {
            self.next_piece(first);
        }
        batch.iter().for_each(|entry| self.head.note(entry));
        let count = batch.len() as u64;
        match self.writer.as_mut().map(|writer| writer.write(batch)) {
            Some(Ok(())) => self.progress.acknowledge(count),
            Some(Err(error)) => {
                self.progress.lose(count);
                self.failed(&error);
            }
            None => self.progress.lose(count),
        }
    }

    /// Whether a new piece must begin.
    fn is_due(&self) -> bool {
        match &self.writer {
            Some(writer) => {
                writer.length() >= self.keep.piece_bytes
                    || self.begun.elapsed() >= self.keep.piece_age
            }
            None => Instant::now() >= self.next_try,
        }
    }

    /// Begins a new piece, if there may be one; `first` will be its first entry.
    fn next_piece(&mut self, first: &Recorded) {
        self.next_try = Instant::now() + TRY_AGAIN;
        self.pieces.make_room(&self.path);
        match self.pieces.next() {
            Ok(Some((file, path))) => {
                if let Some(writer) = self.writer.take() {
                    self.end(writer);
                }
                self.path = path;
                self.open(file);
                if self.writer.is_none() {
                    self.pieces.discard(&self.path);
                    return;
                }
                let head = self.head.at(first);
                if let Some(Err(error)) = self.writer.as_mut().map(|writer| writer.write(&head)) {
                    self.failed(&error);
                }
            }
            // The only piece goes on, whatever its length.
            Ok(None) => (),
            Err(error) if self.writer.is_none() => self.progress.fail(error.to_string()),
            // A piece that is too long is better than none.
            Err(error) => {
                tracing::warn!("the next piece of the recording cannot begin: {error}");
                self.begun = Instant::now();
            }
        }
    }

    fn force(&mut self) {
        self.pieces.make_room(&self.path);
        if let Some(Err(error)) = self.writer.as_ref().map(Writer::force) {
            self.failed(&error);
        }
    }

    fn failed(&mut self, error: &McapError) {
        if let Some(writer) = self.writer.take() {
            self.odom = writer.odom;
        }
        self.next_try = Instant::now() + TRY_AGAIN;
        self.progress.fail(words(error, &self.path));
    }

    fn end(&mut self, writer: Writer<P::File>) {
        match writer.finish() {
            Ok(odom) => self.odom = odom,
            Err(error) => self.progress.fail(words(&error, &self.path)),
        }
    }

    fn finish(mut self) {
        if let Some(writer) = self.writer.take() {
            self.end(writer);
        }
    }
}

/// The error as a sentence for people.
fn words(error: &McapError, path: &Path) -> String {
    let path = path.display();
    match error {
        McapError::Io(error) if is_full(error) => {
            format!("the disk is full: nothing more is recorded to {path}; make room")
        }
        error => format!("nothing more is recorded to {path}: {error}"),
    }
}

/// Whether the disk is full, or a quota or a limit of the file's size is reached.
pub(crate) fn is_full(error: &io::Error) -> bool {
    use io::ErrorKind::{FileTooLarge, QuotaExceeded, StorageFull};
    matches!(error.kind(), StorageFull | QuotaExceeded | FileTooLarge)
}

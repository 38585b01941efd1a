//! The recorder's thread: takes what waits, writes it, acknowledges it.
//!
//! A piece that is long or old enough is finished, and the next begins with what its reader must
//! know: the bridge's hello, which names the robot, its devices, and the state of safety. Where a
//! piece takes no more, another is tried now and then: room on a disk comes back.

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use mcap::records::MessageHeader;
use mcap::{McapError, WriteOptions};
use slamlab_core::wire::message::{
    Format, FromBridge, Header, PROTOCOL, RecordingBody, SCHEMA, encode,
};
use slamlab_core::wire::recording::{CHANNEL, ENCODING, Recorded, Said};

use super::journal::{Journal, Storage};
use super::pieces::{Keep, Pieces};
use super::ros::{self, Messages, Topic};

/// How often what was written is forced to the disk.
const FORCE: Duration = Duration::from_secs(1);
/// Between two tries to go on, where the disk takes nothing.
pub(super) const TRY_AGAIN: Duration = match cfg!(test) {
    true => Duration::from_millis(500),
    false => Duration::from_secs(5),
};
/// Entries that are written at once, and acknowledged or lost together.
pub(super) const MOST_AT_ONCE: usize = 256;

/// How the recording goes; the hub reads it.
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

    /// Why nothing more is written, in words for a person; logged once.
    fn fail(&self, why: String) {
        let mut body = self.lock();
        if body.fault.as_ref() != Some(&why) {
            tracing::error!("{why}");
            body.fault = Some(why);
        }
    }

    fn begin(&self, path: &Path) {
        let name = path.file_name().unwrap_or_default();
        self.lock().file = name.to_string_lossy().into();
    }
}

/// What goes on while a recording is written.
struct Recording<'a, P: Pieces> {
    pieces: P,
    keep: Keep,
    progress: &'a Progress,
    /// None while the disk takes nothing.
    writer: Option<Writer<P::File>>,
    path: PathBuf,
    begun: Instant,
    /// Not tried again before.
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

    /// As at the beginning of a piece that begins with `first`.
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

/// Writes until nothing more can come: into `first`, at this path, and into further pieces.
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

    /// Whether another piece is to begin.
    fn is_due(&self) -> bool {
        match &self.writer {
            Some(writer) => {
                writer.journal.length() >= self.keep.piece_bytes
                    || self.begun.elapsed() >= self.keep.piece_age
            }
            None => Instant::now() >= self.next_try,
        }
    }

    /// Begins another piece, if there may be one, whose first entry is to be `first`.
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
            // The only piece goes on for as long as it takes.
            Ok(None) => (),
            Err(error) if self.writer.is_none() => self.progress.fail(error.to_string()),
            // Better too long a piece than none.
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

/// What a person reads of it.
fn words(error: &McapError, path: &Path) -> String {
    let path = path.display();
    match error {
        McapError::Io(error) if is_full(error) => {
            format!("the disk is full: nothing more is recorded to {path}; make room")
        }
        error => format!("nothing more is recorded to {path}: {error}"),
    }
}

/// Also where a quota or a limit of the file's size is reached.
fn is_full(error: &io::Error) -> bool {
    use io::ErrorKind::{FileTooLarge, QuotaExceeded, StorageFull};
    matches!(error.kind(), StorageFull | QuotaExceeded | FileTooLarge)
}

/// The file and its channels.
pub(super) struct Writer<S: Storage> {
    journal: Journal<S>,
    mcap: mcap::Writer<Journal<S>>,
    slamlab: u16,
    topics: BTreeMap<Topic, u16>,
    sequence: u32,
    odom: ros::Odom,
}

impl<S: Storage> Writer<S> {
    /// Writes the beginning of a file that holds these topics beside every message as it is.
    ///
    /// Readers can jump between chunks, and some read nothing else (Rerun); but a chunk under way
    /// is lost with the program.
    pub(super) fn new(storage: S, topics: &[Topic], in_chunks: bool) -> Result<Self, McapError> {
        let journal = Journal::new(storage);
        let options = WriteOptions::new()
            .use_chunks(in_chunks)
            // What was written stays: the file only grows.
            .disable_seeking(in_chunks)
            .compression(None)
            .profile("ros2")
            .library(concat!("slamlab ", env!("CARGO_PKG_VERSION")));
        let mut mcap = options.create(journal.clone())?;
        let facts = [
            ("protocol".to_owned(), PROTOCOL.to_string()),
            ("schema".to_owned(), format!("{SCHEMA:016x}")),
        ];
        let slamlab = mcap.add_channel(0, CHANNEL, ENCODING, &BTreeMap::from(facts))?;
        let mut channels = BTreeMap::new();
        for &topic in topics {
            let schema =
                mcap.add_schema(topic.schema(), "ros2msg", topic.definition().as_bytes())?;
            let channel = mcap.add_channel(schema, topic.name(), "cdr", &BTreeMap::new())?;
            channels.insert(topic, channel);
        }
        journal.commit()?;
        Ok(Self {
            journal,
            mcap,
            slamlab,
            topics: channels,
            sequence: 0,
            odom: ros::Odom::default(),
        })
    }

    /// Writes all entries, or none.
    pub(super) fn write(&mut self, entries: &[Recorded]) -> Result<(), McapError> {
        for entry in entries {
            self.entry(entry)?;
        }
        Ok(self.journal.commit()?)
    }

    fn entry(&mut self, entry: &Recorded) -> Result<(), McapError> {
        self.sequence = self.sequence.wrapping_add(1);
        let header = Header {
            sequence: self.sequence,
            ..entry.header
        };
        let time = Duration::from_nanos(entry.nanos);
        let (bytes, ros) = match &entry.said {
            Said::ByBridge(message) => (
                encode(header, message, Format::Binary),
                ros::messages_of(&mut self.odom, message, time),
            ),
            Said::ToRobot(message) => (
                encode(header, message, Format::Binary),
                ros::ordered(message),
            ),
        };
        let bytes = bytes.map_err(io::Error::other)?;
        self.put(self.slamlab, time, &bytes)?;
        self.made(&ros, time)
    }

    /// Adds messages of topics; not written before the next [`Self::write`].
    pub(super) fn made(&mut self, messages: &Messages, time: Duration) -> Result<(), McapError> {
        for (topic, bytes) in messages {
            if let Some(&channel) = self.topics.get(topic) {
                self.put(channel, time, bytes)?;
            }
        }
        Ok(())
    }

    fn put(&mut self, channel_id: u16, time: Duration, bytes: &[u8]) -> Result<(), McapError> {
        let nanos = time.as_nanos() as u64;
        let header = MessageHeader {
            channel_id,
            sequence: self.sequence,
            log_time: nanos,
            publish_time: nanos,
        };
        self.mcap.write_to_known_channel(&header, bytes)
    }

    fn force(&self) -> Result<(), McapError> {
        Ok(self.journal.force()?)
    }

    /// Adds the summary; the odometry so far.
    pub(super) fn finish(mut self) -> Result<ros::Odom, McapError> {
        self.mcap.finish()?;
        self.journal.commit()?;
        self.journal.force()?;
        Ok(self.odom)
    }
}

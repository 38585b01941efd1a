//! The recorder's thread: takes what waits, writes it, acknowledges it.

use std::collections::BTreeMap;
use std::io;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use mcap::records::MessageHeader;
use mcap::{McapError, WriteOptions};
use slamlab_core::wire::message::{Format, Header, PROTOCOL, SCHEMA, encode};
use slamlab_core::wire::recording::{CHANNEL, ENCODING, Said};

use super::journal::{Journal, Storage};
use super::ros::{self, Messages, Topic};

/// How often what was written is forced to the disk.
const FORCE: Duration = Duration::from_secs(1);
/// Entries that are written at once, and acknowledged or lost together.
pub(super) const MOST_AT_ONCE: usize = 256;

/// What waits to be written.
#[derive(Debug)]
pub(super) struct Entry {
    pub(super) said: Said,
    /// Since the bridge started.
    pub(super) at: Duration,
    /// Since 1970.
    pub(super) time_of_day: Duration,
}

/// How far the thread has come; the hub reads it.
#[derive(Debug, Default)]
pub(super) struct Progress {
    acknowledged: AtomicU64,
    lost: AtomicU64,
    fault: Mutex<Option<String>>,
}

impl Progress {
    pub(super) fn acknowledged(&self) -> u64 {
        self.acknowledged.load(Ordering::Acquire)
    }

    pub(super) fn lost(&self) -> u64 {
        self.lost.load(Ordering::Relaxed)
    }

    pub(super) fn fault(&self) -> Option<String> {
        let fault = self.fault.lock();
        fault.unwrap_or_else(PoisonError::into_inner).clone()
    }

    fn take(&self, written: u64, result: Result<(), McapError>) {
        match result {
            Ok(()) => _ = self.acknowledged.fetch_add(written, Ordering::Release),
            Err(error) => {
                self.lost.fetch_add(written, Ordering::Relaxed);
                let mut fault = self.fault.lock().unwrap_or_else(PoisonError::into_inner);
                if fault.is_none() {
                    tracing::error!("the recording has ended: {error}");
                    *fault = Some(error.to_string());
                }
            }
        }
    }
}

/// Writes until nothing more can come.
pub(super) fn run<S: Storage>(
    writer: impl FnOnce() -> Result<Writer<S>, McapError>,
    waiting: &Receiver<Entry>,
    progress: &Progress,
) {
    let mut writer = match writer() {
        Ok(writer) => writer,
        Err(error) => return progress.take(0, Err(error)),
    };
    let mut forced = Instant::now();
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
        progress.take(batch.len() as u64, writer.write(&batch));
        if forced.elapsed() >= FORCE {
            forced = Instant::now();
            progress.take(0, writer.force());
        }
    }
    progress.take(0, writer.finish());
}

/// How a file is written.
#[derive(Debug)]
pub(super) struct Layout {
    /// What it holds beside every message as it is.
    pub(super) topics: &'static [Topic],
    /// In chunks, which readers can jump between, and some read nothing else (Rerun). A chunk under
    /// way is lost with the program.
    pub(super) in_chunks: bool,
}

/// Of a recording under way.
pub(super) const LIVE: Layout = Layout {
    topics: &Topic::HEARD,
    in_chunks: false,
};

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
    /// Writes the beginning of the file.
    pub(super) fn new(storage: S, layout: &Layout) -> Result<Self, McapError> {
        let journal = Journal::new(storage);
        let options = WriteOptions::new()
            .use_chunks(layout.in_chunks)
            // What was written stays: the file only grows.
            .disable_seeking(layout.in_chunks)
            .compression(None)
            .profile("ros2")
            .library(concat!("slamlab ", env!("CARGO_PKG_VERSION")));
        let mut mcap = options.create(journal.clone())?;
        let facts = [
            ("protocol".to_owned(), PROTOCOL.to_string()),
            ("schema".to_owned(), format!("{SCHEMA:016x}")),
        ];
        let slamlab = mcap.add_channel(0, CHANNEL, ENCODING, &BTreeMap::from(facts))?;
        let mut topics = BTreeMap::new();
        for &topic in layout.topics {
            let schema =
                mcap.add_schema(topic.schema(), "ros2msg", topic.definition().as_bytes())?;
            let channel = mcap.add_channel(schema, topic.name(), "cdr", &BTreeMap::new())?;
            topics.insert(topic, channel);
        }
        journal.commit()?;
        Ok(Self {
            journal,
            mcap,
            slamlab,
            topics,
            sequence: 0,
            odom: ros::Odom::default(),
        })
    }

    /// Writes all entries, or none.
    pub(super) fn write(&mut self, entries: &[Entry]) -> Result<(), McapError> {
        for entry in entries {
            self.entry(entry)?;
        }
        Ok(self.journal.commit()?)
    }

    fn entry(&mut self, entry: &Entry) -> Result<(), McapError> {
        self.sequence = self.sequence.wrapping_add(1);
        let header = Header {
            sequence: self.sequence,
            micros: entry.at.as_micros() as u64,
        };
        let (bytes, ros) = match &entry.said {
            Said::ByBridge(message) => (
                encode(header, message, Format::Binary),
                ros::messages_of(&mut self.odom, message, entry.time_of_day),
            ),
            Said::ToRobot(message) => (
                encode(header, message, Format::Binary),
                ros::ordered(message),
            ),
        };
        let bytes = bytes.map_err(io::Error::other)?;
        self.put(self.slamlab, entry.time_of_day, &bytes)?;
        self.made(&ros, entry.time_of_day)
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

    pub(super) fn finish(mut self) -> Result<(), McapError> {
        self.mcap.finish()?;
        self.journal.commit()?;
        Ok(self.journal.force()?)
    }
}

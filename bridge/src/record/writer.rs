//! Writes entries of a recording as MCAP: each message as it crossed the wire, followed by the same
//! content for other tools.

use std::collections::BTreeMap;
use std::io;
use std::time::Duration;

use mcap::records::MessageHeader;
use mcap::{McapError, WriteOptions};
use slamlab_core::wire::message::{Format, Header, PROTOCOL, SCHEMA, encode};
use slamlab_core::wire::recording::{CHANNEL, ENCODING, Recorded, Said};

use super::journal::{Journal, Storage};
use super::ros::{self, Messages, Topic};

/// The file and its channels.
pub(super) struct Writer<S: Storage> {
    journal: Journal<S>,
    mcap: mcap::Writer<Journal<S>>,
    slamlab: u16,
    topics: BTreeMap<Topic, u16>,
    sequence: u32,
    /// The accumulated odometry; it goes on from piece to piece.
    pub(super) odom: ros::Odom,
}

impl<S: Storage> Writer<S> {
    /// Writes the beginning of a file with these topics, in addition to every message as it is.
    ///
    /// Readers can seek between chunks, and some require chunks (Rerun); but an unfinished chunk is
    /// lost if the program dies.
    pub(super) fn new(storage: S, topics: &[Topic], in_chunks: bool) -> Result<Self, McapError> {
        let journal = Journal::new(storage);
        let options = WriteOptions::new()
            .use_chunks(in_chunks)
            // Never seek back: the file only grows.
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

    /// Bytes in the file.
    pub(super) fn length(&self) -> u64 {
        self.journal.length()
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

    /// Adds ROS messages; they are written with the next [`Self::write`].
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

    pub(super) fn force(&self) -> Result<(), McapError> {
        Ok(self.journal.force()?)
    }

    /// Adds the summary, and returns the accumulated odometry.
    pub(super) fn finish(mut self) -> Result<ros::Odom, McapError> {
        self.mcap.finish()?;
        self.journal.commit()?;
        self.journal.force()?;
        Ok(self.odom)
    }
}

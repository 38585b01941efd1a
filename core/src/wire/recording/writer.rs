//! A recording of messages that did not come from a bridge: for instance of another program's log,
//! converted to messages.

use std::collections::BTreeMap;
use std::io::Cursor;

use mcap::records::MessageHeader;
use mcap::{McapError, WriteOptions};

use super::super::message::{Format, FromBridge, Header, MessageError, SCHEMA, encode};
use super::{CHANNEL, ENCODING, Recording, SCHEMA_KEY};

impl Recording {
    /// Makes a recording of messages in order, each with its time, µs.
    ///
    /// # Errors    [`MessageError`] for a message that is longer than allowed.
    pub fn of_messages(
        messages: impl IntoIterator<Item = (u64, FromBridge)>,
    ) -> Result<Self, MessageError> {
        let mut recording = Self::default();
        for (index, (micros, message)) in messages.into_iter().enumerate() {
            let header = Header {
                sequence: index as u32 + 1,
                micros,
            };
            let bytes = encode(header, &message, Format::Binary)?;
            let offset = recording.bytes.len() as u64;
            recording.keep(&bytes, offset, micros.saturating_mul(1000));
        }
        Ok(recording)
    }

    /// The file as the bridge writes it, without chunks; [`super::RecordingReader`] reads it back.
    ///
    /// # Errors    None that a recording can cause: writing to memory does not fail.
    pub fn write(&self) -> Result<Vec<u8>, McapError> {
        let mut file = Cursor::new(vec![]);
        let options = WriteOptions::new().use_chunks(false).compression(None);
        let mut writer = options.create(&mut file)?;
        let facts = BTreeMap::from([(SCHEMA_KEY.to_owned(), format!("{SCHEMA:016x}"))]);
        let channel_id = writer.add_channel(0, CHANNEL, ENCODING, &facts)?;
        for (index, span) in self.spans.iter().enumerate() {
            let header = MessageHeader {
                channel_id,
                sequence: index as u32 + 1,
                log_time: span.nanos,
                publish_time: span.nanos,
            };
            let bytes = self.bytes.get(span.start..span.end).unwrap_or(&[]);
            writer.write_to_known_channel(&header, bytes)?;
        }
        writer.finish()?;
        drop(writer);
        Ok(file.into_inner())
    }
}

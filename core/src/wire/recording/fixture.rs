//! Recordings for tests, written by the format's own writer.

use std::collections::BTreeMap;
use std::io::Cursor;

use mcap::WriteOptions;
use mcap::records::MessageHeader;

use super::super::message::{Format, FromBridge, Header, encode};
use super::{CHANNEL, ENCODING};

/// An unchunked file, as the bridge writes it, with a message of a foreign channel beside each of
/// ours; times are µs of the bridge.
pub(crate) fn write(messages: &[(u64, FromBridge)]) -> Vec<u8> {
    write_with(WriteOptions::new().use_chunks(false), messages)
}

pub(crate) fn write_with(options: WriteOptions, messages: &[(u64, FromBridge)]) -> Vec<u8> {
    let mut bytes = Cursor::new(vec![]);
    let mut writer = options.compression(None).create(&mut bytes).unwrap();
    let facts = BTreeMap::new();
    let foreign = writer.add_channel(0, "/odom", "cdr", &facts).unwrap();
    let ours = writer.add_channel(0, CHANNEL, ENCODING, &facts).unwrap();
    for (index, (micros, message)) in messages.iter().enumerate() {
        let sequence = index as u32 + 1;
        let header = Header {
            sequence,
            micros: *micros,
        };
        let body = encode(header, message, Format::Binary).unwrap();
        for (channel_id, body) in [(ours, body.as_slice()), (foreign, b"\0\x01\0\0nothing")] {
            let log_time = 1_700_000_000_000_000_000 + micros * 1000;
            let header = MessageHeader {
                channel_id,
                sequence,
                log_time,
                publish_time: log_time,
            };
            writer.write_to_known_channel(&header, body).unwrap();
        }
    }
    writer.finish().unwrap();
    drop(writer);
    bytes.into_inner()
}

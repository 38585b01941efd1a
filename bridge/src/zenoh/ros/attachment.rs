//! What `rmw_zenoh` attaches to each message: number, time, and the endpoint that sent it.
//!
//! # Source    github.com/ros2/rmw_zenoh, attachment_helpers.cpp (Jazzy to Rolling), and Zenoh's
//! serialisation format: numbers little-endian, then the length of the last part and the part
//! itself.

use std::time::Duration;

use super::names::{GID_BYTES, Gid};

const BYTES: usize = 8 + 8 + 1 + GID_BYTES;

/// An attachment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Attachment {
    /// Counts the messages of the endpoint.
    pub(super) sequence: i64,
    /// When it was sent, ns since 1970 by the sender's clock.
    pub(super) nanos: i64,
    pub(super) gid: Gid,
}

impl Attachment {
    pub(super) fn new(sequence: i64, now: Duration, gid: Gid) -> Self {
        let nanos = now.as_nanos() as i64;
        Self {
            sequence,
            nanos,
            gid,
        }
    }

    pub(super) fn to_bytes(self) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(BYTES);
        bytes.extend(self.sequence.to_le_bytes());
        bytes.extend(self.nanos.to_le_bytes());
        bytes.push(GID_BYTES as u8);
        bytes.extend(self.gid);
        bytes
    }

    /// Reads an attachment; none if the bytes are not one.
    pub(super) fn read(bytes: &[u8]) -> Option<Self> {
        let (sequence, rest) = bytes.split_first_chunk()?;
        let (nanos, rest) = rest.split_first_chunk()?;
        let (length, gid) = rest.split_first()?;
        let gid = gid.try_into().ok()?;
        (usize::from(*length) == GID_BYTES).then(|| Self {
            sequence: i64::from_le_bytes(*sequence),
            nanos: i64::from_le_bytes(*nanos),
            gid,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_are_those_of_the_format() {
        let attachment = Attachment::new(0x0102, Duration::from_nanos(0x0304), [9; 16]);
        let bytes = attachment.to_bytes();
        let mut expect = vec![2, 1, 0, 0, 0, 0, 0, 0, 4, 3, 0, 0, 0, 0, 0, 0, 16];
        expect.extend([9; 16]);
        assert_eq!(bytes, expect);
        assert_eq!(Attachment::read(&bytes), Some(attachment));
        for cut in 0..bytes.len() {
            assert_eq!(Attachment::read(&bytes[..cut]), None);
        }
        assert_eq!(Attachment::read(&[bytes, vec![0]].concat()), None);
    }
}

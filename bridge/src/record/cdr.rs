//! CDR, the encoding of ROS 2 messages: values one after the other, each aligned to its own size,
//! little-endian.
//!
//! Source: OMG, DDSI-RTPS 2.5, §10 (encapsulation), and CORBA 3.4 part 2, §9.3 (CDR).

use std::time::Duration;

/// Collects the bytes of one message.
#[derive(Debug)]
pub(crate) struct Cdr {
    bytes: Vec<u8>,
}

/// Encapsulation: CDR, little-endian, no options. Alignment counts from its end.
const HEAD: [u8; 4] = [0, 1, 0, 0];

impl Cdr {
    pub(crate) fn new() -> Self {
        Self {
            bytes: HEAD.to_vec(),
        }
    }

    pub(crate) fn u8(&mut self, value: u8) -> &mut Self {
        self.put([value])
    }

    /// Bytes that need no alignment of their own.
    pub(crate) fn bytes(&mut self, bytes: &[u8]) -> &mut Self {
        self.bytes.extend_from_slice(bytes);
        self
    }

    pub(crate) fn u32(&mut self, value: u32) -> &mut Self {
        self.put(value.to_le_bytes())
    }

    pub(crate) fn i32(&mut self, value: i32) -> &mut Self {
        self.put(value.to_le_bytes())
    }

    pub(crate) fn f32(&mut self, value: f32) -> &mut Self {
        self.put(value.to_le_bytes())
    }

    pub(crate) fn f64(&mut self, value: f64) -> &mut Self {
        self.put(value.to_le_bytes())
    }

    pub(crate) fn all(&mut self, values: &[f64]) -> &mut Self {
        for &value in values {
            self.f64(value);
        }
        self
    }

    /// Length with the closing zero, bytes, zero.
    pub(crate) fn text(&mut self, text: &str) -> &mut Self {
        self.u32(text.len() as u32 + 1);
        self.bytes.extend(text.as_bytes());
        self.bytes.push(0);
        self
    }

    /// `std_msgs/Header`.
    pub(crate) fn header(&mut self, stamp: Duration, frame: &str) -> &mut Self {
        self.time(stamp).text(frame)
    }

    /// `builtin_interfaces/Time`.
    pub(crate) fn time(&mut self, time: Duration) -> &mut Self {
        self.i32(time.as_secs() as i32).u32(time.subsec_nanos())
    }

    pub(crate) fn finish(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.bytes)
    }

    fn put<const N: usize>(&mut self, value: [u8; N]) -> &mut Self {
        let length = self.bytes.len() - HEAD.len();
        self.bytes
            .resize(self.bytes.len() + length.next_multiple_of(N) - length, 0);
        self.bytes.extend(value);
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_aligned_to_their_size_behind_the_head() {
        let bytes = Cdr::new().text("ab").f64(1.0).u32(7).f32(1.0).finish();
        #[rustfmt::skip]
        let expect = [
            0, 1, 0, 0,
            3, 0, 0, 0, b'a', b'b', 0, 0, // three bytes of text, one of padding
            0, 0, 0, 0, 0, 0, 0xF0, 0x3F, // 1.0, at 8
            7, 0, 0, 0,
            0, 0, 0x80, 0x3F,
        ];
        assert_eq!(bytes, expect);
    }
}

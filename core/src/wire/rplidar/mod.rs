//! SLAMTEC RPLIDAR A1 and relatives: 115200 baud, 8N1, little-endian.
//!
//! In: bytes from the sensor, in pieces of any size. Out: answers and readings; requests go the
//! other way. The same types encode what the sensor sends, for simulated devices.
//!
//! Request: `A5 command`, with a payload `A5 command length payload xor` (xor of all before it).
//! Descriptor of an answer: `A5 5A | u32: length of a packet (30 bits), mode (2 bits: 0 one packet,
//! 1 endless) | type`.
//!
//! | command | | answer |
//! |---|---|---|
//! | `20` | scan | `A5 5A 05 00 00 40 81`, then endless nodes of 5 bytes |
//! | `25` | stop | none; at least 1 ms must pass |
//! | `40` | reset | none; 2 ms, then a banner in ASCII |
//! | `50` | information | `A5 5A 14 00 00 00 04`, 20 bytes: model, firmware minor, major, hardware, serial number\[16\] |
//! | `52` | health | `A5 5A 03 00 00 00 06`, 3 bytes: status 0 good, 1 warning, 2 error; error u16 |
//! | `59` | rate | `A5 5A 04 00 00 00 15`, 4 bytes: µs a reading, standard u16, express u16 |
//! | `82` | express scan, payload `00 00 00 00 00` | `A5 5A 54 00 00 40 82`, then endless capsules of 84 bytes |
//! | `84` | configuration, payload: see [`configuration`] | `A5 5A length 00 00 00 20`, kind and value |
//!
//! The A1's board switches the motor by DTR.
//!
//! | node | bits | |
//! |---|---|---|
//! | 0 | 7..2 quality, 1 not S, 0 S | S: first of a turn |
//! | 1, 2 | 15..1 angle, 0 check bit, always 1 | 1/64°, clockwise from ahead |
//! | 3, 4 | distance u16 | 1/4 mm; 0 invalid |
//!
//! | capsule | bits | |
//! |---|---|---|
//! | 0, 1 | `A` and low nibble, `5` and high nibble of the xor of bytes 2..84 | |
//! | 2, 3 | 15 first capsule of a scan, 14..0 start angle | 1/64° |
//! | 4 + 5i | u16: 15..2 distance 1, 1..0 bits 5..4 of offset 1 | 1/4 mm, the two low bits taken as 0 |
//! | 6 + 5i | the same for reading 2 | |
//! | 8 + 5i | 3..0 low bits of offset 1, 7..4 of offset 2 | 1/8° |
//!
//! Reading k of the 32 in a capsule lies at start + k Δ/32 - offset, with Δ from this capsule's
//! start angle to the next one's.
//!
//! Source: SLAMTEC, "RPLIDAR interface protocol and application notes", rev. 1.1 (2018); Pilch 2016
//! §2.1. The protocol calls the top bit of an offset a sign; the maker's own driver, and so this
//! one, reads six bits without sign.

pub mod answer;
pub mod configuration;
pub mod decoder;
pub mod express;
pub mod node;
pub mod request;

/// Begins every request and every descriptor.
pub(crate) const SYNC: u8 = 0xA5;
/// Follows [`SYNC`] in a descriptor.
pub(crate) const SYNC_OF_ANSWER: u8 = 0x5A;

#[cfg(test)]
mod tests;

//! How long a count takes out of the robot: from the edge at an encoder's pin until the telemetry
//! that tells of it has left the chip.
//!
//! In: the true counts after each slice, the bytes the chip sends. Out: both instants, of the
//! computer's clock, which other programs share.

use std::time::SystemTime;

use slamlab_core::wire::rp6::{Decoder, Report};

/// Waits for one edge of a robot that stands.
#[derive(Default)]
pub struct EdgeWatch {
    /// True counts when it was set, while it waits for another.
    counts: Option<[i64; 2]>,
    /// As last reported before the edge.
    reported_before: Option<[i32; 2]>,
    decoder: Decoder<Report>,
    edge: Option<SystemTime>,
    reported: Option<SystemTime>,
}

impl EdgeWatch {
    /// From now on, with these counts.
    pub fn set(&mut self, counts: [i64; 2]) {
        self.counts = Some(counts);
        (self.edge, self.reported) = (None, None);
    }

    /// A slice has passed.
    pub fn saw(&mut self, counts: [i64; 2]) {
        if self.counts.is_some_and(|before| before != counts) {
            self.counts = None;
            self.edge = Some(SystemTime::now());
        }
    }

    /// These bytes are on the line to their last bit.
    pub fn sent(&mut self, bytes: &[u8]) {
        for frame in self.decoder.push(bytes) {
            let Report::Telemetry(telemetry) = frame.message else {
                continue;
            };
            if self.edge.is_none() {
                self.reported_before = Some(telemetry.counts);
            } else if self.reported.is_none() && self.reported_before != Some(telemetry.counts) {
                self.reported = Some(SystemTime::now());
            }
        }
    }

    /// When the edge was, and when it was reported; s since 1970.
    #[must_use]
    pub fn instants(&self) -> [Option<f64>; 2] {
        let seconds = |time: SystemTime| {
            let since = time.duration_since(SystemTime::UNIX_EPOCH);
            since.ok().map(|since| since.as_secs_f64())
        };
        [self.edge, self.reported].map(|time| time.and_then(seconds))
    }
}

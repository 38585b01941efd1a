//! Maps a device's clock to the host's time line, so that messages of different devices can be put
//! in order.
//!
//! In: the device's time in each message, and when the message arrived. Out: the device's times on
//! the host's clock.
//!
//! 1. The delay of a message is never negative. So the minimum of (came - said) over a while is the
//!    offset of the clocks plus the minimum delay (Cristian 1989; the lower bound that NTP's clock
//!    filter takes).
//! 2. Two windows of 10 s are kept, the current one and the last: quartzes drift apart by some 100
//!    µs in a second, so an old minimum soon becomes worthless.
//! 3. The offset in use follows that minimum by at most 5 % of the elapsed time. So stamps never go
//!    back, and a motion between two of them keeps its duration to within that part.
//!
//! The known part of the minimum delay (a frame's own time on a slow line) is subtracted.

use std::collections::VecDeque;

use crate::robot::Stamp;

/// Length of a window, s.
const WINDOW: f64 = 10.0;
/// Greatest change of the offset, as a part of the elapsed time.
const SLEW: f64 = 0.05;

/// Maps the stamps of one device to the host's time line.
#[derive(Clone, Debug, Default)]
pub struct ClockMap {
    known_delay: f64,
    /// Minimum offset of each window and the window's start by the device's clock, s; the newest at
    /// the back.
    windows: VecDeque<(f64, f64)>,
    /// Offset in use, and the device's time at which it was set, s.
    used: Option<(f64, f64)>,
}

impl ClockMap {
    /// A map without observations. `known_delay`: seconds that every message takes at least.
    #[must_use]
    pub fn new(known_delay: f64) -> Self {
        Self {
            known_delay,
            ..Self::default()
        }
    }

    /// A message that the device stamped `said` arrived at `came` by the host's clock.
    ///
    /// `said` must not decrease: a device that restarted needs a new map.
    pub fn observe(&mut self, said: Stamp, came: Stamp) {
        let (said, came) = (said.seconds(), came.seconds());
        let offset = came - said - self.known_delay;
        match self.windows.back_mut() {
            Some((start, least)) if said - *start < WINDOW => *least = least.min(offset),
            _ => self.windows.push_back((said, offset)),
        }
        if self.windows.len() > 2 {
            self.windows.pop_front();
        }
        let least = self.windows.iter().map(|(_, least)| *least);
        let target = least.fold(f64::INFINITY, f64::min);
        self.used = Some(match self.used {
            None => (target, said),
            Some((used, then)) => {
                let most = SLEW * (said - then).max(0.0);
                (used + (target - used).clamp(-most, most), said)
            }
        });
    }

    /// The device's time `said` on the host's clock; `None` before anything was observed.
    #[must_use]
    pub fn host_time(&self, said: Stamp) -> Option<Stamp> {
        self.offset()
            .map(|offset| Stamp::from_seconds(said.seconds() + offset))
    }

    /// What is added to the device's time, s; `None` before anything was observed.
    #[must_use]
    pub fn offset(&self) -> Option<f64> {
        self.used.map(|(offset, _)| offset)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// Telemetry at 50 Hz from a device that started 100 s after the host, whose clock is fast by
    /// `drift`, over a line that takes `least` seconds and up to `jitter` more. Returns the error
    /// of each mapped stamp, s, and how much it advanced.
    fn run(drift: f64, least: f64, jitter: f64, seconds: u32) -> Vec<(f64, f64)> {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let mut map = ClockMap::new(least);
        let mut last = None;
        let mut out = vec![];
        for k in 0..50 * seconds {
            let truth = 100.0 + 0.02 * f64::from(k);
            let said = Stamp::from_seconds((truth - 100.0) * (1.0 + drift));
            let delay = least + jitter * rng.random::<f64>();
            map.observe(said, Stamp::from_seconds(truth + delay));
            let mapped = map.host_time(said).unwrap().seconds();
            let step = last.map_or(0.02, |last: f64| mapped - last);
            out.push((mapped - truth, step));
            last = Some(mapped);
        }
        out
    }

    #[test]
    fn jitter_of_the_line_does_not_reach_the_stamps() {
        let stamps = run(0.0, 0.009, 0.03, 60);
        // The minimum of 500 uniform delays lies within 3 % of their range, except for one window
        // in four million.
        for (error, _) in &stamps[500..] {
            assert!((-2e-6..1e-3).contains(error), "{error}");
        }
    }

    #[test]
    fn a_clock_that_runs_fast_or_slow_is_followed() {
        for drift in [2e-4, -2e-4] {
            let stamps = run(drift, 0.009, 0.01, 600);
            for (error, _) in &stamps[100..] {
                // Two windows of 10 s at 200 µs/s, and what is left of the jitter.
                assert!(error.abs() < 5e-3, "{error} at drift {drift}");
            }
        }
    }

    #[test]
    fn stamps_never_go_back_and_keep_their_distances() {
        for (_, step) in run(2e-4, 0.0, 0.05, 120) {
            assert!((step - 0.02).abs() <= 0.02 * SLEW + 1e-5, "{step}");
        }
    }

    #[test]
    fn nothing_observed_is_nothing_known() {
        assert_eq!(ClockMap::new(0.0).host_time(Stamp(5)), None);
    }
}

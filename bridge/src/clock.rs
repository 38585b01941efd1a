//! The bridge's clock: counts from the start of the program, and does not jump when somebody sets
//! the time of day.

use std::time::{Duration, SystemTime, UNIX_EPOCH};

use tokio::time::Instant;

/// Time since the bridge started.
#[derive(Clone, Copy, Debug)]
pub struct Clock {
    start: Instant,
    /// Time of day at the start, for recordings, whose readers expect one.
    start_of_day: Duration,
}

impl Clock {
    /// Starts now.
    #[must_use]
    pub fn start() -> Self {
        Self {
            start: Instant::now(),
            // A clock before 1970 was never set.
            start_of_day: SystemTime::now()
                .duration_since(UNIX_EPOCH)
                .unwrap_or_default(),
        }
    }

    /// Time since the start.
    #[must_use]
    pub fn now(&self) -> Duration {
        self.start.elapsed()
    }

    /// The time of day at `at` after the start, as time since 1970; setting the system's time of
    /// day does not change it.
    #[must_use]
    pub fn time_of_day(&self, at: Duration) -> Duration {
        self.start_of_day + at
    }

    pub(crate) fn instant(&self, at: Duration) -> Instant {
        self.start + at
    }
}

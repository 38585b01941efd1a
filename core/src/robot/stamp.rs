//! Time by the robot's own clock.

/// Microseconds since the robot started; never the wall clock.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Stamp(pub u64);

impl Stamp {
    /// The stamp `seconds` after the start; negative times and NaN become the start.
    #[must_use]
    pub fn from_seconds(seconds: f64) -> Self {
        // A float-to-integer `as` saturates, and maps NaN to 0.
        Self((seconds * 1e6).round() as u64)
    }

    /// Seconds since the robot started.
    #[must_use]
    pub fn seconds(self) -> f64 {
        self.0 as f64 * 1e-6
    }

    /// The stamp `seconds` later.
    #[must_use]
    pub fn plus(self, seconds: f64) -> Self {
        Self(self.0.saturating_add(Self::from_seconds(seconds).0))
    }

    /// Seconds from `earlier` to this stamp; negative if `earlier` is later.
    #[must_use]
    pub fn since(self, earlier: Self) -> f64 {
        self.seconds() - earlier.seconds()
    }
}

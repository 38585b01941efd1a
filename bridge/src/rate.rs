//! Rate limit: a token bucket.

use std::time::Duration;

/// Fills at `rate` per second, and holds at most `most`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bucket {
    rate: f64,
    most: f64,
    level: f64,
    filled: Duration,
}

impl Bucket {
    /// `rate` times per second on average, and twice as often in a burst.
    pub(crate) fn new(rate: u32, now: Duration) -> Self {
        let rate = f64::from(rate);
        Self::full(rate, 2.0 * rate, now)
    }

    /// `rate` times per minute on average, and as often in a burst.
    #[cfg(feature = "storage")]
    pub(crate) fn a_minute(rate: u32, now: Duration) -> Self {
        let rate = f64::from(rate);
        Self::full(rate / 60.0, rate, now)
    }

    fn full(rate: f64, most: f64, now: Duration) -> Self {
        Self {
            rate,
            most,
            level: most,
            filled: now,
        }
    }

    /// Whether the bucket is full.
    #[cfg(feature = "storage")]
    pub(crate) fn is_full(&self, now: Duration) -> bool {
        self.at(now) >= self.most
    }

    /// Takes one token; false if there is none.
    pub(crate) fn take(&mut self, now: Duration) -> bool {
        self.level = self.at(now);
        self.filled = now;
        let is_left = self.level >= 1.0;
        if is_left {
            self.level -= 1.0;
        }
        is_left
    }

    fn at(&self, now: Duration) -> f64 {
        let passed = now.saturating_sub(self.filled).as_secs_f64();
        (self.level + self.rate * passed).min(self.most)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn twice_the_rate_at_once_and_the_rate_for_ever() {
        let mut bucket = Bucket::new(10, Duration::ZERO);
        let at_once = (0..100).filter(|_| bucket.take(Duration::ZERO)).count();
        assert_eq!(at_once, 20);
        let steady = (1..=1000)
            .filter(|i| bucket.take(Duration::from_millis(10 * i)))
            .count();
        assert!((99..=101).contains(&steady), "{steady} in 10 s");
        // A long pause does not fill it beyond its limit.
        let later = Duration::from_secs(1000);
        assert_eq!((0..100).filter(|_| bucket.take(later)).count(), 20);
    }
}

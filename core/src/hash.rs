//! A fingerprint of state: equal bits give equal hashes, natively and in the browser.

use twox_hash::XxHash64;

use crate::geom::{Pose2, PoseEstimate};

/// Collects the bits of numbers into one XXH64 hash. The order of the calls counts.
#[derive(Clone, Debug, Default)]
pub struct StateHash(XxHash64);

impl StateHash {
    /// A hash of no input yet.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds an integer.
    pub fn integer(&mut self, value: u64) -> &mut Self {
        self.bytes(&value.to_le_bytes())
    }

    /// Adds a number, by its bits: 0.0 and -0.0 differ, as results that follow from them may.
    pub fn number(&mut self, value: f64) -> &mut Self {
        self.integer(value.to_bits())
    }

    /// Adds many single-precision numbers.
    pub fn singles(&mut self, values: &[f32]) -> &mut Self {
        for value in values {
            self.bytes(&value.to_bits().to_le_bytes());
        }
        self
    }

    /// Adds a pose.
    pub fn pose(&mut self, pose: &Pose2) -> &mut Self {
        let (cos, sin) = pose.cos_sin();
        self.number(pose.x())
            .number(pose.y())
            .number(cos)
            .number(sin)
    }

    /// Adds an estimate: the pose and its covariance.
    pub fn estimate(&mut self, estimate: &PoseEstimate) -> &mut Self {
        self.pose(&estimate.pose);
        for value in estimate.cov.iter() {
            self.number(*value);
        }
        self
    }

    /// The hash of everything added.
    #[must_use]
    pub fn finish(&self) -> u64 {
        std::hash::Hasher::finish(&self.0)
    }

    fn bytes(&mut self, bytes: &[u8]) -> &mut Self {
        // `Hasher::write` takes the bytes as given; `write_u64` would depend on the machine's byte
        // order.
        std::hash::Hasher::write(&mut self.0, bytes);
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn same_as_the_published_xxh64_of_the_same_bytes() {
        // XXH64 with seed 0 of no input, from the xxHash specification's test vectors.
        assert_eq!(StateHash::new().finish(), 0xEF46_DB37_51D8_E999);
        let whole = XxHash64::oneshot(0, &1.5_f64.to_bits().to_le_bytes());
        assert_eq!(StateHash::new().number(1.5).finish(), whole);
    }

    #[test]
    fn one_bit_or_another_order_is_another_hash() {
        let of = |a: f64, b: f64| StateHash::new().number(a).number(b).finish();
        assert_ne!(of(1.0, 2.0), of(2.0, 1.0));
        assert_ne!(of(1.0, 2.0), of(1.0, f64::from_bits(2.0_f64.to_bits() + 1)));
    }
}

//! What a faulty line does to bytes.

/// The faults of a line.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Faults {
    /// Fraction of the bits that are flipped, 0 to 1.
    pub flipped_bits: f64,
    /// The same for what the device receives.
    pub flipped_bits_heard: f64,
    /// Both sides hear noise, as at a wrong baud rate.
    pub is_garbled: bool,
    /// Fraction of the bytes that get lost, 0 to 1.
    pub lost_bytes: f64,
    /// Nothing comes from the device any more, but it still receives.
    pub is_mute: bool,
}

/// A line with its own random numbers: the same seed spoils the same bits.
#[derive(Clone, Debug)]
pub struct Line {
    state: u64,
}

impl Line {
    /// A line with this seed.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self { state: seed | 1 }
    }

    /// The bytes that arrive when `bytes` are sent.
    #[must_use]
    pub fn carry(&mut self, bytes: &[u8], faults: &Faults) -> Vec<u8> {
        if faults.is_mute {
            return vec![];
        }
        let mut out = Vec::with_capacity(bytes.len());
        for &byte in bytes {
            if self.chance(faults.lost_bytes) {
                continue;
            }
            let flips = (0..8).filter(|_| self.chance(faults.flipped_bits));
            out.push(flips.fold(byte, |byte, bit| byte ^ 1 << bit));
        }
        out
    }

    /// What a receiver at another rate makes of `bytes`: noise of about the right length.
    pub(super) fn garble(&mut self, bytes: &[u8]) -> Vec<u8> {
        bytes.iter().map(|_| (self.number() >> 40) as u8).collect()
    }

    fn chance(&mut self, part: f64) -> bool {
        part > 0.0 && ((self.number() >> 11) as f64 / (1_u64 << 53) as f64) < part
    }

    /// Knuth's MMIX generator.
    fn number(&mut self) -> u64 {
        self.state = self
            .state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        self.state
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_flip_as_often_as_told() {
        let faults = Faults {
            flipped_bits: 1e-3,
            ..Faults::default()
        };
        let out = Line::new(1).carry(&[0; 125_000], &faults);
        let flipped: u32 = out.iter().map(|byte| byte.count_ones()).sum();
        // A million bits: 1000 ± 32, so 5 σ.
        assert!(flipped.abs_diff(1000) < 160, "{flipped}");
    }

    #[test]
    fn a_line_without_faults_carries_all() {
        let bytes: Vec<u8> = (0..=255).collect();
        assert_eq!(Line::new(1).carry(&bytes, &Faults::default()), bytes);
    }
}

//! Analogue to digital. In: volts. Out: counts, and the volts that a count stands for.

/// An analogue-to-digital converter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Adc {
    /// Width of its counts, 1 to 31 bits.
    pub bits: u32,
    /// Volts of full scale.
    pub reference: f64,
}

impl Adc {
    /// The RP6's: 10 bits over 5 V, so that a count is 4.9 mV.
    #[must_use]
    pub fn rp6() -> Self {
        Self {
            bits: 10,
            reference: 5.0,
        }
    }

    /// Volts of one count.
    #[must_use]
    pub fn step(&self) -> f64 {
        self.reference / f64::from(1_u32 << self.bits.clamp(1, 31))
    }

    /// The count for these volts; beyond full scale the nearest valid count, 0 for NaN.
    #[must_use]
    pub fn counts(&self, volts: f64) -> u32 {
        let most = (1_u32 << self.bits.clamp(1, 31)) - 1;
        // A float-to-integer `as` saturates and maps NaN to 0.
        ((volts / self.step()) as u32).min(most)
    }

    /// The middle of the voltage range of this count.
    #[must_use]
    pub fn volts(&self, counts: u32) -> f64 {
        (f64::from(counts) + 0.5) * self.step()
    }

    /// Standard deviation of the quantisation error, V: that of a uniform distribution.
    #[must_use]
    pub fn sigma(&self) -> f64 {
        self.step() / 12.0_f64.sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_stand_for_volts_within_half_a_step() {
        let adc = Adc::rp6();
        assert!((adc.step() - 5.0 / 1024.0).abs() < 1e-15);
        for millivolts in 0..5000 {
            let volts = f64::from(millivolts) * 1e-3;
            let again = adc.volts(adc.counts(volts));
            assert!((again - volts).abs() <= 0.5 * adc.step() + 1e-12, "{volts}");
        }
        let ends = [-1.0, 0.0, 4.9999, 7.0, f64::NAN].map(|v| adc.counts(v));
        assert_eq!(ends, [0, 0, 1023, 1023, 0]);
    }

    #[test]
    fn sigma_is_that_of_the_rounding() {
        let adc = Adc::rp6();
        let n = 100_000;
        let error = |i: i32| {
            let volts = 1.0 + 3.0 * f64::from(i) / f64::from(n);
            adc.volts(adc.counts(volts)) - volts
        };
        let squares: f64 = (0..n).map(|i| error(i) * error(i)).sum();
        let sigma = (squares / f64::from(n)).sqrt();
        assert!((sigma / adc.sigma() - 1.0).abs() < 0.01);
    }
}

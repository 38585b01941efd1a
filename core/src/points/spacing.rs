//! The distance to expect between neighbouring points: k(ρ) = a ρ + b.
//!
//! Source: Pilch 2016 §3.5.1, the distance coefficient; **Erratum** of the specification: eq. (3.6)
//! gives no units. 22.3 mm at 1 m with 280 samples a turn is a = 2π/280, b = 0 in metres.

use std::f64::consts::TAU;

/// The expected distance of neighbouring points on a surface at right angles to the beam: k(ρ) = a
/// ρ + b.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpacingModel {
    /// m per m of range; the step in bearing, rad, for an ideal sensor.
    pub slope: f64,
    /// m at range 0.
    pub offset: f64,
}

impl SpacingModel {
    /// That of an ideal sensor with `samples_per_turn` evenly spaced beams.
    ///
    /// # Example
    /// ```
    /// // Pilch 2016: 280 samples a turn, 22.3 mm at 1 m by measurement.
    /// let k = slamlab_core::points::SpacingModel::even(280.0);
    /// assert!((k.at(1.0) - 0.0223).abs() < 2e-4);
    /// ```
    #[must_use]
    pub fn even(samples_per_turn: f64) -> Self {
        Self {
            slope: TAU / samples_per_turn,
            offset: 0.0,
        }
    }

    /// k at one range, m.
    #[inline]
    #[must_use]
    pub fn at(&self, range: f64) -> f64 {
        self.slope * range + self.offset
    }

    /// The mean of k at two ranges, m.
    #[inline]
    #[must_use]
    pub fn between(&self, a: f64, b: f64) -> f64 {
        0.5 * (self.at(a) + self.at(b))
    }
}

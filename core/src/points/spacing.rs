//! In: ranges and the distances between neighbouring points. Out: k(ρ) = a ρ + b, the distance to expect.
//!
//! 1. Least squares of distance on range.
//! 2. Pairs farther than 3 standard deviations off (a step from one surface to another) are skipped, and the rest is fitted
//!    again, until nothing changes.
//!
//! Source: Pilch 2016 §3.5.1, the distance coefficient; **Erratum** of the specification: eq. (3.6) gives no units. 22.3 mm at
//! 1 m with 280 samples a turn is a = 2π/280, b = 0 in metres.

use std::f64::consts::TAU;

/// The expected distance of neighbouring points on a surface at right angles to the beam: k(ρ) = a ρ + b.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpacingModel {
    /// m per m of range; the step in bearing, rad, for an ideal sensor.
    pub slope: f64,
    /// m at range 0.
    pub offset: f64,
}

/// Why no spacing can be fitted.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SpacingError {
    /// A straight line needs two different ranges.
    #[error(
        "{n_pairs} pairs of range and distance, with ranges from {min_range} to {max_range} m; expected at least 2 different ranges"
    )]
    TooFew {
        /// How many pairs there are.
        n_pairs: usize,
        /// The shortest range, m.
        min_range: f64,
        /// The longest range, m.
        max_range: f64,
    },
    /// A pair that cannot be used.
    #[error(
        "pair {index}: range {range} m, distance {distance} m; expected finite numbers, not negative"
    )]
    Value {
        /// Number of the pair.
        index: usize,
        /// Its range, m.
        range: f64,
        /// Its distance, m.
        distance: f64,
    },
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

    /// Fitted to pairs of (range, distance to the next point), m.
    ///
    /// # Errors   [`SpacingError`]: fewer than two different ranges; a number that is negative or not finite.
    pub fn fit(pairs: &[(f64, f64)]) -> Result<Self, SpacingError> {
        let is_usable = |v: f64| v >= 0.0 && v.is_finite();
        if let Some(index) = pairs
            .iter()
            .position(|&(range, distance)| !(is_usable(range) && is_usable(distance)))
        {
            let (range, distance) = pairs[index];
            return Err(SpacingError::Value {
                index,
                range,
                distance,
            });
        }
        let mut kept = pairs.to_vec();
        loop {
            let model = Self::least_squares(&kept)?;
            let residual = |&(range, distance): &(f64, f64)| (distance - model.at(range)).abs();
            let sum: f64 = kept.iter().map(|p| residual(p) * residual(p)).sum();
            let limit = 3.0 * (sum / kept.len() as f64).sqrt();
            let before = kept.len();
            kept.retain(|pair| residual(pair) <= limit);
            if kept.len() == before || kept.len() < 2 {
                return Ok(model);
            }
        }
    }

    fn least_squares(pairs: &[(f64, f64)]) -> Result<Self, SpacingError> {
        let n = pairs.len().max(1) as f64;
        let sum = pairs.iter().fold((0.0, 0.0), |s, p| (s.0 + p.0, s.1 + p.1));
        let (range, distance) = (sum.0 / n, sum.1 / n);
        let (mut spread, mut product) = (0.0, 0.0);
        for pair in pairs {
            spread += (pair.0 - range) * (pair.0 - range);
            product += (pair.0 - range) * (pair.1 - distance);
        }
        if spread <= 1e-12 * (n * range * range).max(1e-12) {
            let ranges = || pairs.iter().map(|p| p.0);
            return Err(SpacingError::TooFew {
                n_pairs: pairs.len(),
                min_range: ranges().fold(f64::INFINITY, f64::min),
                max_range: ranges().fold(0.0, f64::max),
            });
        }
        let slope = product / spread;
        Ok(Self {
            slope,
            offset: distance - slope * range,
        })
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spacing_of_an_even_sensor_is_found_in_spite_of_steps() {
        let truth = SpacingModel {
            slope: TAU / 280.0,
            offset: 0.002,
        };
        let mut pairs: Vec<_> = (0..200)
            .map(|i| 0.3 + 0.03 * f64::from(i))
            .map(|range| (range, truth.at(range) + 1e-4 * libm::sin(90.0 * range)))
            .collect();
        for i in [10, 60, 61, 150] {
            pairs[i].1 += 1.5;
        }
        let found = SpacingModel::fit(&pairs).unwrap();
        assert!((found.slope - truth.slope).abs() < 2e-4, "{found:?}");
        assert!((found.offset - truth.offset).abs() < 5e-4, "{found:?}");
    }

    #[test]
    fn pairs_that_fix_no_line_are_refused_with_their_numbers() {
        assert!(matches!(
            SpacingModel::fit(&[(1.0, 0.02), (1.0, 0.03)]),
            Err(SpacingError::TooFew { n_pairs: 2, .. })
        ));
        assert!(matches!(
            SpacingModel::fit(&[]),
            Err(SpacingError::TooFew { n_pairs: 0, .. })
        ));
        assert!(matches!(
            SpacingModel::fit(&[(1.0, 0.02), (f64::NAN, 0.03)]),
            Err(SpacingError::Value { index: 1, .. })
        ));
        assert!(matches!(
            SpacingModel::fit(&[(1.0, -0.02), (2.0, 0.03)]),
            Err(SpacingError::Value { index: 0, .. })
        ));
    }
}

//! Something at one place, as one scan shows it.

use std::f64::consts::SQRT_2;

use nalgebra::{Matrix2, Point2};

/// Something at one place, as one scan shows it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointFeature {
    /// Where it is, robot frame, m.
    pub position: Point2<f64>,
    /// Covariance of the position, m².
    pub cov: Matrix2<f64>,
    /// What it is.
    pub kind: PointKind,
    /// The probability, from the noise of the beams alone, that the figure by which it was found
    /// (angle, jump, radius) is truly within its limits; 0 to 1.
    pub confidence: f64,
    /// Indices in the scan of the first and the last beam that show it; the first may be greater if
    /// it lies across the end of the scan.
    pub beams: [usize; 2],
}

/// What a point of a scan is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PointKind {
    /// Where a row of neighbours bends ([`super::CornerConfig`]).
    Corner,
    /// An object that stands out in range: a post, a table leg, an edge ([`super::SpikeConfig`]).
    Spike,
    /// Where the lines of two walls cross ([`super::CrossingConfig`]).
    Crossing,
    /// The centre of something round ([`super::CircleConfig`]).
    Circle {
        /// Its radius, m.
        radius: f64,
        /// Variance of the radius, m².
        var_radius: f64,
    },
}

impl PointKind {
    /// Whether both are of one kind, whatever their values.
    #[must_use]
    pub fn is_like(&self, other: &Self) -> bool {
        std::mem::discriminant(self) == std::mem::discriminant(other)
    }

    /// Combines it with another sighting: the radius becomes the mean of both, weighted by their
    /// information.
    pub fn refine(&mut self, seen: &Self) {
        if let (
            Self::Circle { radius, var_radius },
            Self::Circle {
                radius: seen,
                var_radius: var_seen,
            },
        ) = (self, seen)
        {
            let gain = *var_radius / (*var_radius + var_seen);
            // Both are known exactly.
            let gain = if gain.is_finite() { gain } else { 0.0 };
            *radius += gain * (seen - *radius);
            *var_radius *= 1.0 - gain;
        }
    }

    /// Whether it is the centre of something round.
    #[must_use]
    pub fn is_round(&self) -> bool {
        matches!(self, Self::Circle { .. })
    }
}

/// The probability that a normal variable with this mean and standard deviation is within the
/// limits.
pub(super) fn probability_within(mean: f64, sigma: f64, [low, high]: [f64; 2]) -> f64 {
    if sigma <= 0.0 {
        return f64::from(u8::from((low..=high).contains(&mean)));
    }
    // Φ(b) - Φ(a), by the tails, so no precision is lost where both are near 1.
    let upper_tail = |limit: f64| 0.5 * libm::erfc((limit - mean) / (sigma * SQRT_2));
    (upper_tail(low) - upper_tail(high)).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn probability_is_that_of_the_tables() {
        let within = |n: f64| probability_within(0.0, 2.0, [-2.0 * n, 2.0 * n]);
        assert!((within(1.0) - 0.682_689_492).abs() < 1e-9);
        assert!((within(1.959_963_985) - 0.95).abs() < 1e-9);
        assert!((probability_within(3.0, 1.0, [3.0, f64::INFINITY]) - 0.5).abs() < 1e-15);
        assert_eq!(probability_within(3.0, 0.0, [1.0, 3.0]), 1.0);
        assert_eq!(probability_within(3.1, 0.0, [1.0, 3.0]), 0.0);
    }
}

//! The expected distance between neighbouring points: k(ρ) = a ρ + b.
//!
//! Source: Pilch 2016 §3.5.1, the distance coefficient; **Erratum** of the specification: eq. (3.6)
//! gives no units. 22.3 mm at 1 m with 280 samples a turn is a = 2π/280, b = 0 in metres.

use std::f64::consts::TAU;

use nalgebra::Vector2;

use super::Points;

/// The expected distance k(ρ) = a ρ + b of neighbouring points on a surface perpendicular to the
/// beam.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpacingModel {
    /// m per m of range; for an ideal sensor this is the step in bearing, rad.
    pub slope: f64,
    /// m at range 0.
    pub offset: f64,
}

impl SpacingModel {
    /// The spacing of an ideal sensor with `samples_per_turn` evenly spaced beams.
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

    /// The spacing of a scan, from the median step in bearing between beams. 0 for fewer than two
    /// beams.
    #[must_use]
    pub fn of(points: &Points) -> Self {
        let rays = points
            .beams
            .iter()
            .map(|b| b.end_in_robot - b.origin_in_robot);
        let next = rays.clone().skip(1);
        let step = |(a, b): (Vector2<f64>, Vector2<f64>)| libm::atan2(a.perp(&b), a.dot(&b)).abs();
        let mut steps: Vec<f64> = rays.zip(next).map(step).collect();
        let middle = steps.len() / 2;
        let slope = match steps.get(middle) {
            Some(_) => *steps.select_nth_unstable_by(middle, f64::total_cmp).1,
            None => 0.0,
        };
        Self { slope, offset: 0.0 }
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
    use nalgebra::Point2;

    use super::*;
    use crate::geom::unit_vector;
    use crate::points::fixture::scan_of_hits;

    #[test]
    fn spacing_of_a_scan_is_that_of_its_beams_also_where_some_are_lost() {
        for n in [1.0, -1.0].map(|sign: f64| sign * 280.0) {
            let beams = (0..280).filter(|i| i % 7 != 3 && !(100..130).contains(i));
            let at = |i: i32| {
                Point2::from(unit_vector(TAU * f64::from(i) / n) * (1.0 + 0.01 * f64::from(i)))
            };
            let found = SpacingModel::of(&scan_of_hits(beams.map(at)));
            assert!((found.slope - SpacingModel::even(280.0).slope).abs() < 1e-12);
        }
        assert_eq!(SpacingModel::of(&scan_of_hits([])).at(3.0), 0.0);
    }
}

//! Position and velocity of an object: the constant-velocity Kalman filter.
//!
//! In: the time that passed, and sightings, each taken a little before the instant of the state.
//! Out: position and velocity with their covariance.
//!
//! 1. Prediction: the velocity is constant except for white-noise acceleration of spectral density
//!    q.
//! 2. A sighting that was taken `age` before now shows p - age · v: a lidar takes a fifth of a
//!    second for a revolution, in which people walk as far as their radius.
//! 3. Correction, in Joseph's form, which stays positive definite in spite of rounding.
//!
//! Source: Bar-Shalom, Li & Kirubarajan (2001), "Estimation with applications to tracking and
//! navigation", §5.2 and §6.3.2 (discretised continuous white noise acceleration).

use nalgebra::{Matrix2, Matrix2x4, Matrix4, Point2, Vector2, Vector4};

use crate::geom::symmetrize;

/// Something in a scan that may be an object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sighting {
    /// Position of its middle, m.
    pub at: Point2<f64>,
    /// Covariance of that, m².
    pub cov: Matrix2<f64>,
    /// How long before the instant of the scan it was seen, s.
    pub age: f64,
    /// Whether it certainly stands in free space: only such sightings begin a track, or show that
    /// it moves.
    pub is_free: bool,
}

/// Position and velocity of an object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ObjectState {
    /// x, y (m), and their rates (m/s).
    pub mean: Vector4<f64>,
    /// Covariance of these.
    pub cov: Matrix4<f64>,
}

/// The innovation of a state by a sighting.
#[derive(Clone, Copy, Debug)]
pub(super) struct Innovation {
    /// Measured minus expected position, m.
    v: Vector2<f64>,
    observation: Matrix2x4<f64>,
    noise: Matrix2<f64>,
    inverse: Matrix2<f64>,
    /// Squared Mahalanobis distance.
    pub(super) d2: f64,
    /// Likelihood of the sighting, given that it is of this object, 1/m².
    pub(super) likelihood: f64,
}

impl ObjectState {
    /// The state from one sighting alone: nothing is known of the velocity except that it is that
    /// of a person, with standard deviation `speed_sigma`, m/s.
    #[must_use]
    pub fn begun(sighting: &Sighting, speed_sigma: f64) -> Self {
        let mut cov = Matrix4::zeros();
        let variance = speed_sigma * speed_sigma;
        // p = z + age · v.
        let moved = Matrix2::identity() * (sighting.age * variance);
        let position = sighting.cov + moved * sighting.age;
        cov.fixed_view_mut::<2, 2>(0, 0).copy_from(&position);
        cov.fixed_view_mut::<2, 2>(0, 2).copy_from(&moved);
        cov.fixed_view_mut::<2, 2>(2, 0).copy_from(&moved);
        let velocity = Matrix2::identity() * variance;
        cov.fixed_view_mut::<2, 2>(2, 2).copy_from(&velocity);
        Self {
            mean: Vector4::new(sighting.at.x, sighting.at.y, 0.0, 0.0),
            cov,
        }
    }

    /// Position, m.
    #[must_use]
    pub fn position(&self) -> Point2<f64> {
        Point2::new(self.mean.x, self.mean.y)
    }

    /// Velocity, m/s.
    #[must_use]
    pub fn velocity(&self) -> Vector2<f64> {
        Vector2::new(self.mean.z, self.mean.w)
    }

    /// Covariance of the position, m².
    #[must_use]
    pub fn position_cov(&self) -> Matrix2<f64> {
        self.cov.fixed_view::<2, 2>(0, 0).into_owned()
    }

    /// The state `seconds` later (step 1); `acceleration` is q, m²/s³.
    #[must_use]
    pub fn predicted(&self, seconds: f64, acceleration: f64) -> Self {
        let t = seconds;
        let mut step = Matrix4::identity();
        (step[(0, 2)], step[(1, 3)]) = (t, t);
        let [way, both, rate] = [t * t * t / 3.0, t * t / 2.0, t].map(|e| e * acceleration);
        let noise = Matrix4::new(
            way, 0.0, both, 0.0, 0.0, way, 0.0, both, both, 0.0, rate, 0.0, 0.0, both, 0.0, rate,
        );
        let mut cov = step * self.cov * step.transpose() + noise;
        symmetrize(&mut cov);
        Self {
            mean: step * self.mean,
            cov,
        }
    }

    /// Step 2; `None` if the covariance is not positive definite.
    pub(super) fn innovation(&self, sighting: &Sighting) -> Option<Innovation> {
        let mut observation = Matrix2x4::identity();
        (observation[(0, 2)], observation[(1, 3)]) = (-sighting.age, -sighting.age);
        let v = sighting.at.coords - observation * self.mean;
        let cov = observation * self.cov * observation.transpose() + sighting.cov;
        let determinant = cov.determinant();
        if !(cov[(0, 0)] > 0.0 && determinant > 0.0) {
            return None;
        }
        let inverse = cov.try_inverse()?;
        let d2 = v.dot(&(inverse * v));
        let likelihood = libm::exp(-0.5 * d2) / (std::f64::consts::TAU * determinant.sqrt());
        likelihood.is_finite().then_some(Innovation {
            v,
            observation,
            noise: sighting.cov,
            inverse,
            d2,
            likelihood,
        })
    }

    /// Step 3.
    #[must_use]
    pub(super) fn corrected(&self, by: &Innovation) -> Self {
        let gain = self.cov * by.observation.transpose() * by.inverse;
        let kept = Matrix4::identity() - gain * by.observation;
        let mut cov = kept * self.cov * kept.transpose() + gain * by.noise * gain.transpose();
        symmetrize(&mut cov);
        Self {
            mean: self.mean + gain * by.v,
            cov,
        }
    }

    /// One state with the mean and the covariance of a mixture, whose weights need not add up to 1;
    /// `None` for a mixture without weight.
    #[must_use]
    pub(super) fn of_mixture(parts: &[(f64, Self)]) -> Option<Self> {
        let all: f64 = parts.iter().map(|(weight, _)| weight).sum();
        if !(all > 0.0 && all.is_finite()) {
            return None;
        }
        let weighted = parts
            .iter()
            .map(|(weight, state)| state.mean * (weight / all));
        let mean: Vector4<f64> = weighted.sum();
        let mut cov = Matrix4::zeros();
        for (weight, state) in parts {
            let off = state.mean - mean;
            cov += (state.cov + off * off.transpose()) * (weight / all);
        }
        symmetrize(&mut cov);
        Some(Self { mean, cov })
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use proptest::prelude::*;

    pub(crate) fn sighting(x: f64, y: f64) -> Sighting {
        Sighting {
            at: Point2::new(x, y),
            cov: Matrix2::identity() * 0.0025,
            age: 0.0,
            is_free: true,
        }
    }

    proptest! {
        /// Straight lines have a closed form: without acceleration noise, the filter is the
        /// least-squares line through all sightings and the prior.
        #[test]
        fn without_acceleration_it_is_the_regression_line(
            places in proptest::collection::vec((-2.0..2.0_f64, 0.0..0.15_f64), 2..8), step in 0.1..0.5_f64,
        ) {
            let seen: Vec<Sighting> = places.iter()
                .map(|&(x, age)| Sighting { age, ..sighting(x, 0.0) })
                .collect();
            let mut state = ObjectState::begun(&seen[0], 10.0);
            for sighting in &seen[1..] {
                state = state.predicted(step, 0.0);
                state = state.corrected(&state.innovation(sighting).unwrap());
            }
            // Normal equations of x(t) = p + v t about the last instant, with the prior of v.
            let (mut a, mut b) = (Matrix2::new(0.0, 0.0, 0.0, 1e-2), Vector2::zeros());
            let last = (seen.len() - 1) as f64 * step;
            for (number, sighting) in seen.iter().enumerate() {
                let row = Vector2::new(1.0, number as f64 * step - sighting.age - last);
                a += row * row.transpose() / 0.0025;
                b += row * (sighting.at.x / 0.0025);
            }
            let cov = a.try_inverse().unwrap();
            let expect = cov * b;
            prop_assert!((state.mean.x - expect.x).abs() < 1e-7 * (1.0 + expect.x.abs()), "{} {}", state.mean.x, expect.x);
            prop_assert!((state.mean.z - expect.y).abs() < 1e-6 * (1.0 + expect.y.abs()), "{} {}", state.mean.z, expect.y);
            prop_assert!((state.cov[(0, 0)] - cov[(0, 0)]).abs() < 1e-9);
            prop_assert!((state.cov[(0, 2)] - cov[(0, 1)]).abs() < 1e-7);
        }
    }

    #[test]
    fn two_predictions_are_one_of_both_times() {
        let state = ObjectState::begun(&sighting(1.0, 2.0), 1.0);
        let (once, twice) = (
            state.predicted(0.5, 0.3),
            state.predicted(0.2, 0.3).predicted(0.3, 0.3),
        );
        assert!((once.cov - twice.cov).amax() < 1e-12);
        assert!((once.mean - twice.mean).amax() < 1e-12);
    }

    #[test]
    fn a_mixture_of_two_points_has_their_mean_and_spread() {
        let at = |x: f64| ObjectState {
            mean: Vector4::new(x, 0.0, 0.0, 0.0),
            cov: Matrix4::zeros(),
        };
        // Of 0 and 4 with weights 3 to 1: mean 1, variance 3.
        let state = ObjectState::of_mixture(&[(1.5, at(0.0)), (0.5, at(4.0))]).unwrap();
        assert!((state.mean.x - 1.0).abs() < 1e-12 && (state.cov[(0, 0)] - 3.0).abs() < 1e-12);
        assert_eq!(ObjectState::of_mixture(&[(0.0, at(1.0))]), None);
    }
}

//! Gaussian numbers from uniform ones.
//!
//! Source: Box & Muller (1958), with `libm`, so that every platform draws the same bits. It gives
//! two numbers at a time and has no rejection loop: the number of draws never depends on the values
//! drawn.

use rand::{Rng, RngExt};

/// Two independent standard normal numbers.
#[must_use]
pub fn gaussian_pair(rng: &mut impl Rng) -> (f64, f64) {
    // In (0, 1]: the logarithm of 0 does not exist.
    let u = 1.0 - rng.random::<f64>();
    let radius = (-2.0 * libm::log(u)).sqrt();
    let (sin, cos) = super::sin_cos(std::f64::consts::TAU * rng.random::<f64>());
    (radius * cos, radius * sin)
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    use super::*;

    #[test]
    fn moments_are_those_of_the_standard_normal() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let n = 100_000;
        let (mut mean, mut square, mut fourth, mut product) = (0.0, 0.0, 0.0, 0.0);
        for _ in 0..n {
            let (a, b) = gaussian_pair(&mut rng);
            mean += a + b;
            square += a * a + b * b;
            fourth += a * a * a * a + b * b * b * b;
            product += a * b;
        }
        let count = f64::from(2 * n);
        // Five standard errors of each estimate.
        assert!((mean / count).abs() < 5.0 / count.sqrt());
        assert!((square / count - 1.0).abs() < 5.0 * (2.0 / count).sqrt());
        assert!((fourth / count - 3.0).abs() < 5.0 * (96.0 / count).sqrt());
        assert!((product / f64::from(n)).abs() < 5.0 / f64::from(n).sqrt());
    }
}

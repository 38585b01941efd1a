//! Random numbers, and what is to be expected of averages of them.

use std::f64::consts::TAU;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// A standard normal number, by Box and Muller.
pub(crate) fn normal(rng: &mut ChaCha8Rng) -> f64 {
    let (u, v): (f64, f64) = (rng.random(), rng.random());
    (-2.0 * libm::log(1.0 - u)).sqrt() * libm::cos(TAU * v)
}

/// The 95 % band of the mean of `n` values of χ² with `degrees` degrees of freedom.
///
/// Source: Wilson & Hilferty (1931): the cube root of χ²/k is nearly normal; good to 0.1 % for the
/// hundreds of degrees here.
pub(crate) fn chi2_mean_band(degrees: f64, n: f64) -> [f64; 2] {
    let k = degrees * n;
    let part = 2.0 / (9.0 * k);
    [-1.959_964, 1.959_964].map(|z| {
        let root = 1.0 - part + z * part.sqrt();
        degrees * root * root * root
    })
}

//! Random numbers, and the expected range of their averages; quantiles and lines through points.

use std::borrow::Borrow;
use std::f64::consts::TAU;

use nalgebra::Point2;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// The median; NaN of no values.
pub(crate) fn median(values: impl IntoIterator<Item = impl Borrow<f64>>) -> f64 {
    quantile(values, 0.5)
}

/// The value with this part of the others below it; NaN of no values.
pub(crate) fn quantile(values: impl IntoIterator<Item = impl Borrow<f64>>, part: f64) -> f64 {
    let mut sorted: Vec<f64> = values.into_iter().map(|value| *value.borrow()).collect();
    sorted.sort_by(f64::total_cmp);
    let at = (part * sorted.len() as f64) as usize;
    let last = sorted.len().saturating_sub(1);
    sorted.get(at.min(last)).copied().unwrap_or(f64::NAN)
}

/// Intercept and slope of the least-squares line, and the root mean square of the residuals.
pub(crate) fn fit_line(points: &[(f64, f64)]) -> (f64, f64, f64) {
    let n = points.len() as f64;
    let mean = |of: fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / n;
    let (x, y) = (mean(|p| p.0), mean(|p| p.1));
    let across: f64 = points.iter().map(|p| (p.0 - x) * (p.1 - y)).sum();
    let along: f64 = points.iter().map(|p| (p.0 - x).powi(2)).sum();
    let slope = across / along;
    let residual = |p: &(f64, f64)| (p.1 - y - slope * (p.0 - x)).powi(2);
    let squares: f64 = points.iter().map(residual).sum();
    (y - slope * x, slope, (squares / n).sqrt())
}

/// Probability that of `count` trials, each of which succeeds with probability `part`, at least
/// `least` succeed.
pub(crate) fn at_least_so_many(least: usize, count: usize, part: f64) -> f64 {
    let (mut exactly, mut fewer) = ((1.0 - part).powf(count as f64), 0.0);
    for successes in 0..least.min(count + 1) {
        fewer += exactly;
        let next = (count - successes) as f64 / (successes + 1) as f64;
        exactly *= next * part / (1.0 - part);
    }
    (1.0 - fewer).max(0.0)
}

/// A random place between two corners.
pub(crate) fn place_between(
    low: Point2<f64>,
    high: Point2<f64>,
    rng: &mut ChaCha8Rng,
) -> Point2<f64> {
    let x = rng.random_range(low.x..high.x);
    Point2::new(x, rng.random_range(low.y..high.y))
}

/// A standard normal number, by the Box-Muller method.
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

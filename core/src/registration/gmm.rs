//! Two mixtures of Gaussians, one for each cloud, and the motion that minimises their L2 distance.
//!
//! In: two clouds, a start, and a list of widths. Out: the linear map and the shift.
//!
//! Each point is the centre of a Gaussian of width σ. The integral of the squared difference of the
//! two mixtures is, up to a factor and to terms that the motion does not change,
//!
//! f = 1/M² ΣΣ g(T y_i - T y_j) - 2/(MN) ΣΣ g(T y_i - x_j), g(d) = exp(-|d|² / 4σ²),
//!
//! because the product of two Gaussians integrates to a Gaussian of their distance, of variance
//! 2σ². A rigid motion does not change the first sum. Gradient and Hessian have closed forms. For
//! each width, f is minimised by BFGS, from wide to narrow, so the clouds pull each other together
//! from afar before details count. For a rigid motion, BFGS begins with the true Hessian, or where
//! f is not convex, with that of a parabola above it. Widths before the last one need only come
//! near the minimum, with less exact sums. All sums go through [`gauss_transform`].
//!
//! Source: Jian & Vemuri (2011), "Robust point set registration using Gaussian mixture models";
//! Pilch (2016), eqs. (1.56)-(1.58).

mod bfgs;
#[cfg(test)]
mod tests;

use nalgebra::{DMatrix, DVector, Matrix2, Matrix2x3, Matrix3, Point2, Vector2};

use self::bfgs::{Until, descend};

use super::trace::{Correspondence, Iteration, Watch};
use super::{AffineMap, gauss_transform};
use crate::bounds::config;
use crate::geom::{Pose2, sin_cos};

config! {
    /// How mixtures are laid on each other.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct GmmConfig {
        /// First width of the Gaussians, in extents (root mean square distances from the mean) of
        /// the larger cloud. Default 0.5; larger pulls in worse starts.
        pub first_width: f64 = 0.5,
        /// Last width, in extents. Default 0.01; larger smooths noise.
        pub last_width: f64 = 0.01,
        /// What is left of the width after each round. Default 0.4; larger is surer and slower.
        pub shrink: f64 = 0.4,
        /// Most steps of BFGS at each width. Default 20.
        pub max_iterations: usize = 20,
        /// Whether any linear map is sought, and not a rotation. Default false.
        pub is_affine: bool = false,
        /// Error of the sums, in parts of the number of points. Default 1e-7.
        pub error: f64 = 1e-7,
    }
}

/// How two mixtures came to lie on each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GmmFit {
    /// From the moving cloud to the fixed one.
    pub map: AffineMap,
    /// How far they still differ, at the last width: 0 for equal clouds, 1 if nothing of one lies
    /// near the other.
    pub distance: f64,
    /// Steps taken at all widths together.
    pub iterations: usize,
    /// Whether f was minimised at the last width.
    pub is_settled: bool,
}

/// Gradients smaller than this count as zero: f is about 1.
const FLAT: f64 = 1e-7;
/// At the last width, a step shorter than this part of it ends the descent: the steps of BFGS
/// become shorter ever faster.
const LAST_STEP: f64 = 1e-3;
/// The same for the widths before, which only lead to the last one. Not much larger: where f is not
/// convex, steps are also short far from its minimum.
const STEP_BETWEEN: f64 = 0.01;
/// Least error of the sums at those widths: a step that matters lowers f by more.
const ERROR_BETWEEN: f64 = 1e-4;
/// Most rounds of shrinking.
const MOST_ROUNDS: usize = 100;

/// The map that lays `moving` on `fixed`, from `start`. `None` if the clouds have no extent, or a
/// coordinate is not a number.
#[must_use]
pub fn register_mixtures(
    moving: &[Point2<f64>],
    fixed: &[Point2<f64>],
    start: &Pose2,
    config: &GmmConfig,
) -> Option<GmmFit> {
    register_mixtures_watched(moving, fixed, start, config, &mut ())
}

/// [`register_mixtures`], with a [`Watch`] that sees each step.
pub(super) fn register_mixtures_watched(
    moving: &[Point2<f64>],
    fixed: &[Point2<f64>],
    start: &Pose2,
    config: &GmmConfig,
    watch: &mut impl Watch,
) -> Option<GmmFit> {
    let (from, to) = (Extent::of(moving)?, Extent::of(fixed)?);
    let scale = from.size.max(to.size);
    let normal = |points: &[Point2<f64>], mean: &Vector2<f64>| -> Vec<Point2<f64>> {
        let moved = |p: &Point2<f64>| Point2::from((p.coords - mean) / scale);
        points.iter().map(moved).collect()
    };
    let (y, x) = (normal(moving, &from.mean), normal(fixed, &to.mean));
    // The start, between the clouds as moved and scaled.
    let shift = (start.rotate(from.mean) + start.position().coords - to.mean) / scale;
    let (sin, cos) = sin_cos(start.heading());
    let mut parameters = DVector::from_vec(match config.is_affine {
        true => vec![shift.x, shift.y, cos, -sin, sin, cos],
        false => vec![shift.x, shift.y, start.heading()],
    });
    let map = |parameters: &DVector<f64>| {
        let (linear, shift) = linear(parameters.as_slice());
        AffineMap {
            linear,
            shift: to.mean + shift * scale - linear * from.mean,
        }
    };
    let back = |point: Vector2<f64>| Point2::from(to.mean + point * scale);
    let mut width = config.first_width.max(config.last_width);
    let (mut iterations, mut is_settled) = (0, false);
    for _ in 0..MOST_ROUNDS {
        let is_last = width <= config.last_width;
        let (error, short) = match is_last {
            true => (config.error, LAST_STEP),
            false => (config.error.max(ERROR_BETWEEN), STEP_BETWEEN),
        };
        let until = Until {
            flat: FLAT,
            short: short * width,
            iterations: config.max_iterations,
        };
        let problem = Mixtures::of(&y, &x, width, error);
        let value = |at: &DVector<f64>| {
            let (value, gradient) = problem.value(at.as_slice());
            (value, DVector::from_vec(gradient))
        };
        let look = |at: &DVector<f64>| {
            watch.see(|| {
                let pulls = problem.pulls(at.as_slice()).into_iter();
                let pairs = pulls.map(|(from, to, weight)| Correspondence {
                    from: back(from),
                    to: back(to),
                    weight,
                });
                Iteration::of(map(at).rigid(), width * scale, pairs)
            });
        };
        let inverse = problem.inverse_hessian(parameters.as_slice());
        let found = descend(parameters, inverse, &until, value, look);
        parameters = found.at;
        iterations += found.iterations;
        is_settled = found.is_settled;
        if is_last {
            break;
        }
        width = (width * config.shrink.clamp(0.05, 0.95)).max(config.last_width);
    }
    let problem = Mixtures::of(&y, &x, width, config.error);
    let own = problem.own(&x);
    let (mut value, _) = problem.value(parameters.as_slice());
    if !config.is_affine {
        value += problem.own(&y);
    }
    Some(GmmFit {
        map: map(&parameters),
        distance: ((value + own) / (2.0 * own)).max(0.0),
        iterations,
        is_settled,
    })
}

/// Mean and root mean square distance from it, m.
struct Extent {
    mean: Vector2<f64>,
    size: f64,
}

impl Extent {
    fn of(points: &[Point2<f64>]) -> Option<Self> {
        let count = points.len() as f64;
        let mean = points.iter().map(|p| p.coords).sum::<Vector2<f64>>() / count;
        let squares = points.iter().map(|p| (p.coords - mean).norm_squared());
        let size = (squares.sum::<f64>() / count).sqrt();
        (size > 0.0 && size.is_finite()).then_some(Self { mean, size })
    }
}

/// The linear map and the shift of (x, y, θ) or (x, y, a, b, c, d).
fn linear(parameters: &[f64]) -> (Matrix2<f64>, Vector2<f64>) {
    match *parameters {
        [x, y, turn] => {
            let (sin, cos) = sin_cos(turn);
            (Matrix2::new(cos, -sin, sin, cos), Vector2::new(x, y))
        }
        [x, y, a, b, c, d] => (Matrix2::new(a, b, c, d), Vector2::new(x, y)),
        _ => (Matrix2::identity(), Vector2::zeros()),
    }
}

/// f at one width.
struct Mixtures<'a> {
    moving: &'a [Point2<f64>],
    fixed: &'a [Point2<f64>],
    /// σ of g: √2 times that of the points.
    sigma: f64,
    error: f64,
    /// 1, x and y of each fixed point.
    weights: Vec<[f64; 3]>,
}

impl<'a> Mixtures<'a> {
    fn of(moving: &'a [Point2<f64>], fixed: &'a [Point2<f64>], width: f64, error: f64) -> Self {
        Self {
            moving,
            fixed,
            sigma: std::f64::consts::SQRT_2 * width,
            error,
            weights: weights(fixed),
        }
    }

    /// ΣΣ g of a cloud with itself, divided by the square of its size.
    fn own(&self, points: &[Point2<f64>]) -> f64 {
        let ones = vec![[1.0]; points.len()];
        let sums = gauss_transform(points, &ones, points, self.sigma, self.error, None);
        let count = points.len() as f64;
        sums.iter().map(|[sum]| sum).sum::<f64>() / (count * count)
    }

    fn moved(&self, parameters: &[f64]) -> Vec<Point2<f64>> {
        let (linear, shift) = linear(parameters);
        let moved = |p: &Point2<f64>| Point2::from(linear * p.coords + shift);
        self.moving.iter().map(moved).collect()
    }

    /// Σ g, Σ g x and Σ g y of the fixed points at each of these points.
    fn at(&self, moved: &[Point2<f64>]) -> Vec<[f64; 3]> {
        let (fixed, weights) = (self.fixed, &self.weights);
        gauss_transform(fixed, weights, moved, self.sigma, self.error, None)
    }

    /// For each moving point, the mean of the fixed points weighted by g, and the total weight.
    fn pulls(&self, parameters: &[f64]) -> Vec<(Vector2<f64>, Vector2<f64>, f64)> {
        let moved = self.moved(parameters);
        let sums = self.at(&moved);
        let heard = moved.iter().zip(sums).filter(|(_, [sum, ..])| *sum > 0.0);
        heard
            .map(|(p, [sum, x, y])| (p.coords, Vector2::new(x, y) / sum, sum))
            .collect()
    }

    /// The inverse of the Hessian of f by (x, y, θ), where f is convex; otherwise of an upper bound
    /// of it: -g(d) lies below the parabola that touches it, because it is concave in |d|². `None`
    /// for other parameters, and if the clouds are too far apart to affect each other.
    fn inverse_hessian(&self, parameters: &[f64]) -> Option<DMatrix<f64>> {
        let [hessian, above] = self.hessians(parameters)?;
        let inverse = (hessian.cholesky()).or_else(|| above.cholesky())?.inverse();
        Some(DMatrix::from_column_slice(3, 3, inverse.as_slice()))
    }

    /// The Hessian of f by (x, y, θ), and that of the parabola above it.
    fn hessians(&self, parameters: &[f64]) -> Option<[Matrix3<f64>; 2]> {
        let [x, y, _] = *parameters else {
            return None;
        };
        let moved = self.moved(parameters);
        let squares: Vec<_> = (self.fixed.iter())
            .map(|p| [1.0, p.x, p.y, p.x * p.x, p.x * p.y, p.y * p.y])
            .collect();
        let sums = gauss_transform(self.fixed, &squares, &moved, self.sigma, self.error, None);
        let scale = 1.0 / (self.sigma * self.sigma);
        let (mut hessian, mut above) = (Matrix3::zeros(), Matrix3::zeros());
        for (p, [sum, x_sum, y_sum, xx, xy, yy]) in moved.iter().zip(sums) {
            // Σ g d and Σ g d dᵀ of d = p - x_j.
            let toward = Vector2::new(x_sum, y_sum);
            let off = p.coords * sum - toward;
            let across = p.coords * toward.transpose();
            let spread = Matrix2::new(xx, xy, xy, yy) - across - across.transpose()
                + p.coords * p.coords.transpose() * sum;
            let arm = Vector2::new(p.x - x, p.y - y);
            let by = Matrix2x3::new(1.0, 0.0, -arm.y, 0.0, 1.0, arm.x);
            let touching = by.transpose() * by * sum;
            above += touching;
            hessian += touching - by.transpose() * spread * by * scale;
            // The second derivative of p by θ is -arm.
            hessian[(2, 2)] -= off.dot(&arm);
        }
        let factor = 2.0 * scale / (self.moving.len() as f64 * self.fixed.len() as f64);
        Some([hessian * factor, above * factor])
    }

    /// f and its gradient. For a rigid motion, without the constant sum of the moving cloud with
    /// itself.
    fn value(&self, parameters: &[f64]) -> (f64, Vec<f64>) {
        let (_, shift) = linear(parameters);
        let moved = self.moved(parameters);
        let (m, n) = (self.moving.len() as f64, self.fixed.len() as f64);
        let scale = 1.0 / (self.sigma * self.sigma);
        let (mut value, mut gradient) = (0.0, vec![0.0; parameters.len()]);
        let mut add = |moved: &[Point2<f64>], sums: &[[f64; 3]], factor: f64, is_own: bool| {
            for ((p, y), [sum, x_sum, y_sum]) in moved.iter().zip(self.moving).zip(sums) {
                value += factor * sum;
                // d g / d p = -(p - x) g / σ²; in the cloud's own sum each point occurs twice.
                let toward = Vector2::new(*x_sum, *y_sum) - p.coords * *sum;
                let twice = if is_own { 2.0 } else { 1.0 };
                let by_point = toward * (factor * scale * twice);
                let by = |direction: Vector2<f64>| by_point.dot(&direction);
                match gradient.as_mut_slice() {
                    [x, y_part, turn] => {
                        *x += by_point.x;
                        *y_part += by_point.y;
                        let arm = p.coords - shift;
                        *turn += by(Vector2::new(-arm.y, arm.x));
                    }
                    [x, y_part, a, b, c, d] => {
                        *x += by_point.x;
                        *y_part += by_point.y;
                        *a += by_point.x * y.x;
                        *b += by_point.x * y.y;
                        *c += by_point.y * y.x;
                        *d += by_point.y * y.y;
                    }
                    _ => {}
                }
            }
        };
        let sums = self.at(&moved);
        add(&moved, &sums, -2.0 / (m * n), false);
        if parameters.len() > 3 {
            let own = weights(&moved);
            let sums = gauss_transform(&moved, &own, &moved, self.sigma, self.error, None);
            add(&moved, &sums, 1.0 / (m * m), true);
        }
        (value, gradient)
    }
}

fn weights(points: &[Point2<f64>]) -> Vec<[f64; 3]> {
    points.iter().map(|p| [1.0, p.x, p.y]).collect()
}

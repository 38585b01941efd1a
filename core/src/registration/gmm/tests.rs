//! The distance compared with an integral over a grid, its gradient with differences, and clouds
//! whose motion is known.

use nalgebra::Point2;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::geom::Length;

fn cloud(count: usize, seed: u64) -> Vec<Point2<f64>> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut number = |most: f64| rng.random_range(-most..most);
    (0..count)
        .map(|_| Point2::new(number(1.5), number(1.0)))
        .collect()
}

const PARAMETERS: [&[f64]; 2] = [&[0.1, -0.2, 0.3], &[0.1, -0.2, 1.1, 0.2, -0.1, 0.8]];

/// f times 1 / 4πσ², and the sum of the fixed mixture with itself, is the integral of the squared
/// difference of both mixtures.
#[test]
fn the_distance_is_the_integral_of_the_squared_difference() {
    let (y, x, width) = (cloud(5, 1), cloud(7, 2), 0.3);
    for parameters in PARAMETERS {
        let problem = Mixtures::of(&y, &x, width, 1e-12);
        let (mut value, _) = problem.value(parameters);
        if parameters.len() == 3 {
            value += problem.own(&y);
        }
        let (linear, shift) = linear(parameters);
        let moved: Vec<_> = y
            .iter()
            .map(|p| Point2::from(linear * p.coords + shift))
            .collect();
        let density = |points: &[Point2<f64>], at: &Point2<f64>| {
            let scale = 1.0 / (2.0 * width * width);
            let sum: f64 = points
                .iter()
                .map(|p| libm::exp(-scale * (p - at).norm_squared()))
                .sum();
            sum * scale / std::f64::consts::PI / points.len() as f64
        };
        let (step, mut integral) = (0.02, 0.0);
        for i in -250..250 {
            for j in -250..250 {
                let at = Point2::new(step * f64::from(i), step * f64::from(j));
                let off = density(&moved, &at) - density(&x, &at);
                integral += off * off * step * step;
            }
        }
        let ours = (value + problem.own(&x)) / (4.0 * std::f64::consts::PI * width * width);
        assert!((ours - integral).abs() < 1e-6, "{ours} {integral}");
    }
}

#[test]
fn the_gradient_is_that_of_differences() {
    let (y, x) = (cloud(20, 3), cloud(30, 4));
    for width in [0.1, 0.5, 2.0] {
        for parameters in PARAMETERS {
            let problem = Mixtures::of(&y, &x, width, 1e-12);
            let (_, gradient) = problem.value(parameters);
            for (at, gradient) in gradient.iter().enumerate() {
                let moved = |by: f64| {
                    let mut moved = parameters.to_vec();
                    moved[at] += by;
                    problem.value(&moved).0
                };
                let numeric = (moved(1e-5) - moved(-1e-5)) / 2e-5;
                assert!(
                    (gradient - numeric).abs() < 1e-6,
                    "{width} {at}: {gradient} {numeric}"
                );
            }
        }
    }
}

#[test]
fn the_hessian_is_that_of_differences_and_the_parabola_lies_above() {
    // Some points are in both clouds, so f has a minimum where they lie on each other.
    let y = cloud(20, 3);
    let mut x = y.clone();
    x.extend(cloud(10, 4));
    let mut bends_up = [false; 2];
    for width in [0.1, 0.5, 2.0] {
        for at in [[0.1, -0.2, 0.3], [0.9, 0.4, -2.0], [0.0, 0.0, 0.0]] {
            let problem = Mixtures::of(&y, &x, width, 1e-12);
            let [hessian, above] = problem.hessians(&at).unwrap();
            for column in 0..3 {
                let gradient = |by: f64| {
                    let mut moved = at;
                    moved[column] += by;
                    problem.value(&moved).1
                };
                let (more, less) = (gradient(1e-5), gradient(-1e-5));
                for row in 0..3 {
                    let numeric = (more[row] - less[row]) / 2e-5;
                    let off = hessian[(row, column)] - numeric;
                    assert!(off.abs() < 1e-6, "{width} {row} {column}: {off}");
                }
            }
            // The inverse that is used always leads downhill.
            let inverse = problem.inverse_hessian(&at).unwrap();
            assert!(inverse.cholesky().is_some(), "{width} {at:?}");
            let up = hessian.cholesky().is_some();
            bends_up[usize::from(up)] = true;
            // The shift enters p linearly: there the parabola lies above in the plain sense.
            let over = (above - hessian).fixed_view::<2, 2>(0, 0).into_owned();
            assert!(over.symmetric_eigenvalues().min() > -1e-9, "{width} {at:?}");
        }
    }
    assert_eq!(bends_up, [true, true]);
}

#[test]
fn copies_are_laid_on_each_other() {
    let y = cloud(100, 5);
    let truth = Pose2::new(0.6, -0.4, 0.5);
    let x: Vec<_> = y.iter().map(|p| truth * *p).collect();
    for is_affine in [false, true] {
        let config = GmmConfig {
            is_affine,
            ..GmmConfig::default()
        };
        let found = register_mixtures(&y, &x, &Pose2::identity(), &config).unwrap();
        assert!(found.distance < 1e-4, "{found:?}");
        for (y, x) in y.iter().zip(&x) {
            assert!((found.map.apply(y) - x).length() < 1e-3, "{found:?}");
        }
    }
    // If it starts at the solution, it stays there.
    let found = register_mixtures(&y, &x, &truth, &GmmConfig::default()).unwrap();
    assert!(found.distance < 1e-9 && found.is_settled, "{found:?}");
}

#[test]
fn what_has_no_extent_has_no_motion() {
    let (none, some) = (vec![Point2::new(1.0, 2.0); 4], cloud(5, 6));
    let config = GmmConfig::default();
    assert!(register_mixtures(&none, &some, &Pose2::identity(), &config).is_none());
    assert!(register_mixtures(&some, &[], &Pose2::identity(), &config).is_none());
    let nan = [Point2::new(f64::NAN, 0.0), Point2::new(1.0, 0.0)];
    assert!(register_mixtures(&some, &nan, &Pose2::identity(), &config).is_none());
}

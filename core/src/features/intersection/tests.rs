use std::f64::consts::{FRAC_PI_2, PI, TAU};

use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::geom::{Line, sin_cos};

fn feature(alpha: f64, r: f64, cov: Matrix2<f64>) -> LineFeature {
    let line = Line::new(alpha, r);
    let (sin, cos) = sin_cos(line.alpha());
    let at = |t: f64| Point2::new(line.r() * cos - t * sin, line.r() * sin + t * cos);
    LineFeature {
        line,
        cov,
        ends: [at(-10.0), at(10.0)],
        seen_from_origin_side: true,
        first_beam: 0,
        last_beam: 9,
        n_points: 10,
        chi2: 8.0,
        by_heading: [Vector2::zeros(); 2],
    }
}

fn all() -> IntersectionConfig {
    IntersectionConfig {
        max_extension: f64::INFINITY,
        ..IntersectionConfig::default()
    }
}

/// A positive definite covariance with standard deviations `sa`, `sr` and correlation `c`.
fn cov(sa: f64, sr: f64, c: f64) -> Matrix2<f64> {
    Matrix2::new(sa * sa, c * sa * sr, c * sa * sr, sr * sr)
}

#[test]
fn corner_of_two_axis_parallel_walls_is_as_sure_as_each_wall_across() {
    // x = 2 and y = 3: at the corner t is 3 and -2.
    let (a, b) = (
        feature(0.0, 2.0, cov(0.001, 0.01, 0.0)),
        feature(FRAC_PI_2, 3.0, cov(0.002, 0.02, 0.0)),
    );
    let found = intersect(&a, &b, &all()).unwrap();
    assert!((found.position - Point2::new(2.0, 3.0)).norm() < 1e-12);
    assert!((found.cov[(0, 0)] - (9e-6 + 1e-4)).abs() < 1e-12);
    assert!((found.cov[(1, 1)] - (16e-6 + 4e-4)).abs() < 1e-12);
    assert!(found.cov[(0, 1)].abs() < 1e-12 && (found.angle - FRAC_PI_2).abs() < 1e-12);
}

#[test]
fn parallel_walls_and_far_crossings_are_refused_with_numbers() {
    let c = cov(0.001, 0.01, 0.0);
    let parallel = intersect(&feature(0.0, 2.0, c), &feature(PI, 1.0, c), &all());
    assert!(matches!(parallel, Err(IntersectionError::Parallel { angle, .. }) if angle < 1e-9));
    let far = intersect(
        &feature(0.0, 2.0, c),
        &feature(FRAC_PI_2, 13.0, c),
        &IntersectionConfig::default(),
    );
    assert!(
        matches!(far, Err(IntersectionError::Beyond { extension, .. }) if (extension - 3.0).abs() < 1e-9)
    );
    let nan = feature(f64::NAN, 1.0, c);
    assert!(intersect(&nan, &feature(0.0, 2.0, c), &all()).is_err());
}

#[test]
fn covariance_is_that_of_ten_thousand_noisy_pairs() {
    let normal = |rng: &mut ChaCha8Rng| {
        let (u, v): (f64, f64) = (rng.random(), rng.random());
        (-2.0 * libm::log(1.0 - u)).sqrt() * libm::cos(TAU * v)
    };
    let (ca, cb) = (cov(0.004, 0.01, 0.8), cov(0.003, 0.02, -0.5));
    let truth = intersect(&feature(0.3, 2.0, ca), &feature(1.5, 3.0, cb), &all()).unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let (n, mut nees, mut sum) = (10_000, 0.0, Matrix2::zeros());
    for _ in 0..n {
        let mut draw = |alpha: f64, r: f64, c: &Matrix2<f64>| {
            let l = c.cholesky().unwrap().l();
            let e = l * Vector2::new(normal(&mut rng), normal(&mut rng));
            feature(alpha + e.x, r + e.y, *c)
        };
        let seen = intersect(&draw(0.3, 2.0, &ca), &draw(1.5, 3.0, &cb), &all()).unwrap();
        let error = seen.position - truth.position;
        sum += error * error.transpose();
        nees += error.dot(&seen.cov.cholesky().unwrap().solve(&error));
    }
    let (mean, sampled) = (nees / f64::from(n), sum / f64::from(n));
    // The mean of 10 000 χ²(2) values has a standard deviation of 0.02.
    assert!((1.94..2.06).contains(&mean), "NEES {mean}");
    assert!((sampled - truth.cov).norm() < 0.05 * truth.cov.norm());
}

proptest! {
    #[test]
    fn covariance_is_that_of_numeric_derivatives(
        alpha in -PI..PI, turn in 0.4..2.7_f64, ra in 0.1..5.0_f64, rb in 0.1..5.0_f64, c in -0.9..0.9_f64,
    ) {
        let (ca, cb) = (cov(0.01, 0.03, c), cov(0.02, 0.01, -c));
        let at = |d: [f64; 4]| {
            let (a, b) = (feature(alpha + d[0], ra + d[1], ca), feature(alpha + turn + d[2], rb + d[3], cb));
            intersect(&a, &b, &all()).unwrap()
        };
        let h = 1e-6;
        let mut numeric = Matrix2::zeros();
        let column = |i: usize| {
            let (mut plus, mut minus) = ([0.0; 4], [0.0; 4]);
            plus[i] = h;
            minus[i] = -h;
            (at(plus).position - at(minus).position) / (2.0 * h)
        };
        for (first, c) in [(0, ca), (2, cb)] {
            for i in 0..2 {
                for j in 0..2 {
                    numeric += column(first + i) * column(first + j).transpose() * c[(i, j)];
                }
            }
        }
        let found = at([0.0; 4]);
        prop_assert!((found.cov - numeric).norm() < 1e-6 * numeric.norm().max(1e-3), "{} {numeric}", found.cov);
        prop_assert!(found.cov.cholesky().is_some());
    }
}

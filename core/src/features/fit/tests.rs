use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::geom::{Length, sin_cos, wrap};
use crate::points::fixture::{beam_along, normal};

fn beam(bearing: f64, range: f64, sigma: f64) -> Beam {
    let (sin, cos) = sin_cos(bearing);
    Beam {
        sigma,
        ..beam_along(0, Vector2::new(cos, sin), range, true)
    }
}

/// Bearings and true ranges of `n` beams on the line (α, r) from `from` to `to` along it.
fn wall(alpha: f64, r: f64, from: f64, to: f64, n: usize) -> Vec<(f64, f64)> {
    let (first, last) = (libm::atan2(from, r), libm::atan2(to, r));
    let bearing = |i: usize| first + (last - first) * i as f64 / (n - 1) as f64;
    (0..n)
        .map(|i| (alpha + bearing(i), r / libm::cos(bearing(i))))
        .collect()
}

fn exact(alpha: f64, r: f64, from: f64, to: f64) -> Vec<Beam> {
    let points = wall(alpha, r, from, to, 12);
    points.iter().map(|&(b, d)| beam(b, d, 0.01)).collect()
}

#[test]
fn clean_points_give_their_line_at_every_angle() {
    for alpha in [0.0, FRAC_PI_4, FRAC_PI_2, 3.0, PI, -3.0, -FRAC_PI_2, -0.1] {
        let fit = fit_line(&exact(alpha, 1.5, -0.7, 1.9), 0.0).unwrap();
        assert!(
            wrap(fit.line.alpha() - alpha).abs() < 1e-3,
            "{alpha}: {fit:?}"
        );
        assert!((fit.line.r() - 1.5).abs() < 1e-3);
        assert!((fit.length() - 2.6).abs() < 0.01);
        assert!(fit.seen_from_origin_side && fit.chi2 < 0.1);
    }
}

#[test]
fn covariance_of_a_wall_seen_head_on_from_afar_is_that_of_a_regression() {
    // Beams nearly parallel to the normal: var r̄ = σ²/n at the middle, var α = σ²/Σt².
    let beams = exact(0.3, 100.0, -1.0, 1.0);
    let fit = fit_line(&beams, 0.0).unwrap();
    let tangent = Vector2::new(-libm::sin(0.3), libm::cos(0.3));
    let t: Vec<f64> = beams
        .iter()
        .map(|b| tangent.dot(&b.end_in_robot.coords))
        .collect();
    let scatter: f64 = t.iter().map(|t| t * t).sum();
    assert!((fit.cov[(0, 0)] * scatter / 1e-4 - 1.0).abs() < 0.01);
    assert!((fit.cov[(1, 1)] * 12.0 / 1e-4 - 1.0).abs() < 0.01);
}

#[test]
fn line_behind_the_sensor_is_seen_from_the_other_side() {
    // The sensor is 0.1 m ahead of the origin, the wall runs between the two.
    let beams: Vec<_> = (-5..=5)
        .map(|i| {
            let end = Point2::new(0.05, 0.2 * f64::from(i));
            let origin = Point2::new(0.1, 0.0);
            Beam {
                origin_in_robot: origin,
                end_in_robot: end,
                range: (end - origin).length(),
                ..beam(0.0, 1.0, 0.001)
            }
        })
        .collect();
    let fit = fit_line(&beams, 0.0).unwrap();
    assert!((fit.line.r() - 0.05).abs() < 1e-3 && !fit.seen_from_origin_side);
}

#[test]
fn through_one_point_or_a_spot_goes_no_line() {
    assert_eq!(fit_line(&[beam(0.0, 1.0, 0.1)], 0.0), None);
    let spot = [beam(0.0, 1.0, 0.01), beam(0.0, 1.0, 0.01)];
    assert_eq!(fit_line(&spot, 0.0), None);
}

/// Average NEES and mean error in standard deviations over `seeds` noisy scans of one wall.
fn monte_carlo(
    truth: &[(f64, f64)],
    line: [f64; 2],
    sigma: f64,
    bearing_sigma: f64,
    seeds: u64,
) -> (f64, [f64; 2]) {
    let (mut nees, mut bias) = (0.0, [0.0; 2]);
    for seed in 0..seeds {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let beams: Vec<_> = truth
            .iter()
            .map(|&(b, d)| {
                // The sensor reports (b, d + noise); the true bearing differs.
                let range = d + sigma * normal(&mut rng);
                beam(b + bearing_sigma * normal(&mut rng), range, sigma)
            })
            .collect();
        let fit = fit_line(&beams, bearing_sigma).unwrap();
        let error = Vector2::new(wrap(fit.line.alpha() - line[0]), fit.line.r() - line[1]);
        nees += error.dot(&fit.cov.cholesky().unwrap().solve(&error));
        for axis in 0..2 {
            bias[axis] += error[axis] / fit.cov[(axis, axis)].sqrt();
        }
    }
    let n = seeds as f64;
    (nees / n, bias.map(|b| b / n))
}

#[test]
fn experiment_of_the_source_is_consistent_and_unbiased() {
    // TDK 2016 §4.1: α = 135°, r = 1.2388 m, σ = 0.1 m. The mean of 10 000 χ²(2) values has a
    // standard deviation of 0.02.
    let line = [3.0 * FRAC_PI_4, 1.2388];
    let truth = wall(line[0], line[1], -1.2, 1.5, 100);
    let (nees, bias) = monte_carlo(&truth, line, 0.1, 0.0, 10_000);
    println!("nees {nees:.3} bias {bias:?}");
    assert!((1.9..2.1).contains(&nees), "nees {nees}");
    assert!(bias.iter().all(|b| b.abs() < 0.1), "bias {bias:?} sigma");
}

#[test]
fn wall_seen_at_a_flat_angle_is_consistent_and_unbiased() {
    let line = [-1.0, 1.0];
    let truth = wall(line[0], line[1], 0.5, 4.0, 40);
    for bearing_sigma in [0.0, 0.002] {
        let (nees, bias) = monte_carlo(&truth, line, 0.02, bearing_sigma, 4_000);
        println!("nees {nees:.3} bias {bias:?}");
        assert!((1.85..2.15).contains(&nees), "nees {nees}");
        assert!(bias.iter().all(|b| b.abs() < 0.1), "bias {bias:?} sigma");
    }
}

proptest! {
    #[test]
    fn covariance_is_that_of_numeric_derivatives(
        alpha in -PI..PI, r in 0.3..5.0_f64, from in -3.0..-0.2_f64, to in 0.2..3.0_f64, seed in 0..1000_u64,
    ) {
        // Small noise, so that the scatter it adds is constant for the derivative.
        let (bearing_sigma, h) = (2e-6, 1e-7);
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let polar: Vec<(f64, f64, f64)> = wall(alpha, r, from, to, 9)
            .iter()
            .map(|&(b, d)| (b, d + 0.02 * normal(&mut rng), 1e-5 * (1.0 + rng.random::<f64>())))
            .collect();
        let fit = |nudged: usize, db: f64, dr: f64| {
            let beams: Vec<_> = polar
                .iter()
                .enumerate()
                .map(|(i, &(b, d, s))| if i == nudged { beam(b + db, d + dr, s) } else { beam(b, d, s) })
                .collect();
            fit_line(&beams, bearing_sigma).unwrap()
        };
        let mut numeric = Matrix2::zeros();
        for (i, &(_, _, sigma)) in polar.iter().enumerate() {
            for (db, dr, variance) in [(0.0, h, sigma * sigma), (h, 0.0, bearing_sigma * bearing_sigma)] {
                let (plus, minus) = (fit(i, db, dr).line, fit(i, -db, -dr).line);
                let column = Vector2::new(wrap(plus.alpha() - minus.alpha()), plus.r() - minus.r()) / (2.0 * h);
                numeric += column * column.transpose() * variance;
            }
        }
        let analytic = fit(99, 0.0, 0.0).cov;
        prop_assert!((analytic - numeric).length() < 1e-3 * numeric.length(), "{analytic} {numeric}");
    }
}

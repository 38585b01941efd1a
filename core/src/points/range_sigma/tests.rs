//! Estimates compared with the σ from which the noise was drawn, and their stated errors with many
//! repetitions.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;

impl SigmaFit {
    /// Standard deviation of σ at `range`, m.
    fn error_at(&self, range: f64) -> f64 {
        let terms = self.growth.terms(range);
        terms.dot(&(self.cov * terms)).sqrt()
    }
}
use crate::geom::Pose2;
use crate::robot::Stamp;

/// Beams from 0.5 to 8 m; σ = 0.01 + 0.004 ρ or 0.005 + 0.002 ρ²; some readings are lost, some
/// wrong.
fn scans(growth: Growth, outliers: f64, rng: &mut ChaCha8Rng) -> Vec<Scan> {
    let truth = truth(growth);
    let mut normal = || {
        // The sum of twelve uniform numbers has variance 1.
        let sum: f64 = (0..12).map(|_| rng.random::<f64>()).sum();
        (sum - 6.0, rng.random::<f64>())
    };
    let mut scan = || {
        let range = |beam: usize| 0.5 + 7.5 * beam as f64 / 200.0;
        let mut read = |beam| {
            let (noise, luck) = normal();
            if luck < outliers {
                return 0.3 + 9.0 * luck as f32;
            }
            if luck > 0.99 {
                return f32::NAN;
            }
            (range(beam) + truth.dot(&growth.terms(range(beam))) * noise) as f32
        };
        Scan {
            stamp: Stamp(0),
            robot_from_sensor: Pose2::identity(),
            bearings: vec![0.0; 200],
            ranges: (0..200).map(&mut read).collect(),
            sigmas: vec![0.01; 200],
            bearing_sigma: 0.0,
            max_range: 12.0,
            sweep: 0.0,
            qualities: vec![],
        }
    };
    (0..40).map(|_| scan()).collect()
}

fn truth(growth: Growth) -> Vector2<f64> {
    match growth {
        Growth::Linear => Vector2::new(0.01, 0.004),
        Growth::Square => Vector2::new(0.005, 0.002),
    }
}

#[test]
fn true_growth_is_found_and_the_stated_error_is_the_real_one() {
    for growth in [Growth::Linear, Growth::Square] {
        let runs = 200;
        let (mut nees, mut chi) = (0.0, 0.0);
        for seed in 0..runs {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let fit = estimate_sigma(&[&scans(growth, 0.0, &mut rng)], growth).unwrap();
            let error = fit.coefficients - truth(growth);
            nees += error.dot(&(fit.cov.try_inverse().unwrap() * error));
            chi += fit.chi_squared / (fit.bins.len() as f64 - 2.0);
        }
        let n = runs as f64;
        // Two degrees of freedom. Within a bin σ changes, and the sum of uniform numbers has short
        // tails: 25 %.
        assert!(
            (nees / n / 2.0 - 1.0).abs() < 0.25,
            "{growth:?}: NEES {}",
            nees / n
        );
        assert!((chi / n - 1.0).abs() < 0.25, "{growth:?}: χ² {}", chi / n);
    }
}

#[test]
fn outliers_are_skipped() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let fit = estimate_sigma(&[&scans(Growth::Linear, 0.01, &mut rng)], Growth::Linear);
    let fit = fit.unwrap();
    for range in [1.0, 4.0, 7.0] {
        let expect = 0.01 + 0.004 * range;
        assert!(
            (fit.at(range) / expect - 1.0).abs() < 0.1,
            "{range}: {}",
            fit.at(range)
        );
        assert!(fit.error_at(range) < 0.05 * expect);
    }
    let clipped: usize = fit.bins.iter().map(|b| b.clipped).sum();
    let all: usize = fit.bins.iter().map(|b| b.used + b.clipped).sum();
    let part = clipped as f64 / all as f64;
    assert!((0.005..0.03).contains(&part), "{part}");
}

#[test]
fn poor_recordings_are_refused() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let good = scans(Growth::Linear, 0.0, &mut rng);
    let message = |scans: &[Scan]| {
        estimate_sigma(&[scans], Growth::Linear)
            .unwrap_err()
            .to_string()
    };
    assert!(message(&[]).contains("0 bins"));
    assert!(message(&good[..2]).contains("0 bins"));
    let mut uneven = good.clone();
    uneven[7].ranges.pop();
    assert!(message(&uneven).starts_with("scan 7 has 199 beams and the first has 200"));
    let same = vec![good[0].clone(); 40];
    assert!(message(&same).contains("do not differ"));
}

#[test]
fn stretches_are_not_compared_with_one_another() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let here = scans(Growth::Linear, 0.0, &mut rng);
    // In the other stretches everything is 20 cm nearer, and they are long enough that one false
    // pair of scans would show.
    let mut there = scans(Growth::Linear, 0.0, &mut rng);
    for range in there.iter_mut().flat_map(|scan| &mut scan.ranges) {
        *range -= 0.2;
    }
    let stretches: Vec<&[Scan]> = here.chunks(2).chain(there.chunks(2)).collect();
    let fit = estimate_sigma(&stretches, Growth::Linear).unwrap();
    assert!(
        fit.bins.iter().all(|bin| bin.clipped == 0),
        "{:?}",
        fit.bins
    );
    for range in [1.0, 4.0, 7.0] {
        let error = (fit.at(range) - truth(Growth::Linear).dot(&Vector2::new(1.0, range))).abs();
        assert!(error < 4.0 * fit.error_at(range) + 2e-4, "{range}: {error}");
    }
}

#[test]
fn what_is_to_be_used_is_the_fit_and_never_nothing() {
    let mut rng = ChaCha8Rng::seed_from_u64(6);
    let fit = estimate_sigma(&[&scans(Growth::Linear, 0.0, &mut rng)], Growth::Linear).unwrap();
    let mut used = fit.to_use();
    assert!((used.at(3.0) - fit.at(3.0)).abs() < 1e-15);
    used.constant = -1.0;
    assert!(used.at(0.0) == used.least && used.least > 0.004, "{used:?}");
}

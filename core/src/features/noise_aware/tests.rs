use nalgebra::Vector2;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::features::columns::Noise;
use crate::points::fixture::{beam_along, normal};

/// A wall 1 m ahead of `n` points, 8 mm apart, with σ = 1 cm.
fn wall(n: u32, rng: &mut ChaCha8Rng) -> Columns {
    let half = 0.004 * f64::from(n);
    let beams: Vec<_> = (0..n)
        .map(|i| {
            let y = -half + 2.0 * half * f64::from(i) / f64::from(n - 1);
            let range = libm::hypot(1.0, y);
            let noisy = range + 0.01 * normal(rng);
            beam_along(i as usize, Vector2::new(1.0, y) / range, noisy, true)
        })
        .collect();
    let mut columns = Columns::default();
    columns.load(&beams, std::iter::once(0..beams.len()), Noise::default());
    columns
}

/// Share of true walls that the sum of step 1 alone would split.
fn split_rate(split_k: f64) -> f64 {
    let rule = NoiseAware {
        split_k,
        max_residual: f64::INFINITY,
    };
    let (mut splits, trials) = (0, 20_000_u32);
    for seed in 0..trials {
        let mut rng = ChaCha8Rng::seed_from_u64(u64::from(seed));
        let n = rng.random_range(10..100);
        let columns = wall(n, &mut rng);
        let whole = Piece::whole(&columns, 0..columns.len());
        splits += u32::from(rule.examine(&columns, &whole) != SplitTest::Line);
    }
    f64::from(splits) / f64::from(trials)
}

#[test]
fn split_rate_of_a_true_wall_falls_with_k_as_stated() {
    let rates = [1.0, 2.0, 3.0].map(split_rate);
    println!("split rates {rates:?}");
    // One in 8, 60 and 800, as the documentation of `split_k` says.
    assert!((1.0 / 10.0..1.0 / 7.0).contains(&rates[0]), "{rates:?}");
    assert!((1.0 / 80.0..1.0 / 45.0).contains(&rates[1]), "{rates:?}");
    assert!((1.0 / 1300.0..1.0 / 500.0).contains(&rates[2]), "{rates:?}");
}

#[test]
fn short_cut_of_the_test_changes_no_verdict() {
    // Bent by more and more: the sum as written decides each case.
    let rule = NoiseAware::default();
    let mut verdicts = [0; 2];
    for seed in 0..400 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let n = rng.random_range(10..90_u32);
        let columns = wall(n, &mut rng);
        let whole = Piece::whole(&columns, 0..columns.len());
        // A line that is off by some angle.
        let tilt = 0.002 * (seed % 100) as f64;
        let (normal, r) = (Vector2::new(libm::cos(tilt), libm::sin(tilt)), 1.0);
        let (mut sum, mut expected, mut variance, mut is_wild) = (0.0, 0.0, 0.0, false);
        for i in 0..columns.len() {
            let var = columns.variance(i, &normal);
            let d = (normal.dot(&columns.point(i).coords) - r).abs();
            sum += d;
            expected += (var * FRAC_2_PI).sqrt();
            variance += var * (1.0 - FRAC_2_PI);
            is_wild |= d * d > 4.5 * 4.5 * var;
        }
        let fits = sum < expected + 3.0 * variance.sqrt();
        let verdict = rule.test(&columns, whole.range(), (normal, r));
        assert_eq!(verdict == SplitTest::Bent, !fits, "seed {seed}");
        assert_eq!(verdict == SplitTest::Line, fits && !is_wild, "seed {seed}");
        verdicts[usize::from(fits)] += 1;
    }
    assert!(verdicts.iter().all(|&n| n > 50), "{verdicts:?}");
}

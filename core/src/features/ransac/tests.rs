use nalgebra::Point2;
use rand::SeedableRng;

use super::*;
use crate::features::columns::Noise;
use crate::points::fixture::hit;

#[test]
fn number_of_samples_is_that_of_the_formula() {
    let rule = Ransac::default();
    // Half of the points: 1 - u² = 0.75, log 0.01 / log 0.75 = 16.008.
    assert_eq!(rule.samples(0.5), 17.0);
    assert_eq!(rule.samples(1.0), 1.0);
    // Fischler & Bolles: with probability p no sample of N is free of outliers.
    for (u, confidence) in [(0.2, 0.9), (0.35, 0.99), (0.8, 0.999)] {
        let rule = Ransac { confidence, ..rule };
        let n = rule.samples(u);
        let missed = |n: f64| libm::pow(1.0 - u * u, n);
        assert!(missed(n) <= 1.0 - confidence && missed(n - 1.0) > 1.0 - confidence);
    }
}

/// A share of the points on a wall, the rest anywhere.
fn scattered(seed: u64, n: usize, share: f64) -> (Columns, usize) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let n_wall = (share * n as f64) as usize;
    let beams: Vec<_> = (0..n)
        .map(|i| {
            let y = 0.02 * i as f64;
            let x = match i < n_wall {
                true => 2.0,
                false => rng.random_range(3.0..9.0),
            };
            hit(i, Point2::new(x, y))
        })
        .collect();
    let mut columns = Columns::default();
    columns.load(&beams, std::iter::once(0..n), Noise::default());
    (columns, n_wall)
}

#[test]
fn wall_is_found_as_often_as_the_confidence_says() {
    // The number of samples is a promise: it fails in at most 1 - p of the cases.
    let mut found = 0;
    for seed in 0..400 {
        let (columns, n_wall) = scattered(seed, 100, 0.3);
        let rule = Ransac {
            confidence: 0.9,
            ..Ransac::default()
        };
        let mut rng = ChaCha8Rng::seed_from_u64(1000 + seed);
        let [a, b] = rule.best_pair(&columns, &(0..100), &mut rng).unwrap();
        found += usize::from(a < n_wall && b < n_wall);
    }
    // Three standard deviations below 0.9 of 400.
    assert!(found >= 342, "{found} of 400");
}

#[test]
fn walls_come_in_order_and_share_no_point() {
    // A zigzag of four walls, in one run.
    let at = |i: usize| {
        let (wall, step) = (i / 40, 0.03 * (i % 40) as f64);
        let x = 2.0 + if wall % 2 == 0 { step } else { 1.2 - step };
        Point2::new(x, 1.2 * wall as f64 + step)
    };
    let beams: Vec<_> = (0..160).map(|i| hit(i, at(i))).collect();
    for seed in 0..20 {
        let mut columns = Columns::default();
        columns.load(&beams, std::iter::once(0..160), Noise::default());
        let mut pieces = vec![];
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        Ransac::default().split(&mut columns, 0..160, 7, &mut rng, &mut pieces);
        let ranges: Vec<_> = pieces.iter().map(Piece::range).collect();
        assert_eq!(ranges.len(), 4, "{ranges:?}");
        for (wall, range) in ranges.iter().enumerate() {
            assert!(
                range.start.abs_diff(40 * wall) <= 1 && range.end.abs_diff(40 * wall + 40) <= 1,
                "{ranges:?}"
            );
        }
    }
}

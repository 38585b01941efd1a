//! Every way compared with the sum as written, at all bandwidths and errors.

use nalgebra::Point2;
use proptest::prelude::*;

use super::{TransformMethod, gauss_transform};

/// The sum as written.
fn plain(
    sources: &[Point2<f64>],
    weights: &[[f64; 2]],
    targets: &[Point2<f64>],
    sigma: f64,
) -> Vec<[f64; 2]> {
    let at = |target: &Point2<f64>| {
        let mut sums = [0.0; 2];
        for (source, weights) in sources.iter().zip(weights) {
            let value = libm::exp(-0.5 * (target - source).norm_squared() / (sigma * sigma));
            for (sum, weight) in sums.iter_mut().zip(weights) {
                *sum += weight * value;
            }
        }
        sums
    };
    targets.iter().map(at).collect()
}

fn points(most: usize) -> impl Strategy<Value = Vec<Point2<f64>>> {
    let point = (-5.0..5.0, -3.0..3.0).prop_map(|(x, y)| Point2::new(x, y));
    prop::collection::vec(point, 1..most)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn every_way_errs_by_no_more_than_was_asked_for(
        sources in points(80),
        targets in points(40),
        weights in prop::collection::vec([-1.0..1.0, 0.0..2.0], 80),
        log_sigma in -6.0..4.0_f64,
        log_error in -11.0..-1.0_f64,
    ) {
        let (sigma, error) = (libm::exp(log_sigma), libm::pow(10.0, log_error));
        let weights = &weights[..sources.len()];
        let truth = plain(&sources, weights, &targets, sigma);
        let total: [f64; 2] = [0, 1].map(|k| weights.iter().map(|w| w[k].abs()).sum());
        let ways = TransformMethod::ALL.map(|(_, way)| Some(way)).into_iter().chain([None]);
        for way in ways {
            let found = gauss_transform(&sources, weights, &targets, sigma, error, way);
            prop_assert_eq!(found.len(), targets.len());
            for (found, truth) in found.iter().zip(&truth) {
                for column in 0..2 {
                    let off = (found[column] - truth[column]).abs();
                    let most = (error + 1e-13) * total[column];
                    prop_assert!(off <= most, "{:?}: {} > {}", way, off, most);
                }
            }
        }
    }
}

#[test]
fn nothing_comes_of_nothing() {
    let one = [Point2::new(1.0, 2.0)];
    for (_, way) in TransformMethod::ALL {
        let none = gauss_transform::<1>(&[], &[], &one, 0.1, 1e-6, Some(way));
        assert_eq!(none, vec![[0.0]]);
        assert!(gauss_transform(&one, &[[1.0]], &[], 0.1, 1e-6, Some(way)).is_empty());
        // With a bandwidth of 0 there is no Gaussian.
        let flat = gauss_transform(&one, &[[1.0]], &one, 0.0, 1e-6, Some(way));
        assert_eq!(flat, vec![[0.0]]);
        let far = [Point2::new(1e6, -1e6)];
        let here = gauss_transform(&far, &[[2.0]], &far, 0.1, 1e-6, Some(way));
        assert!((here[0][0] - 2.0).abs() < 1e-5, "{way:?}: {here:?}");
    }
}

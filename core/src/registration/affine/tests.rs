//! Known maps; symmetric clouds; invalid input.

use nalgebra::{Matrix2, Point2, Vector2};
use proptest::prelude::*;
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::geom::Length;

fn maps() -> impl Strategy<Value = AffineMap> {
    let number = -3.0..3.0_f64;
    let four = [number.clone(), number.clone(), number.clone(), number];
    (four, -50.0..50.0_f64, -50.0..50.0_f64)
        .prop_map(|([a, b, c, d], x, y)| AffineMap {
            linear: Matrix2::new(a, b, c, d),
            shift: Vector2::new(x, y),
        })
        .prop_filter("of full rank", |map| map.linear.determinant().abs() > 0.1)
}

fn clouds() -> impl Strategy<Value = Vec<Point2<f64>>> {
    let point = (-4.0..4.0_f64, -2.0..6.0_f64).prop_map(|(x, y)| Point2::new(x, y));
    proptest::collection::vec(point, 12..80)
}

proptest! {
    #[test]
    fn a_copy_in_another_order_is_found_to_the_last_digits(
        map in maps(), cloud in clouds(), seed in 0..1000_u64,
    ) {
        let mut copy: Vec<_> = cloud.iter().map(|p| map.apply(p)).collect();
        copy.shuffle(&mut ChaCha8Rng::seed_from_u64(seed));
        for (name, method) in AffineMethod::ALL {
            let fit = register_affine(&cloud, &copy, method);
            prop_assert!(fit.is_ok(), "{name}: {fit:?}");
            let fit = fit.unwrap();
            let off = |p: &Point2<f64>| (fit.map.apply(p) - map.apply(p)).length();
            let worst = cloud.iter().map(off).fold(0.0, f64::max);
            prop_assert!(worst < 1e-7, "{name}: {worst} m, {fit:?}");
            prop_assert!(fit.disagreement < 1e-6, "{name}: {fit:?}");
        }
    }

    #[test]
    fn whatever_is_asked_is_answered_or_refused(
        first in proptest::collection::vec((any::<f64>(), any::<f64>()), 0..8),
        second in proptest::collection::vec((-1e6..1e6_f64, -1.0..1.0_f64), 0..8),
    ) {
        let points = |all: &[(f64, f64)]| -> Vec<_> {
            all.iter().map(|&(x, y)| Point2::new(x, y)).collect()
        };
        let (first, second) = (points(&first), points(&second));
        for (_, method) in AffineMethod::ALL {
            for (from, to) in [(&first, &second), (&second, &first), (&second, &second)] {
                if let Ok(fit) = register_affine(from, to, method) {
                    prop_assert!(fit.map.linear.iter().all(|v| v.is_finite()));
                }
            }
        }
    }
}

/// Corners of a regular polygon, each with a satellite outside.
fn star(corners: u32) -> Vec<Point2<f64>> {
    let corner = |at: u32| {
        let angle = std::f64::consts::TAU * f64::from(at) / f64::from(corners);
        let along = crate::geom::unit_vector(angle);
        [Point2::from(along), Point2::from(1.4 * along)]
    };
    (0..corners).flat_map(corner).collect()
}

#[test]
fn a_square_has_no_third_moments_but_a_fourth_power_sum() {
    let map = AffineMap {
        linear: Matrix2::new(1.0, 0.4, -0.2, 2.0),
        shift: Vector2::new(3.0, -1.0),
    };
    let square = star(4);
    let copy: Vec<_> = square.iter().map(|p| map.apply(p)).collect();
    let fit = |method| register_affine(&square, &copy, method);
    assert_eq!(fit(AffineMethod::Moments), Err(AffineError::Symmetric));
    // Any of the cloud's own rotations and reflections is right: each point falls on one of the
    // copy.
    let found = fit(AffineMethod::PowerSums).unwrap();
    for point in &square {
        let at = found.map.apply(point);
        let nearest = copy.iter().map(|q| (q - at).length());
        assert!(nearest.fold(f64::INFINITY, f64::min) < 1e-9);
    }
}

#[test]
fn clouds_that_fix_no_map_are_refused_in_words() {
    let good = star(5);
    let line: Vec<_> = (0..9).map(|i| Point2::new(f64::from(i), 2.0)).collect();
    let mut broken = good.clone();
    broken[3].y = f64::NAN;
    let refused = |from: &[_], to: &[_]| {
        let found = register_affine(from, to, AffineMethod::PowerSums);
        found.unwrap_err().to_string()
    };
    assert_eq!(
        refused(&good[..2], &good),
        "the first cloud has 2 points, expected at least 3"
    );
    assert_eq!(
        refused(&good, &[]),
        "the second cloud has 0 points, expected at least 3"
    );
    assert_eq!(
        refused(&good, &line),
        "the second cloud lies on a line: an affine map across it is not fixed"
    );
    assert_eq!(
        refused(&[good[0]; 5], &good),
        "the first cloud lies on a line: an affine map across it is not fixed"
    );
    assert_eq!(
        refused(&broken, &good),
        "the first cloud: point 3 is not finite, or farther away than 1e6 m"
    );
    assert_eq!(
        refused(&star(40), &star(40)),
        "the clouds are too symmetric: their moments do not tell how one is turned"
    );
}

#[test]
fn a_cloud_that_shows_other_things_disagrees() {
    let cloud: Vec<_> = (0..40)
        .map(|i| Point2::new(f64::from(i % 7), f64::from(i * i % 11)))
        .collect();
    for (name, method) in AffineMethod::ALL {
        let whole = register_affine(&cloud, &cloud, method).unwrap();
        let half = register_affine(&cloud, &cloud[..20], method).unwrap();
        assert!(whole.disagreement < 1e-9, "{name}: {whole:?}");
        assert!(half.disagreement > 0.05, "{name}: {half:?}");
    }
}

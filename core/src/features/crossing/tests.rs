use std::f64::consts::PI;

use proptest::prelude::*;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::points::fixture::normal;

const COV: Matrix2<f64> = Matrix2::new(4e-5, 1e-5, 1e-5, 9e-5);

fn place(alpha: [f64; 2], r: [f64; 2]) -> Point2<f64> {
    let [a, b] = [0, 1].map(|i| (Line::new(alpha[i], r[i]), COV));
    crossing([a, b]).unwrap().0
}

fn feature(line: Line, from: f64, to: f64, beam: usize) -> LineFeature {
    let (foot, along) = (line.normal() * line.r(), line.normal());
    let along = Vector2::new(-along.y, along.x);
    LineFeature {
        line,
        cov: COV,
        ends: [from, to].map(|t| Point2::from(foot + along * t)),
        seen_from_origin_side: true,
        first_beam: beam,
        last_beam: beam + 9,
        n_points: 10,
        chi2: 8.0,
        by_heading: [Vector2::zeros(); 2],
    }
}

proptest! {
    #[test]
    fn crossing_lies_on_both_and_its_covariance_is_that_of_numeric_derivatives(
        a in -PI..PI, turn in 0.3..2.8_f64, ra in 0.1..9.0_f64, rb in 0.1..9.0_f64,
        va in 1e-6..1e-3_f64, vr in 1e-6..1e-3_f64, part in -0.9..0.9_f64,
    ) {
        let cov = Matrix2::new(va, part * (va * vr).sqrt(), part * (va * vr).sqrt(), vr);
        let lines = [Line::new(a, ra), Line::new(a + turn, rb)];
        let (p, found) = crossing([(lines[0], cov), (lines[1], COV)]).unwrap();
        for line in lines {
            prop_assert!(line.signed_distance(p).abs() < 1e-9);
        }
        let h = 1e-6;
        let alpha = lines.map(|l| l.alpha());
        let r = lines.map(|l| l.r());
        let mut expected = Matrix2::zeros();
        for (i, own) in [cov, COV].into_iter().enumerate() {
            let by = |dalpha: f64, dr: f64| {
                let (mut alpha, mut r) = (alpha, r);
                alpha[i] += dalpha;
                r[i] += dr;
                place(alpha, r)
            };
            let j = Matrix2::from_columns(&[(by(h, 0.0) - by(-h, 0.0)) / (2.0 * h), (by(0.0, h) - by(0.0, -h)) / (2.0 * h)]);
            expected += j * own * j.transpose();
        }
        prop_assert!((found - expected).norm_squared().sqrt() <= 1e-5 * expected.norm_squared().sqrt(), "{found} against {expected}");
    }
}

#[test]
fn covariance_is_honest() {
    // Lines drawn from their covariance; the error of the crossing has 2 degrees of freedom.
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let true_lines = [(0.4, 2.0), (1.7, 1.5)];
    let truth = place([0.4, 1.7], [2.0, 1.5]);
    let chol = COV.cholesky().unwrap().l();
    let n = 4000;
    let mut sum = 0.0;
    for _ in 0..n {
        let drawn = true_lines.map(|(alpha, r)| {
            let e = chol * Vector2::new(normal(&mut rng), normal(&mut rng));
            (Line::new(alpha + e.x, r + e.y), COV)
        });
        let (p, cov) = crossing(drawn).unwrap();
        sum += (p - truth).dot(&cov.cholesky().unwrap().solve(&(p - truth)));
    }
    let mean = sum / f64::from(n);
    // Four standard errors, 2 / √4000 each.
    assert!((mean - 2.0).abs() < 0.13, "mean NEES {mean}");
}

#[test]
fn only_near_walls_that_cross_clearly_have_a_corner() {
    // Walls x = 2 and y = 1.
    let found = |a: LineFeature, b: LineFeature| {
        let mut found = vec![];
        crossings(&[a, b], &CrossingConfig::default(), &mut found);
        found
    };
    let x = |to: f64| feature(Line::new(0.0, 2.0), -1.0, to, 0);
    let y = feature(Line::new(FRAC_PI_2, 1.0), -1.8, 0.0, 10);
    let corner = found(x(0.9), y);
    assert_eq!(corner.len(), 1);
    assert!((corner[0].position - Point2::new(2.0, 1.0)).length() < 1e-12);
    assert!(corner[0].confidence > 0.999 && corner[0].beams == [0, 19]);
    // The wall ends 40 cm earlier; a door, not a corner.
    assert!(found(x(0.6), y).is_empty());
    // Nearly parallel, and parallel.
    assert!(found(x(0.9), feature(Line::new(0.3, 2.2), -1.0, 1.0, 10)).is_empty());
    assert!(found(x(0.9), feature(Line::new(0.0, 2.1), -1.0, 1.0, 10)).is_empty());
    assert!(crossing([(Line::new(1.0, 2.0), COV), (Line::new(1.0, 3.0), COV)]).is_none());
}

//! Compared with (1.45)-(1.53) as written, with dense matrices and an SVD.

use nalgebra::{DMatrix, Matrix2, Point2, Vector2};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::posterior::{Near, Posterior, Pulls};
use super::*;
use crate::geom::{Length, Pose2};

fn cloud(count: usize, seed: u64) -> Vec<Point2<f64>> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut number = |most: f64| rng.random_range(-most..most);
    (0..count)
        .map(|_| Point2::new(number(1.5), number(1.0)))
        .collect()
}

/// P as written, one row per moving point.
fn plain(y: &[Point2<f64>], x: &[Point2<f64>], variance: f64, w: f64) -> DMatrix<f64> {
    let c = 2.0 * std::f64::consts::PI * variance * w / (1.0 - w) * y.len() as f64 / x.len() as f64;
    let k = DMatrix::from_fn(y.len(), x.len(), |m, n| {
        libm::exp(-(x[n] - y[m]).norm_squared() / (2.0 * variance))
    });
    let sums: Vec<f64> = k.column_iter().map(|column| column.sum() + c).collect();
    DMatrix::from_fn(y.len(), x.len(), |m, n| k[(m, n)] / sums[n])
}

#[test]
fn sums_of_the_posterior_are_those_of_the_dense_matrix() {
    for (m, n, variance) in [
        (17, 30, 1.0),
        (40, 25, 0.01),
        (60, 60, 1e-4),
        (1500, 1400, 0.5),
    ] {
        let (mut y, x) = (cloud(m, 1), cloud(n, 2));
        let mut near = None;
        // The neighbours are kept where points hardly move, and searched again where they do.
        for step in [0.0, 1e-4, 0.1] {
            for point in &mut y {
                point.x += step;
            }
            is_like_the_dense_matrix(&y, &x, variance, &mut near);
        }
    }
}

fn is_like_the_dense_matrix(
    y: &[Point2<f64>],
    x: &[Point2<f64>],
    variance: f64,
    near: &mut Option<Near>,
) {
    let m = y.len();
    let config = CpdConfig::default();
    let found = Posterior::of(y, x, variance, &config, near);
    let p = plain(y, x, variance, config.outliers);
    assert!(
        (found.total - p.sum()).abs() < 1e-4 * p.sum().max(1e-3),
        "{m} {variance}"
    );
    for (row, owed) in p.row_iter().zip(&found.of_moving) {
        let place: Vector2<f64> = row.iter().zip(x).map(|(p, x)| x.coords * *p).sum();
        assert!(
            (owed.part - row.sum()).abs() < 2e-4,
            "{m} {variance}: {}",
            owed.part
        );
        assert!((owed.place - place).length() < 2e-4, "{m} {variance}");
    }
    for (column, share) in p.column_iter().zip(&found.of_fixed) {
        assert!((column.sum() - share).abs() < 1e-4, "{m} {variance}");
    }
    let Pulls::OfFixed(pulls) = Pulls::of(y, x, variance, &config, near) else {
        return;
    };
    for ((column, x), pull) in p.column_iter().zip(x).zip(&pulls) {
        let (mut off, mut spread) = (Vector2::zeros(), Matrix2::zeros());
        for (p, y) in column.iter().zip(y) {
            off += (y - x) * *p;
            spread += (y - x) * (y - x).transpose() * *p;
        }
        assert!((column.sum() - pull.part).abs() < 1e-4, "{m} {variance}");
        // Little is left out by ignoring distant points, but they lie up to 10 σ away.
        let most = if near.is_some() { 10.0 } else { 1.0 };
        let error = (off - pull.off).length() / variance.sqrt();
        assert!(error < 1e-4 * most, "{m} {variance}: {error}");
        let error = (spread - pull.spread).amax() / variance;
        assert!(error < 1e-4 * most * most, "{m} {variance}: {error}");
    }
}

#[test]
fn what_was_near_is_kept_while_points_hardly_move() {
    let (mut y, x) = (cloud(300, 1), cloud(300, 2));
    let config = CpdConfig::default();
    let mut near = None;
    for (step, variance, is_kept) in [
        (0.0, 1e-4, true),
        (1e-4, 1e-4, true),
        (0.0, 0.95e-4, true),
        (2e-3, 1e-4, false),
        (0.0, 0.5e-4, false),
        (0.0, 1e-4, false),
    ] {
        for point in &mut y {
            point.x += step;
        }
        let holds = |near: &Near| near.holds(&y, f64::sqrt(variance));
        let held = near.as_ref().is_none_or(holds);
        assert_eq!(held, is_kept, "{step} {variance}");
        Posterior::of(&y, &x, variance, &config, &mut near);
        assert!(near.is_some());
    }
}

#[test]
fn motions_are_those_of_the_closed_forms() {
    let (y, x) = (cloud(20, 3), cloud(25, 4));
    let config = CpdConfig::default();
    let both = Pulls::OfBoth(Posterior::of(&y, &x, 0.3, &config, &mut None));
    let of_fixed = Pulls::of(&y, &x, 0.3, &config, &mut None);
    assert!(matches!(of_fixed, Pulls::OfFixed(_)));
    let p = plain(&y, &x, 0.3, config.outliers);
    let matrix = |points: &[Point2<f64>]| DMatrix::from_fn(points.len(), 2, |i, k| points[i][k]);
    let (xs, ys) = (matrix(&x), matrix(&y));
    let total = p.sum();
    let mean = |points: &DMatrix<f64>, weights: Vec<f64>| {
        let weights = DMatrix::from_vec(1, weights.len(), weights);
        (weights * points / total).transpose()
    };
    let by_x: Vec<f64> = p.column_iter().map(|c| c.sum()).collect();
    let by_y: Vec<f64> = p.row_iter().map(|r| r.sum()).collect();
    let (mx, my) = (mean(&xs, by_x.clone()), mean(&ys, by_y.clone()));
    let off = |points: &DMatrix<f64>, mean: &DMatrix<f64>| {
        DMatrix::from_fn(points.nrows(), 2, |i, k| points[(i, k)] - mean[k])
    };
    let (xh, yh) = (off(&xs, &mx), off(&ys, &my));
    let a = xh.transpose() * p.transpose() * &yh;
    let diagonal = |v: &[f64]| DMatrix::from_diagonal(&nalgebra::DVector::from_row_slice(v));
    let spread = yh.transpose() * diagonal(&by_y) * &yh;
    let square = (xh.transpose() * diagonal(&by_x) * &xh).trace();
    // (1.47): R = U C Vᵀ.
    let svd = a.clone().svd(true, true);
    let (u, vt) = (svd.u.unwrap(), svd.v_t.unwrap());
    let c = DMatrix::from_row_slice(2, 2, &[1.0, 0.0, 0.0, (&u * &vt).determinant()]);
    let r = u * c * vt;
    let dense = |m: &DMatrix<f64>| Matrix2::new(m[(0, 0)], m[(0, 1)], m[(1, 0)], m[(1, 1)]);
    for pulls in [both, of_fixed] {
        let sums = Sums::of(&y, &x, &pulls);
        let (linear, shift, variance) = sums.rigid(true).unwrap();
        let s = (a.transpose() * &r).trace() / spread.trace();
        assert!((linear - dense(&(&r * s))).length() < 1e-4);
        let t = &mx - &r * s * &my;
        assert!((shift - Vector2::new(t[0], t[1])).length() < 1e-4);
        let expected = (square - s * (a.transpose() * &r).trace()) / (2.0 * total);
        assert!((variance - expected).abs() < 1e-4);
        let (linear, _, variance) = sums.affine().unwrap();
        let b = &a * spread.clone().try_inverse().unwrap();
        assert!((linear - dense(&b)).length() < 1e-4);
        let expected = (square - (&a * b.transpose()).trace()) / (2.0 * total);
        assert!((variance - expected).abs() < 1e-4);
    }
}

/// Clouds that are copies end up on each other, to within single precision and the width at which
/// the iteration ends.
#[test]
fn copies_drift_onto_each_other() {
    let y = cloud(150, 5);
    let motions = [
        (CpdKind::Rigid, Matrix2::new(0.8, -0.6, 0.6, 0.8)),
        (CpdKind::Affine, Matrix2::new(1.15, 0.25, -0.1, 0.85)),
    ];
    for (kind, linear) in motions {
        let shift = Vector2::new(3.0, -2.0);
        let x: Vec<_> = y
            .iter()
            .map(|p| Point2::from(linear * p.coords + shift))
            .collect();
        let found = drift(&y, &x, kind, &CpdConfig::default()).unwrap();
        assert!(found.is_settled, "{kind:?}: {found:?}");
        for (moved, x) in found.moved.iter().zip(&x) {
            assert!((moved - x).length() < 2e-3, "{kind:?}: {moved} {x}");
        }
        let map = found.map.unwrap();
        for (y, moved) in y.iter().zip(&found.moved) {
            assert!((map.apply(y) - moved).length() < 1e-9);
        }
    }
}

/// The same affine pair takes 45 iterations, longer than Pilch waits.
#[test]
fn what_is_found_late_has_failed_where_that_is_asked_for() {
    let y = cloud(150, 5);
    let linear = Matrix2::new(1.15, 0.25, -0.1, 0.85);
    let x: Vec<_> = y.iter().map(|p| Point2::from(linear * p.coords)).collect();
    let found = drift(&y, &x, CpdKind::Affine, &CpdConfig::pilch()).unwrap();
    assert!(!found.is_settled && found.iterations == 30);
}

#[test]
fn a_bent_curve_is_bent_onto_another() {
    let curve: Vec<_> = (0..80).map(|i| 0.05 * f64::from(i) - 2.0).collect();
    let y: Vec<_> = curve.iter().map(|t| Point2::new(*t, 0.2 * t * t)).collect();
    let x: Vec<_> = (curve.iter())
        .map(|t| Point2::new(*t, 0.2 * t * t + 0.3 * libm::sin(1.5 * t)))
        .collect();
    let found = drift(&y, &x, CpdKind::NonRigid, &CpdConfig::default()).unwrap();
    assert!(found.map.is_none());
    let off = |points: &[Point2<f64>]| {
        let nearest = |p: &Point2<f64>| {
            x.iter()
                .map(|x| (x - p).length())
                .fold(f64::INFINITY, f64::min)
        };
        points.iter().map(nearest).sum::<f64>() / points.len() as f64
    };
    assert!(
        off(&found.moved) < 0.2 * off(&y),
        "{} {}",
        off(&found.moved),
        off(&y)
    );
}

#[test]
fn a_rigid_motion_keeps_lengths_and_outliers_do_not_pull() {
    let y = cloud(200, 7);
    let truth = Pose2::new(0.2, -0.1, 0.3);
    let mut x: Vec<_> = y.iter().map(|p| truth * *p).collect();
    x.extend(cloud(40, 8).into_iter().map(|p| p * 1.2));
    let found = drift(&y, &x, CpdKind::Rigid, &CpdConfig::default()).unwrap();
    let map = found.map.unwrap();
    assert!((map.linear.determinant() - 1.0).abs() < 1e-12);
    for p in &y {
        assert!((map.apply(p) - truth * *p).length() < 0.01);
    }
}

#[test]
fn what_is_no_cloud_is_refused() {
    let config = CpdConfig::default();
    let (one, some) = (cloud(1, 9), cloud(10, 10));
    let few = drift(&one, &some, CpdKind::Rigid, &config).unwrap_err();
    assert_eq!(
        few.to_string(),
        "the moving cloud has 1 points, expected at least 2"
    );
    let mut broken = some.clone();
    broken[3].y = f64::NAN;
    let error = drift(&some, &broken, CpdKind::Affine, &config).unwrap_err();
    assert_eq!(error.to_string(), "the fixed cloud: point 3 is not finite");
    let many = cloud(MOST_NON_RIGID + 1, 11);
    assert!(drift(&many, &some, CpdKind::NonRigid, &config).is_err());
    let same = vec![Point2::new(1.0, 1.0); 5];
    assert_eq!(
        drift(&same, &same, CpdKind::Rigid, &config),
        Err(CpdError::NoExtent)
    );
    // Points that coincide with others count like any other points.
    let mut doubled = some.clone();
    doubled.extend(some.iter().copied());
    assert!(drift(&doubled, &some, CpdKind::Rigid, &config).is_ok());
}

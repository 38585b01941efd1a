use std::f64::consts::PI;

use nalgebra::Matrix3;
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::geom::{Pose2, pose_cov};
use crate::points::fixture::normal;

fn point(x: f64, y: f64, sigma: f64, kind: PointKind) -> PointFeature {
    PointFeature {
        position: Point2::new(x, y),
        cov: Matrix2::from_diagonal_element(sigma * sigma),
        kind,
        confidence: 1.0,
        beams: [0, 0],
    }
}

/// Points anywhere in a room, some of which are in both scans; the truth is the first `common`.
fn scans(
    seed: u64,
    pose: &Pose2,
    common: usize,
    others: usize,
) -> (Vec<PointFeature>, Vec<PointFeature>) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let kinds = [PointKind::Corner, PointKind::Spike, PointKind::Crossing];
    let draw = |i: usize, rng: &mut ChaCha8Rng| {
        let (x, y) = (rng.random_range(-4.0..4.0), rng.random_range(-4.0..4.0));
        point(x, y, 0.01, kinds[i % 3])
    };
    let world: Vec<_> = (0..common).map(|i| draw(i, &mut rng)).collect();
    let noisy = |p: &PointFeature, rng: &mut ChaCha8Rng| PointFeature {
        position: p.position + Vector2::new(normal(rng), normal(rng)) * 0.01,
        ..*p
    };
    let mut before: Vec<_> = world.iter().map(|p| noisy(p, &mut rng)).collect();
    let now = world.iter().map(|p| PointFeature {
        position: *pose * p.position,
        ..*p
    });
    let mut now: Vec<_> = now.map(|p| noisy(&p, &mut rng)).collect();
    before.extend((0..others).map(|i| draw(i, &mut rng)));
    now.extend((0..others).map(|i| draw(i, &mut rng)));
    (before, now)
}

fn with(method: PointMatching) -> PointMatchConfig {
    PointMatchConfig {
        method,
        ..PointMatchConfig::default()
    }
}

#[test]
fn relations_find_every_point_again_after_any_move() {
    let (mut right, mut wrong) = (0, 0);
    for seed in 0..60 {
        let mut rng = ChaCha8Rng::seed_from_u64(1000 + seed);
        let pose = Pose2::new(
            rng.random_range(-9.0..9.0),
            rng.random_range(-9.0..9.0),
            rng.random_range(-PI..PI),
        );
        let (before, now) = scans(seed, &pose, 9, 4);
        // The given motion is useless.
        let told = PoseEstimate::exact(Pose2::identity());
        for pair in match_points(&before, &now, &told, &with(PointMatching::Relations)) {
            let is_right = pair.before == pair.now && pair.now < 9;
            right += usize::from(is_right);
            wrong += usize::from(!is_right);
        }
    }
    println!("{right} of 540 right, {wrong} wrong");
    assert!(
        right > 500 && wrong < 10,
        "{right} of 540 right, {wrong} wrong"
    );
}

#[test]
fn equal_placements_are_no_placement() {
    // Five equal pillars in a row: shifted by one, four of them fit too, but five do not.
    let pillar = PointKind::Circle {
        radius: 0.2,
        var_radius: 1e-4,
    };
    let row = |from: i32, n: i32| -> Vec<_> {
        (from..from + n)
            .map(|i| point(f64::from(i), 0.0, 0.01, pillar))
            .collect()
    };
    let told = PoseEstimate::exact(Pose2::identity());
    let found = |before: &[PointFeature], now: &[PointFeature]| {
        match_points(before, now, &told, &with(PointMatching::Relations)).len()
    };
    // As it is, or turned by half a turn: two placements for all five.
    assert_eq!(found(&row(0, 5), &row(0, 5)), 0);
    // With something beside the row there is only one.
    let beside = [point(1.0, 2.0, 0.01, PointKind::Corner)];
    let asymmetric = [row(0, 5), beside.to_vec()].concat();
    assert_eq!(found(&asymmetric, &asymmetric), 6);
    // A row of six seen from one end and from the other: the shift is unknown.
    assert_eq!(found(&row(0, 5), &row(1, 5)), 0);
    // Too few to be sure.
    assert_eq!(found(&asymmetric[2..5], &asymmetric[2..5]), 0);
}

#[test]
fn what_is_of_another_kind_or_size_is_another_point() {
    let told = PoseEstimate {
        pose: Pose2::identity(),
        cov: pose_cov(0.1, 0.05),
    };
    let circle = |radius| PointKind::Circle {
        radius,
        var_radius: 1e-4,
    };
    let is_same = |a: PointKind, b: PointKind| {
        let [x, y] = [a, b].map(|kind| [point(1.0, 1.0, 0.02, kind)]);
        [PointMatching::Exhaustive, PointMatching::Nearest]
            .map(|method| match_points(&x, &y, &told, &with(method)).len())
    };
    assert_eq!(is_same(PointKind::Corner, PointKind::Corner), [1, 1]);
    assert_eq!(is_same(PointKind::Corner, PointKind::Crossing), [0, 0]);
    assert_eq!(is_same(circle(0.2), circle(0.22)), [1, 1]);
    assert_eq!(is_same(circle(0.2), circle(0.3)), [0, 0]);
}

#[test]
fn distance_counts_what_is_not_known_of_the_motion() {
    // d² of the right pair is χ² with 2 degrees of freedom, motion and points drawn as said.
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    let cov = Matrix3::new(4e-4, 1e-4, 0.0, 1e-4, 9e-4, 2e-4, 0.0, 2e-4, 4e-4);
    let root = cov.cholesky().unwrap().l();
    let truth = Pose2::new(0.3, -0.2, 0.7);
    let n = 4000;
    let mut sum = 0.0;
    for _ in 0..n {
        let error =
            root * nalgebra::Vector3::new(normal(&mut rng), normal(&mut rng), normal(&mut rng));
        let told = PoseEstimate {
            pose: Pose2::new(0.3 + error.x, -0.2 + error.y, 0.7 + error.z),
            cov,
        };
        let p = point(2.0, 1.0, 0.02, PointKind::Corner);
        let drawn = |at: Point2<f64>, rng: &mut ChaCha8Rng| PointFeature {
            position: at + Vector2::new(normal(rng), normal(rng)) * 0.02,
            ..p
        };
        let (before, now) = (
            drawn(p.position, &mut rng),
            drawn(truth * p.position, &mut rng),
        );
        sum += distance2(&moved(&[before], &told)[0], &now).unwrap();
    }
    let mean = sum / f64::from(n);
    assert!((mean - 2.0).abs() < 0.15, "mean d² {mean}");
}

proptest! {
    /// The index gives the same as comparing all pairs.
    #[test]
    fn mutual_nearest_by_the_grid_are_those_of_all_pairs(seed in 0..500_u64, sigma in 0.01..0.5_f64, gate in 0.5..30.0_f64) {
        let (before, now) = scans(seed, &Pose2::new(0.1, 0.05, 0.02), 8, 8);
        let told = PoseEstimate { pose: Pose2::identity(), cov: pose_cov(sigma, 0.3 * sigma) };
        let config = PointMatchConfig { gate, ..with(PointMatching::Nearest) };
        let found = match_points(&before, &now, &told, &config);
        let expected = moved(&before, &told);
        let d2 = |i: usize, j: usize| distance2(&expected[i], &now[j]).filter(|d2| *d2 <= gate).unwrap_or(f64::INFINITY);
        let all: Vec<_> = (0..16).flat_map(|j| (0..16).map(move |i| (i, j)))
            .filter(|&(i, j)| d2(i, j) < f64::INFINITY && (0..16).all(|k| d2(k, j) >= d2(i, j) && d2(i, k) >= d2(i, j)))
            .collect();
        let found: Vec<_> = found.iter().map(|pair| (pair.before, pair.now)).collect();
        prop_assert_eq!(found, all);
    }

    #[test]
    fn no_point_is_found_twice_and_all_are_within_the_gate(seed in 0..500_u64, which in 0..3_usize, gate in 0.0..50.0_f64) {
        let (before, now) = scans(seed, &Pose2::new(0.2, 0.1, 0.1), 6, 5);
        let told = PoseEstimate { pose: Pose2::new(0.2, 0.1, 0.1), cov: pose_cov(0.5, 0.2) };
        let config = PointMatchConfig { gate, ..with(PointMatching::ALL[which].1) };
        let found = match_points(&before, &now, &told, &config);
        prop_assert!(found.iter().all(|pair| pair.d2 <= gate));
        let mut olds: Vec<_> = found.iter().map(|pair| pair.before).collect();
        olds.sort_unstable();
        olds.dedup();
        prop_assert_eq!(olds.len(), found.len());
        prop_assert!(found.is_sorted_by(|a, b| a.now < b.now));
    }
}

#[test]
fn nothing_and_equal_points_are_no_trouble() {
    let told = PoseEstimate {
        pose: Pose2::identity(),
        cov: pose_cov(0.1, 0.1),
    };
    let heap = vec![point(1.0, 1.0, 0.01, PointKind::Corner); 12];
    let mut broken = heap.clone();
    broken.iter_mut().for_each(|p| p.position.x = f64::NAN);
    for (_, method) in PointMatching::ALL {
        let found =
            |a: &[PointFeature], b: &[PointFeature]| match_points(a, b, &told, &with(method)).len();
        assert_eq!(
            [found(&[], &heap), found(&heap, &[]), found(&broken, &heap)],
            [0; 3]
        );
        assert!(found(&heap, &heap) <= 12);
    }
    let bad = PointMatchConfig {
        min_support: 1,
        ..PointMatchConfig::default()
    };
    assert_eq!(
        bad.validate().unwrap_err().to_string(),
        "min_support is 1, expected 2 to 100"
    );
    assert_eq!(
        PointMatchConfig {
            gate: f64::INFINITY,
            ..PointMatchConfig::default()
        }
        .validate(),
        Ok(())
    );
}

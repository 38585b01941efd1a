use std::f64::consts::{PI, TAU};

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::features::{
    CornerConfig, CrossingConfig, LineConfig, PointFeatureConfig, SpikeConfig, find_points,
};
use crate::geom::{Pose2, Segment, sides_of, unit_vector};
use crate::points::fixture::{beam_along, normal, range_to, scan_of};
use crate::points::{Beam, Points};

fn find(points: &Points) -> Vec<PointFeature> {
    let config = PointFeatureConfig {
        circles: CircleConfig::default(),
        corners: CornerConfig {
            is_on: false,
            ..CornerConfig::default()
        },
        crossings: CrossingConfig {
            is_on: false,
            ..CrossingConfig::default()
        },
        spikes: SpikeConfig {
            is_on: false,
            ..SpikeConfig::default()
        },
    };
    find_points(points, &[], &LineConfig::default(), &config).unwrap()
}

/// 720 beams in a room of 8 m with round things: (centre, radius).
fn look(
    round: &[(Point2<f64>, f64)],
    walls: &[Segment],
    sigma: f64,
    rng: &mut ChaCha8Rng,
) -> Points {
    let mut all = walls.to_vec();
    all.extend(polygon(&[
        (-4.0, -4.0),
        (4.0, -4.0),
        (4.0, 4.0),
        (-4.0, 4.0),
    ]));
    scan_of((0..720).map(|i| {
        let direction = unit_vector(TAU * f64::from(i) / 720.0);
        let to_wall = range_to(&all, &Pose2::identity(), direction);
        let range = (round.iter())
            .filter_map(|(middle, radius)| {
                let (along, beside) = (
                    middle.coords.dot(&direction),
                    middle.coords.perp(&direction),
                );
                let half = radius * radius - beside * beside;
                (half >= 0.0 && along > 0.0).then(|| along - half.sqrt())
            })
            .fold(to_wall, f64::min);
        let beam = beam_along(i as usize, direction, range + sigma * normal(rng), true);
        Beam { sigma, ..beam }
    }))
}

fn polygon(corners: &[(f64, f64)]) -> Vec<Segment> {
    let at = |p: &(f64, f64)| Point2::new(p.0, p.1);
    sides_of(corners)
        .map(|(a, b)| Segment::new(at(a), at(b)))
        .collect()
}

#[test]
fn pillars_are_found_where_they_are_and_as_well_as_they_say() {
    // A thin post has ten to twenty points; half of those might be the edge of a box.
    for (radius, least) in [(0.08, 0.4), (0.2, 0.95), (0.4, 0.95)] {
        let (mut sum, mut radii, mut count) = (0.0, 0.0, 0.0);
        for seed in 0..300 {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let middle =
                Point2::from(unit_vector(rng.random_range(-PI..PI)) * rng.random_range(0.9..1.8));
            let found = find(&look(&[(middle, radius)], &[], 0.008, &mut rng));
            assert!(found.len() <= 1, "seed {seed}: {found:?}");
            for circle in found {
                let PointKind::Circle {
                    radius: r,
                    var_radius,
                } = circle.kind
                else {
                    panic!("{circle:?}");
                };
                let error = circle.position - middle;
                sum += error.dot(&circle.cov.cholesky().unwrap().solve(&error));
                radii += (r - radius) * (r - radius) / var_radius;
                count += 1.0;
                assert!(
                    circle.confidence > 0.5 && error.length() < 0.1,
                    "{circle:?}"
                );
            }
        }
        let (nees, of_radius) = (sum / count, radii / count);
        println!("radius {radius}: NEES {nees:.2}, of the radius {of_radius:.2}, {count} of 300");
        assert!(
            (1.5..2.8).contains(&nees),
            "radius {radius}: mean NEES {nees}"
        );
        assert!(
            (0.7..1.6).contains(&of_radius),
            "radius {radius}: NEES of the radius {of_radius}"
        );
        assert!(
            count > 300.0 * least,
            "radius {radius}: {count} of 300 found"
        );
    }
}

#[test]
fn what_is_not_round_is_no_circle() {
    let mut found = [0; 4];
    for seed in 0..100 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let turn = rng.random_range(0.0..TAU);
        let at = |x: f64, y: f64| {
            let p = unit_vector(turn) * 1.5
                + unit_vector(turn + 0.3) * x
                + unit_vector(turn + 0.3 + 0.5 * PI) * y;
            (p.x, p.y)
        };
        // Boxes of 30 and 60 cm, a board, a round niche.
        let boxes = [0.15, 0.3].map(|h| polygon(&[at(-h, -h), at(h, -h), at(h, h), at(-h, h)]));
        let board = vec![{
            let (a, b) = (at(0.0, -0.25), at(0.0, 0.25));
            Segment::new(Point2::new(a.0, a.1), Point2::new(b.0, b.1))
        }];
        let niche: Vec<_> = (0..24)
            .map(|i| {
                let side = |i: i32| {
                    let out = unit_vector(turn + PI * (f64::from(i) / 24.0 - 0.5)) * 0.4;
                    Point2::from(unit_vector(turn) * 1.5 + out)
                };
                Segment::new(side(i), side(i + 1))
            })
            .collect();
        let [small, large] = boxes;
        for (i, walls) in [small, large, board, niche].iter().enumerate() {
            found[i] += find(&look(&[], walls, 0.008, &mut rng)).len();
        }
    }
    println!("{found:?}");
    assert!(
        found.iter().all(|n| *n <= 2),
        "boxes, board, niche: {found:?} circles of 100"
    );
}

#[test]
fn two_legs_beside_each_other_are_two_circles() {
    let mut both = 0;
    for seed in 0..50 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let legs = [
            (Point2::new(1.0, 0.13), 0.07),
            (Point2::new(1.0, -0.13), 0.07),
        ];
        let found = find(&look(&legs, &[], 0.004, &mut rng));
        for circle in &found {
            let near = legs
                .iter()
                .map(|(middle, _)| (circle.position - middle).length());
            assert!(near.fold(f64::INFINITY, f64::min) < 0.05, "{circle:?}");
        }
        both += usize::from(found.len() == 2);
    }
    assert!(both > 40, "{both} of 50");
}

#[test]
fn fit_of_exact_points_is_exact_and_its_covariance_that_of_drawn_noise() {
    let truth = Circle {
        middle: Point2::new(1.5, 0.4),
        radius: 0.3,
    };
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut fitted = |sigma: f64| {
        let facing = libm::atan2(-truth.middle.y, -truth.middle.x);
        let ends = (0..31).map(|i| {
            truth.middle + unit_vector(facing + 0.09 * (f64::from(i) - 15.0)) * truth.radius
        });
        let beams: Vec<_> = ends
            .enumerate()
            .map(|(i, end)| {
                let range = end.coords.length();
                let beam = beam_along(
                    i,
                    end.coords / range,
                    range + sigma * normal(&mut rng),
                    true,
                );
                Beam {
                    sigma: 0.004,
                    ..beam
                }
            })
            .collect();
        let mut columns = Columns::default();
        columns.load(
            &beams,
            std::iter::once(0..31),
            crate::features::columns::Noise::default(),
        );
        let guess = Circle {
            middle: Point2::new(1.45, 0.45),
            radius: 0.2,
        };
        fit::fit(&columns, &(0..31).collect::<Vec<_>>(), guess).unwrap()
    };
    let exact = fitted(0.0);
    assert!(
        (exact.circle.middle - truth.middle).length() < 1e-9
            && (exact.circle.radius - 0.3).abs() < 1e-9
    );
    let n = 3000;
    let mut scatter = nalgebra::Matrix3::zeros();
    for _ in 0..n {
        let found = fitted(0.004).circle;
        let e = nalgebra::Vector3::new(
            found.middle.x - 1.5,
            found.middle.y - 0.4,
            found.radius - 0.3,
        );
        scatter += e * e.transpose() / f64::from(n);
    }
    // Equally large in every direction, to within the noise of 3000 draws and nonlinearity.
    let ratio = exact.cov.cholesky().unwrap().inverse() * scatter;
    assert!((ratio.trace() / 3.0 - 1.0).abs() < 0.1, "{ratio}");
}

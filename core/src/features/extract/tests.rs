use std::f64::consts::TAU;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use nalgebra::{Point2, Vector2};

use super::*;
use crate::geom::{Line, Pose2, Segment, sides_of, wrap};
use crate::points::Beam;
use crate::points::fixture::{beam_along, normal, range_to, scan_of};

/// A revolution of `n` beams from `robot` against `walls`, with σ = 0.01 m + 0.005 ρ.
fn look(walls: &[Segment], robot: &Pose2, n: usize, rng: &mut ChaCha8Rng) -> Points {
    let beams = (0..n).map(|i| {
        let bearing = TAU * i as f64 / n as f64;
        let direction = Vector2::new(libm::cos(bearing), libm::sin(bearing));
        let range = range_to(walls, robot, direction);
        let sigma = 0.01 + 0.005 * range;
        let noisy = (range + sigma * normal(rng)).clamp(0.05, 12.0);
        Beam {
            sigma: if range.is_finite() { sigma } else { 0.05 },
            ..beam_along(i, direction, noisy, range < 12.0)
        }
    });
    scan_of(beams)
}

fn wall(ax: f64, ay: f64, bx: f64, by: f64) -> Segment {
    Segment::new(Point2::new(ax, ay), Point2::new(bx, by))
}

fn polygon(points: &[(f64, f64)]) -> Vec<Segment> {
    sides_of(points)
        .map(|(a, b)| wall(a.0, a.1, b.0, b.1))
        .collect()
}

/// Rooms with protruding corners, a recess, a slanted wall and boxes.
fn flat() -> Vec<Segment> {
    let mut walls = polygon(&[
        (-3.0, -2.0),
        (4.0, -2.0),
        (4.0, 0.5),
        (3.0, 2.5),
        (0.5, 2.5),
        (0.5, 2.35),
        (-0.5, 2.35),
        (-0.5, 2.5),
        (-3.0, 2.5),
    ]);
    walls.extend(polygon(&[
        (-2.0, -1.0),
        (-1.4, -1.0),
        (-1.4, -0.6),
        (-2.0, -0.6),
    ]));
    walls.extend(polygon(&[(1.9, 0.2), (2.3, 0.4), (2.1, 0.8), (1.7, 0.6)]));
    walls
}

fn circle(x: f64, y: f64, radius: f64) -> Vec<Segment> {
    let corner = |i: usize| {
        let angle = TAU * i as f64 / 64.0;
        (x + radius * libm::cos(angle), y + radius * libm::sin(angle))
    };
    polygon(&(0..64).map(corner).collect::<Vec<_>>())
}

fn lines(points: &Points, config: LineConfig) -> Vec<LineFeature> {
    let mut lines = vec![];
    LineExtractor::new(config)
        .extract(points, &mut lines)
        .unwrap();
    lines
}

/// The wall under a feature and the feature's NEES against it.
fn nees(feature: &LineFeature, walls: &[Segment], robot: &Pose2) -> f64 {
    let middle = *robot * nalgebra::center(&feature.ends[0], &feature.ends[1]);
    let nearest = walls
        .iter()
        .min_by(|a, b| a.distance(middle).total_cmp(&b.distance(middle)))
        .unwrap();
    let (truth, _) = Line::through(nearest.a, nearest.b)
        .unwrap()
        .transformed(&robot.inverse());
    let error = Vector2::new(
        wrap(feature.line.alpha() - truth.alpha()),
        feature.line.r() - truth.r(),
    );
    error.dot(&feature.cov.cholesky().unwrap().solve(&error))
}

#[test]
fn box_room_has_four_walls_with_their_corners() {
    let walls = polygon(&[(-2.0, -1.5), (3.0, -1.5), (3.0, 2.0), (-2.0, 2.0)]);
    let mut refused = 0;
    for seed in 0..20 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let found = lines(
            &look(&walls, &Pose2::identity(), 360, &mut rng),
            LineConfig::default(),
        );
        // One true line in twenty is refused on suspicion.
        assert!((3..=4).contains(&found.len()), "seed {seed}: {found:?}");
        refused += 4 - found.len();
        let lengths: f64 = found.iter().map(LineFeature::length).sum();
        assert!(
            (10.0..17.1).contains(&lengths),
            "seed {seed}: {lengths} m of 17 m"
        );
    }
    assert!(refused <= 8, "{refused} of 80 walls refused");
}

/// The rules that know the noise.
fn by_noise() -> [(&'static str, LineConfig); 3] {
    let [noise_aware, _, _, ransac, hough] = SplitRule::all();
    [noise_aware, ransac, hough].map(|(name, split, _)| {
        let config = LineConfig {
            split,
            ..LineConfig::default()
        };
        (name, config)
    })
}

#[test]
fn features_of_a_furnished_flat_are_as_good_as_they_say() {
    for (name, config) in by_noise() {
        check_flat(name, config);
    }
}

fn check_flat(name: &str, config: LineConfig) {
    let walls = flat();
    let (mut sum, mut count, mut gross, mut scans) = (0.0, 0_u32, 0_u32, 0_u32);
    for seed in 0..400_u64 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let robot = Pose2::new(
            rng.random_range(-2.7..1.5),
            rng.random_range(-0.4..2.0),
            rng.random_range(-3.1..3.1),
        );
        let points = look(&walls, &robot, 360, &mut rng);
        // Not inside a wall.
        if points.hits().any(|b| b.range < 0.2) {
            continue;
        }
        scans += 1;
        for feature in lines(&points, config) {
            let nees = nees(&feature, &walls, &robot);
            count += 1;
            if nees > 18.4 {
                gross += 1;
            } else {
                sum += nees;
            }
        }
    }
    let (mean, gross_share) = (
        sum / f64::from(count - gross),
        f64::from(gross) / f64::from(count),
    );
    println!(
        "{name}: {scans} scans, {:.1} features a scan, NEES {mean:.2}, {gross} of {count} beyond 1e-4",
        f64::from(count) / f64::from(scans)
    );
    assert!(mean < 2.4, "{name}: mean NEES {mean}");
    assert!(
        gross_share < 0.004,
        "{name}: {gross} of {count} features are wrong"
    );
    assert!(
        count > 4 * scans,
        "{name}: {count} features in {scans} scans"
    );
}

#[test]
fn recess_of_fifteen_centimetres_is_not_part_of_the_wall() {
    let walls = flat();
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let robot = Pose2::new(0.0, 0.5, 0.0);
    let points = look(&walls, &robot, 720, &mut rng);
    for (name, config) in by_noise() {
        for feature in lines(&points, config) {
            assert!(nees(&feature, &walls, &robot) < 18.4, "{name}: {feature:?}");
        }
    }
}

#[test]
fn people_and_pillars_are_not_walls() {
    for (name, config) in by_noise() {
        check_round(name, config);
    }
}

fn check_round(name: &str, config: LineConfig) {
    let mut found = 0;
    for seed in 0..200 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut scene = circle(1.5, 0.0, 0.2);
        scene.extend(circle(-1.2, 1.0, 0.35));
        scene.extend(circle(0.0, -2.0, 0.15));
        found += lines(&look(&scene, &Pose2::identity(), 360, &mut rng), config).len();
    }
    println!("{name}: {found} lines on 600 round things");
    assert!(found < 12, "{name}: {found} lines on 600 round things");
}

#[test]
fn lost_and_wild_beams_do_not_tear_a_wall() {
    let mut in_all = 0;
    for seed in 0..30 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut points = look(
            &[wall(2.0, -1.5, 2.0, 1.5)],
            &Pose2::identity(),
            360,
            &mut rng,
        );
        for _ in 0..3 {
            let index = rng.random_range(0..30);
            points.beams[index].is_hit = false;
            let wild = &mut points.beams[rng.random_range(330..355)];
            wild.end_in_robot = Point2::from(wild.end_in_robot.coords * 0.7);
            wild.range *= 0.7;
        }
        let found = lines(&points, LineConfig::default());
        in_all += found.len();
        for feature in found {
            assert!(nees(&feature, &[wall(2.0, -1.5, 2.0, 1.5)], &Pose2::identity()) < 18.4);
        }
    }
    assert!((25..=90).contains(&in_all), "{in_all} lines in 30 scans");
}

#[test]
fn walls_on_both_sides_of_a_door_stay_two() {
    let walls = [wall(1.5, -2.0, 1.5, -0.45), wall(1.5, 0.45, 1.5, 2.0)];
    for (name, config) in by_noise() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let points = look(&walls, &Pose2::identity(), 360, &mut rng);
        assert_eq!(lines(&points, config).len(), 2, "{name}");
    }
}

#[test]
fn extraction_repeats_to_the_bit_with_used_buffers() {
    let mut rng = ChaCha8Rng::seed_from_u64(9);
    let points = look(&flat(), &Pose2::new(0.3, 0.5, 1.0), 360, &mut rng);
    for (name, config) in by_noise() {
        let mut extractor = LineExtractor::new(config);
        let (mut first, mut second) = (vec![], vec![]);
        extractor.extract(&points, &mut first).unwrap();
        extractor.extract(&points, &mut second).unwrap();
        assert!(!first.is_empty(), "{name}");
        assert_eq!(first, second, "{name}");
    }
}

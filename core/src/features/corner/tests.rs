use std::f64::consts::{PI, TAU};

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::features::{
    CircleConfig, CrossingConfig, LineConfig, PointFeatureConfig, SpikeConfig, find_points,
};
use crate::geom::{Pose2, Segment, sides_of, unit_vector};
use crate::points::fixture::{beam_along, normal, range_to, scan_of};

fn only_corners(corners: CornerConfig) -> PointFeatureConfig {
    PointFeatureConfig {
        corners,
        crossings: CrossingConfig {
            is_on: false,
            ..CrossingConfig::default()
        },
        spikes: SpikeConfig {
            is_on: false,
            ..SpikeConfig::default()
        },
        circles: CircleConfig {
            is_on: false,
            ..CircleConfig::default()
        },
    }
}

fn polygon(corners: &[(f64, f64)]) -> Vec<Segment> {
    let at = |p: &(f64, f64)| Point2::new(p.0, p.1);
    sides_of(corners)
        .map(|(a, b)| Segment::new(at(a), at(b)))
        .collect()
}

fn look(walls: &[Segment], robot: &Pose2, n: usize, sigma: f64, rng: &mut ChaCha8Rng) -> Points {
    scan_of((0..n).map(|i| {
        let direction = unit_vector(TAU * i as f64 / n as f64);
        let range = range_to(walls, robot, direction) + sigma * normal(rng);
        let beam = beam_along(i, direction, range.min(12.0), range < 12.0);
        crate::points::Beam { sigma, ..beam }
    }))
}

fn find(points: &Points, config: CornerConfig) -> Vec<PointFeature> {
    find_points(points, &[], &LineConfig::default(), &only_corners(config)).unwrap()
}

/// A room with a box protruding into it: four corners seen from inside, one from outside.
const ROOM: [(f64, f64); 6] = [
    (-2.0, -1.5),
    (2.2, -1.5),
    (2.2, 0.6),
    (0.9, 0.6),
    (0.9, 1.6),
    (-2.0, 1.6),
];

/// Mean NEES, corners per scan, and the share of false ones.
fn trial(sigma: f64, config: CornerConfig, scans: u64) -> (f64, f64, f64) {
    let walls = polygon(&ROOM);
    let (mut sum, mut right, mut wrong) = (0.0, 0.0, 0.0);
    for seed in 0..scans {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let (x, y) = (rng.random_range(-0.8..0.4), rng.random_range(-0.5..0.4));
        let robot = Pose2::new(x, y, rng.random_range(-PI..PI));
        for corner in find(&look(&walls, &robot, 720, sigma, &mut rng), config) {
            let at = robot * corner.position;
            let truth = ROOM.iter().map(|&(x, y)| Point2::new(x, y));
            let nearest = truth
                .min_by(|a, b| (a - at).length().total_cmp(&(b - at).length()))
                .unwrap();
            if (nearest - at).length() > 0.15 {
                wrong += 1.0;
                continue;
            }
            let error = robot.inverse() * nearest - corner.position;
            sum += error.dot(&corner.cov.cholesky().unwrap().solve(&error));
            right += 1.0;
        }
    }
    (sum / right, right / scans as f64, wrong / (right + wrong))
}

#[test]
fn corners_are_found_where_they_are_and_as_well_as_they_say() {
    for half_window in [5, 6, 7] {
        for sigma in [0.002, 0.005, 0.01] {
            let config = CornerConfig {
                half_window,
                ..CornerConfig::default()
            };
            let (nees, found, wrong) = trial(sigma, config, 150);
            println!(
                "{half_window} {sigma}: NEES {nees:.2}, {found:.1} of 6 a scan, {wrong:.3} wrong"
            );
            assert!(
                (1.5..2.7).contains(&nees),
                "{half_window}, {sigma}: mean NEES {nees}"
            );
            assert!(
                found > 3.0,
                "{half_window}, {sigma}: {found} corners of 6 a scan"
            );
            assert!(
                wrong < 0.03,
                "{half_window}, {sigma}: {wrong} of the corners are none"
            );
        }
    }
}

#[test]
fn without_noise_every_angle_within_the_limits_is_a_corner_and_no_other() {
    // At a limit itself, either answer is right.
    for degrees in (20..170).filter(|degrees| ![40, 143].contains(degrees)) {
        let angle = f64::from(degrees).to_radians();
        // Seen from inside the bend, both legs alike.
        let leg = |side: f64| Point2::new(2.0, 0.0) + unit_vector(PI + side * 0.5 * angle) * 1.6;
        let walls = [
            Segment::new(leg(1.0), Point2::new(2.0, 0.0)),
            Segment::new(Point2::new(2.0, 0.0), leg(-1.0)),
        ];
        let mut rng = ChaCha8Rng::seed_from_u64(0);
        // Points of legs that are seen at a flat angle are far apart.
        let config = CornerConfig {
            max_stretch: 20.0,
            ..CornerConfig::default()
        };
        let mut points = look(&walls, &Pose2::identity(), 1000, 0.0, &mut rng);
        points.beams.iter_mut().for_each(|beam| beam.sigma = 0.003);
        let found = find(&points, config);
        let is_within = (40..143).contains(&degrees);
        assert_eq!(found.len(), usize::from(is_within), "{degrees}°: {found:?}");
        if let Some(corner) = found.first() {
            // The fit subtracts the scatter expected from noise, but here there is none.
            let off = (corner.position - Point2::new(2.0, 0.0)).length();
            assert!(off < 1e-3, "{degrees}°: {off}");
        }
    }
}

#[test]
fn straight_walls_gaps_and_steps_between_walls_are_no_corners() {
    let wall = |ax, ay, bx, by| Segment::new(Point2::new(ax, ay), Point2::new(bx, by));
    let scenes = [
        vec![wall(2.0, -3.0, 2.0, 3.0)],
        // Two walls at right angles that do not meet: an open corner of 40 cm.
        vec![wall(2.0, -2.0, 2.0, 0.6), wall(1.6, 1.0, -1.0, 1.0)],
        // One in front of the other.
        vec![wall(2.0, -2.0, 2.0, 0.0), wall(2.6, 0.0, 2.6, 2.0)],
    ];
    for (scene, walls) in scenes.iter().enumerate() {
        let mut found = 0;
        for seed in 0..100 {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            found += find(
                &look(walls, &Pose2::identity(), 720, 0.01, &mut rng),
                CornerConfig::default(),
            )
            .len();
        }
        assert!(found <= 1, "scene {scene}: {found} corners in 100 scans");
    }
}

#[test]
fn check_backwards_takes_out_vertices_that_only_the_window_sees() {
    // One wild point in a wall: the window of 11 around it makes no corner, but that of its
    // neighbours is bent by it only at one step. By the paper's check nothing of it is left.
    let at = |i: usize| Point2::new(2.0, 0.02 * i as f64 - 0.5);
    let mut hits: Vec<_> = (0..50).map(at).collect();
    hits[25].x -= 0.06;
    hits[30].x -= 0.12;
    let points = crate::points::fixture::scan_of_hits(hits);
    let vertices = |config: CornerConfig| {
        let mut columns = Columns::default();
        columns.load(
            &points.beams,
            std::iter::once(0..50),
            crate::features::columns::Noise::default(),
        );
        let finder = Finder {
            columns: &columns,
            points: &points,
            config: &config,
            spacing: SpacingModel {
                slope: 1.0,
                offset: 0.0,
            },
        };
        finder.vertices(&Row {
            range: 0..50,
            n_repeated: 0,
        })
    };
    let unchecked = CornerConfig {
        back_checks: 0,
        ..CornerConfig::default()
    };
    let paper = CornerConfig {
        back_check_sigmas: 0.0,
        ..CornerConfig::default()
    };
    assert!(!vertices(unchecked).is_empty());
    assert_eq!(vertices(paper), [0; 0]);
}

#[test]
fn sigma_of_an_angle_is_that_of_drawn_noise() {
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    let ends = [
        Point2::new(2.0, -0.4),
        Point2::new(2.2, 0.1),
        Point2::new(1.7, 0.6),
    ];
    let angle = |ends: &[Point2<f64>]| {
        let points = crate::points::fixture::scan_of_hits(ends.iter().copied());
        let mut columns = Columns::default();
        columns.load(
            &points.beams,
            std::iter::once(0..3),
            crate::features::columns::Noise::default(),
        );
        let config = CornerConfig::default();
        let finder = Finder {
            columns: &columns,
            points: &points,
            config: &config,
            spacing: SpacingModel::of(&points),
        };
        (finder.angle(1, 1).unwrap(), finder.angle_sigma(1, 1))
    };
    let (mean, sigma) = angle(&ends);
    let n = 5000;
    let mut sum = 0.0;
    for _ in 0..n {
        // σ is 1 cm along the beam, as in the fixture.
        let moved = ends.map(|p| p + p.coords / p.coords.length() * (0.01 * normal(&mut rng)));
        let off = angle(&moved).0 - mean;
        sum += off * off;
    }
    let drawn = (sum / f64::from(n)).sqrt();
    assert!(
        (drawn / sigma - 1.0).abs() < 0.05,
        "{drawn} against {sigma}"
    );
}

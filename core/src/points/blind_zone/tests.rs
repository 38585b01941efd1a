//! A lidar that is blind below 0.15 m, before a wall at x = 0.

use std::f64::consts::TAU;

use super::*;
use crate::geom::{Length, Segment};
use crate::points::fixture;
use crate::robot::Stamp;

const BLIND: f64 = 0.15;

/// What a lidar sees of `walls` from `world_from_robot`: nothing nearer than 0.15 m.
fn look(walls: &[Segment], world_from_robot: &Pose2) -> Points {
    let mut seen = fixture::look(walls, world_from_robot, 5.0);
    seen.beams.retain(|beam| beam.range >= BLIND);
    seen
}

fn wall() -> Vec<Segment> {
    vec![Segment::new(Point2::new(0.0, -3.0), Point2::new(0.0, 3.0))]
}

/// The blind zone after scans from each of the poses.
fn seen_from(walls: &[Segment], poses: &[Pose2]) -> BlindZone {
    let mut field = BlindZone::default();
    let mut before = poses[0];
    for pose in poses {
        field.update(&look(walls, pose), &before.delta_to(pose));
        before = *pose;
    }
    field
}

#[test]
fn a_wall_that_is_too_near_to_be_seen_is_where_it_was() {
    // From 0.2 m to 0.11 m in steps of 1 cm, turning the while.
    let poses: Vec<Pose2> = (0..10)
        .map(|i| Pose2::new(-0.20 + 0.01 * f64::from(i), 0.0, 0.05 * f64::from(i)))
        .collect();
    let field = seen_from(&wall(), &poses);
    let last = poses[9];
    let nearest = field.unseen().iter().map(|p| p.coords.length());
    assert!((nearest.fold(9.9, f64::min) - 0.11).abs() < 1e-3);
    for point in field.unseen() {
        assert!((last * *point).x.abs() < 1e-9, "{point}");
    }
    // The blind part is a cap of ±43° around the wall's nearest place; a degree or so at its rim
    // may be forgotten.
    let angles = field.unseen().iter().map(|p| libm::atan2(p.y, p.x));
    let (low, high) = angles.fold((9.9_f64, -9.9_f64), |(l, h), a| (l.min(a), h.max(a)));
    assert!((high - low).to_degrees() > 80.0, "{low} {high}");
    let all = field.with_unseen(&look(&wall(), &last));
    assert_eq!(
        all.hits().count(),
        look(&wall(), &last).hits().count() + field.unseen().len()
    );
}

#[test]
fn what_can_be_seen_is_not_remembered_beside_it() {
    let field = seen_from(&wall(), &[Pose2::new(-0.25, 0.0, 0.0); 3]);
    assert!(field.unseen().is_empty(), "{:?}", field.unseen());
}

#[test]
fn who_steps_back_is_forgotten() {
    let poses = [
        Pose2::new(-0.18, 0.0, 0.0),
        Pose2::new(-0.12, 0.0, 0.0),
        Pose2::new(-0.12, 0.0, 0.0),
    ];
    let mut field = seen_from(&wall(), &poses);
    assert!(!field.unseen().is_empty());
    let gone = [Segment::new(Point2::new(0.4, -3.0), Point2::new(0.4, 3.0))];
    field.update(&look(&gone, &poses[2]), &Pose2::identity());
    assert!(field.unseen().is_empty(), "{:?}", field.unseen());
}

#[test]
fn what_was_left_behind_is_forgotten_even_where_no_beam_looks() {
    let mut field = seen_from(
        &wall(),
        &[Pose2::new(-0.18, 0.0, 0.0), Pose2::new(-0.13, 0.0, 0.0)],
    );
    assert!(!field.unseen().is_empty());
    let nothing = Points {
        beams: vec![],
        ..look(&[], &Pose2::identity())
    };
    field.update(&nothing, &Pose2::new(-0.1, 0.0, 0.0));
    assert!(!field.unseen().is_empty());
    field.update(&nothing, &Pose2::new(-1.0, 0.0, 0.0));
    assert!(field.unseen().is_empty());
}

#[test]
fn memory_is_bounded_whatever_comes() {
    let mut field = BlindZone::default();
    let points = look(
        &[Segment::new(Point2::new(0.2, -3.0), Point2::new(0.2, 3.0))],
        &Pose2::identity(),
    );
    let only_near = Points {
        beams: points
            .beams
            .iter()
            .filter(|b| b.range < 0.21)
            .copied()
            .collect(),
        ..points
    };
    for i in 0..500 {
        field.update(&only_near, &Pose2::new(0.0, 0.0, 0.4 + 0.01 * f64::from(i)));
    }
    assert!(field.remembered.len() <= MOST);
}

/// The reading of a folding sensor for a wall at `distance`, m: as far beyond 0.2 m as the wall is
/// nearer.
fn folded(distance: f64) -> f64 {
    if distance < 0.15 {
        0.35 - distance
    } else {
        distance
    }
}

#[test]
fn folded_readings_of_a_remembered_wall_are_invalid_and_others_stay() {
    let walls = [
        wall(),
        vec![Segment::new(
            Point2::new(-2.0, -3.0),
            Point2::new(-2.0, 3.0),
        )],
    ]
    .concat();
    let (before, now) = (Pose2::new(-0.6, 0.0, 0.3), Pose2::new(-0.12, 0.0, 0.2));
    let mut field = BlindZone::new(BlindZoneConfig::short_range());
    field.update(&look(&walls, &before), &Pose2::identity());
    let beams = 0..180;
    let bearings: Vec<f64> = beams
        .map(|k| crate::geom::wrap(TAU * f64::from(k) / 180.0))
        .collect();
    let truth = |bearing: f64| {
        let (sin, cos) = sin_cos(bearing);
        let ahead = now.rotate(nalgebra::Vector2::new(cos, sin));
        let hits = walls
            .iter()
            .filter_map(|w| w.hit_by_ray(now.position(), ahead));
        hits.fold(f64::INFINITY, f64::min)
    };
    let scan = Scan {
        stamp: Stamp(1),
        robot_from_sensor: Pose2::identity(),
        ranges: bearings.iter().map(|&b| folded(truth(b)) as f32).collect(),
        sigmas: vec![0.01; bearings.len()],
        qualities: vec![],
        bearing_sigma: 0.0,
        max_range: 1.5,
        sweep: 0.0,
        bearings,
    };
    let kept = field.without_folded(&scan, &before.delta_to(&now));
    let mut masked = 0;
    for (beam, &bearing) in scan.bearings.iter().enumerate() {
        let (truth, is_masked) = (truth(bearing), kept.ranges[beam].is_nan());
        masked += u32::from(is_masked);
        if truth < 0.15 {
            assert!(
                is_masked,
                "{bearing} rad: {truth} m read as {}",
                scan.ranges[beam]
            );
        }
        assert!(!is_masked || truth < 0.2, "{bearing} rad: {truth} m");
    }
    // The wall is inside of 0.15 m over 2 acos(0.12 / 0.15), and of 0.18 m over 2 acos(0.12 /
    // 0.18).
    assert!((37..=50).contains(&masked), "{masked}");
    // Without folding configured, the scan is taken unchanged.
    let mut plain = BlindZone::default();
    plain.update(&look(&walls, &before), &Pose2::identity());
    assert_eq!(*plain.without_folded(&scan, &before.delta_to(&now)), scan);
}

#[test]
fn people_who_come_between_two_sweeps_are_not_gathered_without_end() {
    let mut near = BlindZone::new(BlindZoneConfig::short_range());
    for _ in 0..5_000 {
        near.came(Point2::new(0.3, 0.1));
    }
    assert_eq!(near.remembered.len(), MOST);
}

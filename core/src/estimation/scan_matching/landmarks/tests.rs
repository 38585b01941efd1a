//! Landmarks compared with the true corners of the walls.

use nalgebra::Vector2;

use super::super::ScanMatcherConfig;
use super::super::tests::course::{LAP, drive, feed, ring};
use super::*;
use crate::geom::Length;

fn begin() -> Pose2 {
    Pose2::new(-5.0, -4.0, 0.0)
}

fn mapped(seed: u64) -> ScanMatcher {
    let mut matcher = ScanMatcher::new(ScanMatcherConfig::default()).unwrap();
    feed(&mut matcher, &drive(&LAP, begin(), seed));
    matcher.finish();
    matcher
}

/// How far a place is from the nearest corner of the walls, m.
fn off(place: Point2<f64>) -> f64 {
    let ends = ring().into_iter().flat_map(|wall| [wall.a, wall.b]);
    let offs = ends.map(|corner| (corner - place).length());
    offs.fold(f64::INFINITY, f64::min)
}

#[test]
fn landmarks_stand_where_walls_have_corners() {
    let matcher = mapped(3);
    let landmarks = matcher.landmarks();
    assert!(landmarks.len() >= 20, "{}", landmarks.len());
    assert!(landmarks.iter().all(|landmark| landmark.confidence >= 1));
    let often: Vec<f64> = (landmarks.iter())
        .filter(|landmark| landmark.confidence >= 5)
        .map(|landmark| off(begin() * landmark.position))
        .collect();
    assert!(often.len() >= 12, "{often:?}");
    let near = often.iter().filter(|off| **off < 0.15).count();
    // A few are false: where a wall hides another, points of both may look like a corner.
    assert!(near as f64 >= 0.85 * often.len() as f64, "{often:?}");
}

#[test]
fn those_of_a_submap_are_in_its_frame() {
    let matcher = mapped(4);
    let own = matcher.landmarks_in(1);
    assert!(own.len() >= 3, "{own:?}");
    let submap = matcher.submaps().nth(1).unwrap().map_from_submap;
    let near = |landmark: &&MapLandmark| off(begin() * (submap * landmark.position)) < 0.15;
    let right = own.iter().filter(near).count();
    assert!(right as f64 >= 0.8 * own.len() as f64, "{right} of {own:?}");
    assert!(matcher.landmarks_in(1000).is_empty());
}

#[test]
fn what_is_found_again_is_known_better_and_stands_at_the_mean() {
    let seen = |x: f64| PointFeature {
        position: Point2::new(x, 1.0),
        cov: Matrix2::from_diagonal(&Vector2::new(1e-4, 1e-4)),
        kind: PointKind::Corner,
        confidence: 1.0,
        beams: [0, 0],
    };
    let (mut known, frame) = (Known::default(), Pose2::new(2.0, -1.0, 0.5));
    for (x, again) in [(3.00, 0), (3.02, 0), (3.01, 4), (3.03, 0)] {
        known.take_in(&[seen(x)], &[again], &frame, &[1e-3; 3]);
    }
    // Another corner, seen once.
    known.take_in(&[seen(7.0)], &[0], &frame, &[1e-3; 3]);
    let landmarks = known.found_again();
    let [landmark] = &landmarks[..] else {
        panic!("{landmarks:?}");
    };
    assert_eq!(landmark.confidence, 7);
    let mean = frame * Point2::new(3.015, 1.0);
    assert!((landmark.position - mean).length() < 1e-9, "{landmark:?}");
    let expected = Matrix2::from_diagonal_element(1e-4 / 4.0);
    assert!((landmark.cov - expected).amax() < 1e-12, "{landmark:?}");
}

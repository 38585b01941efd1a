use nalgebra::Point2;
use proptest::prelude::*;

use super::*;
use crate::features::{LineExtractor, PointKind, SpikeForm};
use crate::geom::{Length, Pose2, Segment, sides_of, unit_vector};
use crate::points::fixture::{beam_along, look, scan_of};

/// A square room with a pillar.
fn walls() -> Vec<Segment> {
    let room = [(-2.0, -2.0), (2.0, -2.0), (2.0, 2.0), (-2.0, 2.0)];
    let at = |p: &(f64, f64)| Point2::new(p.0, p.1);
    let mut walls: Vec<_> = sides_of(&room)
        .map(|(a, b)| Segment::new(at(a), at(b)))
        .collect();
    let leg = |i: i32| {
        Point2::new(0.9, 0.5) + unit_vector(std::f64::consts::TAU * f64::from(i) / 48.0) * 0.15
    };
    walls.extend((0..48).map(|i| Segment::new(leg(i), leg(i + 1))));
    walls
}

#[test]
fn each_kind_is_found_where_it_is_asked_for() {
    let points = look(&walls(), &Pose2::new(0.1, -0.2, 0.3), 12.0);
    let (config, mut lines) = (LineConfig::default(), vec![]);
    LineExtractor::new(config)
        .extract(&points, &mut lines)
        .unwrap();
    let kinds = |asked: PointFeatureConfig| {
        let found = find_points(&points, &lines, &config, &asked).unwrap();
        let count = |is: fn(&PointKind) -> bool| found.iter().filter(|f| is(&f.kind)).count();
        [
            count(|k| *k == PointKind::Corner),
            count(|k| *k == PointKind::Spike),
            count(|k| *k == PointKind::Crossing),
            count(|k| matches!(k, PointKind::Circle { .. })),
        ]
    };
    let all = PointFeatureConfig::default();
    // Three corners and crossings, because the pillar hides the fourth; its edges; the pillar.
    assert_eq!(kinds(all), [3, 2, 3, 1]);
    let mut one = all;
    one.corners.is_on = false;
    assert_eq!(kinds(one), [0, 2, 3, 1]);
    one.spikes.is_on = false;
    assert_eq!(kinds(one), [0, 0, 3, 1]);
    one.crossings.is_on = false;
    assert_eq!(kinds(one), [0, 0, 0, 1]);
    one.circles.is_on = false;
    assert_eq!(kinds(one), [0; 4]);
}

#[test]
fn no_corner_of_a_closed_room_is_lost_where_the_scan_begins_and_ends() {
    let side = |i: i32| Point2::from(unit_vector(std::f64::consts::FRAC_PI_2 * f64::from(i)) * 2.5);
    let walls: Vec<_> = (0..4).map(|i| Segment::new(side(i), side(i + 1))).collect();
    for turn in 0..90 {
        // The first beam looks into a corner, then beside it.
        let robot = Pose2::new(0.01, -0.02, f64::from(turn).to_radians());
        let points = look(&walls, &robot, 12.0);
        let found = find_points(
            &points,
            &[],
            &LineConfig::default(),
            &PointFeatureConfig::default(),
        );
        let corners = found
            .unwrap()
            .into_iter()
            .filter(|f| f.kind == PointKind::Corner);
        let places: Vec<_> = corners.map(|f| robot * f.position).collect();
        assert_eq!(places.len(), 4, "{turn}°: {places:?}");
        for corner in (0..4).map(side) {
            let is_there = places.iter().any(|place| (place - corner).length() < 0.01);
            assert!(is_there, "{turn}°: {corner} is not among {places:?}");
        }
    }
}

#[test]
fn settings_out_of_range_are_named() {
    let mut config = PointFeatureConfig::default();
    assert_eq!(config.validate(), Ok(()));
    config.corners.half_window = 8;
    let said = config.validate().unwrap_err().to_string();
    assert_eq!(said, "corners.half_window is 8, expected 5 to 7");
    config = PointFeatureConfig::default();
    config.circles.cell = f64::NAN;
    assert!(
        config
            .validate()
            .unwrap_err()
            .to_string()
            .starts_with("circles.cell is NaN")
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn any_scan_gives_finite_points_with_positive_definite_covariances_or_a_typed_error(
        ranges in prop::collection::vec((0.05..6.0_f64, 1e-4..0.3_f64, prop::bool::weighted(0.95)), 0..150),
        shape in 0..3_u8, bearing_sigma in prop::sample::select(vec![0.0, 0.002, 0.1]), step in 0.0..0.1_f64,
        form in prop::sample::select(SpikeForm::ALL.map(|row| row.1).to_vec()),
    ) {
        let beams = ranges.iter().enumerate().map(|(i, &(range, sigma, is_hit))| {
            let bearing = step * i as f64;
            let range = match shape {
                0 => range,
                // Rooms with corners, and rows of round things.
                1 => 1.0 / libm::cos(bearing % 1.4 - 0.7) + 0.001 * range,
                _ => {
                    let beside = bearing % 0.6 - 0.3;
                    1.5 - (0.09 - beside * beside).max(0.0).sqrt() + 0.001 * range
                }
            };
            crate::points::Beam { sigma, ..beam_along(i, unit_vector(bearing), range, is_hit) }
        });
        let points = Points { bearing_sigma, ..scan_of(beams) };
        let (line_config, mut config) = (LineConfig::default(), PointFeatureConfig::default());
        config.spikes.form = form;
        let mut lines = vec![];
        LineExtractor::new(line_config).extract(&points, &mut lines).unwrap();
        for found in find_points(&points, &lines, &line_config, &config).unwrap() {
            prop_assert!(found.position.coords.length().is_finite() && (0.0..=1.0).contains(&found.confidence), "{found:?}");
            prop_assert!(found.cov.iter().all(|v| v.is_finite()) && found.cov.cholesky().is_some(), "{found:?}");
        }
    }

    #[test]
    fn numbers_that_are_none_are_an_error_that_says_where(which in 0..60_usize, bad in prop::sample::select(vec![f64::NAN, f64::INFINITY, -1.0])) {
        let mut points = look(&walls(), &Pose2::identity(), 12.0);
        points.beams[which].range = bad;
        let found = find_points(&points, &[], &LineConfig::default(), &PointFeatureConfig::default());
        let is_named = matches!(&found, Err(LineError::Beam(beam)) if beam.beam_idx == which);
        prop_assert!(is_named, "{found:?}");
    }
}

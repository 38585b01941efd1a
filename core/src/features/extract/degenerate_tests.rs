//! Input that no line fits, and damaged input.

use nalgebra::{Point2, Vector2};
use proptest::prelude::*;

use super::*;
use crate::features::{AcceptConfig, BadBeam, Hough, MergeConfig, Ransac, fit_line};
use crate::geom::Length;
use crate::points::fixture::{hit, scan_of};
use crate::points::{Beam, SpacingModel};

fn beam(beam_idx: usize, x: f64, y: f64) -> Beam {
    hit(beam_idx, Point2::new(x, y))
}

fn wall() -> Points {
    let along = (0..60).map(|i| beam(i, 2.0, 0.03 * i as f64 - 0.9));
    scan_of(along)
}

/// Every rule, with and without the gates.
fn configs() -> Vec<LineConfig> {
    let open = LineConfig {
        accept: AcceptConfig::all(3, 0.0),
        merge: MergeConfig {
            across_runs: true,
            ..MergeConfig::default()
        },
        ..LineConfig::default()
    };
    let by = |split| LineConfig { split, ..open };
    vec![
        by(SplitRule::Ransac(Ransac::default())),
        by(SplitRule::Hough(Hough::default())),
        LineConfig::default(),
        LineConfig::short_range(),
        LineConfig::classic(0.05),
        LineConfig::pilch(SpacingModel::even(360.0)),
        open,
    ]
}

#[test]
fn only_points_with_a_direction_that_beams_do_not_run_along_have_a_line() {
    assert_eq!(fit_line(&vec![beam(0, 1.0, 1.0); 12], 0.0), None);
    let to_sensor: Vec<_> = (1..12).map(|i| beam(i, 0.3 * i as f64, 0.0)).collect();
    assert_eq!(fit_line(&to_sensor, 0.0), None);
    // If bearings are known to be uncertain, it is a line again, with an equally uncertain
    // distance.
    let unsure = fit_line(&to_sensor, 0.01).unwrap();
    assert!(unsure.cov.cholesky().is_some());
    assert_eq!(fit_line(&[], 0.0), None);
    assert_eq!(fit_line(&[beam(0, 1.0, 0.0)], 0.0), None);
    assert_eq!(
        fit_line(&[beam(0, f64::NAN, 0.0), beam(1, 1.0, 0.5)], 0.0),
        None
    );
    let two = fit_line(&[beam(0, 1.0, -0.5), beam(1, 1.0, 0.5)], 0.0).unwrap();
    assert!((two.line.r() - 1.0).abs() < 1e-9 && two.n_points == 2);
}

#[test]
fn scans_without_a_line_give_none() {
    let equal = scan_of((0..30).map(|i| beam(i, 1.0, 1.0)));
    let two = scan_of([beam(0, 1.0, 0.0), beam(1, 1.0, 0.01)]);
    let to_sensor = scan_of((0..30).map(|i| beam(i, 1.0 + 0.02 * i as f64, 0.0)));
    for config in configs() {
        for points in [&equal, &two, &to_sensor, &scan_of([])] {
            let mut lines = vec![];
            LineExtractor::new(config)
                .extract(points, &mut lines)
                .unwrap();
            assert_eq!(lines, []);
        }
    }
}

#[test]
fn a_number_that_is_none_is_an_error_that_says_where_and_leaves_the_lines() {
    for config in configs() {
        let mut extractor = LineExtractor::new(config);
        let mut lines = vec![];
        extractor.extract(&wall(), &mut lines).unwrap();
        let before = lines.clone();
        assert_eq!(before.len(), 1, "{config:?}");
        let damages: [fn(&mut Beam); 7] = [
            |b| b.end_in_robot.x = f64::NAN,
            |b| b.end_in_robot.y = f64::INFINITY,
            |b| b.range = f64::NAN,
            |b| b.range = 0.0,
            |b| b.sigma = f64::NAN,
            |b| b.sigma = -0.01,
            |b| b.origin_in_robot.x = f64::NEG_INFINITY,
        ];
        for (number, damage) in damages.iter().enumerate() {
            let mut points = wall();
            damage(&mut points.beams[17]);
            let error = extractor.extract(&points, &mut lines);
            assert!(
                matches!(error, Err(LineError::Beam(BadBeam { beam_idx: 17, .. }))),
                "damage {number}: {error:?}"
            );
            assert_eq!(lines, before);
        }
        let mut points = wall();
        points.bearing_sigma = f64::NAN;
        let error = extractor.extract(&points, &mut lines);
        assert!(matches!(error, Err(LineError::Bounds(_))));
        extractor.extract(&wall(), &mut lines).unwrap();
        assert_eq!(lines, before);
    }
}

#[test]
fn settings_out_of_range_are_named() {
    let check = |config: LineConfig, name: &str| {
        let error = config.validate().unwrap_err().to_string();
        assert!(error.contains(name), "{error}");
    };
    for config in configs() {
        assert_eq!(config.validate(), Ok(()));
    }
    check(LineConfig::classic(f64::NAN), "split.threshold is NaN");
    let mut config = LineConfig::default();
    config.accept.min_length = -1.0;
    check(config, "accept.min_length is -1, expected 0 to 5");
    let mut config = LineConfig::default();
    config.segmentation.max_step = 0.0;
    check(config, "segmentation.max_step is 0");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn any_cloud_gives_lines_with_finite_positive_definite_covariances_or_a_typed_error(
        ranges in prop::collection::vec((0.05..12.0_f64, 1e-4..0.3_f64, prop::bool::weighted(0.95)), 0..150),
        flat in 0..2_u8, bearing_sigma in prop::sample::select(vec![0.0, 0.002, 0.1]), which in 0..7_usize, step in 0.0..0.1_f64,
    ) {
        let beams = ranges.iter().enumerate().map(|(i, &(range, sigma, is_hit))| {
            let bearing = step * i as f64;
            // Half of the clouds are rooms with walls, so that there are lines.
            let range = if flat == 1 { (1.0 / libm::cos(bearing % 1.4 - 0.7) + 0.01 * range).min(11.0) } else { range };
            let direction = Vector2::new(libm::cos(bearing), libm::sin(bearing));
            Beam { sigma, is_hit, range, end_in_robot: Point2::from(direction * range), ..beam(i, 1.0, 0.0) }
        });
        let points = Points { bearing_sigma, ..scan_of(beams) };
        let config = configs()[which];
        let mut lines = vec![];
        prop_assert!(LineExtractor::new(config).extract(&points, &mut lines).is_ok());
        for line in &lines {
            prop_assert!(line.cov.iter().all(|v| v.is_finite()) && line.cov.cholesky().is_some(), "{line:?}");
            prop_assert!(line.chi2.is_finite() && line.line.r() >= 0.0 && line.length().is_finite());
            prop_assert!(line.by_heading.iter().all(|v| v.length().is_finite()));
        }
        if let Some(line) = fit_line(&points.beams, bearing_sigma) {
            prop_assert!(line.cov.iter().all(|v| v.is_finite()) && line.cov.cholesky().is_some(), "{line:?}");
        }
    }
}

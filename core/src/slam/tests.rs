//! Bad odometry changes nothing, and methods have names.

use super::*;
use crate::map::CellState;
use crate::robot::{Scan, Stamp};

#[test]
fn odometry_that_is_no_motion_leaves_every_method_as_it_was() {
    for method in Method::ALL {
        let name = method.name();
        let mut slam = Slam::new(method, prior_map_tests::config()).unwrap();
        let mut odometry = Odometry::standing(Stamp(1_000_000));
        slam.odometry(&odometry).unwrap();
        let before = slam.estimate();
        odometry.motion = Pose2::new(f64::NAN, 0.0, 0.0);
        let error = slam.odometry(&odometry).unwrap_err();
        assert!(matches!(error, SlamError::Odometry(_)), "{name}: {error}");
        assert_eq!(slam.estimate(), before, "{name}");
        assert_eq!(slam.motion_since_scan(), Pose2::identity(), "{name}");
    }
}

#[test]
fn methods_are_found_by_name() {
    for method in Method::ALL {
        assert_eq!(method.name().parse(), Ok(method));
        assert!(method.meaning().ends_with('.') && !method.title().is_empty());
    }
    // Saved links and settings use these names.
    let names = Method::ALL.map(Method::name);
    assert_eq!(
        names,
        [
            "odometry",
            "line-ekf",
            "scan-matching",
            "grid-particles",
            "prior-map",
            "particle-localisation",
            "histogram-localisation"
        ]
    );
    let error = "teleport".parse::<Method>().unwrap_err().to_string();
    assert_eq!(
        error,
        "there is no method `teleport`; expected odometry, line-ekf, scan-matching, grid-particles, prior-map, particle-localisation or histogram-localisation"
    );
}

#[test]
fn only_the_map_of_scan_matching_is_changed_by_hand() {
    let ends = [Point2::new(1.0, 0.0), Point2::new(1.0, 1.0)];
    for method in Method::ALL {
        let name = method.name();
        let mut slam = Slam::new(method, prior_map_tests::config()).unwrap();
        let changed = slam.edit(EditKind::Wall, &ends);
        if method != Method::ScanMatching {
            assert_eq!(changed, Err(SlamError::NoEdits), "{name}");
            assert!(!slam.undo_edit(), "{name}");
            continue;
        }
        changed.unwrap();
        let wall = slam.grid().cell_at(Point2::new(1.0, 0.5));
        assert_eq!(slam.grid().state(wall), CellState::Occupied);
        let refused = slam.edit(EditKind::Erase, &ends);
        assert!(matches!(refused, Err(SlamError::Edit(_))), "{refused:?}");
        assert!(slam.undo_edit() && !slam.undo_edit());
        assert_eq!(slam.grid().state(wall), CellState::Unknown);
    }
}

/// A scan with a beam per degree and these ranges, m. No beam goes into a corner, through which a
/// ray may slip.
fn look_round(range: impl Fn(f64) -> f32) -> Scan {
    let bearing = |i: i32| f64::from(i).to_radians() + 0.003;
    let bearings: Vec<f64> = (0..360).map(bearing).collect();
    Scan {
        ranges: bearings.iter().map(|&bearing| range(bearing)).collect(),
        sigmas: vec![0.01; 360],
        qualities: vec![],
        bearings,
        stamp: Stamp(0),
        robot_from_sensor: Pose2::identity(),
        bearing_sigma: 0.0,
        max_range: 12.0,
        sweep: 0.0,
    }
}

/// Glass and black walls return nothing either.
#[test]
fn beams_without_a_return_clear_the_same_few_metres_by_every_method() {
    // Walls to the left, behind and to the right of a robot that faces out of a wide door.
    let scan = look_round(|bearing| {
        let (sin, cos) = crate::geom::sin_cos(bearing);
        match cos > 0.8 {
            true => f32::INFINITY,
            false => (2.0 / (-cos).max(sin.abs())) as f32,
        }
    });
    for method in Method::ALL {
        let name = method.name();
        for (clears, expected) in [(5.0, [true, false, false]), (8.0, [true, true, false])] {
            let mut config = prior_map_tests::config();
            config.evidence.no_return_clears = clears;
            config.matcher.evidence.no_return_clears = clears;
            let mut slam = Slam::new(method, config).unwrap();
            slam.scan(&scan).unwrap();
            let pose = slam.estimate().pose;
            let is_free = |x: f64| {
                let at = slam.grid().cell_at(pose * Point2::new(x, 0.0));
                slam.grid().log_odds(at) < 0.0
            };
            assert_eq!([4.8, 7.8, 11.0].map(is_free), expected, "{name}");
        }
    }
}

#[test]
fn points_of_the_scan_are_found_by_every_method_and_only_those_asked_for() {
    use crate::features::PointKind;
    use crate::geom::Segment;
    // A square room, 2 m from the centre to each wall.
    let corner = |i: i32| {
        let side = crate::geom::unit_vector(std::f64::consts::FRAC_PI_2 * (f64::from(i) + 0.5));
        Point2::from(side * 2.0 * std::f64::consts::SQRT_2)
    };
    let walls: Vec<_> = (0..4)
        .map(|i| Segment::new(corner(i), corner(i + 1)))
        .collect();
    let scan = look_round(|bearing| {
        let along = crate::geom::unit_vector(bearing);
        crate::points::fixture::range_to(&walls, &Pose2::identity(), along) as f32
    });
    for method in Method::ALL {
        let name = method.name();
        let mut config = prior_map_tests::config();
        config.point_features.spikes.is_on = false;
        let mut slam = Slam::new(method, config.clone()).unwrap();
        assert_eq!(slam.point_features(), Ok(vec![]), "{name}");
        slam.scan(&scan).unwrap();
        let found = slam.point_features().unwrap();
        let count = |kind| found.iter().filter(|found| found.kind == kind).count();
        assert_eq!(count(PointKind::Corner), 4, "{name}: {found:?}");
        assert_eq!(count(PointKind::Crossing), 4, "{name}: {found:?}");
        config.point_features.corners.is_on = false;
        slam.reconfigure(&config).unwrap();
        assert_eq!(slam.point_features().unwrap().len(), 4, "{name}");
        config.point_features.corners.half_window = 9;
        let refused = slam.reconfigure(&config).unwrap_err().to_string();
        assert_eq!(
            refused, "corners.half_window is 9, expected 5 to 7",
            "{name}"
        );
        assert!(Slam::new(method, config).is_err(), "{name}");
    }
}

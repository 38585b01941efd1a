//! Bad odometry changes nothing, and methods have names.

use super::*;
use crate::map::CellState;
use crate::robot::Stamp;

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
    // Saved links and settings know them by these names.
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

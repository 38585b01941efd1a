//! Shapes compared with their closed forms, and the errors for bad figures.

use super::shape::CIRCLE_SAGITTA;
use super::*;

#[test]
fn polygon_of_a_circle_stays_within_two_millimetres() {
    for radius in [0.05, 0.3, 2.0] {
        let circle = Shape::Circle {
            centre: Point2::new(1.0, -2.0),
            radius,
        };
        for segment in circle.segments() {
            let nearest = segment.distance(Point2::new(1.0, -2.0));
            assert!(
                radius - nearest <= CIRCLE_SAGITTA * 1.01,
                "{radius}: {nearest}"
            );
        }
        assert_eq!(circle.segments().len(), circle.segment_count());
    }
}

#[test]
fn turned_rectangle_holds_what_it_should() {
    let shape = Shape::Rectangle {
        centre: Point2::new(1.0, 1.0),
        size: Vector2::new(2.0, 0.2),
        angle: std::f64::consts::FRAC_PI_4,
    };
    assert!(shape.holds(Point2::new(1.5, 1.5)));
    assert!(!shape.holds(Point2::new(1.5, 0.5)));
    assert_eq!(shape.segments().len(), 4);
}

#[test]
fn bad_figures_are_named() {
    let room = World::new("room", Pose2::identity()).with_room(&[
        (-1.0, -1.0),
        (1.0, -1.0),
        (1.0, 1.0),
        (-1.0, 1.0),
    ]);
    assert_eq!(room.validate(0.1), Ok(()));
    let message = |world: World| world.validate(0.1).unwrap_err().to_string();
    let inside = message(room.clone().with_pillar((0.0, 0.0), 0.5));
    assert!(
        inside.contains("robot of radius 0.1 m at (0, 0) stands in obstacle 1 (a circle)"),
        "{inside}"
    );
    let near = message(room.clone().with_walls(&[(0.05, -1.0), (0.05, 1.0)]));
    assert!(near.contains("0.050 m from its surface"), "{near}");
    let flat = message(room.clone().with_turned_box((5.0, 5.0), (0.0, 1.0), 0.0));
    assert!(flat.contains("obstacle 1: size x is 0"), "{flat}");
    let far = message(room.clone().with_walls(&[(0.0, 5.0), (f64::NAN, 5.0)]));
    assert!(far.contains("obstacle 1: x is NaN"), "{far}");
    let short = message(room.with_walls(&[(0.0, 5.0)]));
    assert!(short.contains("has 1 points"), "{short}");
}

//! A long robot among points, driven with the speeds that safe mode lets through, compared with the
//! outline's own exact test.

use proptest::prelude::*;

use super::*;
use crate::control::SafeConfig;
use crate::geom::Segment;
use crate::points::fixture::scan_of_hits;
use crate::robot::BodyShape;

fn long() -> RobotModel {
    RobotModel {
        length: 0.5,
        width: 0.3,
        shape: BodyShape::Rectangle,
        ..RobotModel::rp6()
    }
}

/// The walls as points every centimetre, seen from a pose.
fn seen(walls: &[Segment], pose: &Pose2) -> Points {
    let robot_from_world = pose.inverse();
    let on = |wall: &Segment| {
        let count = (wall.length() / 0.01).ceil() as usize;
        let (a, along) = (wall.a, wall.vector());
        (0..=count).map(move |i| a + along * (i as f64 / count as f64))
    };
    let ends = walls.iter().flat_map(on).map(|p| robot_from_world * p);
    scan_of_hits(ends)
}

/// Drives with these requests, each for a second, the speeds following as the model allows; returns
/// the pose at each tick.
fn drive(walls: &[Segment], wishes: &[(f64, f64)]) -> Vec<Pose2> {
    const TICK: f64 = 0.05;
    let (model, config) = (long(), SafeConfig::default());
    let (mut pose, mut speeds, mut commanded) = (Pose2::identity(), (0.0, 0.0), (0.0, 0.0));
    let mut poses = vec![pose];
    for &wish in wishes {
        for _ in 0..20 {
            let underway = Underway {
                commanded,
                runs: speeds,
                since_scan: Pose2::identity(),
                scan_age: 0.0,
            };
            commanded = limit_outline(wish, &seen(walls, &pose), &underway, (&model, &config));
            let towards = |now: f64, wish: f64, most: f64| now + (wish - now).clamp(-most, most);
            speeds = (
                towards(speeds.0, commanded.0, model.max_acceleration * TICK),
                towards(speeds.1, commanded.1, model.max_turn_acceleration * TICK),
            );
            let at = arc(speeds.0 * TICK, speeds.1 * TICK);
            pose = pose * Pose2::new(at.x, at.y, speeds.1 * TICK);
            poses.push(pose);
        }
    }
    poses
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    #[test]
    fn whatever_is_wished_nothing_is_touched(
        walls in proptest::collection::vec((-1.0..1.0_f64, -1.0..1.0_f64, -0.6..0.6_f64, -0.6..0.6_f64), 1..6),
        wishes in proptest::collection::vec((-0.3..0.3_f64, -2.0..2.0_f64), 1..8),
    ) {
        let mut walls: Vec<Segment> = walls
            .into_iter()
            .map(|(x, y, dx, dy)| Segment::new(Point2::new(x, y), Point2::new(x + dx, y + dy)))
            .collect();
        walls.retain(|wall| wall.distance(Point2::origin()) > long().radius() + 0.02);
        let outline = long().outline(0.0).unwrap();
        for pose in drive(&walls, &wishes) {
            prop_assert!(outline.fits(&pose, &walls), "touched at {pose:?}");
        }
    }
}

/// Regression: at each tick it could come nearer by the scatter of points, and crept through the
/// wall.
#[test]
fn a_wish_that_is_held_does_not_creep_into_a_wall() {
    let outline = long().outline(0.0).unwrap();
    for (wall, first, held) in [
        (
            [(0.4492, -0.3767), (0.5369, -0.4541)],
            (0.258, -0.312),
            (0.055, -1.681),
        ),
        (
            [(-0.3186, 0.1328), (-0.6232, -0.1065)],
            (-0.2525, -0.2191),
            (-0.0359, 1.2322),
        ),
    ] {
        let [a, b] = wall.map(|(x, y)| Point2::new(x, y));
        let walls = [Segment::new(a, b)];
        let mut wishes = vec![first; 2];
        wishes.extend([held; 20]);
        for pose in drive(&walls, &wishes) {
            assert!(outline.fits(&pose, &walls), "{walls:?}: {pose:?}");
        }
    }
}

#[test]
fn a_gap_narrower_than_the_disc_is_driven_through_and_no_turn_is_made_in_it() {
    // 40 cm between the walls; the disc around the robot is 58 cm wide.
    let wall = |y: f64| Segment::new(Point2::new(0.6, y), Point2::new(1.6, y));
    let walls = [wall(-0.2), wall(0.2)];
    let poses = drive(&walls, &[(0.3, 0.0); 9]);
    let end = poses.last().unwrap();
    assert!(end.x() > 1.9, "{end:?}");
    // In its middle it turns until a corner is near a wall, and no further.
    let inside = drive(
        &walls,
        &[
            (0.3, 0.0),
            (0.3, 0.0),
            (0.3, 0.0),
            (0.3, 0.0),
            (0.0, 0.0),
            (0.0, 1.0),
            (0.0, 1.0),
        ],
    );
    let end = inside.last().unwrap();
    assert!((0.9..1.4).contains(&end.x()), "{end:?}");
    assert!(end.heading() > 0.02 && end.heading() < 0.2, "{end:?}");
    // The disc does not even fit in.
    let disc = RobotModel {
        shape: BodyShape::Disc,
        ..long()
    };
    let at = Pose2::new(0.4, 0.0, 0.0);
    let rest = Underway::default();
    let config = SafeConfig::default();
    let ahead = limit_outline((0.3, 0.0), &seen(&walls, &at), &rest, (&disc, &config));
    assert!(ahead.0 < 0.05, "{ahead:?}");
}

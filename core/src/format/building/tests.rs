//! Buildings whose walls are known.

use nalgebra::Vector2;

use super::*;
use crate::format::map_server::NOTHING_KNOWN;
use crate::geom::Length;
use crate::sim::{Caster, worlds};

/// A world as a map shows it: cells nearer to a wall than 0.7 cells are occupied, those farther
/// away are free.
pub(super) fn drawn(world: &World, resolution: f64, origin: Pose2) -> OccupancyMap {
    let (low, high) = world.bounds();
    let caster = Caster::new(world.walls());
    let corners = [
        low,
        high,
        Point2::new(low.x, high.y),
        Point2::new(high.x, low.y),
    ];
    let in_map = corners.map(|corner| origin.inverse() * corner);
    let (least, most) = in_map
        .iter()
        .fold((in_map[0], in_map[0]), |(a, b), p| (a.inf(p), b.sup(p)));
    assert!(least.x > -0.5 && least.y > -0.5);
    let cells = |length: f64| (length / resolution).ceil() as usize + 4;
    let (width, height) = (cells(most.x), cells(most.y));
    let cell = |index: usize| {
        let place = Vector2::new((index % width) as f64 + 0.5, (index / width) as f64 + 0.5);
        let at = origin * Point2::from(place * resolution);
        if caster.clearance(at, 1.0) < 0.7 * resolution {
            100
        } else {
            0
        }
    };
    OccupancyMap {
        width,
        height,
        resolution,
        origin,
        cells: (0..width * height).map(cell).collect(),
    }
}

/// How far what is seen from the start of `seen` is from the walls of `other`, m, without the worst
/// two percent.
fn off(from: Point2<f64>, seen: &World, other: &World) -> f64 {
    let (seen, other) = (Caster::new(seen.walls()), Caster::new(other.walls()));
    let mut errors: Vec<f64> = (0..720)
        .filter_map(|i| {
            let (sin, cos) = crate::geom::sin_cos(f64::from(i).to_radians() * 0.5);
            let direction = Vector2::new(cos, sin);
            let hit = seen.cast(from, direction, 50.0)?;
            Some(other.clearance(from + direction * hit.distance, 2.0))
        })
        .collect();
    assert!(errors.len() > 700);
    errors.sort_by(f64::total_cmp);
    errors[errors.len() * 98 / 100]
}

#[test]
fn a_map_becomes_the_building_that_it_was_drawn_from() {
    for (name, turn) in [("office", 0.0), ("doors", 0.0), ("arena", 0.3)] {
        let truth = worlds::builtin(name).unwrap();
        let (low, _) = truth.bounds();
        let origin = match turn {
            0.0 => Pose2::new(low.x - 0.1, low.y - 0.1, 0.0),
            turn => Pose2::new(low.x + 1.2, low.y - 0.3, turn) * Pose2::new(-1.5, -1.5, 0.0),
        };
        let map = drawn(&truth, 0.05, origin);
        let imported = of_map(&map, "a map").unwrap();
        let from = truth.start.position();
        let extra = off(from, &imported.world, &truth);
        let missing = off(from, &truth, &imported.world);
        assert!(
            extra < 0.08 && missing < 0.08,
            "{name}: {extra} and {missing}"
        );
        assert!(
            imported.world.wall_count() < 40 * truth.wall_count(),
            "{name}"
        );
        assert_eq!(
            imported
                .world
                .validate(imported.world.robot.model().radius()),
            Ok(())
        );
    }
}

#[test]
fn the_robot_starts_at_the_origin_or_where_there_is_most_room() {
    let mut truth = World::new("two rooms", Pose2::new(1.0, 1.0, 0.0)).with_room(&[
        (0.0, 0.0),
        (2.0, 0.0),
        (2.0, 2.0),
        (0.0, 2.0),
    ]);
    truth = truth.with_room(&[(3.0, 0.0), (7.0, 0.0), (7.0, 4.0), (3.0, 4.0)]);
    let mut map = drawn(&truth, 0.05, Pose2::new(-0.1, -0.1, 0.0));
    // The map's frame begins in a corner of the small room, too near to the wall.
    let start = of_map(&map, "m").unwrap().world.start.position();
    assert!((start - Point2::new(5.0, 2.0)).length() < 0.1, "{start}");
    map.origin = Pose2::new(-1.0, -1.0, 0.0);
    assert_eq!(
        of_map(&map, "m").unwrap().world.start.position(),
        Point2::origin()
    );
    // A robot must not start in unknown space.
    for (index, cell) in map.cells.iter_mut().enumerate() {
        if index % map.width < 60 && *cell == 0 {
            *cell = NOTHING_KNOWN;
        }
    }
    let start = of_map(&map, "m").unwrap().world.start.position();
    assert!((start - Point2::new(4.0, 1.0)).length() < 0.2, "{start}");
}

#[test]
fn maps_that_are_no_building_are_refused() {
    let map = |cells: Vec<i8>| OccupancyMap {
        width: 40,
        height: cells.len() / 40,
        resolution: 0.05,
        origin: Pose2::identity(),
        cells,
    };
    assert_eq!(
        of_map(&map(vec![0; 1600]), "m"),
        Err(BuildingError::NoWalls)
    );
    let error = of_map(&map(vec![100; 1600]), "m").unwrap_err().to_string();
    assert!(
        error.starts_with("nowhere is room for the robot: the widest place is 0.00 m"),
        "{error}"
    );
    let mut unknown = vec![-1; 1600];
    unknown[0] = 100;
    assert!(matches!(
        of_map(&map(unknown), "m"),
        Err(BuildingError::NoRoom { .. })
    ));
    assert!(matches!(
        walls_of_map(&map(vec![0; 64_000_040])),
        Err(BuildingError::TooLarge { .. })
    ));
}

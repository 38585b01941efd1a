//! Every built-in world: a robot can start in it, it is closed, its rooms are connected, and it has
//! what its name promises.

use super::*;
use crate::geom::Length;
use crate::sim::{Caster, Material, RobotKind, reachable_area};

/// Radius for a robot of 0.11 m that keeps 0.24 m away from the walls.
const WIDE: f64 = 0.35;

#[test]
fn every_name_is_a_world_that_the_robot_can_start_in() {
    for name in NAMES {
        let world = builtin(name).unwrap();
        assert_eq!(world.name, name);
        // Room to turn and to see: twice the radius.
        assert_eq!(
            world.validate(2.0 * RobotKind::Rp6.model().radius()),
            Ok(()),
            "{name}"
        );
    }
    assert!(builtin("atlantis").is_none());
}

#[test]
fn every_world_is_closed_and_its_rooms_are_connected() {
    let floors = [
        ("arena", 16.0, 20.0),
        ("doors", 40.0, 48.0),
        ("office", 150.0, 192.0),
        ("corridor", 55.0, 60.0),
        ("loop", 120.0, 150.0),
        ("maze", 75.0, 106.0),
        ("lab", 160.0, 204.0),
        ("warehouse", 850.0, 1_050.0),
        ("crowd", 120.0, 140.0),
        ("look-alikes", 200.0, 225.0),
        ("parallel", 168.0, 186.0),
        ("campus", 70_000.0, 86_400.0),
    ];
    assert_eq!(floors.map(|f| f.0), NAMES);
    for (name, least, most) in floors {
        let world = builtin(name).unwrap();
        // The bitmap of `campus` automatically has coarser cells.
        let area = reachable_area(&world, 0.11, 0.05);
        let metres = area.centres().count() as f64 * area.resolution * area.resolution;
        assert!(metres > least && metres < most, "{name}: {metres} m²");
        // Closed: the flood never reached the rim of the bitmap.
        let rim = area.standing.iter().enumerate().filter(|(i, _)| {
            let (row, col) = (i / area.cols, i % area.cols);
            row == 0 || col == 0 || row + 1 == area.rows || col + 1 == area.cols
        });
        assert!(rim.clone().all(|(_, stands)| !stands), "{name} leaks");
        // Connected, for a robot that keeps 0.24 m away from the walls: nearly everywhere the small
        // robot gets and the wide one has room, the wide one gets as well.
        let wide = reachable_area(&world, WIDE, 0.05);
        let wide = wide.standing.iter().filter(|stands| **stands).count();
        let caster = Caster::new(world.walls());
        let standing = area.standing.iter().enumerate();
        let has_room = |&(index, stands): &(usize, &bool)| {
            *stands && caster.clearance(area.centre(index), WIDE) >= WIDE
        };
        let room = standing.filter(has_room).count();
        assert!(wide as f64 > 0.97 * room as f64, "{name}: {wide} of {room}");
        if let Some(goal) = world.goal {
            let near = area
                .centres()
                .any(|p| (p - goal).length() < area.resolution.max(0.05));
            assert!(near, "{name}: goal cannot be reached");
        }
    }
}

#[test]
fn worlds_have_the_walls_that_they_promise() {
    for (name, walls) in [("warehouse", 1_000), ("campus", 50_000)] {
        let world = builtin(name).unwrap();
        assert_eq!(world.walls().len(), walls, "{name}");
        assert_eq!(world.wall_count(), walls, "{name}");
    }
    assert_eq!(builtin("crowd").map(|w| w.movers.len()), Some(10));
}

#[test]
fn three_worlds_have_glass_and_dark_walls() {
    for name in ["lab", "warehouse", "campus"] {
        let world = builtin(name).unwrap();
        for material in [Material::Glass, Material::Dark] {
            let made = world.obstacles.iter().filter(|o| o.material == material);
            assert!(made.count() > 0, "{name}: {material:?}");
        }
    }
}

#[test]
fn people_of_the_crowd_do_not_walk_through_walls() {
    let world = builtin("crowd").unwrap();
    let walls = world.walls();
    for (index, mover) in world.movers.iter().enumerate() {
        let corners = &mover.waypoints;
        let legs = corners.iter().zip(corners.iter().skip(1));
        let home = corners.last().zip(corners.first());
        for (from, to) in legs.chain(home.filter(|_| mover.closed)) {
            for step in 0..=100 {
                let at = from + (to - from) * (f64::from(step) / 100.0);
                let distances = walls.iter().map(|w| w.segment.distance(at));
                let free = distances.fold(f64::INFINITY, f64::min);
                assert!(free > mover.radius, "mover {index} at {at}: {free} m");
            }
        }
    }
}

//! Random buildings, robots and lidars, to which nothing could be tuned.
//!
//! A hall of random size is cut in two again and again, at random places, until the rooms are as
//! small as wanted: some buildings have closets, others only halls. Each cut is a partition with
//! one or two door gaps, so all rooms can be reached. Rooms hold boxes, turned by any angle, and
//! pillars; some of them absorb light. In some buildings people walk about. Robot, lidar and
//! odometry errors are drawn as well, within what one can buy.

use std::f64::consts::{PI, TAU};

use nalgebra::Point2;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use slamlab_core::experiment::ExperimentConfig;
use slamlab_core::geom::Pose2;
use slamlab_core::robot::RobotModel;
use slamlab_core::sim::sensors::LidarModel;
use slamlab_core::sim::worlds::solid_parts;
use slamlab_core::sim::{Material, Mover, SensorModel, World};

/// Half the thickness of a partition, m.
const HALF: f64 = 0.05;
/// Free floor around objects in a room, m.
const AISLE: f64 = 0.9;

/// A room, or the part of the hall that is to be cut, m.
#[derive(Clone, Copy)]
struct Room {
    min: Point2<f64>,
    max: Point2<f64>,
}

/// The experiment of this seed; the caller still has to choose scan matching.
pub(crate) fn experiment(seed: u64) -> ExperimentConfig {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let robot = robot(&mut rng);
    let world = building(&mut rng);
    let sensor = SensorModel::Lidar(lidar(&mut rng));
    ExperimentConfig::new(world, robot, sensor, seed)
}

/// A factor from 1 / `most` to `most`, log-uniform.
fn factor(rng: &mut ChaCha8Rng, most: f64) -> f64 {
    most.powf(rng.random_range(-1.0..1.0))
}

fn robot(rng: &mut ChaCha8Rng) -> RobotModel {
    let mut robot = match rng.random_bool(0.5) {
        true => RobotModel::rp6(),
        false => RobotModel::pioneer(),
    };
    let noise = &mut robot.odometry_noise;
    noise.per_metre *= factor(rng, 3.0);
    noise.lateral_per_metre *= factor(rng, 3.0);
    noise.heading_per_radian *= factor(rng, 3.0);
    robot.odometry_bias.track_mismatch *= factor(rng, 3.0);
    robot.odometry_bias.track_width *= factor(rng, 3.0);
    robot
}

fn lidar(rng: &mut ChaCha8Rng) -> LidarModel {
    let mut lidar = match rng.random_range(0..4) {
        0 => LidarModel::sick(),
        // Few beams, and a short reach.
        1 => LidarModel {
            beams: 90,
            slots: 90,
            max_range: rng.random_range(5.0..8.0),
            ..LidarModel::rplidar()
        },
        // Slow, and no echo strengths.
        2 => LidarModel {
            period: 0.3,
            reports_quality: false,
            ..LidarModel::rplidar()
        },
        _ => LidarModel::rplidar(),
    };
    lidar.sigma *= factor(rng, 2.0);
    lidar.sigma_per_metre *= factor(rng, 2.0);
    lidar.dropouts *= factor(rng, 5.0);
    lidar.outliers *= factor(rng, 5.0);
    if rng.random_bool(0.3) {
        lidar.robot_from_sensor = Pose2::new(0.05, 0.02, 0.0);
    }
    lidar
}

fn building(rng: &mut ChaCha8Rng) -> World {
    let size = [rng.random_range(8.0..30.0), rng.random_range(8.0..22.0)];
    let smallest = rng.random_range(2.6..7.0);
    let hall = Room {
        min: Point2::origin(),
        max: Point2::new(size[0], size[1]),
    };
    let corners = [
        (0.0, 0.0),
        (size[0], 0.0),
        (size[0], size[1]),
        (0.0, size[1]),
    ];
    let mut world = World::new("random", Pose2::identity()).with_room(&corners);
    let (mut rooms, mut open) = (vec![], vec![hall]);
    while let Some(room) = open.pop() {
        match cut(rng, &room, smallest) {
            None => rooms.push(room),
            Some((parts, walls)) => {
                open.extend(parts);
                world = (walls.iter()).fold(world, |world, wall| {
                    world.with_box((wall.min.x, wall.min.y), (wall.max.x, wall.max.y))
                });
            }
        }
    }
    let first = rng.random_range(0..rooms.len());
    let start = middle(&rooms[first]);
    world.start = Pose2::new(start.x, start.y, rng.random_range(-PI..PI));
    for (number, room) in rooms.iter().enumerate() {
        world = furnished(rng, world, room, number == first);
    }
    if rng.random_bool(0.3) {
        let walkers = rng.random_range(1..5);
        world.movers = (0..walkers)
            .map(|_| {
                let room = rooms[rng.random_range(0..rooms.len())];
                walker(rng, &room)
            })
            .collect();
    }
    world
}

fn middle(room: &Room) -> Point2<f64> {
    nalgebra::center(&room.min, &room.max)
}

/// Splits a room in two, with the partition between in pieces; none if it is small enough.
fn cut(rng: &mut ChaCha8Rng, room: &Room, smallest: f64) -> Option<([Room; 2], Vec<Room>)> {
    let size = room.max - room.min;
    let along = usize::from(size.y > size.x);
    let (length, across) = (size[along], size[1 - along]);
    if length < 2.0 * smallest || across < 1.6 {
        return None;
    }
    let at = room.min[along] + rng.random_range(smallest..=length - smallest);
    let (mut near, mut far) = (*room, *room);
    near.max[along] = at;
    far.min[along] = at;
    let mut gaps = vec![];
    let mut from = room.min[1 - along];
    let doors = if across > 6.0 && rng.random_bool(0.4) {
        2
    } else {
        1
    };
    let part = across / f64::from(doors);
    for _ in 0..doors {
        let width = rng.random_range(0.9..1.3);
        let begin = from + rng.random_range(0.15..part - width - 0.15);
        gaps.push((begin, begin + width));
        from += part;
    }
    let solid = solid_parts(room.min[1 - along], room.max[1 - along], &gaps);
    let walls = solid.map(|(begin, end)| {
        let mut wall = *room;
        (wall.min[along], wall.max[along]) = (at - HALF, at + HALF);
        (wall.min[1 - along], wall.max[1 - along]) = (begin, end);
        wall
    });
    Some(([near, far], walls.collect()))
}

/// Adds furniture, away from walls, where it blocks no door.
fn furnished(rng: &mut ChaCha8Rng, mut world: World, room: &Room, is_start: bool) -> World {
    let size = room.max - room.min;
    let least = size.x.min(size.y);
    if is_start || least < 2.0 * AISLE + 0.6 {
        return world;
    }
    for _ in 0..rng.random_range(0..3) {
        let side = rng.random_range(0.3..(least - 2.0 * AISLE).min(1.6));
        // However it is turned, it stays within its circumscribed circle.
        let around = 0.5 * side;
        let margin = AISLE + around;
        let at = |rng: &mut ChaCha8Rng, low: f64, high: f64| {
            let (low, high) = (low + margin, high - margin);
            if low < high {
                rng.random_range(low..high)
            } else {
                0.5 * (low + high)
            }
        };
        let (x, y) = (
            at(rng, room.min.x, room.max.x),
            at(rng, room.min.y, room.max.y),
        );
        world = match rng.random_bool(0.3) {
            true => world.with_pillar((x, y), around),
            false => {
                let long = side * 0.8;
                let box_size = (long, long * rng.random_range(0.4..0.75));
                world.with_turned_box((x, y), box_size, rng.random_range(0.0..TAU))
            }
        };
        if rng.random_bool(0.1) {
            world = world.made_of(Material::Dark);
        }
    }
    world
}

fn walker(rng: &mut ChaCha8Rng, room: &Room) -> Mover {
    let mut place = || {
        let between =
            |rng: &mut ChaCha8Rng, low: f64, high: f64| rng.random_range(low + 0.4..high - 0.4);
        Point2::new(
            between(rng, room.min.x, room.max.x),
            between(rng, room.min.y, room.max.y),
        )
    };
    Mover {
        waypoints: vec![place(), place(), place()],
        closed: true,
        speed: rng.random_range(0.4..1.0),
        radius: 0.22,
        pause: rng.random_range(0.0..4.0),
    }
}

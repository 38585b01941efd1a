//! In: the number of a trial. Out: a world, a robot that stands in it, and how a reckless person
//! drives it.
//!
//! 1. Of five scenes two are rooms of 4 to 7 m with turned boxes and thin pillars, one has a
//!    partition with a door about as wide as the robot, one is a hall in which three to seven
//!    people walk at 0.3 to 1.2 m/s, and one is a built-in world.
//! 2. The robot stands in free space and faces a nearby object, a door post, or any direction.
//! 3. The stick is pushed all the way, mostly forward, now and then back, and turned to and fro
//!    every 0.3 to 1.5 s.

use std::f64::consts::{PI, TAU};

use nalgebra::Point2;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use slamlab_core::geom::{Length, Pose2};
use slamlab_core::robot::RobotModel;
use slamlab_core::sim::{Caster, Mover, RobotKind, World, worlds};

use crate::statistics::place_between;

/// Built-in worlds used: small ones, ones with people, and walls of glass.
const BUILTIN: [&str; 5] = ["arena", "doors", "office", "maze", "crowd"];
/// Kinds of scenes, by what the robot is driven against.
pub(crate) const KINDS: [&str; 4] = ["walls", "door_posts", "people", "built_in"];

/// A trial before it is driven.
pub(crate) struct Scene {
    /// Index into [`KINDS`].
    pub(crate) kind: usize,
    pub(crate) world: World,
    pub(crate) robot: RobotModel,
}

impl Scene {
    pub(crate) fn drawn(seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let kind = [0, 1, 2, 0, 3][seed as usize % 5];
        let kind_of_robot = [RobotKind::Rp6, RobotKind::Pioneer][usize::from(rng.random_bool(0.5))];
        let robot = kind_of_robot.model();
        let (mut world, aim) = match kind {
            0 => (room(&mut rng), None),
            1 => doorway(&robot, &mut rng),
            2 => (hall(&mut rng), None),
            _ => (built_in(&mut rng), None),
        };
        world.robot = kind_of_robot;
        place(&mut world, &robot, aim, &mut rng);
        Self { kind, world, robot }
    }
}

/// The stick over time: full speed, as fractions of the robot's maximum.
pub(crate) struct Stick {
    rng: ChaCha8Rng,
    until: f64,
    at: (f64, f64),
}

impl Stick {
    pub(crate) fn new(seed: u64) -> Self {
        Self {
            rng: ChaCha8Rng::seed_from_u64(!seed),
            until: 0.0,
            at: (1.0, 0.0),
        }
    }

    /// Forward and turning speed at a time, s.
    pub(crate) fn at(&mut self, seconds: f64, robot: &RobotModel) -> (f64, f64) {
        if seconds >= self.until {
            self.until = seconds + self.rng.random_range(0.3..1.5);
            let is_ahead = self.rng.random_bool(0.85);
            let forward = if is_ahead { 1.0 } else { -1.0 };
            let turn = match self.rng.random_range(0..4) {
                0 | 1 => 0.0,
                2 => self.rng.random_range(-1.0..1.0),
                _ => [-1.0, 1.0][self.rng.random_range(0..2_usize)],
            };
            self.at = (forward, turn);
        }
        (self.at.0 * robot.max_speed, self.at.1 * robot.max_turn_rate)
    }
}

fn empty_room(rng: &mut ChaCha8Rng) -> (World, f64, f64) {
    let (w, h) = (rng.random_range(4.0..7.0), rng.random_range(4.0..7.0));
    let world = World::new("trial", Pose2::identity());
    let corners = [(0.0, 0.0), (w, 0.0), (w, h), (0.0, h)];
    (world.with_room(&corners), w, h)
}

fn room(rng: &mut ChaCha8Rng) -> World {
    let (mut world, w, h) = empty_room(rng);
    for _ in 0..rng.random_range(1..5) {
        let at = (rng.random_range(0.0..w), rng.random_range(0.0..h));
        let size = (rng.random_range(0.1..1.2), rng.random_range(0.05..0.8));
        world = world.with_turned_box(at, size, rng.random_range(0.0..PI));
    }
    for _ in 0..rng.random_range(0..3) {
        let at = (rng.random_range(0.0..w), rng.random_range(0.0..h));
        world = world.with_pillar(at, rng.random_range(0.03..0.2));
    }
    world
}

/// A partition with a door; the second is one of its posts.
fn doorway(robot: &RobotModel, rng: &mut ChaCha8Rng) -> (World, Option<Point2<f64>>) {
    let (world, w, h) = empty_room(rng);
    let (x, thickness) = (0.5 * w, rng.random_range(0.02..0.2));
    let gap = 2.0 * robot.radius() + rng.random_range(-0.05..0.5);
    let low = rng.random_range(0.5..h - gap - 0.5);
    let world = world
        .with_box((x, 0.0), (x + thickness, low))
        .with_box((x, low + gap), (x + thickness, h));
    let post = if rng.random_bool(0.5) { low } else { low + gap };
    (world, Some(Point2::new(x, post)))
}

fn hall(rng: &mut ChaCha8Rng) -> World {
    let (mut world, w, h) = empty_room(rng);
    let (low, high) = (Point2::new(0.3, 0.3), Point2::new(w - 0.3, h - 0.3));
    for _ in 0..rng.random_range(3..8) {
        let count = rng.random_range(2..5);
        let waypoints = (0..count).map(|_| place_between(low, high, rng));
        world.movers.push(Mover {
            waypoints: waypoints.collect(),
            closed: true,
            speed: rng.random_range(0.3..1.2),
            radius: rng.random_range(0.12..0.25),
            pause: rng.random_range(0.0..2.0),
        });
    }
    world
}

fn built_in(rng: &mut ChaCha8Rng) -> World {
    let name = BUILTIN[rng.random_range(0..BUILTIN.len())];
    worlds::builtin(name).unwrap_or_else(|| World::new(name, Pose2::identity()))
}

/// Puts the robot somewhere free of walls and people, facing roughly `aim`, or the nearest wall, or
/// any direction.
fn place(world: &mut World, robot: &RobotModel, aim: Option<Point2<f64>>, rng: &mut ChaCha8Rng) {
    let caster = Caster::new(world.walls());
    let (low, high) = world.bounds();
    loop {
        let at = place_between(low, high, rng);
        let heading = if rng.random_bool(0.7) {
            bearing_of(aim.or_else(|| nearest(&caster, at)), at) + rng.random_range(-0.4..0.4)
        } else {
            rng.random_range(0.0..TAU)
        };
        world.start = Pose2::new(at.x, at.y, heading);
        let keeps_off = caster.clearance(at, 1.0) > robot.radius() + 0.06;
        let stands_apart = world.movers.iter().all(|mover| {
            let first = mover.waypoints.first();
            first.is_none_or(|p| (p - at).length() > mover.radius + robot.radius() + 0.3)
        });
        if keeps_off && stands_apart && world.validate(robot.radius()).is_ok() {
            return;
        }
    }
}

fn nearest(caster: &Caster, at: Point2<f64>) -> Option<Point2<f64>> {
    let walls = caster.walls().iter().map(|w| w.segment.closest_point(at));
    walls.min_by(|a, b| (a - at).norm_squared().total_cmp(&(b - at).norm_squared()))
}

fn bearing_of(to: Option<Point2<f64>>, from: Point2<f64>) -> f64 {
    to.map_or(0.0, |to| (to.y - from.y).atan2(to.x - from.x))
}

//! `corridor`, 30 x 2 m: two bare walls. Only the wheels measure how far a robot drove.

use nalgebra::Point2;

use crate::geom::Pose2;
use crate::sim::World;

pub(super) fn world() -> World {
    let mut world = World::new("corridor", Pose2::new(1.0, 1.0, 0.0)).with_room(&[
        (0.0, 0.0),
        (30.0, 0.0),
        (30.0, 2.0),
        (0.0, 2.0),
    ]);
    world.goal = Some(Point2::new(29.0, 1.0));
    world
}

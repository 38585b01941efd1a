//! `crowd`, 14 x 10 m: a hall in which ten people walk, stop and walk on.

use nalgebra::Point2;

use super::hall;
use crate::sim::{Mover, World};

/// Path of a person: corners, whether it is closed, speed (m/s), pause at each corner (s).
type Way = (&'static [(f64, f64)], bool, f64, f64);

/// Radius of a person, m.
const PERSON: f64 = 0.22;

#[rustfmt::skip]
const WAYS: [Way; 10] = [
    (&[(2.5, 1.2), (12.5, 1.2)], false, 0.9, 2.0),
    (&[(13.2, 2.0), (13.2, 8.6)], false, 0.7, 1.0),
    (&[(12.6, 9.1), (1.5, 9.1)], false, 1.1, 3.0),
    (&[(0.8, 8.4), (0.8, 3.4)], false, 0.5, 0.0),
    (&[(3.2, 3.2), (6.2, 3.2), (6.2, 6.6), (3.2, 6.6)], true, 0.8, 0.5),
    (&[(10.8, 6.8), (7.8, 6.8), (7.8, 3.4), (10.8, 3.4)], true, 0.6, 4.0),
    (&[(7.0, 2.2), (7.0, 8.2)], false, 0.7, 1.5),
    (&[(2.2, 8.0), (6.0, 7.6), (11.6, 8.2)], false, 1.0, 2.5),
    (&[(11.8, 2.2), (11.8, 7.4)], false, 0.4, 6.0),
    (&[(4.7, 2.2), (2.2, 4.9)], false, 0.5, 8.0),
];

pub(super) fn world() -> World {
    let mut world = hall("crowd", (1.0, 1.0), (14.0, 10.0))
        .with_goal((12.4, 8.6))
        .with_pillar((4.7, 4.9), 0.3)
        .with_pillar((9.3, 5.1), 0.3)
        .with_box((5.2, 0.0), (6.6, 0.5))
        .with_box((0.0, 5.6), (0.4, 7.0))
        .with_turned_box((9.4, 9.7), (1.6, 0.6), 0.0)
        .with_box((13.6, 4.6), (14.0, 5.8));
    world.movers = WAYS.iter().map(person).collect();
    world
}

fn person(&(corners, closed, speed, pause): &Way) -> Mover {
    Mover {
        waypoints: corners.iter().map(|&(x, y)| Point2::new(x, y)).collect(),
        closed,
        speed,
        radius: PERSON,
        pause,
    }
}

//! `loop`: a ring corridor 2 m wide whose centre line is 64 m long, with niches so that no stretch
//! is without features.

use crate::geom::Pose2;
use crate::sim::World;

/// Outer corners, counter-clockwise from the lower left; one row for each corner of the ring and
/// for each niche, no two alike.
#[rustfmt::skip]
const OUTER: [(f64, f64); 36] = [
    (0.0, 0.0),
    (4.0, 0.0), (4.0, -0.7), (5.2, -0.7), (5.2, 0.0),
    (9.5, 0.0), (9.5, -0.4), (11.5, -0.4), (11.5, 0.0),
    (15.5, 0.0), (15.5, -0.9), (16.4, -0.9), (16.4, 0.0),
    (21.0, 0.0),
    (21.0, 4.5), (21.6, 4.5), (21.6, 5.5), (21.0, 5.5),
    (21.0, 9.6), (21.9, 9.6), (21.9, 11.2), (21.0, 11.2),
    (21.0, 15.0),
    (13.8, 15.0), (13.8, 15.5), (12.4, 15.5), (12.4, 15.0),
    (7.0, 15.0), (7.0, 15.8), (6.1, 15.8), (6.1, 15.0),
    (0.0, 15.0),
    (0.0, 8.8), (-0.6, 8.8), (-0.6, 6.9), (0.0, 6.9),
];

pub(super) fn world() -> World {
    World::new("loop", Pose2::new(2.5, 1.0, 0.0))
        .with_room(&OUTER)
        .with_box((2.0, 2.0), (19.0, 13.0))
        .with_box((0.0, 3.6), (0.4, 4.4))
        .with_box((12.6, 1.7), (13.3, 2.0))
        .with_box((9.8, 13.0), (10.2, 13.4))
        .with_pillar((20.6, 13.2), 0.2)
}

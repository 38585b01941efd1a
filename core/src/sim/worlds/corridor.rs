//! `corridor`, 30 x 2 m: two bare walls. Only the wheels measure how far a robot drove.

use super::hall;
use crate::sim::World;

pub(super) fn world() -> World {
    hall("corridor", (1.0, 1.0), (30.0, 2.0)).with_goal((29.0, 1.0))
}

//! What a lidar sees of a world.

use nalgebra::Vector2;
use slamlab_core::geom::{Pose2, sin_cos};
use slamlab_core::sim::{Caster, World};

/// A place in a world from which ranges are measured, without noise.
#[derive(Clone, Debug)]
pub struct View {
    caster: Caster,
    /// Where the sensor stands: `world_from_sensor`.
    pub pose: Pose2,
    /// Farthest range, m.
    pub max_range: f64,
}

impl View {
    /// From the start of a world, up to 12 m.
    #[must_use]
    pub fn from_start(world: &World) -> Self {
        Self {
            caster: Caster::new(world.walls()),
            pose: world.start,
            max_range: 12.0,
        }
    }

    /// Range in this direction, rad, counter-clockwise in the sensor frame; `None` if nothing is
    /// within range.
    #[must_use]
    pub fn range(&self, bearing: f64) -> Option<f64> {
        let (sin, cos) = sin_cos(self.pose.heading() + bearing);
        let hit = self
            .caster
            .cast(self.pose.position(), Vector2::new(cos, sin), self.max_range);
        hit.map(|hit| hit.distance)
    }
}

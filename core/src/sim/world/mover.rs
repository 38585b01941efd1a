//! What moves about in a building.

use nalgebra::Point2;

use super::WorldError;
use super::check::{check_count, check_point, check_value};

/// A disc that walks along way-points: a person, another robot.
#[derive(Clone, Debug, PartialEq)]
pub struct Mover {
    /// Corners of its path; it starts at the first.
    pub waypoints: Vec<Point2<f64>>,
    /// Whether it walks on from the last way-point to the first; otherwise it walks back the same
    /// way.
    pub closed: bool,
    /// Walking speed, m/s.
    pub speed: f64,
    /// Radius of its disc, m.
    pub radius: f64,
    /// How long it stands at each way-point, s.
    pub pause: f64,
}

/// A disc: where a mover is now.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disc {
    /// Its middle, world frame.
    pub centre: Point2<f64>,
    /// Its radius, m.
    pub radius: f64,
}

impl Mover {
    pub(super) fn check(&self, part: &str) -> Result<(), WorldError> {
        let count = self.waypoints.len();
        check_count(part, "waypoints", count, 1..=10_000, "1 to 10000")?;
        let mut waypoints = self.waypoints.iter();
        waypoints.try_for_each(|p| check_point(part, p))?;
        check_value(part, "speed", self.speed, 0.0..=20.0, "0 to 20 m/s")?;
        check_value(part, "radius", self.radius, 0.01..=10.0, "0.01 to 10 m")?;
        check_value(part, "pause", self.pause, 0.0..=3600.0, "0 to 3600 s")
    }
}

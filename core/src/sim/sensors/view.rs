//! What a beam meets: static walls, movers, glass.

use nalgebra::{Point2, Vector2};

use crate::geom::{Length, Pose2, sin_cos, wrap};
use crate::sim::{Caster, Disc, Hit, Material};

/// Beyond glass, a beam continues from this far behind the pane, m.
const PANE: f64 = 1e-6;
/// Panes that one beam can cross; what lies behind further panes is not seen.
const MOST_PANES: usize = 8;

/// The world as a beam sees it.
pub(in crate::sim) struct View<'a> {
    pub(in crate::sim) caster: &'a Caster,
    pub(in crate::sim) movers: &'a [Disc],
}

/// What came back.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Echo {
    /// Distance, m.
    pub(super) distance: f64,
    /// Material of the surface.
    pub(super) material: Material,
    /// Cosine of the angle between the beam and the surface's normal: 1 if it is met squarely.
    pub(super) facing: f64,
}

impl View<'_> {
    /// The first surface that sends the beam back. Glass does so only if the beam meets it within
    /// `glass_angle` (rad) of its normal; otherwise the beam continues behind it.
    pub(super) fn echo(
        &self,
        origin: Point2<f64>,
        direction: Vector2<f64>,
        max_range: f64,
        glass_angle: f64,
    ) -> Option<Echo> {
        let mover = self.mover_ahead(origin, direction, max_range);
        let far = mover.map_or(max_range, |m| m.distance);
        let mut behind = 0.0;
        for _ in 0..MOST_PANES {
            let from = origin + direction * behind;
            let Some(hit) = self.caster.cast(from, direction, far - behind) else {
                return mover;
            };
            let distance = behind + hit.distance;
            let Hit {
                material, surface, ..
            } = hit;
            if material != Material::Glass || self.is_square(surface, direction, glass_angle) {
                return Some(Echo {
                    distance,
                    material,
                    facing: self.facing(surface, direction),
                });
            }
            behind = distance + PANE;
        }
        None
    }

    /// Distance of the first surface, if it sends sound back: a mover always does, a wall of any
    /// material if it is met within `specular_angle` (rad) of its normal.
    pub(super) fn sound(
        &self,
        origin: Point2<f64>,
        direction: Vector2<f64>,
        max_range: f64,
        specular_angle: f64,
    ) -> Option<f64> {
        let mover = self.mover_ahead(origin, direction, max_range);
        let far = mover.map_or(max_range, |m| m.distance);
        match self.caster.cast(origin, direction, far) {
            None => mover.map(|m| m.distance),
            Some(hit) => self
                .is_square(hit.surface, direction, specular_angle)
                .then_some(hit.distance),
        }
    }

    fn is_square(&self, surface: usize, direction: Vector2<f64>, within: f64) -> bool {
        let Some(wall) = self.caster.walls().get(surface) else {
            return false;
        };
        let along = wall.segment.vector();
        along.perp(&direction).abs() >= along.length() * libm::cos(within)
    }

    fn facing(&self, surface: usize, direction: Vector2<f64>) -> f64 {
        let wall = self.caster.walls().get(surface);
        let along = wall.map(|wall| wall.segment.vector()).unwrap_or_default();
        // A wall without length has no normal, and the cosine would be 0/0; it counts as met
        // squarely.
        (along.perp(&direction).abs() / along.length()).min(1.0)
    }

    fn mover_ahead(
        &self,
        origin: Point2<f64>,
        direction: Vector2<f64>,
        max_range: f64,
    ) -> Option<Echo> {
        let ahead = |disc: &Disc| {
            let to = disc.centre - origin;
            let along = to.dot(&direction);
            let root = disc.radius * disc.radius - to.norm_squared() + along * along;
            let distance = along - root.max(0.0).sqrt();
            // The beam enters the disc half a chord before the foot of the centre.
            let echo = || Echo {
                distance,
                material: Material::Opaque,
                facing: (root.max(0.0).sqrt() / disc.radius).min(1.0),
            };
            (root >= 0.0 && distance >= 0.0 && distance <= max_range).then(echo)
        };
        let ahead = self.movers.iter().filter_map(ahead);
        ahead.min_by(|a, b| a.distance.total_cmp(&b.distance))
    }
}

/// The robot's motion through one time step.
pub(in crate::sim) struct Span {
    /// Start and end, s.
    pub(in crate::sim) from: f64,
    /// End, s.
    pub(in crate::sim) to: f64,
    /// Position and heading at the start.
    pub(in crate::sim) start: (Point2<f64>, f64),
    /// Position and heading at the end.
    pub(in crate::sim) end: (Point2<f64>, f64),
}

impl Span {
    /// Position and heading of a sensor at `robot_from_sensor`; `seconds` must be within the span.
    ///
    /// Interpolated linearly: in 5 ms the arc departs from its chord by micrometres.
    pub(super) fn sensor_at(&self, seconds: f64, robot_from_sensor: &Pose2) -> (Point2<f64>, f64) {
        let part = ((seconds - self.from) / (self.to - self.from)).clamp(0.0, 1.0);
        let position = self.start.0 + (self.end.0 - self.start.0) * part;
        let heading = self.start.1 + wrap(self.end.1 - self.start.1) * part;
        if *robot_from_sensor == Pose2::identity() {
            return (position, heading);
        }
        let (sin, cos) = sin_cos(heading);
        let (x, y) = (robot_from_sensor.x(), robot_from_sensor.y());
        let offset = Vector2::new(x * cos - y * sin, x * sin + y * cos);
        (position + offset, heading + robot_from_sensor.heading())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Segment;
    use crate::sim::Wall;

    fn caster() -> Caster {
        let wall = |x: f64, material| Wall {
            segment: Segment::new(Point2::new(x, -9.0), Point2::new(x, 9.0)),
            material,
        };
        Caster::new(vec![wall(2.0, Material::Glass), wall(4.0, Material::Dark)])
    }

    fn ahead(caster: &Caster, movers: &[Disc], angle: f64) -> Option<Echo> {
        let direction = Vector2::new(libm::cos(angle), libm::sin(angle));
        View { caster, movers }.echo(Point2::origin(), direction, 10.0, 0.2)
    }

    #[test]
    fn glass_answers_a_square_beam_and_lets_a_slanting_one_through() {
        let caster = caster();
        let echo = |angle| ahead(&caster, &[], angle).unwrap();
        assert_eq!(
            echo(0.0),
            Echo {
                distance: 2.0,
                material: Material::Glass,
                facing: 1.0,
            }
        );
        assert_eq!(echo(0.19).material, Material::Glass);
        let slanting = echo(0.5);
        assert_eq!(slanting.material, Material::Dark);
        assert!((slanting.distance - 4.0 / libm::cos(0.5)).abs() < 1e-9);
        assert!((slanting.facing - libm::cos(0.5)).abs() < 1e-12);
        assert_eq!(ahead(&caster, &[], 3.0), None);
    }

    #[test]
    fn nearest_of_mover_and_wall_answers() {
        let caster = caster();
        let disc = |x| Disc {
            centre: Point2::new(x, 0.0),
            radius: 0.5,
        };
        assert_eq!(
            ahead(&caster, &[disc(1.5)], 0.0).map(|e| e.distance),
            Some(1.0)
        );
        assert_eq!(
            ahead(&caster, &[disc(3.0)], 0.0).map(|e| e.distance),
            Some(2.0)
        );
        assert_eq!(
            ahead(&caster, &[disc(-1.5)], 0.0).map(|e| e.distance),
            Some(2.0)
        );
    }
}

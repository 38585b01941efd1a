//! A wall grown by the distance that the robot keeps from it.
//!
//! In: a wall and a radius. Out: whether a point is inside the capsule, and where a straight leg
//! enters it, in closed form.

use nalgebra::{Point2, Vector2};

use crate::geom::Segment;

/// All points nearer than `radius` to a segment; the border is outside.
#[derive(Clone, Copy, Debug)]
pub(super) struct Capsule {
    a: Point2<f64>,
    /// Unit vector from one end to the other; arbitrary for a segment without length.
    along: Vector2<f64>,
    length: f64,
    radius: f64,
}

impl Capsule {
    pub(super) fn new(segment: &Segment, radius: f64) -> Self {
        let length = segment.length();
        let along = if length > 0.0 {
            segment.vector() / length
        } else {
            Vector2::x()
        };
        Self {
            a: segment.a,
            along,
            length,
            radius,
        }
    }

    /// Squared distance of a point from the axis, m².
    #[inline]
    pub(super) fn distance_squared(&self, point: Point2<f64>) -> f64 {
        let from_a = point - self.a;
        let at = from_a.dot(&self.along).clamp(0.0, self.length);
        (from_a - self.along * at).norm_squared()
    }

    #[inline]
    pub(super) fn contains(&self, point: Point2<f64>) -> bool {
        self.distance_squared(point) < self.radius * self.radius
    }

    /// Distance from `origin` to where a leg along the unit vector `direction` enters, m; infinite
    /// if it does not enter, 0 if it starts inside. A leg that touches the border does not enter.
    #[inline]
    pub(super) fn entry(&self, origin: Point2<f64>, direction: Vector2<f64>) -> f64 {
        let from_a = origin - self.a;
        let (place, off) = (from_a.dot(&self.along), self.along.perp(&from_a));
        // The strip between the flat sides is entered first; inside it the leg meets the axis
        // itself, or the disc at one end.
        let mut there = place;
        if off.abs() >= self.radius {
            let closing = -off.signum() * self.along.perp(&direction);
            if closing <= 0.0 {
                return f64::INFINITY;
            }
            let t = (off.abs() - self.radius) / closing;
            there += t * direction.dot(&self.along);
            if (0.0..=self.length).contains(&there) {
                return t;
            }
        } else if (0.0..=self.length).contains(&place) {
            return 0.0;
        }
        if there < 0.0 {
            disc_entry(from_a, direction, self.radius)
        } else {
            disc_entry(from_a - self.along * self.length, direction, self.radius)
        }
    }
}

/// Where a leg from `from`, relative to the disc's centre, enters a disc; 0 if it starts inside.
#[inline]
fn disc_entry(from: Vector2<f64>, direction: Vector2<f64>, radius: f64) -> f64 {
    let outside = from.norm_squared() - radius * radius;
    if outside < 0.0 {
        return 0.0;
    }
    let middle = -from.dot(&direction);
    let half_squared = middle * middle - outside;
    if half_squared <= 0.0 || middle <= 0.0 {
        return f64::INFINITY;
    }
    (middle - half_squared.sqrt()).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn entry_is_where_small_steps_meet_the_capsule(
            ends in proptest::array::uniform4(-2.0..2.0_f64), x in -3.0..3.0_f64, y in -3.0..3.0_f64,
            angle in -3.2..3.2_f64, radius in 0.05..0.8_f64,
        ) {
            let wall = Segment::new(Point2::new(ends[0], ends[1]), Point2::new(ends[2], ends[3]));
            let (origin, direction) = (Point2::new(x, y), Vector2::new(libm::cos(angle), libm::sin(angle)));
            let capsule = Capsule::new(&wall, radius);
            let entry = capsule.entry(origin, direction);
            let step = 1e-3;
            let inside = |slack: f64| move |i: &usize| wall.distance(origin + direction * (*i as f64 * step)) < radius - slack;
            let first = (0..8000).find(inside(0.0)).map_or(f64::INFINITY, |i| i as f64 * step);
            // Steps may miss a chord shorter than themselves, which is no deeper than 1e-5 m.
            prop_assert!(entry <= first, "{entry} after {first}");
            prop_assert!(first <= entry + step || entry > 7.9 || (0..8000).find(inside(-1e-5)).is_some_and(|i| i as f64 * step <= entry + step));
            prop_assert_eq!(capsule.contains(origin), wall.distance(origin) < radius);
        }
    }

    #[test]
    fn a_wall_without_length_is_a_disc_and_touching_is_not_entering() {
        let at = Point2::new(1.0, 0.0);
        let disc = Capsule::new(&Segment::new(at, at), 0.25);
        let east = Vector2::x();
        assert_eq!(disc.entry(Point2::origin(), east), 0.75);
        assert!(disc.entry(Point2::new(0.0, 0.25), east).is_infinite());
        assert_eq!(disc.entry(Point2::new(0.9, 0.0), east), 0.0);
        assert!(disc.entry(Point2::new(1.25, 0.0), east).is_infinite());
    }
}

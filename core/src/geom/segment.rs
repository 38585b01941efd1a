//! Line segments, such as straight pieces of wall.

use std::ops::Mul;

use nalgebra::{Point2, Vector2};

use super::Pose2;
use crate::geom::Length;

/// The straight piece between two points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    /// One end.
    pub a: Point2<f64>,
    /// The other end.
    pub b: Point2<f64>,
}

impl Segment {
    /// The segment from `a` to `b`.
    #[must_use]
    pub fn new(a: Point2<f64>, b: Point2<f64>) -> Self {
        Self { a, b }
    }

    /// The vector from `a` to `b`.
    #[must_use]
    pub fn vector(&self) -> Vector2<f64> {
        self.b - self.a
    }

    /// Direction from `a` to `b`, rad.
    #[must_use]
    pub fn heading(&self) -> f64 {
        let along = self.vector();
        libm::atan2(along.y, along.x)
    }

    /// Length, m.
    #[must_use]
    pub fn length(&self) -> f64 {
        self.vector().length()
    }

    /// The point of the segment nearest to `point`.
    #[must_use]
    pub fn closest_point(&self, point: Point2<f64>) -> Point2<f64> {
        let along = self.vector();
        let squared = along.norm_squared();
        if squared <= 0.0 {
            return self.a;
        }
        let t = (point - self.a).dot(&along) / squared;
        self.a + along * t.clamp(0.0, 1.0)
    }

    /// Distance of a point from the segment, m.
    #[must_use]
    pub fn distance(&self, point: Point2<f64>) -> f64 {
        (point - self.closest_point(point)).length()
    }

    /// Least distance between two segments, m; 0 if they cross.
    #[must_use]
    pub fn distance_to(&self, other: &Self) -> f64 {
        if self.crosses(other) {
            return 0.0;
        }
        self.distance(other.a)
            .min(self.distance(other.b))
            .min(other.distance(self.a))
            .min(other.distance(self.b))
    }

    /// Whether the segments cross between their ends. [`Segment::distance_to`] also gives 0 for
    /// ends that only touch.
    #[must_use]
    pub fn crosses(&self, other: &Self) -> bool {
        let side = |s: &Self, p: Point2<f64>| s.vector().perp(&(p - s.a));
        side(self, other.a) * side(self, other.b) < 0.0
            && side(other, self.a) * side(other, self.b) < 0.0
    }

    /// Distance along a ray to the segment, m; `None` if the ray misses it. `direction` has unit
    /// length.
    #[inline]
    #[must_use]
    pub fn hit_by_ray(&self, origin: Point2<f64>, direction: Vector2<f64>) -> Option<f64> {
        let along = self.vector();
        let to_a = self.a - origin;
        let denominator = direction.perp(&along);
        if denominator.abs() < 1e-12 {
            return None;
        }
        let distance = to_a.perp(&along) / denominator;
        let t = to_a.perp(&direction) / denominator;
        (distance >= 0.0 && (0.0..=1.0).contains(&t)).then_some(distance)
    }
}

/// Moves a segment, both ends.
impl Mul<Segment> for Pose2 {
    type Output = Segment;

    fn mul(self, segment: Segment) -> Segment {
        Segment::new(self * segment.a, self * segment.b)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn segment() -> impl Strategy<Value = Segment> {
        (-5.0..5.0_f64, -5.0..5.0_f64, -5.0..5.0_f64, -5.0..5.0_f64)
            .prop_map(|(ax, ay, bx, by)| Segment::new(Point2::new(ax, ay), Point2::new(bx, by)))
    }

    fn sampled(s: &Segment) -> impl Iterator<Item = Point2<f64>> + '_ {
        (0..=400).map(|i| s.a + s.vector() * (f64::from(i) / 400.0))
    }

    proptest! {
        #[test]
        fn distance_is_the_least_over_sampled_points(s in segment(), o in segment()) {
            let step = (s.length() + o.length()) / 400.0;
            let to_point = sampled(&s).map(|p| (p - o.a).length()).fold(f64::INFINITY, f64::min);
            prop_assert!((s.distance(o.a) - to_point).abs() <= step);
            let between = sampled(&s).map(|p| o.distance(p)).fold(f64::INFINITY, f64::min);
            prop_assert!((s.distance_to(&o) - between).abs() <= step);
        }

        #[test]
        fn ray_hit_lies_on_both(s in segment(), x in -5.0..5.0_f64, y in -5.0..5.0_f64, angle in -3.2..3.2_f64) {
            let origin = Point2::new(x, y);
            let direction = Vector2::new(libm::cos(angle), libm::sin(angle));
            if let Some(distance) = s.hit_by_ray(origin, direction) {
                prop_assert!(s.distance(origin + direction * distance) < 1e-6);
            }
        }

        #[test]
        fn ray_towards_a_place_on_the_segment_hits_it_and_one_away_does_not(
            s in segment(), x in -5.0..5.0_f64, y in -5.0..5.0_f64, part in 0.01..0.99_f64,
        ) {
            let origin = Point2::new(x, y);
            let aim = s.a + s.vector() * part;
            let way = aim - origin;
            // Not along the segment, where the hit would be ambiguous.
            prop_assume!(way.length() > 1e-3 && way.normalize().perp(&s.vector()).abs() > 1e-3);
            let hit = s.hit_by_ray(origin, way.normalize());
            prop_assert!(hit.is_some_and(|distance| (distance - way.length()).abs() < 1e-6), "{hit:?}");
            prop_assert_eq!(s.hit_by_ray(origin, -way.normalize()), None);
        }
    }

    #[test]
    fn point_like_segment_is_a_point() {
        let s = Segment::new(Point2::new(1.0, 1.0), Point2::new(1.0, 1.0));
        assert!((s.distance(Point2::new(1.0, 3.0)) - 2.0).abs() < 1e-12);
    }
}

//! Corners round which a taut path winds, and the tangents between them.
//!
//! In: ends of walls as circles, free or partly blocked by other walls. Out: tangents from circle
//! to circle, and which arcs are free.
//!
//! With the left normal n of a leg's direction u, the centre of a circle that is wound
//! counter-clockwise lies at +R n from the point of tangency, of one wound clockwise at -R n. So
//! for signed radii σ and centres c: c₂ - c₁ = L u + (σ₂ - σ₁) n, and one formula gives all four
//! tangents, and those to points with σ = 0.

use std::f64::consts::{FRAC_PI_2, TAU};

use nalgebra::{Point2, Vector2};

use crate::geom::{Length, Segment, sin_cos};

/// A circle and the direction in which the path winds round it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Wound {
    pub(super) centre: Point2<f64>,
    /// Positive: counter-clockwise; negative: clockwise; 0: a point.
    pub(super) radius: f64,
}

/// A directed leg that touches two circles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Tangent {
    pub(super) leg: Segment,
    pub(super) length: f64,
    /// Direction, rad.
    pub(super) heading: f64,
}

impl Tangent {
    /// The tangent from one circle to another; `None` if one contains the other.
    pub(super) fn between(from: &Wound, to: &Wound) -> Option<Self> {
        let between = to.centre - from.centre;
        let (squared, turn) = (between.norm_squared(), to.radius - from.radius);
        let length_squared = squared - turn * turn;
        if length_squared <= 0.0 {
            return None;
        }
        let length = length_squared.sqrt();
        let across = Vector2::new(-between.y, between.x);
        let direction = (between * length - across * turn) / squared;
        let normal = Vector2::new(-direction.y, direction.x);
        Some(Self {
            leg: Segment::new(
                from.centre - normal * from.radius,
                to.centre - normal * to.radius,
            ),
            length,
            heading: libm::atan2(direction.y, direction.x),
        })
    }
}

impl Wound {
    /// Angle from one heading to another along the arc, in [0, 2π).
    pub(super) fn turn(&self, from: f64, to: f64) -> f64 {
        let turn = (to - from) * self.radius.signum();
        let turn = turn - TAU * (turn / TAU).floor();
        // Rounding: a tangent that goes straight on must not count as a full turn.
        if turn > TAU - 1e-9 { 0.0 } else { turn }
    }

    /// The point where a leg of the given heading touches the circle, as an angle in [0, 2π).
    pub(super) fn angle_at(&self, heading: f64) -> f64 {
        let angle = heading - FRAC_PI_2 * self.radius.signum();
        angle - TAU * (angle / TAU).floor()
    }
}

/// The arcs of a circle that are blocked, as angles in [0, 2π], in order.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Blocked(Vec<(f64, f64)>);

impl Blocked {
    /// Which arcs of the circle lie nearer than `keep` to one of the walls, or out of bounds.
    pub(super) fn new(
        centre: Point2<f64>,
        radius: f64,
        keep: f64,
        walls: &[Segment],
        bounds: (Point2<f64>, Point2<f64>),
    ) -> Self {
        let mut angles = vec![0.0, TAU];
        let reach = radius + keep;
        let near: Vec<&Segment> = walls
            .iter()
            .filter(|w| w.distance(centre) < reach)
            .collect();
        for wall in &near {
            crossings(centre, radius, keep, wall, &mut angles);
        }
        let (low, high) = bounds;
        for (normal, off) in [
            (Vector2::x(), low.x - centre.x),
            (Vector2::x(), high.x - centre.x),
            (Vector2::y(), low.y - centre.y),
            (Vector2::y(), high.y - centre.y),
        ] {
            on_line(normal, off / radius, &mut angles);
        }
        angles.sort_unstable_by(f64::total_cmp);
        let is_blocked = |angle: f64| {
            let (sin, cos) = sin_cos(angle);
            let at = centre + Vector2::new(cos, sin) * radius;
            near.iter().any(|w| w.distance(at) < keep) || !(at >= low && at <= high)
        };
        let mut arcs: Vec<(f64, f64)> = vec![];
        for pair in angles.windows(2) {
            if pair[1] <= pair[0] || !is_blocked(0.5 * (pair[0] + pair[1])) {
                continue;
            }
            match arcs.last_mut() {
                Some(last) if last.1 >= pair[0] => last.1 = pair[1],
                _ => arcs.push((pair[0], pair[1])),
            }
        }
        Self(arcs)
    }

    /// Whether no part of the circle is free.
    pub(super) fn is_all(&self) -> bool {
        self.0 == [(0.0, TAU)]
    }

    /// Whether the arc from an angle in [0, 2π) on, by `turn` ≥ 0 in the sense of `sign`, is free.
    pub(super) fn is_free(&self, from: f64, turn: f64, sign: f64) -> bool {
        let (begin, end) = if sign > 0.0 {
            (from, from + turn)
        } else {
            (from - turn, from)
        };
        let meets = |low: f64, high: f64| begin < high && end > low;
        !self.0.iter().any(|&(low, high)| {
            meets(low, high) || meets(low + TAU, high + TAU) || meets(low - TAU, high - TAU)
        })
    }
}

/// Angles at which a circle enters or leaves a capsule.
fn crossings(centre: Point2<f64>, radius: f64, keep: f64, wall: &Segment, angles: &mut Vec<f64>) {
    let length = wall.length();
    if length > 0.0 {
        let along = wall.vector() / length;
        let normal = Vector2::new(-along.y, along.x);
        let off = normal.dot(&(wall.a - centre));
        on_line(normal, (off + keep) / radius, angles);
        on_line(normal, (off - keep) / radius, angles);
    }
    for end in [wall.a, wall.b] {
        let to_end = end - centre;
        let distance = to_end.length();
        if distance > 0.0 {
            let (d, r, k) = (distance, radius, keep);
            on_line(to_end / d, (d * d + r * r - k * k) / (2.0 * d * r), angles);
        }
    }
}

/// Angles whose unit vectors have this component along the normal.
fn on_line(normal: Vector2<f64>, component: f64, angles: &mut Vec<f64>) {
    if component.abs() > 1.0 {
        return;
    }
    let (middle, half) = (libm::atan2(normal.y, normal.x), libm::acos(component));
    for angle in [middle - half, middle + half] {
        angles.push(angle - TAU * (angle / TAU).floor());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn tangents_touch_both_circles_on_the_side_they_are_wound(
            at in proptest::array::uniform4(-3.0..3.0_f64), r in -0.8..0.8_f64, s in -0.8..0.8_f64,
        ) {
            let from = Wound { centre: Point2::new(at[0], at[1]), radius: r };
            let to = Wound { centre: Point2::new(at[2], at[3]), radius: s };
            let gap = (to.centre - from.centre).length() - (r - s).abs();
            let tangent = Tangent::between(&from, &to);
            prop_assert_eq!(tangent.is_some(), gap > 0.0);
            // Circles that nearly touch internally leave a leg without direction.
            prop_assume!(gap > 1e-6);
            let Tangent { leg, length, heading } = tangent.unwrap();
            prop_assert!((leg.length() - length).abs() < 1e-9);
            let (sin, cos) = sin_cos(heading);
            prop_assert!((leg.vector() - Vector2::new(cos, sin) * length).length() < 1e-9);
            for (circle, touch) in [(from, leg.a), (to, leg.b)] {
                let off = Vector2::new(cos, sin).perp(&(circle.centre - touch));
                prop_assert!((off - circle.radius).abs() < 1e-9);
                prop_assert!(((circle.centre - touch).length() - circle.radius.abs()).abs() < 1e-9);
                if circle.radius != 0.0 {
                    let (sin, cos) = sin_cos(circle.angle_at(heading));
                    let on = circle.centre + Vector2::new(cos, sin) * circle.radius.abs();
                    prop_assert!((on - touch).length() < 1e-8);
                }
            }
        }

        #[test]
        fn blocked_arcs_are_those_that_sampling_finds(
            walls in proptest::collection::vec(proptest::array::uniform4(-1.0..1.0_f64), 0..5),
            from in 0.0..6.2_f64, turn in 0.0..6.2_f64, sign in prop_oneof![Just(1.0), Just(-1.0)],
        ) {
            let walls: Vec<Segment> = walls.iter()
                .map(|w| Segment::new(Point2::new(w[0], w[1]), Point2::new(w[2], w[3])))
                .collect();
            let (centre, radius, keep) = (Point2::new(0.1, -0.2), 0.30001, 0.3);
            let bounds = (Point2::new(-0.3, -0.8), Point2::new(1.0, 1.0));
            let blocked = Blocked::new(centre, radius, keep, &walls, bounds);
            let deepest = (0..=2000).map(|i| {
                let (sin, cos) = sin_cos(from + sign * turn * f64::from(i) / 2000.0);
                let at = centre + Vector2::new(cos, sin) * radius;
                let room = walls.iter().map(|w| w.distance(at) - keep).fold(f64::INFINITY, f64::min);
                room.min((at - bounds.0).min()).min((bounds.1 - at).min())
            }).fold(f64::INFINITY, f64::min);
            // Within the resolution of the samples, sampling decides nothing.
            prop_assume!(deepest.abs() > 1e-3);
            prop_assert_eq!(blocked.is_free(from, turn, sign), deepest > 0.0);
        }
    }
}

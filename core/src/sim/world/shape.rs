//! Outlines, and the straight pieces they consist of.

use std::f64::consts::TAU;

use nalgebra::{Point2, Vector2};

use super::WorldError;
use super::check::{FARTHEST, check_coordinate, check_count, check_point, check_value};
use crate::geom::{Segment, sin_cos, unit_vector};

/// Greatest distance between a circle and its polygon, m.
pub(super) const CIRCLE_SAGITTA: f64 = 0.002;

/// Outlines, in metres.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// Thin walls from point to point; closed ones return to the first, as the outline of a room
    /// does.
    Polyline {
        /// At least two corners.
        points: Vec<Point2<f64>>,
        /// Whether the last corner joins the first.
        closed: bool,
    },
    /// A solid polygon.
    Polygon(Vec<Point2<f64>>),
    /// A solid rectangle.
    Rectangle {
        /// Its middle.
        centre: Point2<f64>,
        /// Full width along its own x and its own y.
        size: Vector2<f64>,
        /// Rotation of its own x axis from the world's, rad.
        angle: f64,
    },
    /// A solid disc.
    Circle {
        /// Its middle.
        centre: Point2<f64>,
        /// Its radius.
        radius: f64,
    },
}

impl Shape {
    /// Its name in world files.
    #[must_use]
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Polyline { .. } => "polyline",
            Self::Polygon(_) => "polygon",
            Self::Rectangle { .. } => "rectangle",
            Self::Circle { .. } => "circle",
        }
    }

    /// Its straight pieces.
    #[must_use]
    pub fn segments(&self) -> Vec<Segment> {
        let (corners, closed) = self.corners();
        let sides = corners
            .windows(2)
            .map(|side| Segment::new(side[0], side[1]));
        let mut segments: Vec<Segment> = sides.collect();
        if let (true, [first, _, .., last]) = (closed, corners.as_slice()) {
            segments.push(Segment::new(*last, *first));
        }
        segments
    }

    /// Whether `point` lies inside it; a polyline has no inside.
    ///
    /// Source: crossing number, Shimrat (1962), Algorithm 112.
    #[must_use]
    pub fn holds(&self, point: Point2<f64>) -> bool {
        if matches!(self, Self::Polyline { .. }) {
            return false;
        }
        let crossed = |s: &Segment| {
            (s.a.y > point.y) != (s.b.y > point.y)
                && point.x < s.a.x + (point.y - s.a.y) / (s.b.y - s.a.y) * (s.b.x - s.a.x)
        };
        self.segments().iter().filter(|s| crossed(s)).count() % 2 == 1
    }

    fn corners(&self) -> (Vec<Point2<f64>>, bool) {
        match self {
            Self::Polyline { points, closed } => (points.clone(), *closed),
            Self::Polygon(points) => (points.clone(), true),
            Self::Rectangle {
                centre,
                size,
                angle,
            } => {
                let (sin, cos) = sin_cos(*angle);
                let u = Vector2::new(cos, sin) * (0.5 * size.x);
                let v = Vector2::new(-sin, cos) * (0.5 * size.y);
                let (left, right) = (centre - u, centre + u);
                (vec![left - v, right - v, right + v, left + v], true)
            }
            Self::Circle { centre, radius } => {
                let sides = circle_sides(*radius);
                let corner =
                    |i: usize| centre + unit_vector(TAU * i as f64 / sides as f64) * *radius;
                ((0..sides).map(corner).collect(), true)
            }
        }
    }

    pub(super) fn segment_count(&self) -> usize {
        match self {
            Self::Polyline { points, closed } => {
                (points.len() + usize::from(*closed)).saturating_sub(1)
            }
            Self::Polygon(points) => points.len(),
            Self::Rectangle { .. } => 4,
            Self::Circle { radius, .. } => circle_sides(*radius),
        }
    }

    pub(super) fn check(&self, part: &str) -> Result<(), WorldError> {
        let size = |field, value: f64| {
            check_value(part, field, value, 0.001..=FARTHEST, "0.001 to 10000 m")
        };
        let corners = |points: &[Point2<f64>], least: usize, expected| {
            check_count(part, "points", points.len(), least.., expected)?;
            points.iter().try_for_each(|p| check_point(part, p))
        };
        match self {
            Self::Polyline { points, closed } => {
                let least = if *closed { 3 } else { 2 };
                corners(points, least, "at least 2, or 3 where closed")
            }
            Self::Polygon(points) => corners(points, 3, "at least 3"),
            Self::Rectangle {
                centre,
                size: full,
                angle,
            } => {
                check_point(part, centre)?;
                size("size x", full.x)?;
                size("size y", full.y)?;
                check_coordinate(part, "angle", *angle)
            }
            Self::Circle { centre, radius } => {
                check_point(part, centre)?;
                size("radius", *radius)
            }
        }
    }
}

/// Sides of a polygon that stays within [`CIRCLE_SAGITTA`] of a circle: r (1 - cos(π/n)) ≈ r π²/(2
/// n²).
fn circle_sides(radius: f64) -> usize {
    let sides = std::f64::consts::PI * (radius / (2.0 * CIRCLE_SAGITTA)).sqrt();
    (sides.ceil() as usize).clamp(8, 512)
}

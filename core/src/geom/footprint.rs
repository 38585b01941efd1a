//! The robot's outline as a second, exact test: for doors through which the disc around it does not
//! fit.
//!
//! In: a convex outline in the robot's frame, and walls. Out: whether the robot can stand in a
//! pose, drive a leg, turn on the spot, and so follow a path, without touching a wall; and how near
//! it stands to one.
//!
//! 1. Standing: a wall touches a convex outline if clipping it by all sides leaves a piece (Cyrus &
//!    Beck 1978).
//! 2. Driving straight: the swept area is the convex hull of the outline at both ends.
//! 3. Turning: nothing is touched at the beginning, and the first contact is made either by a
//!    corner of the outline on its arc, or by the end of a wall that a side sweeps over. Both are
//!    circles cut by segments, in closed form.
//! 4. Apart: of an outline and a wall that do not touch, one end of the shortest line between them
//!    is a corner of the outline or an end of the wall.

use std::f64::consts::TAU;

use nalgebra::{Point2, Vector2};

use super::{Pose2, Segment, sides_of, wrap};
use crate::geom::Length;

/// A convex outline, counter-clockwise, the robot's centre inside.
#[derive(Clone, Debug, PartialEq)]
pub struct Footprint {
    corners: Vec<Point2<f64>>,
}

impl Footprint {
    /// A rectangle about the centre; `None` if a side is not positive.
    #[must_use]
    pub fn rectangle(length: f64, width: f64) -> Option<Self> {
        let corner = |x: f64, y: f64| Point2::new(0.5 * length * x, 0.5 * width * y);
        let signs = [(1.0, -1.0), (1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0)];
        (length > 0.0 && width > 0.0).then(|| Self {
            corners: signs.map(|(x, y)| corner(x, y)).to_vec(),
        })
    }

    /// Radius of the largest disc about the centre inside the outline, m.
    #[must_use]
    pub fn radius_within(&self) -> f64 {
        let sides =
            sides_of(&self.corners).map(|(a, b)| (b - a).perp(&-a.coords) / (b - a).length());
        sides.fold(f64::INFINITY, f64::min)
    }

    /// Radius of the smallest disc about the centre that contains the outline, m.
    #[must_use]
    pub fn radius_around(&self) -> f64 {
        let corners = self.corners.iter().map(|corner| corner.coords.length());
        corners.fold(0.0, f64::max)
    }

    /// The corners in the robot's frame, m, counter-clockwise.
    #[must_use]
    pub fn corners(&self) -> &[Point2<f64>] {
        &self.corners
    }

    /// Distance of a point (robot frame, m) from the outline, m; inside it the negative distance to
    /// the nearest side.
    #[must_use]
    pub fn distance(&self, point: Point2<f64>) -> f64 {
        let mut depth = f64::INFINITY;
        let mut apart = f64::INFINITY;
        for (a, b) in sides_of(&self.corners) {
            let side = Segment::new(*a, *b);
            let along = side.vector();
            depth = depth.min(along.perp(&(point - a)) / along.length());
            apart = apart.min(side.distance(point));
        }
        if depth > 0.0 { -depth } else { apart }
    }

    /// The point of the outline nearest to a point outside of it, robot frame, m.
    #[must_use]
    pub fn closest_point(&self, point: Point2<f64>) -> Point2<f64> {
        let on_sides =
            sides_of(&self.corners).map(|(a, b)| Segment::new(*a, *b).closest_point(point));
        let nearer = |p: &Point2<f64>, q: &Point2<f64>| {
            let off = |at: &Point2<f64>| (at - point).norm_squared();
            off(p).total_cmp(&off(q))
        };
        on_sides.min_by(nearer).unwrap_or(point)
    }

    /// Step 4: the points of outline and wall that are nearest to each other, world frame, m, for a
    /// robot that does not touch the wall.
    #[must_use]
    pub fn nearest(&self, pose: &Pose2, wall: &Segment) -> [Point2<f64>; 2] {
        let seen = pose.inverse() * *wall;
        let of_corners = self.corners.iter().map(|&c| [c, seen.closest_point(c)]);
        let of_ends = [seen.a, seen.b].map(|end| [self.closest_point(end), end]);
        let pairs = of_corners.chain(of_ends);
        let apart = |[p, q]: &[Point2<f64>; 2]| (p - q).norm_squared();
        let nearest = pairs.min_by(|p, q| apart(p).total_cmp(&apart(q)));
        nearest.unwrap_or_default().map(|point| *pose * point)
    }

    fn at(&self, pose: &Pose2) -> Vec<Point2<f64>> {
        self.corners.iter().map(|&corner| *pose * corner).collect()
    }

    /// Whether the robot can stand in this pose.
    #[must_use]
    pub fn fits(&self, pose: &Pose2, walls: &[Segment]) -> bool {
        let outline = self.at(pose);
        walls.iter().all(|wall| !touches(&outline, wall))
    }

    /// Whether the robot can drive a leg, facing along it.
    #[must_use]
    pub fn drives(&self, leg: &Segment, walls: &[Segment]) -> bool {
        let heading = leg.heading();
        let mut swept = self.at(&Pose2::new(leg.a.x, leg.a.y, heading));
        swept.extend(self.at(&Pose2::new(leg.b.x, leg.b.y, heading)));
        let swept = hull(swept);
        walls.iter().all(|wall| !touches(&swept, wall))
    }

    /// Whether the robot can turn on the spot from one heading by `turn` rad, positive to the left.
    #[must_use]
    pub fn turns(&self, pose: &Pose2, turn: f64, walls: &[Segment]) -> bool {
        self.fits(pose, walls) && walls.iter().all(|wall| !self.sweeps_over(pose, turn, wall))
    }

    fn sweeps_over(&self, pose: &Pose2, turn: f64, wall: &Segment) -> bool {
        let in_robot = pose.inverse() * *wall;
        // Corners rotate by `turn`; in the robot's frame, ends of walls rotate the other way.
        let by_corner = self.corners.iter().any(|&c| meets(c, turn, &in_robot));
        let sides = || sides_of(&self.corners).map(|(a, b)| Segment::new(*a, *b));
        let over_end = [in_robot.a, in_robot.b]
            .iter()
            .any(|&end| sides().any(|side| meets(end, -turn, &side)));
        by_corner || over_end
    }

    /// Whether the robot can follow straight legs from a heading, turning on the spot at their
    /// corners.
    pub fn follows(
        &self,
        legs: impl IntoIterator<Item = Segment>,
        heading: f64,
        walls: &[Segment],
    ) -> bool {
        let mut heading = heading;
        let mut legs = legs.into_iter().filter(|leg| leg.length() > 0.0);
        legs.all(|leg| {
            let next = leg.heading();
            let pose = Pose2::new(leg.a.x, leg.a.y, heading);
            let turn = wrap(next - heading);
            heading = next;
            self.turns(&pose, turn, walls) && self.drives(&leg, walls)
        })
    }
}

/// Whether a point that rotates about the origin by `turn` meets a segment.
fn meets(point: Point2<f64>, turn: f64, segment: &Segment) -> bool {
    let along = segment.vector();
    // |a + t v|² = r²
    let (a, b, c) = (
        along.norm_squared(),
        segment.a.coords.dot(&along),
        segment.a.coords.norm_squared() - point.coords.norm_squared(),
    );
    let squared = b * b - a * c;
    if a <= 0.0 || squared < 0.0 {
        return false;
    }
    let root = squared.sqrt();
    [(-b - root) / a, (-b + root) / a].iter().any(|&t| {
        (0.0..=1.0).contains(&t) && {
            let at = segment.a.coords + along * t;
            let from = libm::atan2(point.y, point.x);
            let off = (libm::atan2(at.y, at.x) - from) * turn.signum();
            off - TAU * (off / TAU).floor() <= turn.abs()
        }
    })
}

/// Whether a segment touches a convex outline: each side clips the segment, whose remaining part is
/// kept as parameters from 0 to 1.
fn touches(outline: &[Point2<f64>], segment: &Segment) -> bool {
    let (mut from, mut to) = (0.0_f64, 1.0_f64);
    let along = segment.vector();
    for (a, b) in sides_of(outline) {
        let side = b - a;
        let inside = Vector2::new(-side.y, side.x);
        let (depth, rate) = (inside.dot(&(segment.a - a)), inside.dot(&along));
        if rate == 0.0 {
            if depth < 0.0 {
                return false;
            }
        } else if rate > 0.0 {
            from = from.max(-depth / rate);
        } else {
            to = to.min(-depth / rate);
        }
    }
    from <= to
}

/// Convex hull, counter-clockwise (Andrew 1979).
fn hull(mut points: Vec<Point2<f64>>) -> Vec<Point2<f64>> {
    points.sort_unstable_by(|p, q| p.x.total_cmp(&q.x).then(p.y.total_cmp(&q.y)));
    let chain = |points: &mut dyn Iterator<Item = Point2<f64>>| {
        let mut chain: Vec<Point2<f64>> = vec![];
        for point in points {
            while let [.., a, b] = chain[..]
                && (b - a).perp(&(point - b)) <= 0.0
            {
                chain.pop();
            }
            chain.push(point);
        }
        chain.pop();
        chain
    };
    let mut lower = chain(&mut points.iter().copied());
    lower.extend(chain(&mut points.iter().rev().copied()));
    lower
}

#[cfg(test)]
mod tests;

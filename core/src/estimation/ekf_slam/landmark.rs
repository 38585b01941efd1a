//! A wall as the state keeps it and as the map shows it.

use nalgebra::{Matrix2, Point2, Vector2};

use crate::geom::{Line, sin_cos, symmetrize};

/// Name of a landmark, the same for its whole life and never given again.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct LandmarkId(pub u32);

/// A wall in the map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Landmark {
    /// Its name.
    pub id: LandmarkId,
    /// The line in the map frame.
    pub line: Line,
    /// Covariance of (α, r).
    pub cov: Matrix2<f64>,
    /// Where the part seen so far begins and ends, map frame.
    pub ends: [Point2<f64>; 2],
    /// How often it was seen.
    pub sightings: u32,
    /// Whether that is often enough to be a wall.
    pub is_confirmed: bool,
}

/// A landmark's place in the state is `ROBOT + 2 * index`.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Entry {
    pub(super) id: LandmarkId,
    /// Where r counts from, map frame; never moves.
    pub(super) anchor: Point2<f64>,
    /// (α, r), r signed.
    pub(super) line: [f64; 2],
    /// α at the first sighting.
    pub(super) first_alpha: f64,
    /// From where to where it was seen, m along (-sin α, cos α) from the anchor's foot on the line.
    pub(super) extent: [f64; 2],
    /// The part of it that the last scan that saw it saw.
    pub(super) seen_now: [f64; 2],
    pub(super) sightings: u32,
    pub(super) last_seen: u32,
}

impl Entry {
    pub(super) fn tangent(&self) -> Vector2<f64> {
        let (sin, cos) = sin_cos(self.line[0]);
        Vector2::new(-sin, cos)
    }

    pub(super) fn ends(&self) -> [Point2<f64>; 2] {
        let tangent = self.tangent();
        let foot = self.anchor + Vector2::new(tangent.y, -tangent.x) * self.line[1];
        self.extent.map(|along| foot + tangent * along)
    }

    /// The line and its covariance with r counted from the origin of the map, r ≥ 0.
    pub(super) fn in_map(&self, cov: &Matrix2<f64>) -> (Line, Matrix2<f64>) {
        let tangent = self.tangent();
        let normal = Vector2::new(tangent.y, -tangent.x);
        let r = self.line[1] + normal.dot(&self.anchor.coords);
        let sign = if r < 0.0 { -1.0 } else { 1.0 };
        let jacobian = Matrix2::new(1.0, 0.0, sign * tangent.dot(&self.anchor.coords), sign);
        let mut cov = jacobian * cov * jacobian.transpose();
        symmetrize(&mut cov);
        (Line::new(self.line[0], r), cov)
    }
}

/// The least interval around two.
pub(super) fn hull(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0].min(b[0]), a[1].max(b[1])]
}

//! In: a line seen now and a line expected from the map. Out: their distance, in standard
//! deviations and in metres.
//!
//! Lines are compared as oriented ones: the normal points from the viewer's side into the wall, and
//! r is signed. So the two faces of a wall are different lines even if their (α, r) agree, nothing
//! jumps when a line passes through the origin, and no Jacobian has to flip its sign.
//!
//! Source: TDK 2016 §3.2, the gate vᵀ Z⁻¹ v ≤ g².

use nalgebra::{Matrix2, Point2, Vector2};

use crate::features::LineFeature;
use crate::geom::wrap;

/// A landmark as the filter expects to see it, in the robot frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExpectedLine {
    /// Direction of the normal from the viewer into the wall, rad.
    pub alpha: f64,
    /// Signed distance of the line along that normal, m.
    pub r: f64,
    /// Covariance of (α, r): H P Hᵀ, without the sensor's part.
    pub cov: Matrix2<f64>,
    /// Where the known part of the wall begins and ends.
    pub ends: [Point2<f64>; 2],
}

/// Difference between a sighting and what was expected.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Innovation {
    /// (α, r) seen minus expected; of a point, (x, y).
    pub v: Vector2<f64>,
    /// Covariance of `v`.
    pub cov: Matrix2<f64>,
    /// vᵀ Z⁻¹ v.
    pub d2: f64,
}

impl Innovation {
    /// `None` if the covariance is not positive definite.
    #[must_use]
    pub fn new(v: Vector2<f64>, cov: Matrix2<f64>) -> Option<Self> {
        let determinant = cov[(0, 0)] * cov[(1, 1)] - cov[(0, 1)] * cov[(1, 0)];
        if !(cov[(0, 0)] > 0.0 && determinant > 0.0) {
            return None;
        }
        let d2 = (cov[(1, 1)] * v.x * v.x - (cov[(0, 1)] + cov[(1, 0)]) * v.x * v.y
            + cov[(0, 0)] * v.y * v.y)
            / determinant;
        d2.is_finite().then_some(Self { v, cov, d2 })
    }
}

impl ExpectedLine {
    /// Compares with a sighting; `None` if it shows the other face of the wall, or if the
    /// covariance is not positive definite.
    #[must_use]
    pub fn innovation(&self, seen: &OrientedLine) -> Option<Innovation> {
        let v = Vector2::new(wrap(seen.alpha - self.alpha), seen.r - self.r);
        if v.x.abs() > std::f64::consts::FRAC_PI_2 {
            return None;
        }
        Innovation::new(v, self.cov + seen.cov)
    }
}

/// Free distance between the seen part of a wall and its known part with these `ends`, measured
/// along the seen line, m; negative if they overlap.
#[must_use]
pub fn gap(ends: [Point2<f64>; 2], seen: &LineFeature) -> f64 {
    let normal = seen.line.normal();
    let along = |p: Point2<f64>| normal.perp(&p.coords);
    let span = |[a, b]: [Point2<f64>; 2]| {
        let (a, b) = (along(a), along(b));
        (a.min(b), a.max(b))
    };
    let ((from, to), (known_from, known_to)) = (span(seen.ends), span(ends));
    (known_from - to).max(from - known_to)
}

/// A seen line with its normal from the viewer into the wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrientedLine {
    /// Direction of the normal, rad.
    pub alpha: f64,
    /// Signed distance from the robot's origin, m: negative only if the line passes between it and
    /// the sensor.
    pub r: f64,
    /// Covariance of (α, r).
    pub cov: Matrix2<f64>,
}

impl OrientedLine {
    /// Orients a feature.
    #[must_use]
    pub fn of(feature: &LineFeature) -> Self {
        let (alpha, r) = (feature.line.alpha(), feature.line.r());
        if feature.seen_from_origin_side {
            return Self {
                alpha,
                r,
                cov: feature.cov,
            };
        }
        let c = &feature.cov;
        Self {
            alpha: wrap(alpha + std::f64::consts::PI),
            r: -r,
            cov: Matrix2::new(c[(0, 0)], -c[(0, 1)], -c[(1, 0)], c[(1, 1)]),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::geom::Length;
    use crate::geom::Line;

    fn feature(alpha: f64, r: f64, from: f64, to: f64) -> LineFeature {
        let line = Line::new(alpha, r);
        let foot = line.normal() * line.r();
        let tangent = Vector2::new(-line.normal().y, line.normal().x);
        LineFeature {
            line,
            cov: Matrix2::new(1e-4, 2e-5, 2e-5, 4e-4),
            ends: [from, to].map(|t| Point2::from(foot + tangent * t)),
            seen_from_origin_side: true,
            first_beam: 0,
            last_beam: 9,
            n_points: 10,
            chi2: 8.0,
            by_heading: [Vector2::zeros(); 2],
        }
    }

    fn expected(alpha: f64, r: f64, from: f64, to: f64) -> ExpectedLine {
        ExpectedLine {
            alpha,
            r,
            cov: Matrix2::new(3e-4, -1e-5, -1e-5, 1e-4),
            ends: feature(alpha, r, from, to).ends,
        }
    }

    #[test]
    fn distance_is_that_of_the_dense_inverse_also_across_pi() {
        for alpha in [0.0, 3.0, PI, -3.1] {
            let seen = OrientedLine::of(&feature(alpha + 0.05, 2.03, 0.0, 1.0));
            let innovation = expected(alpha, 2.0, 0.0, 1.0).innovation(&seen).unwrap();
            let v = Vector2::new(0.05, 0.03);
            let inverse = (expected(alpha, 2.0, 0.0, 1.0).cov + seen.cov)
                .try_inverse()
                .unwrap();
            assert!((innovation.v - v).length() < 1e-12);
            assert!((innovation.d2 - (v.transpose() * inverse * v)[0]).abs() < 1e-9);
        }
    }

    #[test]
    fn other_face_of_a_wall_is_another_line() {
        let seen = OrientedLine::of(&feature(PI, 0.0, 0.0, 1.0));
        assert!(expected(0.0, 0.0, 0.0, 1.0).innovation(&seen).is_none());
    }

    #[test]
    fn line_between_sensor_and_origin_keeps_its_face() {
        // The sensor sits in front of the robot's origin and looks back at a wall line that passes
        // between the two: the normal from the sensor into the wall points backwards.
        let mut behind = feature(0.0, 0.02, 0.0, 1.0);
        behind.seen_from_origin_side = false;
        let oriented = OrientedLine::of(&behind);
        assert!((oriented.alpha - PI).abs() < 1e-12 && (oriented.r + 0.02).abs() < 1e-12);
        let innovation = expected(PI, -0.02, 0.0, 1.0).innovation(&oriented).unwrap();
        assert!(innovation.d2 < 1e-12);
    }

    #[test]
    fn gap_is_the_free_distance_along_the_wall() {
        let wall = expected(1.0, 2.0, -1.0, 1.0);
        for (from, to, free) in [
            (1.5, 2.0, 0.5),
            (-3.0, -1.2, 0.2),
            (0.0, 5.0, -1.0),
            (-0.5, 0.5, -1.5),
        ] {
            assert!((gap(wall.ends, &feature(1.0, 2.0, from, to)) - free).abs() < 1e-12);
            assert!((gap(wall.ends, &feature(1.0, 2.0, to, from)) - free).abs() < 1e-12);
        }
    }

    #[test]
    fn broken_covariance_matches_nothing() {
        let seen = OrientedLine::of(&feature(0.0, 1.0, 0.0, 1.0));
        let mut wall = expected(0.0, 1.0, 0.0, 1.0);
        wall.cov[(0, 0)] = -1.0;
        assert!(wall.innovation(&seen).is_none());
        wall.cov[(0, 0)] = f64::NAN;
        assert!(wall.innovation(&seen).is_none());
    }
}

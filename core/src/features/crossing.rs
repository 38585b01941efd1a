//! In: the lines of a scan. Out: the places where two of them cross, with covariance.
//!
//! Source: Pilch 2016 §3.5.1: if lines are exact, their crossings are found again at the same
//! place.
//!
//! 1. p solves nᵢ · p = rᵢ with nᵢ = (cos αᵢ, sin αᵢ): p = (r₁ sin α₂ - r₂ sin α₁, r₂ cos α₁ - r₁
//!    cos α₂) / sin(α₂ - α₁).
//! 2. From nᵢ · dp = drᵢ - (tᵢ · p) dαᵢ, tᵢ = dnᵢ/dα: an error of a line acts on p as a shift of
//!    its foot by vᵢ = drᵢ - (tᵢ · p) dαᵢ, along a column of the inverse of (n₁, n₂)ᵀ. So cov =
//!    var(v₁) a aᵀ + var(v₂) b bᵀ, because the two lines have no beam in common.
//! 3. Pilch keeps all crossings. A crossing far from the seen part of either wall depends more on
//!    the walls' directions than on a place, so this distance is limited by `reach`.

use std::f64::consts::FRAC_PI_2;

use nalgebra::{Matrix2, Point2, Vector2};

use super::feature::LineFeature;
use super::point::{PointFeature, PointKind, probability_within};
use crate::bounds::config;
use crate::geom::{Length, Line, wrap};

config! {
    /// Which crossings of lines are features.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct CrossingConfig {
        /// Whether they are looked for. Default yes.
        pub is_on: bool = true,
        /// Smallest angle between two lines, rad. Default 0.5 (30°). Larger: fewer, better placed.
        pub min_angle: f64 = 0.5,
        /// Farthest from the seen part of either wall, m. Default 0.3. Larger: also corners that
        /// something hides, and places where nothing is.
        pub reach: f64 = 0.3,
    }
}

/// Where two lines cross, with its covariance if those of (α, r) are given. `None` if the lines are
/// parallel.
pub(super) fn crossing(
    [(a, cov_a), (b, cov_b)]: [(Line, Matrix2<f64>); 2],
) -> Option<(Point2<f64>, Matrix2<f64>)> {
    let (na, nb) = (a.normal(), b.normal());
    let sin = na.perp(&nb);
    let p = Vector2::new(a.r() * nb.y - b.r() * na.y, b.r() * na.x - a.r() * nb.x) / sin;
    let along_a = Vector2::new(nb.y, -nb.x) / sin;
    let along_b = Vector2::new(-na.y, na.x) / sin;
    let var = |normal: Vector2<f64>, cov: Matrix2<f64>| {
        let by = Vector2::new(-normal.perp(&p), 1.0);
        by.dot(&(cov * by))
    };
    let cov = along_a * along_a.transpose() * var(na, cov_a)
        + along_b * along_b.transpose() * var(nb, cov_b);
    let is_finite = p.iter().chain(&cov).all(|v| v.is_finite());
    is_finite.then_some((Point2::from(p), cov))
}

/// The angle at which two lines cross, 0 to π/2, rad.
pub(super) fn crossing_angle(a: &Line, b: &Line) -> f64 {
    let turn = wrap(b.alpha() - a.alpha()).abs();
    turn.min(std::f64::consts::PI - turn)
}

/// The crossings of all pairs, added to `found` in the order of the lines.
pub(super) fn crossings(
    lines: &[LineFeature],
    config: &CrossingConfig,
    found: &mut Vec<PointFeature>,
) {
    let pairs = lines
        .iter()
        .enumerate()
        .flat_map(|(i, a)| lines.iter().skip(i + 1).map(move |b| (a, b)));
    for (a, b) in pairs {
        let angle = crossing_angle(&a.line, &b.line);
        if angle < config.min_angle {
            continue;
        }
        let Some((position, cov)) = crossing([(a.line, a.cov), (b.line, b.cov)]) else {
            continue;
        };
        if beside(a, position).max(beside(b, position)) > config.reach {
            continue;
        }
        let sigma = (a.cov[(0, 0)] + b.cov[(0, 0)]).sqrt();
        found.push(PointFeature {
            position,
            cov,
            kind: PointKind::Crossing,
            // Noise that carries the angle past a right angle does not make it a sharp one.
            confidence: probability_within(
                angle.min(FRAC_PI_2),
                sigma,
                [config.min_angle, f64::INFINITY],
            ),
            beams: [a.first_beam, b.last_beam],
        });
    }
}

/// The distance of a point of a line from the seen part of it, m.
fn beside(line: &LineFeature, point: Point2<f64>) -> f64 {
    let [from, to] = line.ends;
    let along = to - from;
    let length = along.length();
    if length <= 0.0 {
        return (point - from).length();
    }
    let at = (point - from).dot(&along) / length;
    (-at).max(at - length).max(0.0)
}

#[cfg(test)]
mod tests;

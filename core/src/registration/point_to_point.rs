//! Distances of points to the places of their surfels.
//!
//! A pair's residual is r = p - q for the point p and the surfel's place q. It is the metric of the
//! first ICP: it needs no normals, but along a wall it pulls points towards where the map was
//! sampled, which takes many iterations.
//!
//! Source: Besl & McKay (1992), "A method for registration of 3-D shapes".

use nalgebra::Vector3;

use super::gauss_newton::{MatchConfig, Pair, Sums};

/// The sums of all pairs, each weighted by a Cauchy kernel of this scale, m.
pub(super) fn sums<'a>(
    pairs: impl Iterator<Item = Pair<'a>>,
    kernel: f64,
    config: &MatchConfig,
) -> Sums {
    let scale = 1.0 / (kernel * kernel);
    let limit = config.inlier_kernels * kernel;
    let mut sums = Sums::default();
    for Pair { arm, place, surfel } in pairs {
        let residual = place - surfel.position;
        let square = residual.norm_squared();
        let weight = 1.0 / (1.0 + square * scale);
        // Derivatives of both coordinates by x, y and the turn.
        let by_x = Vector3::new(1.0, 0.0, -arm.y);
        let by_y = Vector3::new(0.0, 1.0, arm.x);
        sums.hessian += (by_x * by_x.transpose() + by_y * by_y.transpose()) * weight;
        sums.gradient += (by_x * residual.x + by_y * residual.y) * weight;
        sums.matched += 1;
        if square < limit * limit {
            sums.inliers += 1;
            sums.squares += square;
        }
    }
    sums
}

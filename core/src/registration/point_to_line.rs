//! Distances of points to the lines of their surfels.
//!
//! A pair's residual is r = nᵀ(p - q) for the point p, the surfel's place q and normal n. Moving
//! along a wall costs nothing, so points slide along it to where they belong, in few iterations.
//!
//! Source: Censi (2008), "An ICP variant using a point-to-line metric".

use nalgebra::{Matrix3, Vector3};

use super::gauss_newton::{MatchConfig, Pair, Sums};

/// The sums of all pairs, each weighted by a Cauchy kernel of this scale, m.
pub(super) fn sums<'a>(
    pairs: impl Iterator<Item = Pair<'a>>,
    kernel: f64,
    config: &MatchConfig,
) -> Sums {
    let scale = 1.0 / (kernel * kernel);
    let limit = config.inlier_kernels * kernel;
    let (mut xx, mut xy, mut yy, mut xt, mut yt, mut tt) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    let (mut gx, mut gy, mut gt) = (0.0, 0.0, 0.0);
    let (mut matched, mut inliers, mut squares) = (0, 0, 0.0);
    pairs.for_each(|Pair { arm, place, surfel }| {
        let normal = surfel.normal;
        let residual = normal.dot(&(place - surfel.position));
        let weight = 1.0 / (1.0 + residual * residual * scale);
        // The residual's derivative by the turn: the normal on the arm turned by +90°.
        let by_turn = normal.y * arm.x - normal.x * arm.y;
        let (wx, wy, wt) = (weight * normal.x, weight * normal.y, weight * by_turn);
        xx += wx * normal.x;
        xy += wx * normal.y;
        yy += wy * normal.y;
        xt += wx * by_turn;
        yt += wy * by_turn;
        tt += wt * by_turn;
        gx += wx * residual;
        gy += wy * residual;
        gt += wt * residual;
        matched += 1;
        if residual.abs() < limit {
            inliers += 1;
            squares += residual * residual;
        }
    });
    Sums {
        hessian: Matrix3::new(xx, xy, xt, xy, yy, yt, xt, yt, tt),
        gradient: Vector3::new(gx, gy, gt),
        matched,
        inliers,
        squares,
    }
}

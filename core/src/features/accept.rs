//! In: a piece. Out: its line, if it is surely a wall.
//!
//! 1. Points at a corner or an edge are given up on both sides: which wall they belong to is anyone's guess, and the wrong
//!    guess pulls the line every time the same way.
//! 2. Fit with covariance; short, sparse, crooked and bent pieces are refused. A filter is ruined by one wrong
//!    line and hardly misses a true one.

use std::ops::Range;

use wide::f64x4;

use super::columns::{Columns, total};
use super::config::AcceptConfig;
use super::fit::{Fit, fit_columns};
use super::piece::Piece;

/// The line of a piece; `None` where it is refused.
pub(super) fn accept(
    columns: &mut Columns,
    mut piece: Piece,
    config: &AcceptConfig,
) -> Option<Fit> {
    for _ in 0..config.trim {
        for end in [piece.first(columns), piece.last(columns)] {
            piece.drop_point(columns, end?);
        }
    }
    let (first, last) = (piece.first(columns)?, piece.last(columns)?);
    // The feet of two points are no farther apart than the points.
    let reach = (columns.point(last) - columns.point(first)).norm();
    if last + 1 - first < config.min_points.max(3) || reach < config.min_length {
        return None;
    }
    piece.start = first;
    piece.end = last + 1;
    let fit = fit_columns(columns, &piece).ok()?;
    let is_wall = fit.n_points >= config.min_points.max(3)
        && (fit.ends[1] - fit.ends[0]).norm() >= config.min_length
        && fit.cov[(0, 0)] <= config.max_alpha_sigma * config.max_alpha_sigma
        && fit.chi2 <= chi2_limit(fit.n_points - 2, config.max_chi2_sigmas)
        && (config.max_bend_sigmas.is_infinite()
            || bend(columns, piece.range(), &fit) <= config.max_bend_sigmas);
    is_wall.then_some(fit)
}

/// The value that χ² with `dof` degrees of freedom exceeds as seldom as a normal variable exceeds `sigmas`.
///
/// Source: Wilson & Hilferty (1931), "The distribution of chi-square".
fn chi2_limit(dof: usize, sigmas: f64) -> f64 {
    let dof = dof.max(1) as f64;
    let spread = 2.0 / (9.0 * dof);
    let root = 1.0 - spread + sigmas * spread.sqrt();
    dof * root * root * root
}

/// The quadratic term of the residuals along the line, in standard deviations.
///
/// It is the part of t² that no line can take up, q = t² - a - b t by least squares, so that Σ w q = Σ w q t = 0: sums of
/// w tᵏ and w tᵏ d suffice.
fn bend(columns: &Columns, range: Range<usize>, fit: &Fit) -> f64 {
    let [from, to] = fit.ends;
    let (middle, half) = (nalgebra::center(&from, &to), 0.5 * (to - from));
    let along = half / half.norm_squared().max(f64::MIN_POSITIVE);
    let [nx, ny, r, tx, ty, t0, surface] = [
        fit.normal.x,
        fit.normal.y,
        fit.line.r(),
        along.x,
        along.y,
        along.dot(&middle.coords),
        columns.var_surface() + f64::MIN_POSITIVE,
    ]
    .map(f64x4::splat);
    let (mut powers, mut products) = ([f64x4::ZERO; 5], [f64x4::ZERO; 3]);
    for b in columns.blocks(range) {
        let t = tx * b.x + ty * b.y - t0;
        let d = nx * b.x + ny * b.y - r;
        let mut w = b.keep / b.variance(nx, ny, surface);
        for k in 0..5 {
            powers[k] += w;
            if let Some(product) = products.get_mut(k) {
                *product += w * d;
            }
            w *= t;
        }
    }
    let ([s0, s1, s2, s3, s4], [d0, d1, d2]) = (powers.map(total), products.map(total));
    let determinant = s0 * s2 - s1 * s1;
    if determinant.is_nan() || determinant <= 0.0 {
        return 0.0;
    }
    let (a, b) = (
        (s2 * s2 - s1 * s3) / determinant,
        (s0 * s3 - s1 * s2) / determinant,
    );
    let (product, norm) = (d2 - a * d0 - b * d1, s4 - a * s2 - b * s3);
    if norm > 0.0 {
        product.abs() / norm.sqrt()
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chi2_limits_are_those_of_the_tables() {
        // 99.9 % quantiles.
        for (dof, quantile) in [(4, 18.467), (10, 29.588), (50, 86.661)] {
            assert!((chi2_limit(dof, 3.0902) - quantile).abs() < 0.02 * quantile);
        }
    }
}

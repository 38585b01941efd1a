//! In: a piece. Out: its line, if it is surely a wall.
//!
//! 1. Points at a corner or an edge are discarded on both sides: which wall they belong to is a
//!    guess, and a wrong guess pulls the line the same way every time.
//! 2. Fit with covariance. Short, sparse, crooked and bent pieces are refused: one wrong line ruins
//!    a filter, while a true one is hardly missed.

use super::columns::Columns;
use super::config::AcceptConfig;
use super::fit::{Fit, fit_columns};
use super::piece::Piece;
use crate::geom::{Length, chi2_quantile};

/// The line of a piece and χ² of its points; `None` if it is refused.
pub(super) fn accept(
    columns: &mut Columns,
    mut piece: Piece,
    config: &AcceptConfig,
) -> Option<(Fit, f64)> {
    for _ in 0..config.trim {
        for end in [piece.first(columns), piece.last(columns)] {
            piece.drop_point(columns, end?);
        }
    }
    let (first, last) = (piece.first(columns)?, piece.last(columns)?);
    // The feet of two points are no farther apart than the points.
    let reach = (columns.point(last) - columns.point(first)).length();
    if last + 1 - first < config.min_points.max(3) || reach < config.min_length {
        return None;
    }
    piece.start = first;
    piece.end = last + 1;
    let fit = fit_columns(columns, &piece)?;
    let is_sure = fit.n_points >= config.min_points.max(3)
        && (fit.ends[1] - fit.ends[0]).length() >= config.min_length
        && fit.cov[(0, 0)] <= config.max_alpha_sigma * config.max_alpha_sigma;
    if !is_sure {
        return None;
    }
    let degrees = fit.n_points.saturating_sub(2).max(1) as f64;
    let residuals = fit.residuals(columns, config.max_bend_sigmas < f64::INFINITY);
    let is_wall = residuals.chi2 <= chi2_quantile(degrees, config.max_chi2_sigmas)
        && residuals.bend <= config.max_bend_sigmas;
    is_wall.then_some((fit, residuals.chi2))
}

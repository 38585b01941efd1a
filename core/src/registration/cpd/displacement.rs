//! A smooth motion: y + G w, with G_ij = exp(-|y_i - y_j|² / 2β²).
//!
//! w solves (d(P1) G + λσ² I) w = P X - d(P1) Y (Myronenko & Song 2010, eq. (22)), for x and y
//! together.

use nalgebra::{DMatrix, Point2, Vector2};

use super::NOTHING_OWED;
use super::posterior::Posterior;

pub(super) struct Smooth {
    kernel: DMatrix<f64>,
    /// One row for each point.
    weights: DMatrix<f64>,
}

impl Smooth {
    pub(super) fn of(start: &[Point2<f64>], beta: f64) -> Self {
        let count = start.len();
        let scale = -0.5 / (beta * beta);
        let value = |i: usize, j: usize| match (start.get(i), start.get(j)) {
            (Some(a), Some(b)) => libm::exp(scale * (a - b).norm_squared()),
            _ => 0.0,
        };
        Self {
            kernel: DMatrix::from_fn(count, count, value),
            weights: DMatrix::zeros(count, 2),
        }
    }

    /// The M step. Returns the new σ².
    pub(super) fn fit(
        &mut self,
        start: &[Point2<f64>],
        x: &[Point2<f64>],
        owed: &Posterior,
        variance: f64,
        lambda: f64,
    ) -> Option<f64> {
        if owed.total < NOTHING_OWED {
            return None;
        }
        let count = start.len();
        let parts: Vec<f64> = owed.of_moving.iter().map(|owed| owed.part).collect();
        let mut system = self.kernel.clone();
        for (mut row, part) in system.row_iter_mut().zip(&parts) {
            row *= *part;
        }
        for at in 0..count {
            system[(at, at)] += lambda * variance;
        }
        let mut right = DMatrix::zeros(count, 2);
        for (mut row, (owed, start)) in right.row_iter_mut().zip(owed.of_moving.iter().zip(start)) {
            row.copy_from(&(owed.place - start.coords * owed.part).transpose());
        }
        self.weights = system.lu().solve(&right)?;
        let moved = &self.kernel * &self.weights;
        // σ² from how far every fixed point is from the new places of the points it is assigned to.
        let x_square: f64 = (x.iter().zip(&owed.of_fixed))
            .map(|(x, part)| x.coords.norm_squared() * part)
            .sum();
        let mut rest = 0.0;
        for ((owed, start), moved) in owed.of_moving.iter().zip(start).zip(moved.row_iter()) {
            let place = start.coords + Vector2::new(moved[0], moved[1]);
            rest += owed.part * place.norm_squared() - 2.0 * owed.place.dot(&place);
        }
        let after = (x_square + rest) / (2.0 * owed.total);
        after.is_finite().then_some(after)
    }

    pub(super) fn apply(&self, start: &[Point2<f64>], y: &mut [Point2<f64>]) {
        let moved = &self.kernel * &self.weights;
        for ((y, start), moved) in y.iter_mut().zip(start).zip(moved.row_iter()) {
            *y = start + Vector2::new(moved[0], moved[1]);
        }
    }
}

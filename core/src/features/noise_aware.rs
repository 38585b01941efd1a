//! Split by what noise can explain: TDK 2016 §4.2.
//!
//! 1. A set of points is one line while Σ|dᵢ| < E + k √V, with E = Σ σ_dᵢ √(2/π) and V = Σ σ_dᵢ²
//!    (1 - 2/π), σ_d the standard deviation of a point's distance from the line. The paper has k =
//!    1, which splits a true line about one time in eight.
//! 2. If the test fails, the set is split at the point farthest from the chord through its ends.
//! 3. A single point farther than `max_residual` σ_d from the line is skipped instead: the sum
//!    would not notice it, but the line would be pulled by it.

use std::f64::consts::FRAC_2_PI;
use std::ops::Range;

use nalgebra::Vector2;

use super::columns::Columns;
use super::piece::Piece;
use crate::bounds::config;
use crate::lanes::{Kernel, Lanes, greatest, run, total};

config! {
    /// When points are one line, by what is known of their noise.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct NoiseAware {
        /// k of the split test. Default 3. Larger: fewer true walls are split, shallower corners
        /// stay undetected. A true wall of 10 to 100 points is split once in 8 (k = 1), 60 (k = 2),
        /// 800 (k = 3) times, as the test measures; 3 is where splits no longer show among the
        /// lines that other gates refuse (1 in 20).
        pub split_k: f64 = 3.0,
        /// A point this many standard deviations off its line is skipped. Default 4.5: one true
        /// point in 150 000.
        pub max_residual: f64 = 4.5,
    }
}

impl NoiseAware {
    /// Splits a run of points; `pieces` receives its lines in order.
    pub(super) fn split(
        &self,
        columns: &mut Columns,
        run: Range<usize>,
        stack: &mut Vec<Piece>,
        pieces: &mut Vec<Piece>,
    ) {
        stack.clear();
        stack.push(Piece::whole(columns, run));
        while let Some(mut piece) = stack.pop() {
            if piece.n_points() < 3 {
                continue;
            }
            if self.hold(columns, &mut piece) {
                pieces.push(piece);
            } else if let Some((corner, _)) = piece.farthest_from_chord(columns) {
                // The earlier part is processed first.
                let [earlier, later] = piece.split_after(columns, corner);
                stack.push(later);
                stack.push(earlier);
            }
        }
    }

    /// Whether a piece is one line, after skipping some outliers.
    fn hold(&self, columns: &mut Columns, piece: &mut Piece) -> bool {
        let mut leave_out = piece.n_points() / 10 + 1;
        loop {
            match self.examine(columns, piece) {
                SplitTest::Line => return true,
                SplitTest::Wild(worst) if leave_out > 0 => {
                    leave_out -= 1;
                    piece.drop_point(columns, worst);
                }
                _ => return false,
            }
        }
    }

    /// Whether two pieces with a gap between them are one line.
    pub(super) fn allows(&self, columns: &Columns, union: &Piece, gap: Range<usize>) -> bool {
        let line = union.moments.line();
        let is_line = |range| matches!(self.test(columns, range, line), SplitTest::Line);
        if gap.is_empty() {
            return is_line(union.range());
        }
        is_line(union.start..gap.start) && is_line(gap.end..union.end)
    }

    /// The tests of steps 1 and 3 with the piece's own line.
    pub(super) fn examine(&self, columns: &Columns, piece: &Piece) -> SplitTest {
        // Σ|d| is at least √Σd², and Σd² at least σ² Σwd² with the smallest σ: around a corner,
        // this already fails without computing the line.
        let most = self.most(columns, piece.n_points()) / columns.smallest_sigma();
        if piece.moments.is_wider_than(most * most) {
            return SplitTest::Bent;
        }
        self.test(columns, piece.range(), piece.moments.line())
    }

    fn test(
        &self,
        columns: &Columns,
        range: Range<usize>,
        (normal, r): (Vector2<f64>, f64),
    ) -> SplitTest {
        let most = self.most(columns, range.len());
        let sums = run(Residuals {
            columns,
            range: &range,
            line: (&normal, r),
            wild: self.max_residual * self.max_residual,
            most,
        });
        if sums.distances > most || sums.distances >= self.bound(sums.sigmas, sums.variances) {
            return SplitTest::Bent;
        }
        if !sums.has_wild {
            return SplitTest::Line;
        }
        self.worst(columns, range, (normal, r))
            .map_or(SplitTest::Line, SplitTest::Wild)
    }

    /// An upper bound of the limit for any line through this many points, with all as uncertain as
    /// the worst, m.
    fn most(&self, columns: &Columns, n_points: usize) -> f64 {
        let n = n_points as f64;
        columns.largest_sigma() * self.bound(n, n)
    }

    /// E + k √V for Σσ and Σσ².
    fn bound(&self, sigmas: f64, variances: f64) -> f64 {
        sigmas * FRAC_2_PI.sqrt() + self.split_k * (variances * (1.0 - FRAC_2_PI)).sqrt()
    }

    /// The farthest outlier in standard deviations, if a point is too far.
    fn worst(
        &self,
        columns: &Columns,
        range: Range<usize>,
        (normal, r): (Vector2<f64>, f64),
    ) -> Option<usize> {
        let mut worst = (None, self.max_residual * self.max_residual);
        for index in columns.kept(range) {
            let var = columns.variance(index, &normal);
            let d = normal.dot(&columns.point(index).coords) - r;
            if d * d > worst.1 * var {
                worst = (Some(index), d * d / var);
            }
        }
        worst.0
    }
}

/// The result of the split test.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum SplitTest {
    /// One line.
    Line,
    /// One line apart from outliers, of which this is the farthest.
    Wild(usize),
    /// More than one line.
    Bent,
}

/// Sums over the points of a range and their distances from a line.
struct Residuals<'a> {
    columns: &'a Columns,
    range: &'a Range<usize>,
    line: (&'a Vector2<f64>, f64),
    /// Squared distance, in variances, beyond which a point is an outlier.
    wild: f64,
    /// A sum of distances beyond which the rest is not computed, m.
    most: f64,
}

/// The result of [`Residuals`]; if `distances` exceeds the limit, not all points are included.
struct ResidualSums {
    /// Σ|d|, m.
    distances: f64,
    /// Σσ_d, m.
    sigmas: f64,
    /// Σσ_d², m².
    variances: f64,
    has_wild: bool,
}

impl Kernel for Residuals<'_> {
    type Output = ResidualSums;

    #[inline(always)]
    fn run<L: Lanes>(self, machine: L::Machine) -> ResidualSums {
        let (normal, r) = self.line;
        let splat = |value| L::splat(machine, value);
        let (nx, ny, r) = (splat(normal.x), splat(normal.y), splat(r));
        let surface = splat(self.columns.var_surface());
        let wild_squared = splat(self.wild);
        let exact = self.columns.bearings_are_exact();
        let mut sum = splat(0.0);
        let (mut expected, mut variance, mut wild) = (sum, sum, sum);
        let blocks = self.columns.blocks(self.range);
        for block in 0..blocks.len() {
            let b = blocks.at(machine, block);
            let mut var = b.variance_by_range(nx, ny) + surface;
            if !exact {
                var += b.variance_by_bearing(nx, ny);
            }
            let var = var * b.keep;
            let d = (nx * b.x + ny * b.y - r) * b.keep;
            sum += d.abs();
            expected += var.sqrt();
            variance += var;
            wild = wild.or_greater(d * d - wild_squared * var);
            if block % 4 == 0 && total(sum) > self.most {
                break;
            }
        }
        ResidualSums {
            distances: total(sum),
            sigmas: total(expected),
            variances: total(variance),
            has_wild: greatest(wild) > 0.0,
        }
    }
}

#[cfg(test)]
mod tests;

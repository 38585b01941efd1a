//! Split where the line stops being good enough: Pilch 2016 §3.5.1.
//!
//! 1. A line begins with the first `min_points` neighbours that form one: S_E < `max_error` and r²
//!    ≥ `min_r2`.
//! 2. It grows neighbour by neighbour until one of the two conditions fails.
//! 3. Points are removed from its ends as long as that lowers the error per point.
//!
//! Neighbours closer than 2 k belong together: that is [`crate::points::BreakRule::Spacing`],
//! chosen in the same configuration.
//!
//! **Erratum** of the specification: the paper's r² of y on x fails on walls along y. S_E is here
//! the sum of squares across the fitted line, and r² = 1 - S_E / (sum of squares along it): both
//! are the same for every direction. The paper gives no unit of S_E < 3. In mm² or cm² not even
//! six points with the noise of its own sensor (1 cm) would pass, so it is read as 3 dm².

use std::ops::Range;

use super::columns::Columns;
use super::moments::Moments;
use super::piece::Piece;

use crate::bounds::config;

config! {
    /// When points are one line, by the error of a regression.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct Pilch {
        /// Largest sum of squared distances, m². Default 0.03 (3 dm²). It does not grow with the
        /// number of points: long walls and noisy ones are cut.
        pub max_error: f64 = 0.03,
        /// Least share of the scatter that the line explains. Default 0.98.
        pub min_r2: f64 = 0.98,
        /// Fewest points of a line, at least 2. Default 6.
        pub min_points: usize = 6,
    }
}

impl Pilch {
    /// Splits a run of points; `pieces` receives its lines in order. `sums` is a buffer.
    pub(super) fn split(
        &self,
        columns: &Columns,
        run: Range<usize>,
        sums: &mut Vec<Moments>,
        pieces: &mut Vec<Piece>,
    ) {
        let few = self.min_points.max(2);
        let sums = Unweighted::over(columns, &run, sums);
        let mut start = run.start;
        while start + few <= run.end {
            let mut end = start + few;
            if !self.holds(&sums, start..end) {
                start += 1;
                continue;
            }
            while end < run.end && self.holds(&sums, start..end + 1) {
                end += 1;
            }
            pieces.push(Piece::whole(columns, trimmed(&sums, start..end, few)));
            start = end;
        }
    }

    fn holds(&self, sums: &Unweighted<'_>, range: Range<usize>) -> bool {
        let (across, along) = sums.spreads(range);
        across < self.max_error && across <= (1.0 - self.min_r2) * along
    }
}

/// Step 3.
fn trimmed(sums: &Unweighted<'_>, mut range: Range<usize>, few: usize) -> Range<usize> {
    let per_point = |r: &Range<usize>| sums.spreads(r.clone()).0 / r.len() as f64;
    let mut error = per_point(&range);
    while range.len() > few {
        let shorter = [range.start + 1..range.end, range.start..range.end - 1];
        let [front, back] = shorter.each_ref().map(per_point);
        if front.min(back) >= error {
            break;
        }
        let [without_first, without_last] = shorter;
        (range, error) = if front <= back {
            (without_first, front)
        } else {
            (without_last, back)
        };
    }
    range
}

/// Prefix sums in which every point has the same weight, relative to the first point.
struct Unweighted<'a> {
    start: usize,
    sums: &'a [Moments],
}

impl<'a> Unweighted<'a> {
    fn over(columns: &Columns, run: &Range<usize>, sums: &'a mut Vec<Moments>) -> Self {
        sums.clear();
        let mut sum = Moments::default();
        sums.push(sum);
        let origin = columns.point(run.start);
        for index in run.clone() {
            let p = columns.point(index) - origin;
            sum = sum.plus(&Moments::of(1.0, p.x, p.y));
            sums.push(sum);
        }
        Self {
            start: run.start,
            sums,
        }
    }

    fn spreads(&self, range: Range<usize>) -> (f64, f64) {
        let [from, to] = [range.start, range.end].map(|i| &self.sums[i - self.start]);
        to.minus(from).spreads()
    }
}

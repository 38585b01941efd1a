//! The cells of Bresenham's line.
//!
//! In: the two ends, in cells. Out: its cells, as runs of a row.
//!
//! 1. Along the longer axis every column (or row) has one cell: that whose centre is nearest to the line between the centres of the
//!    first and the last cell; of two the one farther on.
//! 2. Where columns are more than rows, whole runs are found at once: row k begins at column ⌈n (2k - 1) / 2m⌉ of n columns and m
//!    rows, and the quotient grows from row to row by ⌊n / m⌋ or by one more.
//!
//! Source: Bresenham (1965), "Algorithm for computer control of a digital plotter", as in Celej §4 (`BresenhamLine`); for step 2
//! Bresenham (1985), "Run length slice algorithm for incremental lines".

use nalgebra::Point2;

use super::CellIndex;
use super::ray::{Run, are_in_reach, cell_of};

/// Visits the line from the cell of `start` to that of `end`, both given in cells (metres / resolution); a run at a time, that of
/// `end` last. Ends that are not finite visit nothing.
pub(super) fn runs_on_line(start: Point2<f64>, end: Point2<f64>, visit: impl FnMut(Run)) {
    if !are_in_reach(start, end) {
        return;
    }
    let (first, last) = (cell_of(start), cell_of(end));
    let cols = i64::from(last.col) - i64::from(first.col);
    let rows = i64::from(last.row) - i64::from(first.row);
    if cols.abs() >= rows.abs() {
        flat(first, cols, rows, visit);
    } else {
        steep(first, cols, rows, visit);
    }
}

/// At least as many columns as rows: step 2.
fn flat(first: CellIndex, cols: i64, rows: i64, mut visit: impl FnMut(Run)) {
    let (n, m) = (cols.abs(), rows.abs());
    let (step_col, step_row) = (cols.signum(), rows.signum());
    let col = |along: i64| first.col + (along * step_col) as i32;
    // Where the next row begins, as quotient and remainder of a division by 2m that rounds up.
    let divisor = (2 * m).max(1);
    let (mut next, mut rest) = ((n + divisor - 1) / divisor, (n + divisor - 1) % divisor);
    let (whole, part) = (2 * n / divisor, 2 * n % divisor);
    let mut from = 0;
    for k in 0..m {
        visit(Run {
            row: first.row + (k * step_row) as i32,
            from: col(from),
            to: col(next - 1),
        });
        from = next;
        next += whole;
        rest += part;
        if rest >= divisor {
            rest -= divisor;
            next += 1;
        }
    }
    visit(Run {
        row: first.row + rows as i32,
        from: col(from),
        to: col(n),
    });
}

/// More rows than columns: a cell in each row.
fn steep(first: CellIndex, cols: i64, rows: i64, mut visit: impl FnMut(Run)) {
    let (n, m) = (cols.abs(), rows.abs());
    let (step_col, step_row) = (cols.signum() as i32, rows.signum() as i32);
    let CellIndex { mut col, mut row } = first;
    let mut rest = m;
    for _ in 0..=m {
        visit(Run {
            row,
            from: col,
            to: col,
        });
        row += step_row;
        rest += 2 * n;
        if rest >= 2 * m {
            rest -= 2 * m;
            col += step_col;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn cells((ax, ay): (i32, i32), (bx, by): (i32, i32)) -> Vec<(i32, i32)> {
        let centre = |x: i32, y: i32| Point2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
        let mut cells = vec![];
        runs_on_line(centre(ax, ay), centre(bx, by), |run| {
            let mut col = run.from;
            cells.push((col, run.row));
            while col != run.to {
                col += (run.to - col).signum();
                cells.push((col, run.row));
            }
        });
        cells
    }

    /// By the definition: along the longer axis, the shorter one rounded, halves onwards.
    fn rounded((ax, ay): (i32, i32), (bx, by): (i32, i32)) -> Vec<(i32, i32)> {
        let (dx, dy) = (bx - ax, by - ay);
        let n = dx.abs().max(dy.abs()).max(1);
        let at = |d: i32, i: i32| d.signum() * (2 * d.abs() * i + n).div_euclid(2 * n);
        (0..=dx.abs().max(dy.abs()))
            .map(|i| (ax + at(dx, i), ay + at(dy, i)))
            .collect()
    }

    #[test]
    fn short_lines() {
        assert_eq!(cells((0, 0), (3, 1)), [(0, 0), (1, 0), (2, 1), (3, 1)]);
        assert_eq!(cells((0, 0), (-1, 2)), [(0, 0), (-1, 1), (-1, 2)]);
        assert_eq!(cells((4, 4), (4, 4)), [(4, 4)]);
        let mut seen = 0;
        runs_on_line(Point2::new(0.5, f64::NAN), Point2::origin(), |_| seen += 1);
        assert_eq!(seen, 0);
    }

    #[test]
    fn every_line_within_a_square_is_the_rounded_one() {
        for x in -20..=20 {
            for y in -20..=20 {
                assert_eq!(cells((3, -2), (x, y)), rounded((3, -2), (x, y)), "{x} {y}");
            }
        }
    }

    proptest! {
        #[test]
        fn long_lines_are_the_rounded_ones(ax in -900..900, ay in -900..900, bx in -900..900, by in -900..900) {
            prop_assert_eq!(cells((ax, ay), (bx, by)), rounded((ax, ay), (bx, by)));
        }
    }
}

//! In: pieces in order. Out: pieces in which neighbours on one line are joined.
//!
//! Two neighbours are one line if little lies between them, if their (α, r) agree by χ² (for rules
//! that know the noise), and if the union passes the test by which pieces are split. Pieces are
//! joined across the end of a run (a door, a pillar in front) only if the settings ask for it.

use std::f64::consts::PI;
use std::ops::Range;

use nalgebra::Vector2;

use super::columns::Columns;
use super::config::{MergeConfig, SplitRule};
use super::consensus;
use super::fit::fit_columns;
use super::hough::Hough;
use super::piece::Piece;
use super::ransac::Ransac;
use crate::geom::{CHI2_2DOF_99, Length, wrap};

/// Merges from left to right, in place. `run_starts`: where runs begin in the columns, in order.
pub(super) fn merge(
    columns: &mut Columns,
    pieces: &mut Vec<Piece>,
    run_starts: &[usize],
    rule: &SplitRule,
    config: &MergeConfig,
) {
    let mut merged: usize = 0;
    for index in 0..pieces.len() {
        let next = pieces[index];
        let last = merged.checked_sub(1).map(|i| pieces[i]);
        let union = last.and_then(|last| {
            let is_near = near(columns, last.end..next.start, run_starts, config);
            is_near
                .then(|| union(columns, &last, &next, rule))
                .flatten()
        });
        if let (Some(last), Some(union)) = (last, union) {
            for between in last.end..next.start {
                columns.drop_point(between);
            }
            pieces[merged - 1] = union;
        } else {
            pieces[merged] = next;
            merged += 1;
        }
    }
    pieces.truncate(merged);
}

/// Whether pieces may be merged across a gap.
fn near(columns: &Columns, gap: Range<usize>, run_starts: &[usize], config: &MergeConfig) -> bool {
    let next_run = run_starts.partition_point(|&start| start < gap.start.max(1));
    let ends_a_run = (run_starts.get(next_run)).is_some_and(|&start| start <= gap.end);
    if ends_a_run && !config.across_runs || gap.len() > config.gap_points {
        return false;
    }
    let is_closed = gap.is_empty() && !ends_a_run;
    let distance = (columns.point(gap.end) - columns.point(gap.start - 1)).length();
    is_closed || distance <= config.gap.max(0.0)
}

/// Both pieces as one, if they are one line.
fn union(columns: &Columns, a: &Piece, b: &Piece, rule: &SplitRule) -> Option<Piece> {
    let (normal_a, normal_b) = (a.moments.line().0, b.moments.line().0);
    // Walls at a clear angle need no test; 0.5 is the sine of 30°.
    if normal_a.perp(&normal_b).abs() > 0.5 && a.n_points() > 3 && b.n_points() > 3 {
        return None;
    }
    let union = Piece {
        start: a.start,
        end: b.end,
        moments: a.moments.plus(&b.moments),
    };
    let gap = a.end..b.start;
    let is_line = match rule {
        SplitRule::NoiseAware(rule) => rule.allows(columns, &union, gap) && agree(columns, a, b),
        SplitRule::Classic(rule) => rule.allows(columns, &union, gap),
        SplitRule::Ransac(Ransac { inlier_sigmas, .. })
        | SplitRule::Hough(Hough { inlier_sigmas, .. }) => {
            consensus::allows(columns, &union, &gap, *inlier_sigmas) && agree(columns, a, b)
        }
        // The paper's lines have already grown as far as possible.
        SplitRule::Pilch(_) => false,
    };
    is_line.then_some(union)
}

/// χ² of the difference of (α, r), if both pieces have a line of their own.
fn agree(columns: &Columns, a: &Piece, b: &Piece) -> bool {
    let (Some(a), Some(b)) = (fit_columns(columns, a), fit_columns(columns, b)) else {
        // Too short to have a direction: only the test of the union decides.
        return true;
    };
    let mut difference = Vector2::new(
        wrap(b.line.alpha() - a.line.alpha()),
        b.line.r() - a.line.r(),
    );
    let mut cov_b = b.cov;
    if difference.x.abs() > 0.5 * PI {
        // The same line through the origin, with its normal reversed.
        difference = Vector2::new(wrap(difference.x + PI), -b.line.r() - a.line.r());
        cov_b[(0, 1)] = -cov_b[(0, 1)];
        cov_b[(1, 0)] = -cov_b[(1, 0)];
    }
    (a.cov + cov_b)
        .cholesky()
        .is_some_and(|c| difference.dot(&c.solve(&difference)) < CHI2_2DOF_99)
}

//! Split by a distance: classic split-and-merge, with the line through the end points.
//!
//! 1. A set of points is one line if none is farther than the threshold from the line through the
//!    first and the last.
//! 2. Otherwise it is split at the farthest point.
//! 3. Neighbouring pieces merge if none of their points is farther than the threshold from the line
//!    fitted to both.
//!
//! Source: Pilch 2016 §1.2, eq. (1.6); TDK 2016 §4.2, fig. 4.4; Nguyen et al. (2007), "A comparison
//! of line extraction algorithms using 2D range data for indoor mobile robotics", table 1.

use std::ops::Range;

use super::columns::Columns;
use super::piece::{LargestDistance, Piece};
use crate::bounds::config;
use crate::lanes::run;

config! {
    /// When points are one line, by a fixed distance.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct Classic {
        /// Farthest that a point may be from its line, m. Default 0.1. Larger: fewer walls torn by
        /// noise, fewer shallow corners found.
        pub threshold: f64 = 0.1,
    }
}

impl Classic {
    /// Splits a run of points; `pieces` receives its lines in order.
    pub(super) fn split(
        &self,
        columns: &Columns,
        run: Range<usize>,
        stack: &mut Vec<Piece>,
        pieces: &mut Vec<Piece>,
    ) {
        stack.clear();
        stack.push(Piece::whole(columns, run));
        while let Some(piece) = stack.pop() {
            match piece.farthest_from_chord(columns) {
                Some((corner, distance)) if distance > self.threshold => {
                    // The earlier part is processed first.
                    let [earlier, later] = piece.split_after(columns, corner);
                    stack.push(later);
                    stack.push(earlier);
                }
                _ if piece.n_points() >= 3 => pieces.push(piece),
                _ => {}
            }
        }
    }

    /// Whether two pieces with a gap between them are one line.
    pub(super) fn allows(&self, columns: &Columns, union: &Piece, gap: Range<usize>) -> bool {
        let (normal, r) = union.moments.line();
        [union.start..gap.start, gap.end..union.end]
            .into_iter()
            .all(|range| {
                let largest = run(LargestDistance {
                    columns,
                    range,
                    normal: &normal,
                    r,
                });
                largest <= self.threshold
            })
    }
}

//! In: a line guessed through points of a run. Out: the neighbours that lie on it, as a piece; and
//! borders between pieces. RANSAC and the Hough transform share this.
//!
//! 1. A stretch begins and ends with a point on the line; at most [`MAX_SKIP`] neighbours in a row
//!    are off it. So no line goes through points that do not follow each other: across a recess, or
//!    through two walls that happen to be collinear.
//! 2. The longest stretch is refined: the weighted line through its points and the points on that
//!    line are found in turn, until the points stay the same. A point is on the line within n σ of
//!    its distance and of the line at that place, var = σ_d² + 1/W + t² / S (W the sum of weights,
//!    S their scatter along the line, t the distance from the middle), and never beyond n σ of its
//!    range.
//! 3. Near a corner, points lie on both lines, and the line that was found first has all of them.
//!    The border is moved to where the sum of weighted squares of both lines is least.

use std::ops::Range;

use nalgebra::Vector2;

use super::columns::Columns;
use super::moments::Moments;
use super::piece::Piece;

/// Neighbours in a row that may be off a line within it.
const MAX_SKIP: usize = 2;
/// Steps of the refinement; most end after two.
const MOST_STEPS: usize = 6;
/// How far from its old place a border is looked for, in points.
const BORDER_REACH: usize = 20;

/// A stretch of a run, and how many of its points are on the line.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Stretch {
    pub(super) range: Range<usize>,
    pub(super) n_inliers: usize,
}

/// Step 1: the stretch with the most points on the line; of two with equally many, the earlier.
pub(super) fn longest_stretch(
    range: Range<usize>,
    mut is_inlier: impl FnMut(usize) -> bool,
) -> Stretch {
    let mut best = Stretch::default();
    let mut open: Option<Stretch> = None;
    for index in range {
        if !is_inlier(index) {
            continue;
        }
        let goes_on = (open.as_ref()).is_some_and(|open| index <= open.range.end + MAX_SKIP);
        let stretch = match open.take() {
            Some(open) if goes_on => Stretch {
                range: open.range.start..index + 1,
                n_inliers: open.n_inliers + 1,
            },
            _ => Stretch {
                range: index..index + 1,
                n_inliers: 1,
            },
        };
        if stretch.n_inliers > best.n_inliers {
            best = stretch.clone();
        }
        open = Some(stretch);
    }
    best
}

/// Whether a point's distance from a line is within n σ of its range, and `slack` (m) more.
pub(super) fn is_near(
    columns: &Columns,
    index: usize,
    (normal, r): (&Vector2<f64>, f64),
    sigmas: f64,
    slack: f64,
) -> bool {
    let off = (normal.dot(&columns.point(index).coords) - r).abs() - slack;
    off <= 0.0 || off * off <= sigmas * sigmas * columns.variance_along(index)
}

/// A line through some points, and its uncertainty along its length.
#[derive(Clone, Copy, Debug)]
struct Fitted {
    normal: Vector2<f64>,
    r: f64,
    middle: Vector2<f64>,
    var_middle: f64,
    /// rad².
    var_turn: f64,
}

impl Fitted {
    fn through(columns: &Columns, points: impl Iterator<Item = usize>) -> Self {
        let sum = points.fold(Moments::default(), |sum, index| {
            sum.plus(&columns.moments_of(index))
        });
        Self::of(&sum)
    }

    fn of(moments: &Moments) -> Self {
        let (normal, r) = moments.line();
        Self {
            normal,
            r,
            middle: Vector2::new(moments.x, moments.y) / moments.w,
            var_middle: 1.0 / moments.w,
            var_turn: 1.0 / moments.spreads().1,
        }
    }

    /// Step 2.
    fn has(&self, columns: &Columns, index: usize, sigmas: f64) -> bool {
        let p = columns.point(index).coords;
        let (off, along) = (
            self.normal.dot(&p) - self.r,
            self.normal.perp(&(p - self.middle)),
        );
        let own = columns.variance(index, &self.normal);
        let line = self.var_middle + along * along * self.var_turn;
        let var = (own + line).min(columns.variance_along(index));
        off * off <= sigmas * sigmas * var
    }
}

/// The neighbours on one line, and that line.
#[derive(Clone, Debug)]
pub(super) struct Found {
    pub(super) stretch: Stretch,
    line: Fitted,
}

/// Step 2, from the points of `range` that are near a guessed line; `None` if fewer than `few` are
/// left. Points for which `is_free` does not hold are left out.
pub(super) fn refined(
    columns: &Columns,
    range: &Range<usize>,
    (sigmas, few): (f64, usize),
    is_free: impl Fn(usize) -> bool,
    is_near: impl Fn(usize) -> bool,
) -> Option<Found> {
    let mut stretch = longest_stretch(range.clone(), |i| is_free(i) && is_near(i));
    if stretch.n_inliers < few {
        return None;
    }
    let mut line = Fitted::through(columns, stretch.range.clone().filter(|&i| is_near(i)));
    for _ in 0..MOST_STEPS {
        let on_it = |i: usize| is_free(i) && line.has(columns, i, sigmas);
        let next = longest_stretch(range.clone(), on_it);
        if next.n_inliers < few {
            return None;
        }
        let stays = next == stretch;
        stretch = next;
        if stays {
            break;
        }
        line = Fitted::through(columns, stretch.range.clone().filter(|&i| on_it(i)));
    }
    Some(Found { stretch, line })
}

impl Found {
    /// The piece; from here on, its points off the line are skipped.
    pub(super) fn take(&self, columns: &mut Columns, sigmas: f64) -> Piece {
        let range = self.stretch.range.clone();
        for index in range.clone() {
            if columns.is_kept(index) && !self.line.has(columns, index, sigmas) {
                columns.drop_point(index);
            }
        }
        Piece::kept_of(columns, range)
    }
}

/// Whether the union of two pieces is one line: no kept point of either is off it.
pub(super) fn allows(columns: &Columns, union: &Piece, gap: &Range<usize>, sigmas: f64) -> bool {
    let line = Fitted::of(&union.moments);
    [union.start..gap.start, gap.end..union.end]
        .into_iter()
        .flat_map(|range| columns.kept(range))
        .all(|index| line.has(columns, index, sigmas))
}

/// Step 3, for the pieces of one run in order; each keeps at least `few` points.
pub(super) fn settle_borders(columns: &mut Columns, pieces: &mut [Piece], few: usize) {
    for index in 1..pieces.len() {
        let (head, tail) = pieces.split_at_mut(index);
        if let (Some(a), Some(b)) = (head.last_mut(), tail.first_mut())
            && b.start - a.end <= MAX_SKIP
        {
            settle_border(columns, a, b, few);
        }
    }
}

fn settle_border(columns: &mut Columns, a: &mut Piece, b: &mut Piece, few: usize) {
    for between in a.end..b.start {
        columns.drop_point(between);
    }
    let (line_a, line_b) = (a.moments.line(), b.moments.line());
    let reach = |piece: &Piece| piece.n_points().saturating_sub(few).min(BORDER_REACH);
    let (from, to) = (a.end - reach(a), b.start + reach(b));
    let square = |index: usize, (normal, r): &(Vector2<f64>, f64)| {
        let off = normal.dot(&columns.point(index).coords) - r;
        off * off / columns.variance_along(index)
    };
    // The sum for a border before `from`, up to a constant.
    let (mut sum, mut least, mut border) = (0.0, 0.0, from);
    for index in columns.kept(from..to) {
        sum += square(index, &line_a) - square(index, &line_b);
        if sum < least {
            (least, border) = (sum, index + 1);
        }
    }
    *a = Piece::kept_of(columns, a.start..border);
    *b = Piece::kept_of(columns, border..b.end);
}

#[cfg(test)]
mod tests;

//! How well a point fits a map, for every cell and for every square of cells, as branch and bound
//! needs it.
//!
//! In: positions of surfaces. Out: levels of a grid of bytes. Level 0 holds 255 exp(-d²/2σ²) of the
//! distance d to the nearest surface; level h holds, for each cell, the largest value of the 2^h x
//! 2^h cells of which it is the lower left. The sum over a scan's points at level h is then an
//! upper bound for all shifts of the scan within such a square.
//!
//! Source: Hess et al. (2016), "Real-time loop closure in 2D LIDAR SLAM", section V-B; Olson
//! (2009), "Real-time correlative scan matching".

use nalgebra::Point2;

use super::cell::floor;

/// The levels.
#[derive(Clone, Debug)]
pub struct LikelihoodPyramid {
    cell: f64,
    /// Cell (0, 0) has its lower left corner at this many cells from the origin.
    low: (i32, i32),
    cols: i32,
    rows: i32,
    levels: Vec<Vec<u8>>,
}

/// Most cells of one level; a byte each, so seven levels stay below 64 MB.
const MAX_CELLS: i64 = 1 << 23;

impl LikelihoodPyramid {
    /// Builds `levels` levels with cells of `cell` metres over the places; `sigma` is the standard
    /// deviation of a surface's position, m.
    ///
    /// `None` if there are no places, or they span more than eight million cells.
    #[must_use]
    pub fn new(
        places: impl Iterator<Item = Point2<f64>> + Clone,
        cell: f64,
        sigma: f64,
        levels: usize,
    ) -> Option<Self> {
        let to_cell = |p: Point2<f64>| (floor(p.x / cell), floor(p.y / cell));
        let (mut min, mut max) = ((i32::MAX, i32::MAX), (i32::MIN, i32::MIN));
        for (col, row) in places.clone().map(to_cell) {
            min = (min.0.min(col), min.1.min(row));
            max = (max.0.max(col), max.1.max(row));
        }
        if min.0 > max.0 {
            return None;
        }
        let reach = (3.0 * sigma / cell).ceil() as i32;
        // Squares that begin left of or below the map still overlap it.
        let pad = (1_i32 << levels.clamp(1, 12)) + reach;
        let low = (min.0.checked_sub(pad)?, min.1.checked_sub(pad)?);
        let cols = max.0.checked_add(reach + 1)?.checked_sub(low.0)?;
        let rows = max.1.checked_add(reach + 1)?.checked_sub(low.1)?;
        if i64::from(cols) * i64::from(rows) > MAX_CELLS {
            return None;
        }
        let mut finest = vec![0_u8; (cols * rows) as usize];
        let scale = -0.5 / (sigma * sigma);
        let mut across = vec![];
        for place in places {
            let (col, row) = to_cell(place);
            // A Gaussian over (x, y) is one over x times one over y.
            let along = |cells: i32, place: f64| {
                let off = (f64::from(cells) + 0.5) * cell - place;
                libm::exp(scale * off * off)
            };
            across.clear();
            across.extend((col - reach..=col + reach).map(|c| along(c, place.x)));
            for r in row - reach..=row + reach {
                let height = 255.0 * along(r, place.y);
                let first = ((r - low.1) * cols + col - reach - low.0) as usize;
                let stored = finest.iter_mut().skip(first);
                for (stored, part) in stored.zip(&across) {
                    *stored = (*stored).max((height * part) as u8);
                }
            }
        }
        let mut pyramid = Self {
            cell,
            low,
            cols,
            rows,
            levels: vec![finest],
        };
        for level in 1..levels {
            let next = pyramid.coarser(1 << (level - 1));
            pyramid.levels.push(next);
        }
        Some(pyramid)
    }

    /// Side of a cell, m.
    #[must_use]
    pub fn cell(&self) -> f64 {
        self.cell
    }

    /// Number of levels.
    #[must_use]
    pub fn levels(&self) -> usize {
        self.levels.len()
    }

    /// Memory use.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.levels.iter().map(Vec::len).sum()
    }

    /// Column and row of the cell that holds a place, which may be outside the map.
    #[inline]
    #[must_use]
    pub fn cell_of(&self, place: Point2<f64>) -> (i32, i32) {
        let scale = 1.0 / self.cell;
        (
            floor(place.x * scale).saturating_sub(self.low.0),
            floor(place.y * scale).saturating_sub(self.low.1),
        )
    }

    /// Number of columns and rows.
    #[must_use]
    pub fn size(&self) -> (i32, i32) {
        (self.cols, self.rows)
    }

    /// The middle of a cell.
    #[must_use]
    pub fn middle_of(&self, (col, row): (i32, i32)) -> Point2<f64> {
        let at = |cell: i32, low: i32| (f64::from(cell) + f64::from(low) + 0.5) * self.cell;
        Point2::new(at(col, self.low.0), at(row, self.low.1))
    }

    /// The sum of the cells shifted by `shift`, at a level.
    #[must_use]
    pub fn sum(&self, level: usize, cells: &[(i32, i32)], shift: (i32, i32)) -> u32 {
        let Some(values) = self.levels.get(level) else {
            return 0;
        };
        let (cols, rows) = (self.cols as u32, self.rows as u32);
        let mut sum = 0;
        for &(col, row) in cells {
            // A negative index becomes larger than any size.
            let (col, row) = (
                col.wrapping_add(shift.0) as u32,
                row.wrapping_add(shift.1) as u32,
            );
            if col < cols && row < rows {
                sum += u32::from(values[(row * cols + col) as usize]);
            }
        }
        sum
    }

    /// The same sum if it is above `least`; otherwise some number that is not, found sooner.
    #[must_use]
    pub fn sum_above(
        &self,
        level: usize,
        cells: &[(i32, i32)],
        shift: (i32, i32),
        least: u32,
    ) -> u32 {
        let Some(values) = self.levels.get(level) else {
            return 0;
        };
        let (cols, rows) = (self.cols as u32, self.rows as u32);
        let (mut sum, mut left) = (0, 255 * cells.len() as u32);
        for some in cells.chunks(32) {
            for &(col, row) in some {
                // A negative index becomes larger than any size.
                let col = col.wrapping_add(shift.0) as u32;
                let row = row.wrapping_add(shift.1) as u32;
                if col < cols && row < rows {
                    sum += u32::from(values[(row * cols + col) as usize]);
                }
            }
            left -= 255 * some.len() as u32;
            if sum + left <= least {
                return 0;
            }
        }
        sum
    }

    /// The last level with squares of twice the side: the maximum of four squares that lie `half`
    /// cells apart.
    fn coarser(&self, half: i32) -> Vec<u8> {
        let Some(last) = self.levels.last() else {
            return vec![];
        };
        let (cols, half) = (self.cols as usize, half as usize);
        let mut wide = last.clone();
        for (out, row) in wide.chunks_mut(cols).zip(last.chunks(cols)) {
            for (o, &r) in out.iter_mut().zip(row.iter().skip(half)) {
                *o = (*o).max(r);
            }
        }
        let mut tall = wide.clone();
        for (o, &r) in tall.iter_mut().zip(wide.iter().skip(half * cols)) {
            *o = (*o).max(r);
        }
        tall
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_level_holds_the_maximum_of_its_square() {
        let places = [
            Point2::new(0.0, 0.0),
            Point2::new(1.3, -0.7),
            Point2::new(-2.0, 1.0),
        ];
        let pyramid = LikelihoodPyramid::new(places.iter().copied(), 0.1, 0.1, 5).unwrap();
        for level in 0..5 {
            let side = 1 << level;
            for col in (-40..40).step_by(3) {
                for row in (-40..40).step_by(7) {
                    let (c, r) =
                        pyramid.cell_of(Point2::new(f64::from(col) * 0.1, f64::from(row) * 0.1));
                    let mut brute = 0;
                    for dc in 0..side {
                        for dr in 0..side {
                            brute = brute.max(pyramid.sum(0, &[(c + dc, r + dr)], (0, 0)));
                        }
                    }
                    assert_eq!(
                        pyramid.sum(level, &[(c, r)], (0, 0)),
                        brute,
                        "{level} {col} {row}"
                    );
                }
            }
        }
    }

    #[test]
    fn nothing_or_too_much_is_no_pyramid() {
        assert!(LikelihoodPyramid::new(std::iter::empty(), 0.1, 0.1, 3).is_none());
        let far = [Point2::new(0.0, 0.0), Point2::new(1e8, 1e8)];
        assert!(LikelihoodPyramid::new(far.iter().copied(), 0.1, 0.1, 3).is_none());
    }
}

//! A symmetric matrix that grows and shrinks at its end, kept as its lower triangle.
//!
//! Row i starts at i (i + 1) / 2, so a new landmark's rows are pushed at the end and nothing moves;
//! the update of the filter touches half as many numbers as in a full matrix; and symmetry is
//! automatic, because each pair is stored only once.

mod pair;

use self::pair::PairPass;
use crate::lanes::widened;

/// Columns that are updated together. Twice as many as a register of 256 bits holds, or of 128 bits
/// in the browser, where wider tiles do not stay in registers: 8 there make a pass of 20 vectors
/// take 1.5 times as long; 4 natively take up to 1.2 times as long.
pub(super) const TILE: usize = if IS_NARROW { 4 } else { 8 };
const IS_NARROW: bool = cfg!(any(target_family = "wasm", feature = "narrow"));
/// Rows that are updated together: with [`TILE`], as many numbers as the registers hold.
const ROWS: usize = 4;
/// Vectors that are subtracted together.
pub(super) const MOST: usize = 32;

/// Lower triangle of a symmetric matrix, packed by rows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SymmetricMatrix {
    n: usize,
    packed: Vec<f64>,
}

impl SymmetricMatrix {
    /// The matrix with `n` rows whose elements on and below the diagonal are
    /// `element(row, column)`.
    #[must_use]
    pub fn from_fn(n: usize, mut element: impl FnMut(usize, usize) -> f64) -> Self {
        let rows = (0..n).flat_map(|row| (0..=row).map(move |column| (row, column)));
        Self {
            n,
            packed: rows.map(|(row, column)| element(row, column)).collect(),
        }
    }

    /// Number of rows.
    #[must_use]
    pub fn n(&self) -> usize {
        self.n
    }

    /// The element in `row` and `column`; NaN outside of the matrix.
    #[inline]
    #[must_use]
    pub fn get(&self, row: usize, column: usize) -> f64 {
        let (i, j) = (row.max(column), row.min(column));
        let value = self.packed.get(i * (i + 1) / 2 + j).copied();
        value.unwrap_or(f64::NAN)
    }

    /// Correlation coefficient of two states, -1 to 1: TDK 2016 fig. 3.4. 0 if one of them is known
    /// exactly.
    #[must_use]
    pub fn correlation(&self, row: usize, column: usize) -> f64 {
        let scale = (self.get(row, row) * self.get(column, column)).sqrt();
        if scale > 0.0 {
            (self.get(row, column) / scale).clamp(-1.0, 1.0)
        } else {
            0.0
        }
    }

    #[inline]
    pub(super) fn set(&mut self, row: usize, column: usize, value: f64) {
        let (i, j) = (row.max(column), row.min(column));
        if let Some(element) = self.packed.get_mut(i * (i + 1) / 2 + j) {
            *element = value;
        }
    }

    /// The elements of `row` up to the diagonal.
    #[inline]
    pub(super) fn row(&self, row: usize) -> &[f64] {
        let start = row * (row + 1) / 2;
        self.packed.get(start..=start + row).unwrap_or(&[])
    }

    /// The rows from `first` on, each up to its diagonal.
    pub(super) fn rows_mut(&mut self, first: usize) -> impl Iterator<Item = &mut [f64]> {
        let rest = self
            .packed
            .get_mut(first * (first + 1) / 2..)
            .unwrap_or_default();
        (first..self.n).scan(rest, |rest, row| {
            let (this, next) = std::mem::take(rest).split_at_mut_checked(row + 1)?;
            *rest = next;
            Some(this)
        })
    }

    /// Appends a row (and so a column); `row` ends with the diagonal.
    pub(super) fn push_row(&mut self, row: impl IntoIterator<Item = f64>) {
        self.packed.extend(row);
        self.n += 1;
        debug_assert_eq!(self.packed.len(), self.n * (self.n + 1) / 2);
    }

    /// Removes rows and columns `first` and `first + 1`; what remains is the marginal.
    pub(super) fn remove_pair(&mut self, first: usize) {
        let mut kept = 0;
        let mut read = 0;
        for row in 0..self.n {
            for column in 0..=row {
                let gone = |i: usize| i == first || i == first + 1;
                if !gone(row) && !gone(column) {
                    self.packed[kept] = self.packed[read];
                    kept += 1;
                }
                read += 1;
            }
        }
        self.packed.truncate(kept);
        self.n -= 2;
    }

    /// The definition of [`Self::add_columns`], one number after another. The fast form gives the
    /// same bits.
    #[cfg(test)]
    fn add_columns_plainly(
        &self,
        column: usize,
        factors: &[[f64; 2]],
        first: &mut [f64],
        second: &mut [f64],
    ) {
        for (column, h) in (column..).zip(factors) {
            for row in 0..self.n {
                first[row] += h[0] * self.get(row, column);
                second[row] += h[1] * self.get(row, column);
            }
        }
    }

    /// The definition of [`Self::subtract_outer`], one number after another: P_ij -= Σ w_i w_j. The
    /// fast form gives the same bits: it takes rows and columns in another order, but subtracts the
    /// same products from each number, in the order of the vectors.
    #[cfg(test)]
    fn subtract_outer_plainly(&mut self, vectors: &[f64]) {
        for w in vectors.chunks_exact(self.n) {
            for row in 0..self.n {
                for column in 0..=row {
                    let value = self.get(row, column) - w[row] * w[column];
                    self.set(row, column, value);
                }
            }
        }
    }

    /// Adds neighbouring columns to two vectors: `first` += Σ h₀ p, `second` += Σ h₁ p, for the
    /// columns from `column` on and their `factors` h. A column's part above the diagonal is the
    /// row of the same number; below it, neighbours share a cache line.
    pub(super) fn add_columns<const N: usize>(
        &self,
        column: usize,
        factors: &[[f64; 2]; N],
        first: &mut [f64],
        second: &mut [f64],
    ) {
        // Down to the last of these columns, they begin in different rows.
        let head = column + N;
        for (number, h) in (column..).zip(factors) {
            let above = self.row(number).iter().copied();
            let below = (number + 1..head).map(|row| self.get(row, number));
            for ((a, b), p) in first
                .iter_mut()
                .zip(second.iter_mut())
                .zip(above.chain(below))
            {
                *a += h[0] * p;
                *b += h[1] * p;
            }
        }
        let mut start = head * (head + 1) / 2 + column;
        let rest = first.iter_mut().zip(second.iter_mut()).enumerate();
        for (row, (a, b)) in rest.skip(head) {
            let Some(own) = self.packed.get(start..).and_then(|p| p.first_chunk::<N>()) else {
                return;
            };
            for (p, h) in own.iter().zip(factors) {
                *a += h[0] * p;
                *b += h[1] * p;
            }
            start += row + 1;
        }
    }

    /// P -= Σ w wᵀ for the vectors stored one after another in `vectors`, n numbers each: one pass
    /// over the triangle for each 32 of them. `tiles` is working memory.
    pub(super) fn subtract_outer(&mut self, vectors: &[f64], tiles: &mut Vec<[f64; TILE]>) {
        let n = self.n;
        if vectors.len() == 2 * n {
            let (a, b) = vectors.split_at(n);
            let packed = &mut self.packed;
            return widened(PairPass { packed, a, b });
        }
        // With the widest vector instructions of the machine; products and differences are rounded
        // one by one in all of them, so the bits are the same.
        for some in vectors.chunks((MOST * n).max(1)) {
            let rank = some.len() / n;
            pack(some, n, rank, tiles);
            widened(Pass {
                packed: &mut self.packed,
                n,
                rank,
                tiles,
            });
        }
    }
}

/// One pass over the triangle for some vectors; two have their own, [`PairPass`].
struct Pass<'a> {
    packed: &'a mut [f64],
    n: usize,
    rank: usize,
    tiles: &'a [[f64; TILE]],
}

impl pulp::NullaryFnOnce for Pass<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        subtract_rows(self.packed, self.n, self.rank, self.tiles);
    }
}

/// Sorts vectors of `n` numbers by tiles: the first tile of each vector, the next of each, …; zeros
/// at the end.
fn pack(vectors: &[f64], n: usize, rank: usize, tiles: &mut Vec<[f64; TILE]>) {
    tiles.clear();
    tiles.resize(n.div_ceil(TILE) * rank, [0.0; TILE]);
    for (k, w) in vectors.chunks_exact(n).enumerate() {
        let own = tiles.iter_mut().skip(k).step_by(rank);
        for (lanes, part) in own.zip(w.chunks(TILE)) {
            for (lane, value) in lanes.iter_mut().zip(part) {
                *lane = *value;
            }
        }
    }
}

/// The pass over the triangle: four rows at a time, so that each tile of the vectors is read once
/// for them.
#[inline(always)]
fn subtract_rows(packed: &mut [f64], n: usize, rank: usize, tiles: &[[f64; TILE]]) {
    let mut rest = packed;
    for first in (0..n).step_by(ROWS) {
        let mut scales = [[0.0; ROWS]; MOST];
        // A tile also holds the numbers of these rows, because TILE is a multiple of ROWS.
        let own = tiles.iter().skip(first / TILE * rank).take(rank);
        for (scales, own) in scales.iter_mut().zip(own) {
            *scales = std::array::from_fn(|row| own[first % TILE + row]);
        }
        let mut rows: [&mut [f64]; ROWS] = Default::default();
        for (length, row) in (first + 1..=n).zip(&mut rows) {
            let Some((elements, next)) = rest.split_at_mut_checked(length) else {
                return;
            };
            (*row, rest) = (elements, next);
        }
        // Tiles that lie in all four rows, then the rest of each. There may be fewer than four last
        // rows of the matrix.
        let full = if first + ROWS <= n {
            (first + 1) / TILE
        } else {
            0
        };
        subtract_tiles(&mut rows, &scales, rank, tiles);
        subtract_rest(&mut rows, &scales, rank, (full, tiles));
    }
}

/// The tiles that lie in all four rows: their elements stay in registers while all vectors are
/// subtracted.
#[inline(always)]
fn subtract_tiles(
    rows: &mut [&mut [f64]; ROWS],
    scales: &[[f64; ROWS]; MOST],
    rank: usize,
    tiles: &[[f64; TILE]],
) {
    let [r0, r1, r2, r3] = rows
        .each_mut()
        .map(|row| row.as_chunks_mut::<TILE>().0.iter_mut());
    let rows = r0.zip(r1).zip(r2.zip(r3));
    for (((e0, e1), (e2, e3)), tile) in rows.zip(tiles.chunks_exact(rank)) {
        [*e0, *e1, *e2, *e3] = less([*e0, *e1, *e2, *e3], scales, tile);
    }
}

/// The tiles from the one numbered `full` on, in which some of the rows end. They are padded with
/// zeros and processed like the others: at a hundred landmarks they hold an eighth of all numbers,
/// and one number at a time would take as long as all the rest.
#[inline(always)]
fn subtract_rest(
    rows: &mut [&mut [f64]; ROWS],
    scales: &[[f64; ROWS]; MOST],
    rank: usize,
    (full, tiles): (usize, &[[f64; TILE]]),
) {
    let longest = rows.iter().map(|row| row.len()).max().unwrap_or(0);
    let used = full..longest.div_ceil(TILE);
    for (index, tile) in used.zip(tiles.chunks_exact(rank).skip(full)) {
        let mut parts = [[0.0; TILE]; ROWS];
        for (part, row) in parts.iter_mut().zip(rows.iter()) {
            let own = row.get(TILE * index..).unwrap_or_default();
            for (to, from) in part.iter_mut().zip(own) {
                *to = *from;
            }
        }
        let parts = less(parts, scales, tile);
        for (part, row) in parts.iter().zip(rows.iter_mut()) {
            let own = row.get_mut(TILE * index..).unwrap_or_default();
            for (to, from) in own.iter_mut().zip(part) {
                *to = *from;
            }
        }
    }
}

/// A tile of four rows minus the products of all vectors.
#[inline(always)]
fn less(
    [mut a, mut b, mut c, mut d]: [[f64; TILE]; ROWS],
    scales: &[[f64; ROWS]; MOST],
    tile: &[[f64; TILE]],
) -> [[f64; TILE]; ROWS] {
    // By name and number, which the compiler keeps in registers; it does not do so for nested loops
    // over arrays.
    for ([s0, s1, s2, s3], w) in scales.iter().zip(tile) {
        for lane in 0..TILE {
            a[lane] -= s0 * w[lane];
            b[lane] -= s1 * w[lane];
            c[lane] -= s2 * w[lane];
            d[lane] -= s3 * w[lane];
        }
    }
    [a, b, c, d]
}

#[cfg(test)]
mod tests {
    use nalgebra::DMatrix;
    use proptest::prelude::*;

    use super::*;
    use crate::geom::Length;

    fn dense(m: &SymmetricMatrix) -> DMatrix<f64> {
        DMatrix::from_fn(m.n(), m.n(), |i, j| m.get(i, j))
    }

    fn filled(n: usize) -> SymmetricMatrix {
        let mut m = SymmetricMatrix::default();
        for row in 0..n {
            m.push_row((0..=row).map(|column| (row * 31 + column * 7) as f64));
        }
        m
    }

    proptest! {
        #[test]
        fn outer_products_are_the_dense_ones(n in 1..70_usize, rank in 0..40_usize, seed in prop::collection::vec(-2.0..2.0_f64, 97)) {
            let vectors: Vec<f64> = (0..n * rank).map(|i| seed[(i * 31) % 97]).collect();
            let mut m = filled(n);
            let full = DMatrix::from_column_slice(n, rank, &vectors);
            let expect = dense(&m) - &full * full.transpose();
            let mut plain = m.clone();
            m.subtract_outer(&vectors, &mut vec![]);
            plain.subtract_outer_plainly(&vectors);
            prop_assert!((dense(&m) - expect).length() < 1e-9);
            prop_assert_eq!(m.packed, plain.packed);
        }

        #[test]
        fn a_pair_by_itself_has_the_bits_of_a_pair_among_others(n in 1..70_usize, seed in prop::collection::vec(-2.0..2.0_f64, 97)) {
            let mut vectors: Vec<f64> = (0..2 * n).map(|i| seed[(i * 31) % 97]).collect();
            let (mut alone, mut among) = (filled(n), filled(n));
            alone.subtract_outer(&vectors, &mut vec![]);
            // Subtracting further vectors of zeros changes nothing.
            vectors.resize(5 * n, 0.0);
            among.subtract_outer(&vectors, &mut vec![]);
            prop_assert_eq!(alone.packed, among.packed);
        }

        #[test]
        fn columns_are_those_of_the_dense_matrix(n in 2..12_usize, column in 0..12_usize) {
            prop_assume!(column + 1 < n);
            let m = filled(n);
            let (mut first, mut second) = (vec![1.0; n], vec![0.0; n]);
            m.add_columns(column, &[[1.0, 0.5], [3.0, -2.0]], &mut first, &mut second);
            let (p, q) = (dense(&m).column(column).into_owned(), dense(&m).column(column + 1).into_owned());
            let sums = [(&p + &q * 3.0).add_scalar(1.0), &p * 0.5 - &q * 2.0];
            let (mut plain_first, mut plain_second) = (vec![1.0; n], vec![0.0; n]);
            let factors = [[1.0, 0.5], [3.0, -2.0]];
            m.add_columns_plainly(column, &factors, &mut plain_first, &mut plain_second);
            prop_assert_eq!(&first, &plain_first);
            prop_assert_eq!(&second, &plain_second);
            prop_assert_eq!(first, sums[0].as_slice());
            prop_assert_eq!(second, sums[1].as_slice());
        }

        #[test]
        fn removing_a_pair_is_removing_rows_and_columns(n in 2..12_usize, first in 0..10_usize) {
            prop_assume!(first + 1 < n);
            let mut m = filled(n);
            let expect = dense(&m).remove_rows(first, 2).remove_columns(first, 2);
            m.remove_pair(first);
            prop_assert_eq!(dense(&m), expect);
        }
    }

    #[test]
    fn outside_is_nan_and_rows_end_at_the_diagonal() {
        let mut m = filled(4);
        assert!(m.get(4, 0).is_nan() && !m.get(3, 3).is_nan());
        assert_eq!(m.row(2).len(), 3);
        assert_eq!(
            m.rows_mut(1).map(|r| r.len()).collect::<Vec<_>>(),
            [2, 3, 4]
        );
        m.set(1, 3, 5.0);
        assert!((m.get(3, 1) - 5.0).abs() < 1e-12);
    }
}

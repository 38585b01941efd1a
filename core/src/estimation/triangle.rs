//! A symmetric matrix that grows and shrinks at its end, kept as its lower triangle.
//!
//! Row i starts at i (i + 1) / 2, so a new landmark's rows are pushed at the end and nothing moves; the update of the filter
//! touches half of the numbers a full matrix would have; and symmetry needs no care, because there is only one of
//! each pair.

/// Lower triangle of a symmetric matrix, packed by rows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SymmetricMatrix {
    n: usize,
    packed: Vec<f64>,
}

impl SymmetricMatrix {
    /// The matrix with `n` rows whose elements on and below the diagonal are `element(row, column)`.
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

    /// Correlation coefficient of two states, -1 to 1: TDK 2016 fig. 3.4. 0 where one of them is known exactly.
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
    #[cfg(test)]
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

    /// Takes rows and columns `first` and `first + 1` out: the marginal of what is left.
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

    /// P -= a aᵀ + b bᵀ, with (a, b) the rows of `w`: one pass over the triangle.
    pub(super) fn subtract_rank2(&mut self, w: &[[f64; 2]]) {
        for (row, wi) in self.rows_mut(0).zip(w) {
            for (element, wj) in row.iter_mut().zip(w) {
                *element -= wi[0] * wj[0] + wi[1] * wj[1];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::DMatrix;
    use proptest::prelude::*;

    use super::*;

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
        fn rank_two_update_is_the_dense_one(n in 2..12_usize, seed in prop::collection::vec((-2.0..2.0_f64, -2.0..2.0_f64), 12)) {
            let w: Vec<[f64; 2]> = seed.iter().take(n).map(|&(a, b)| [a, b]).collect();
            let mut m = filled(n);
            let full = DMatrix::from_fn(n, 2, |i, j| w[i][j]);
            let expect = dense(&m) - &full * full.transpose();
            m.subtract_rank2(&w);
            prop_assert!((dense(&m) - expect).norm() < 1e-9);
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

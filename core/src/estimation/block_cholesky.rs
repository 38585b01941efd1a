//! Sparse symmetric positive definite systems of 3 x 3 blocks: the linear step of a pose graph.
//!
//! In: the pattern of the blocks, then their values and a right side. Out: the solution.
//!
//! 1. The elimination order is that of least degree: the block with fewest neighbours goes first
//!    and makes its neighbours a clique (Tinney & Walker 1967). The fill-in comes out on the way.
//!    Order and fill depend on the pattern alone and are kept for all later steps.
//! 2. The factor L of L Lᵀ is made column by column; each column updates the clique of its rows.
//! 3. Forward and backward substitution.
//!
//! Our own and not a crate's: with blocks of fixed size the inner loops are unrolled, the order is
//! kept, and the result is the same to the bit everywhere.

use std::collections::BTreeSet;

use nalgebra::{Matrix3, Vector3};

/// Order and pattern of the factor.
#[derive(Clone, Debug)]
pub(super) struct BlockPattern {
    /// Place in the order, for each block.
    place: Vec<usize>,
    /// Rows below the diagonal of each column, as places, rising.
    rows: Vec<Vec<usize>>,
}

/// A symmetric matrix on its way to its factor.
#[derive(Clone, Debug)]
pub(super) struct BlockMatrix {
    diagonal: Vec<Matrix3<f64>>,
    below: Vec<Vec<Matrix3<f64>>>,
}

impl BlockPattern {
    /// Orders `size` blocks that are coupled as `pairs` say.
    #[must_use]
    pub(super) fn new(size: usize, pairs: impl IntoIterator<Item = (usize, usize)>) -> Self {
        let mut neighbours = vec![BTreeSet::new(); size];
        for (a, b) in pairs {
            if a != b && a < size && b < size {
                neighbours[a].insert(b);
                neighbours[b].insert(a);
            }
        }
        let mut waiting: BTreeSet<_> = neighbours
            .iter()
            .enumerate()
            .map(|(block, n)| (n.len(), block))
            .collect();
        let mut place = vec![0; size];
        let mut columns = Vec::with_capacity(size);
        while let Some((_, block)) = waiting.pop_first() {
            place[block] = columns.len();
            let clique: Vec<usize> = std::mem::take(&mut neighbours[block]).into_iter().collect();
            for &a in &clique {
                let old = neighbours[a].len();
                neighbours[a].remove(&block);
                neighbours[a].extend(clique.iter().copied().filter(|&b| b != a));
                if neighbours[a].len() != old {
                    waiting.remove(&(old, a));
                    waiting.insert((neighbours[a].len(), a));
                }
            }
            columns.push(clique);
        }
        let rows = columns
            .into_iter()
            .map(|column| {
                let mut rows: Vec<_> = column.into_iter().map(|block| place[block]).collect();
                rows.sort_unstable();
                rows
            })
            .collect();
        Self { place, rows }
    }

    /// Blocks of the factor below the diagonal.
    #[cfg(test)]
    #[must_use]
    pub(super) fn fill(&self) -> usize {
        self.rows.iter().map(Vec::len).sum()
    }

    /// A matrix of zeros with this pattern.
    #[must_use]
    pub(super) fn zeros(&self) -> BlockMatrix {
        BlockMatrix {
            diagonal: vec![Matrix3::zeros(); self.rows.len()],
            below: self
                .rows
                .iter()
                .map(|rows| vec![Matrix3::zeros(); rows.len()])
                .collect(),
        }
    }

    /// Adds to the block at (`row`, `column`), and so to its mirror image; pairs outside of the
    /// pattern are left out.
    pub(super) fn add(
        &self,
        matrix: &mut BlockMatrix,
        row: usize,
        column: usize,
        value: &Matrix3<f64>,
    ) {
        let (Some(&r), Some(&c)) = (self.place.get(row), self.place.get(column)) else {
            return;
        };
        if r == c {
            matrix.diagonal[r] += value;
            return;
        }
        let (low, high, value) = if r > c {
            (c, r, *value)
        } else {
            (r, c, value.transpose())
        };
        if let Ok(at) = self.rows[low].binary_search(&high) {
            matrix.below[low][at] += value;
        }
    }

    /// Adds `damping` times the diagonal to the diagonal (Marquardt).
    pub(super) fn damp(&self, matrix: &mut BlockMatrix, damping: f64) {
        for block in &mut matrix.diagonal {
            for i in 0..3 {
                block[(i, i)] += damping * block[(i, i)] + 1e-12;
            }
        }
    }

    /// Turns the matrix into its factor; `false` where it is not positive definite.
    #[must_use]
    pub(super) fn factor(&self, matrix: &mut BlockMatrix) -> bool {
        for (column, rows) in self.rows.iter().enumerate() {
            let Some(cholesky) = matrix.diagonal[column].cholesky() else {
                return false;
            };
            let l = cholesky.l();
            matrix.diagonal[column] = l;
            let mut values = std::mem::take(&mut matrix.below[column]);
            for value in &mut values {
                *value = times_inverse_transpose(value, &l);
            }
            for (j, (&row_j, value_j)) in rows.iter().zip(&values).enumerate() {
                matrix.diagonal[row_j] -= value_j * value_j.transpose();
                // The rows after j stand in column j too: both lists rise, so one walk finds them
                // all.
                let mut targets = self.rows[row_j]
                    .iter()
                    .zip(matrix.below[row_j].iter_mut())
                    .peekable();
                for (&row_i, value_i) in rows.iter().zip(&values).skip(j + 1) {
                    while targets.next_if(|(row, _)| **row < row_i).is_some() {}
                    if let Some((_, target)) = targets.next_if(|(row, _)| **row == row_i) {
                        *target -= value_i * value_j.transpose();
                    }
                }
            }
            matrix.below[column] = values;
        }
        true
    }

    /// Solves with a factor, in place.
    pub(super) fn solve(&self, factor: &BlockMatrix, right: &mut [Vector3<f64>]) {
        let mut x = vec![Vector3::zeros(); self.rows.len()];
        for (&place, value) in self.place.iter().zip(right.iter()) {
            x[place] = *value;
        }
        for (column, rows) in self.rows.iter().enumerate() {
            let l = &factor.diagonal[column];
            let value = forward(l, &x[column]);
            x[column] = value;
            for (&row, block) in rows.iter().zip(&factor.below[column]) {
                x[row] -= block * value;
            }
        }
        for (column, rows) in self.rows.iter().enumerate().rev() {
            let mut value = x[column];
            for (&row, block) in rows.iter().zip(&factor.below[column]) {
                value -= block.transpose() * x[row];
            }
            x[column] = backward(&factor.diagonal[column], &value);
        }
        for (&place, value) in self.place.iter().zip(right.iter_mut()) {
            *value = x[place];
        }
    }
}

/// A L⁻ᵀ for a lower triangular L.
fn times_inverse_transpose(a: &Matrix3<f64>, l: &Matrix3<f64>) -> Matrix3<f64> {
    let mut x = Matrix3::zeros();
    for row in 0..3 {
        let r = forward(l, &a.row(row).transpose());
        x.set_row(row, &r.transpose());
    }
    x
}

/// L⁻¹ b.
fn forward(l: &Matrix3<f64>, b: &Vector3<f64>) -> Vector3<f64> {
    let x = b.x / l[(0, 0)];
    let y = (b.y - l[(1, 0)] * x) / l[(1, 1)];
    let z = (b.z - l[(2, 0)] * x - l[(2, 1)] * y) / l[(2, 2)];
    Vector3::new(x, y, z)
}

/// L⁻ᵀ b.
fn backward(l: &Matrix3<f64>, b: &Vector3<f64>) -> Vector3<f64> {
    let z = b.z / l[(2, 2)];
    let y = (b.y - l[(2, 1)] * z) / l[(1, 1)];
    let x = (b.x - l[(1, 0)] * y - l[(2, 0)] * z) / l[(0, 0)];
    Vector3::new(x, y, z)
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn solves_as_a_dense_solver_does(
            size in 1_usize..12,
            pairs in proptest::collection::vec((0_usize..12, 0_usize..12, -1.0..1.0_f64), 0..30),
        ) {
            let pairs: Vec<_> = pairs.into_iter().map(|(a, b, v)| (a % size, b % size, v)).filter(|p| p.0 != p.1).collect();
            let pattern = BlockPattern::new(size, pairs.iter().map(|p| (p.0, p.1)));
            let mut matrix = pattern.zeros();
            let mut dense = DMatrix::zeros(3 * size, 3 * size);
            for block in 0..size {
                let value = Matrix3::from_diagonal_element(40.0) + Matrix3::new(0.0, 1.0, 2.0, 1.0, 0.0, 3.0, 2.0, 3.0, 0.0);
                pattern.add(&mut matrix, block, block, &value);
                let mut view = dense.fixed_view_mut::<3, 3>(3 * block, 3 * block);
                view += value;
            }
            for &(a, b, v) in &pairs {
                let value = Matrix3::new(v, 0.1, 0.3, -0.2, v * v, 0.5, 0.7, v, -v);
                pattern.add(&mut matrix, a, b, &value);
                let mut view = dense.fixed_view_mut::<3, 3>(3 * a, 3 * b);
                view += value;
                let mut view = dense.fixed_view_mut::<3, 3>(3 * b, 3 * a);
                view += value.transpose();
            }
            let right: Vec<_> = (0..size).map(|i| Vector3::new(i as f64, 1.0, -2.0)).collect();
            let flat = DVector::from_iterator(3 * size, right.iter().flat_map(|v| v.iter().copied()));
            let Some(cholesky) = dense.clone().cholesky() else {
                prop_assert!(!pattern.factor(&mut matrix));
                return Ok(());
            };
            let expect = cholesky.solve(&flat);
            let mut solved = right;
            prop_assert!(pattern.factor(&mut matrix));
            pattern.solve(&matrix, &mut solved);
            for (i, value) in solved.iter().enumerate() {
                for axis in 0..3 { prop_assert!((value[axis] - expect[3 * i + axis]).abs() < 1e-9); }
            }
        }
    }

    #[test]
    fn a_chain_fills_nothing_in() {
        let pattern = BlockPattern::new(50, (1..50).map(|i| (i - 1, i)));
        assert_eq!(pattern.fill(), 49);
    }
}

//! Ground truth: dense matrices.

use nalgebra::{DMatrix, DVector, Vector3};
use proptest::prelude::*;

use super::*;

/// Couplings of up to `size` blocks, with a number each.
fn pairs(size: usize) -> impl Strategy<Value = Vec<(usize, usize, f64)>> {
    let pair = (0..size, 0..size, -1.0..1.0_f64);
    let pairs = proptest::collection::vec(pair, 0..3 * size);
    pairs.prop_map(|pairs| pairs.into_iter().filter(|p| p.0 != p.1).collect())
}

fn coupled(size: usize) -> impl Strategy<Value = (usize, Vec<(usize, usize, f64)>)> {
    (1..=size).prop_flat_map(|size| (Just(size), pairs(size)))
}

/// The same matrix, sparse and dense.
fn matrices(pattern: &BlockPattern, pairs: &[(usize, usize, f64)]) -> (BlockMatrix, DMatrix<f64>) {
    let size = pattern.size();
    let mut sparse = pattern.zeros(None);
    let mut dense = DMatrix::zeros(3 * size, 3 * size);
    let mut add = |row: usize, column: usize, value: Matrix3<f64>| {
        sparse.add(pattern.slot(row, column).unwrap(), &value);
        let mut view = dense.fixed_view_mut::<3, 3>(3 * row, 3 * column);
        view += value;
        if row != column {
            let mut view = dense.fixed_view_mut::<3, 3>(3 * column, 3 * row);
            view += value.transpose();
        }
    };
    for block in 0..size {
        let off = Matrix3::new(0.0, 1.0, 2.0, 1.0, 0.0, 3.0, 2.0, 3.0, 0.0);
        add(block, block, Matrix3::from_diagonal_element(30.0) + off);
    }
    for &(a, b, v) in pairs {
        add(
            a,
            b,
            Matrix3::new(v, 0.1, 0.3, -0.2, v * v, 0.5, 0.7, v, -v),
        );
    }
    (sparse, dense)
}

fn ends(pairs: &[(usize, usize, f64)]) -> impl Iterator<Item = (usize, usize)> + Clone {
    pairs.iter().map(|p| (p.0, p.1))
}

fn check(pattern: &BlockPattern, pairs: &[(usize, usize, f64)]) -> Result<(), TestCaseError> {
    let (sparse, dense) = matrices(pattern, pairs);
    let factor = pattern.factor(sparse, 0.0);
    let Some(cholesky) = dense.clone().cholesky() else {
        prop_assert!(factor.is_none());
        return Ok(());
    };
    prop_assert!(factor.is_some());
    let factor = factor.unwrap();
    let right: Vec<_> = (0..pattern.size())
        .map(|i| Vector3::new(i as f64, 1.0, -2.0))
        .collect();
    let flat = DVector::from_iterator(dense.nrows(), right.iter().flat_map(|v| v.iter().copied()));
    let inverse = cholesky.inverse();
    // As accurate as the condition of the matrix allows.
    let most = 1e-10 * (1.0 + inverse.amax());
    let expect = cholesky.solve(&flat);
    let mut solved = right;
    pattern.solve(&factor, &mut solved);
    for (i, value) in solved.iter().enumerate() {
        let error = (value - expect.fixed_rows::<3>(3 * i)).amax();
        prop_assert!(error < most * (1.0 + flat.amax()), "{error}");
    }
    for (i, block) in pattern.inverse_diagonal(&factor).iter().enumerate() {
        let error = (block - inverse.fixed_view::<3, 3>(3 * i, 3 * i)).amax();
        prop_assert!(error < most * (1.0 + inverse.amax()), "{error}");
    }
    Ok(())
}

proptest! {
    #[test]
    fn solves_and_inverts_as_dense_matrices_do((size, pairs) in coupled(40)) {
        check(&BlockPattern::new(size, ends(&pairs)), &pairs)?;
    }

    #[test]
    fn a_pattern_that_has_grown_serves_as_a_new_one((size, pairs) in coupled(30)) {
        let half = pairs.len() / 2;
        let old = pairs[..half].iter().filter(|p| p.0.max(p.1) <= size / 2);
        let old = BlockPattern::new(size / 2 + 1, old.map(|p| (p.0, p.1)));
        check(&old.grown(size, ends(&pairs)), &pairs)?;
    }

    #[test]
    fn each_column_holds_what_elimination_leaves((size, pairs) in coupled(25)) {
        let pattern = BlockPattern::new(size, ends(&pairs));
        let place = &pattern.tree.place;
        let mut filled = vec![vec![false; size]; size];
        for &(a, b, _) in &pairs {
            filled[place[a].max(place[b])][place[a].min(place[b])] = true;
        }
        for column in 0..size {
            let rows: Vec<_> = (column + 1..size).filter(|&row| filled[row][column]).collect();
            prop_assert_eq!(pattern.tree.rows(column), &rows);
            for &a in &rows {
                for &b in rows.iter().filter(|&&b| b < a) {
                    filled[a][b] = true;
                }
            }
        }
    }
}

#[test]
fn a_chain_fills_nothing_in() {
    let pattern = BlockPattern::new(50, (1..50).map(|i| (i - 1, i)));
    assert_eq!(pattern.tree.fill(), 49);
}

#[test]
fn a_growing_chain_keeps_its_order_until_it_fills_in() {
    let chain = |size: usize| (1..size).map(|i| (i - 1, i));
    let pattern = BlockPattern::new(50, chain(50));
    let longer = pattern.grown(60, chain(60));
    assert_eq!(longer.tree.fill(), 59);
    // Every new block is coupled with all: a new order is computed.
    let dense = (0..60).flat_map(|a| (0..a).map(move |b| (b, a)));
    assert_eq!(longer.grown(60, dense).tree.fill(), 60 * 59 / 2);
}

#[test]
fn nothing_is_solved_at_once() {
    let pattern = BlockPattern::new(0, std::iter::empty());
    let factor = pattern.factor(pattern.zeros(None), 0.0).unwrap();
    assert!(pattern.inverse_diagonal(&factor).is_empty());
}

#[test]
fn what_nothing_holds_is_no_positive_definite_matrix_unless_damped() {
    let pattern = BlockPattern::new(2, std::iter::empty());
    let mut matrix = pattern.zeros(None);
    matrix.add(pattern.slot(0, 0).unwrap(), &Matrix3::identity());
    assert!(pattern.factor(matrix.clone(), 0.0).is_none());
    assert!(pattern.factor(matrix, 1e-8).is_some());
}

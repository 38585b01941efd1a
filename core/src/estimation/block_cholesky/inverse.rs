//! The diagonal blocks of the inverse, without the rest of it.
//!
//! From the root down. With the factor of a supernode's columns split into L₁ (its own rows) and L₂
//! (those below), and the inverse S₂₂ at the rows below known from the parent:
//!
//! ```text
//! G = L₂ L₁⁻¹    S₂₁ = -S₂₂ G    S₁₁ = L₁⁻ᵀ L₁⁻¹ - Gᵀ S₂₁
//! ```
//!
//! Source: Takahashi, Fagan & Chin (1973); Erisman & Tinney (1975).

use nalgebra::Matrix3;
use pulp::NullaryFnOnce;

use super::dense::BLOCK;
use super::{BlockFactor, BlockPattern};
use crate::lanes::{LANES, widened};

impl BlockPattern {
    /// The blocks on the diagonal of the inverse, from a factor.
    #[must_use]
    pub(in super::super) fn inverse_diagonal(&self, factor: &BlockFactor) -> Vec<Matrix3<f64>> {
        let mut diagonal = vec![Matrix3::zeros(); self.size()];
        widened(Inverting {
            pattern: self,
            factor,
            diagonal: &mut diagonal,
        });
        self.tree
            .place
            .iter()
            .map(|&place| diagonal[place])
            .collect()
    }
}

struct Inverting<'a> {
    pattern: &'a BlockPattern,
    factor: &'a BlockFactor,
    /// By place in the order.
    diagonal: &'a mut [Matrix3<f64>],
}

/// A dense square matrix, by columns.
#[derive(Clone, Default)]
struct Square {
    height: usize,
    values: Vec<f64>,
}

impl NullaryFnOnce for Inverting<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self {
            pattern,
            factor,
            diagonal,
        } = self;
        let tree = &pattern.tree;
        let mut inverses = vec![Square::default(); tree.supernodes.len()];
        for (index, (node, front)) in tree
            .supernodes
            .iter()
            .zip(&pattern.fronts)
            .enumerate()
            .rev()
        {
            let below = tree.below(node).len();
            let places = &pattern.in_parent[front.in_parent..];
            let at_rows_below = match tree.parent(node) {
                Some(parent) => inverses[parent].at(&places[..below]),
                None => Square::default(),
            };
            let panel =
                factor.panels[front.panel..][..BLOCK * node.width * front.fours].as_flattened();
            let inverse = invert(
                panel,
                LANES * front.fours,
                BLOCK * node.width,
                &at_rows_below,
            );
            for within in 0..node.width {
                let at = BLOCK * within;
                diagonal[node.first + within] =
                    Matrix3::from_fn(|r, c| inverse.values[(at + c) * inverse.height + at + r]);
            }
            if !front.children.is_empty() {
                inverses[index] = inverse;
            }
        }
    }
}

impl Square {
    fn zeros(height: usize) -> Self {
        Self {
            height,
            values: vec![0.0; height * height],
        }
    }

    /// The rows and columns at these places, in blocks.
    #[inline(always)]
    fn at(&self, places: &[usize]) -> Self {
        let mut values = Vec::with_capacity(BLOCK * BLOCK * places.len() * places.len());
        for &place in places {
            for column in self
                .values
                .chunks_exact(self.height)
                .skip(BLOCK * place)
                .take(BLOCK)
            {
                for &row in places {
                    values.extend_from_slice(&column[BLOCK * row..][..BLOCK]);
                }
            }
        }
        Self {
            height: BLOCK * places.len(),
            values,
        }
    }

    fn column(&self, index: usize) -> &[f64] {
        &self.values[index * self.height..][..self.height]
    }
}

/// The inverse at the rows of a supernode, whose columns of the factor are `panel`, with `stride`
/// from column to column; `below` is the inverse at the rows below its `own`.
#[inline(always)]
fn invert(panel: &[f64], stride: usize, own: usize, below: &Square) -> Square {
    let l = |row: usize, column: usize| panel[column * stride + row];
    // L₁⁻¹, by columns.
    let mut k = Square::zeros(own);
    for column in 0..own {
        k.values[column * own + column] = l(column, column);
        for row in column + 1..own {
            let sum: f64 = (column..row)
                .map(|i| l(row, i) * k.values[column * own + i])
                .sum();
            k.values[column * own + row] = -sum * l(row, row);
        }
    }
    let mut inverse = Square::zeros(own + below.height);
    let height = inverse.height;
    let mut g = vec![0.0; below.height * own];
    for (column, g) in g.chunks_exact_mut(below.height.max(1)).enumerate() {
        for i in column..own {
            add(g, k.values[column * own + i], &panel[i * stride + own..]);
        }
        let s21 = &mut inverse.values[column * height..][own..height];
        for (i, &g) in g.iter().enumerate() {
            add(s21, -g, below.column(i));
        }
    }
    for column in 0..own {
        for row in column..own {
            let square: f64 = (row..own)
                .map(|i| k.values[row * own + i] * k.values[column * own + i])
                .sum();
            let s21 = &inverse.values[column * height..][own..height];
            let g = &g[row * below.height..][..below.height];
            let carried: f64 = g.iter().zip(s21).map(|(g, s)| g * s).sum();
            inverse.values[column * height + row] = square - carried;
            inverse.values[row * height + column] = square - carried;
        }
        for row in own..height {
            inverse.values[row * height + column] = inverse.values[column * height + row];
        }
    }
    for column in own..height {
        let known = below.column(column - own);
        inverse.values[column * height..][own..height].copy_from_slice(known);
    }
    inverse
}

/// target += by * values.
#[inline(always)]
fn add(target: &mut [f64], by: f64, values: &[f64]) {
    for (target, value) in target.iter_mut().zip(values) {
        *target += by * value;
    }
}

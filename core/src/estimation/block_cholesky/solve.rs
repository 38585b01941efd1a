//! Forward and backward substitution.

use nalgebra::Vector3;
use pulp::NullaryFnOnce;

use super::dense::BLOCK;
use super::{BlockFactor, BlockPattern};
use crate::lanes::{LANES, widened};

impl BlockPattern {
    /// Solves with a factor, in place.
    pub(in super::super) fn solve(&self, factor: &BlockFactor, right: &mut [Vector3<f64>]) {
        let mut x = vec![0.0; BLOCK * self.size()];
        for (value, &place) in right.iter().zip(&self.tree.place) {
            x[BLOCK * place..][..BLOCK].copy_from_slice(value.as_slice());
        }
        widened(Solving {
            pattern: self,
            factor,
            x: &mut x,
        });
        for (value, &place) in right.iter_mut().zip(&self.tree.place) {
            value.copy_from_slice(&x[BLOCK * place..][..BLOCK]);
        }
    }
}

struct Solving<'a> {
    pattern: &'a BlockPattern,
    factor: &'a BlockFactor,
    x: &'a mut [f64],
}

impl NullaryFnOnce for Solving<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { pattern, factor, x } = self;
        let tree = &pattern.tree;
        // The rows of one supernode.
        let mut local: Vec<f64> = vec![];
        for (node, front) in tree.supernodes.iter().zip(&pattern.fronts) {
            let (first, rows) = (BLOCK * node.first, BLOCK * node.width);
            let height = LANES * front.fours;
            local.clear();
            local.extend_from_slice(&x[first..first + rows]);
            local.resize(height, 0.0);
            let panel = factor.panels[front.panel..][..rows * front.fours].as_flattened();
            for (index, column) in panel.chunks_exact(height).enumerate() {
                let value = local[index] / column[index];
                local[index] = value;
                for (x, l) in local[index + 1..].iter_mut().zip(&column[index + 1..]) {
                    *x -= l * value;
                }
            }
            x[first..first + rows].copy_from_slice(&local[..rows]);
            for (sums, &row) in local[rows..].chunks_exact(BLOCK).zip(tree.below(node)) {
                for (x, sum) in x[BLOCK * row..][..BLOCK].iter_mut().zip(sums) {
                    *x += sum;
                }
            }
        }
        for (node, front) in tree.supernodes.iter().zip(&pattern.fronts).rev() {
            let (first, rows) = (BLOCK * node.first, BLOCK * node.width);
            let height = LANES * front.fours;
            local.clear();
            local.extend_from_slice(&x[first..first + rows]);
            for &row in tree.below(node) {
                local.extend_from_slice(&x[BLOCK * row..][..BLOCK]);
            }
            let panel = factor.panels[front.panel..][..rows * front.fours].as_flattened();
            for (index, column) in panel.chunks_exact(height).enumerate().rev() {
                let known = local[index + 1..].iter().zip(&column[index + 1..]);
                let sum = known.fold(local[index], |sum, (x, l)| sum - l * x);
                local[index] = sum / column[index];
            }
            x[first..first + rows].copy_from_slice(&local[..rows]);
        }
    }
}

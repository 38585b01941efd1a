//! The factor of a matrix, supernode by supernode.

use super::dense::{self, BLOCK, Four};
use super::tree::Supernode;
use super::{BlockFactor, BlockMatrix, BlockPattern, Front};
use crate::lanes::{self, Kernel, LANES, Lanes};

/// Added with damping, so that unconstrained poses have a pivot too.
const LEAST_PIVOT: f64 = 1e-12;

impl BlockPattern {
    /// Factorises a matrix to whose diagonal `damping` times itself is added (Marquardt); `None` if
    /// that is not positive definite.
    #[must_use]
    pub(in super::super) fn factor(
        &self,
        matrix: BlockMatrix,
        damping: f64,
    ) -> Option<BlockFactor> {
        let BlockMatrix { panels, mut stack } = matrix;
        stack.resize(self.stack, [0.0; LANES]);
        let mut factor = BlockFactor { panels, stack };
        let is_definite = lanes::run(Factoring {
            pattern: self,
            damping,
            factor: &mut factor,
        });
        is_definite.then_some(factor)
    }
}

struct Factoring<'a> {
    pattern: &'a BlockPattern,
    damping: f64,
    /// The matrix, until it becomes its factor.
    factor: &'a mut BlockFactor,
}

impl Kernel for Factoring<'_> {
    type Output = bool;

    #[inline(always)]
    fn run<L: Lanes>(self, machine: L::Machine) -> bool {
        let BlockFactor { panels, stack } = self.factor;
        let pattern = self.pattern;
        let mut top = 0;
        for (node, front) in pattern.tree.supernodes.iter().zip(&pattern.fronts) {
            let rows = BLOCK * node.width;
            let panel = &mut panels[front.panel..][..rows * front.fours];
            if self.damping > 0.0 {
                damp(self.damping, panel, front.fours);
            }
            let (waiting, free) = stack.split_at_mut(top);
            let left = &mut free[..front.left];
            left.fill([0.0; LANES]);
            let mut base = top;
            for &child in front.children.iter().rev() {
                let of_child = pattern.fronts[child].left;
                base -= of_child;
                let from = &waiting[base..base + of_child];
                take(pattern, child, from, (node, front), panel, left);
            }
            if !dense::factor::<L>(machine, panel, front.fours) {
                return false;
            }
            // At least 1: if no rows are below, there are no columns either.
            let block = (BLOCK * (front.fours - rows / LANES)).max(1);
            for (index, target) in left.chunks_exact_mut(block).enumerate() {
                let at = rows + BLOCK * index;
                dense::subtract::<L>(machine, target, at, panel, front.fours);
            }
            stack.copy_within(top..top + front.left, base);
            top = base + front.left;
        }
        true
    }
}

/// Damps the diagonal of a supernode's columns, before its children are added.
#[inline(always)]
fn damp(damping: f64, panel: &mut [Four], fours: usize) {
    for (index, column) in panel.chunks_exact_mut(fours).enumerate() {
        if let Some(number) = column.as_flattened_mut().get_mut(index) {
            *number += damping * *number + LEAST_PIVOT;
        }
    }
}

/// Adds what a child left to the columns of its parent, and to what the parent will leave.
#[inline(always)]
fn take(
    pattern: &BlockPattern,
    child: usize,
    from: &[Four],
    (node, front): (&Supernode, &Front),
    panel: &mut [Four],
    left: &mut [Four],
) {
    let (of_child, child) = (&pattern.tree.supernodes[child], &pattern.fronts[child]);
    let rows = BLOCK * of_child.width;
    let fours = child.fours - rows / LANES;
    let below = pattern.tree.below(of_child).len();
    let places = &pattern.in_parent[child.in_parent..][..below];
    let own = BLOCK * node.width;
    let own_fours = front.fours - own / LANES;
    for (index, (columns, &place)) in from.chunks_exact(BLOCK * fours).zip(places).enumerate() {
        // Either a column of the parent itself, or one that it leaves in turn.
        let (target, length, skipped) = if place < node.width {
            (&mut panel[place * BLOCK * front.fours..], front.fours, 0)
        } else {
            let at = (place - node.width) * BLOCK * own_fours;
            (&mut left[at..], own_fours, own - own % LANES)
        };
        for (column, target) in columns
            .chunks_exact(fours)
            .zip(target.chunks_exact_mut(length))
        {
            let column = &column.as_flattened()[rows % LANES + BLOCK * index..];
            let target = target.as_flattened_mut();
            for (numbers, &row) in column.chunks_exact(BLOCK).zip(&places[index..]) {
                let at = BLOCK * row - skipped;
                for (target, number) in target[at..at + BLOCK].iter_mut().zip(numbers) {
                    *target += number;
                }
            }
        }
    }
}

//! Sparse symmetric positive definite systems of 3 x 3 blocks: the linear step of a pose graph.
//!
//! In: which blocks are coupled, then their values and a right side. Out: the solution, and blocks
//! of the inverse.
//!
//! 1. An elimination order with little fill-in (`couplings`: approximate minimum degree).
//! 2. Columns that share their rows become supernodes of a tree (`tree`). Both depend on the
//!    pattern alone and are kept for all later steps.
//! 3. The factor L of L Lᵀ, supernode by supernode (`factor`): each takes its own blocks of the
//!    matrix and the contributions of its children, eliminates its columns densely (`dense`), and
//!    leaves the Schur complement to its parent (Duff & Reid 1983, "multifrontal").
//! 4. Forward and backward substitution (`solve`).
//! 5. The diagonal blocks of the inverse, from the root down (`inverse`).
//!
//! The order comes from the crate `amd`, the factor is our own. `faer` 0.24, the best maintained
//! sparse Cholesky in Rust, knows nothing of blocks: for `m3500.g2o` it took 18 ms for a factor,
//! where this one takes 0.9, and 14 for its pattern, where this one takes 1.7; g2o solves that
//! graph in 31. It uses fused multiply-add where the machine has it, so its bits differ from those
//! in the browser; and it takes two minutes to compile.

mod couplings;
mod dense;
mod factor;
mod inverse;
mod saved;
mod solve;
#[cfg(test)]
mod tests;
mod tree;

use nalgebra::Matrix3;

use self::couplings::Couplings;
use self::dense::{BLOCK, Four};
use self::tree::Tree;
use crate::lanes::LANES;

/// Order and pattern of the factor.
#[derive(Clone, Debug, Default)]
pub(super) struct BlockPattern {
    tree: Tree,
    /// The blocks of the matrix's lower triangle, by columns; the diagonal first.
    entries: Vec<Entry>,
    /// Where the entries of each column begin, and finally where the last ones end.
    starts: Vec<usize>,
    /// In the order of the tree's supernodes.
    fronts: Vec<Front>,
    /// For each supernode, the places of the rows below its columns among the rows of its parent,
    /// in blocks.
    in_parent: Vec<usize>,
    /// Length of the factor, in fours.
    panels: usize,
    /// The largest amount that waits for parents at once, in fours.
    stack: usize,
    /// Blocks of the factor per block column, when its order was found.
    density: f64,
}

/// A block of the matrix.
#[derive(Clone, Copy, Debug)]
struct Entry {
    /// The place of its row.
    row: usize,
    /// The index of its first number in the factor.
    at: usize,
}

/// Where the numbers of a supernode are stored.
#[derive(Clone, Debug)]
struct Front {
    /// Where its columns begin in the factor, in fours.
    panel: usize,
    /// Length of each, in fours.
    fours: usize,
    /// Length of what it leaves to its parent, in fours: the rows below its columns, starting with
    /// the four that contains the first of them.
    left: usize,
    /// Where its rows begin in `BlockPattern::in_parent`.
    in_parent: usize,
    children: Vec<usize>,
}

/// A symmetric matrix, already stored in the layout of its factor.
#[derive(Clone, Debug)]
pub(super) struct BlockMatrix {
    panels: Vec<Four>,
    /// Working memory for the factorisation.
    stack: Vec<Four>,
}

/// A factor, in the memory of the matrix from which it was made.
#[derive(Clone, Debug)]
pub(super) struct BlockFactor {
    panels: Vec<Four>,
    stack: Vec<Four>,
}

/// Where a block of the matrix is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Slot {
    /// Its first number.
    at: usize,
    /// The distance from one column to the next.
    height: usize,
    /// Whether the transposed block is stored instead.
    is_mirrored: bool,
}

/// An order is kept until its fill-in is this many times that at the time it was found.
const MOST_DENSITY: f64 = 1.2;

impl BlockPattern {
    /// Orders `size` blocks that are coupled as given by `pairs`.
    #[cfg(test)]
    #[must_use]
    pub(super) fn new(size: usize, pairs: impl Iterator<Item = (usize, usize)> + Clone) -> Self {
        Self::ordered(&Couplings::new(size, pairs))
    }

    /// The pattern of a matrix that has grown. The order is kept, with new blocks at the end, until
    /// this causes too much fill-in.
    #[must_use]
    pub(super) fn grown(
        &self,
        size: usize,
        pairs: impl Iterator<Item = (usize, usize)> + Clone,
    ) -> Self {
        let couplings = Couplings::new(size, pairs);
        let mut order = self.tree.order.clone();
        if order.is_empty() || order.len() > size {
            return Self::ordered(&couplings);
        }
        order.extend(order.len()..size);
        let tree = Tree::new(&order, &couplings);
        if density(&tree) > MOST_DENSITY * self.density {
            return Self::ordered(&couplings);
        }
        Self {
            density: self.density,
            ..Self::of(tree, &couplings)
        }
    }

    fn ordered(couplings: &Couplings) -> Self {
        Self::of(Tree::new(&couplings.least_fill(), couplings), couplings)
    }

    /// Number of blocks on the diagonal.
    pub(super) fn size(&self) -> usize {
        self.tree.order.len()
    }

    /// Where the block at (`row`, `column`) is stored; `None` outside of the pattern.
    pub(super) fn slot(&self, row: usize, column: usize) -> Option<Slot> {
        let (r, c) = (*self.tree.place.get(row)?, *self.tree.place.get(column)?);
        let (low, high) = (r.min(c), r.max(c));
        let own = &self.entries[self.starts[low]..self.starts[low + 1]];
        let entry = own.iter().find(|entry| entry.row == high)?;
        let front = &self.fronts[self.tree.of_column[low]];
        Some(Slot {
            at: entry.at,
            height: LANES * front.fours,
            is_mirrored: r < c,
        })
    }

    fn of(tree: Tree, couplings: &Couplings) -> Self {
        let mut pattern = Self {
            starts: vec![0],
            density: density(&tree),
            ..Self::default()
        };
        for index in 0..tree.supernodes.len() {
            pattern.lay_out(&tree, index, couplings);
        }
        let mut top = 0;
        for index in 0..pattern.fronts.len() {
            let front = &pattern.fronts[index];
            // What it leaves is built above what its children left.
            pattern.stack = pattern.stack.max(top + front.left);
            let taken: usize = front.children.iter().map(|&c| pattern.fronts[c].left).sum();
            top = top + front.left - taken;
            if let Some(parent) = tree.parent(&tree.supernodes[index]) {
                pattern.fronts[parent].children.push(index);
            }
        }
        pattern.tree = tree;
        pattern
    }

    /// Gives a supernode its place in the factor.
    fn lay_out(&mut self, tree: &Tree, index: usize, couplings: &Couplings) {
        let node = &tree.supernodes[index];
        let below = tree.below(node);
        let fours = (BLOCK * (node.width + below.len())).div_ceil(LANES);
        let panel = self.panels;
        for within in 0..node.width {
            let column = node.first + within;
            let at = LANES * (panel + within * BLOCK * fours);
            let start = self.entries.len();
            let coupled = couplings.of(tree.order[column]).iter();
            let rows = coupled
                .map(|&other| tree.place[other])
                .filter(|&row| row > column);
            self.entries.push(Entry { row: column, at });
            self.entries.extend(rows.map(|row| Entry { row, at }));
            self.entries[start..].sort_unstable_by_key(|entry| entry.row);
            let mut place = RowPlaces::of(tree, index);
            for entry in &mut self.entries[start..] {
                entry.at += BLOCK * place.of_next(entry.row);
            }
            self.starts.push(self.entries.len());
        }
        let in_parent = self.in_parent.len();
        if let Some(parent) = tree.parent(node) {
            let mut place = RowPlaces::of(tree, parent);
            self.in_parent
                .extend(below.iter().map(|&row| place.of_next(row)));
        }
        self.fronts.push(Front {
            panel,
            fours,
            left: BLOCK * below.len() * (fours - BLOCK * node.width / LANES),
            in_parent,
            children: vec![],
        });
        self.panels += BLOCK * node.width * fours;
    }
}

/// Blocks of the factor per block column.
fn density(tree: &Tree) -> f64 {
    tree.fill() as f64 / tree.order.len().max(1) as f64
}

/// Finds rows, requested in ascending order, among those of a supernode.
struct RowPlaces<'a> {
    first: usize,
    width: usize,
    below: &'a [usize],
    passed: usize,
}

impl<'a> RowPlaces<'a> {
    fn of(tree: &'a Tree, index: usize) -> Self {
        let node = &tree.supernodes[index];
        Self {
            first: node.first,
            width: node.width,
            below: tree.below(node),
            passed: 0,
        }
    }

    fn of_next(&mut self, row: usize) -> usize {
        if row < self.first + self.width {
            return row - self.first;
        }
        let rest = &self.below[self.passed..];
        self.passed += rest.iter().take_while(|&&passed| passed < row).count();
        self.width + self.passed
    }
}

impl BlockPattern {
    /// A matrix of zeros, in the memory of a factor that is no longer needed.
    pub(super) fn zeros(&self, room: Option<BlockFactor>) -> BlockMatrix {
        let (mut panels, stack) = room
            .map(|room| (room.panels, room.stack))
            .unwrap_or_default();
        panels.clear();
        panels.resize(self.panels, [0.0; LANES]);
        BlockMatrix { panels, stack }
    }
}

impl BlockMatrix {
    /// Adds to a block, and thereby to its mirror image.
    #[inline]
    pub(super) fn add(&mut self, slot: Slot, value: &Matrix3<f64>) {
        if slot.is_mirrored {
            self.add_kept(slot, &value.transpose());
        } else {
            self.add_kept(slot, value);
        }
    }

    #[inline(always)]
    fn add_kept(&mut self, slot: Slot, value: &Matrix3<f64>) {
        let numbers = self.panels.as_flattened_mut();
        for (index, column) in value.as_slice().chunks_exact(BLOCK).enumerate() {
            let at = slot.at + index * slot.height;
            if let (Some([a, b, c]), [x, y, z]) = (numbers.get_mut(at..at + BLOCK), column) {
                *a += x;
                *b += y;
                *c += z;
            }
        }
    }
}

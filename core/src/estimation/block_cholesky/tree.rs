//! From an elimination order to supernodes: columns of the factor that are computed together.
//!
//! In: which blocks are coupled, and an elimination order. Out: the order, rearranged so that
//! related columns are neighbours, and the supernodes with their rows.
//!
//! 1. The elimination tree: the parent of a column is its first row below the diagonal (Liu 1990).
//! 2. Columns in postorder, so that each subtree is contiguous; the largest child comes last.
//! 3. The rows of a column are those of its own couplings and of its children.
//! 4. A column joins the supernode of its last child if they share all rows, or if this stores only
//!    few zeros: small dense matrices cost more in bookkeeping than in arithmetic.

use super::couplings::Couplings;

/// Columns of the factor that share their rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Supernode {
    /// The first of its columns.
    pub(super) first: usize,
    /// How many.
    pub(super) width: usize,
}

/// The tree of supernodes, children before parents.
#[derive(Clone, Debug, Default)]
pub(super) struct Tree {
    /// The block at each place.
    pub(super) order: Vec<usize>,
    /// The place of each block.
    pub(super) place: Vec<usize>,
    pub(super) supernodes: Vec<Supernode>,
    /// The supernode of each column.
    pub(super) of_column: Vec<usize>,
    /// Rows below the diagonal, column after column.
    rows: Vec<usize>,
    /// Where the rows of each column begin, and finally where the last ones end.
    starts: Vec<usize>,
}

/// Columns may form one supernode if at most this part of it is zeros.
const MOST_ZEROS: f64 = 0.25;
/// Supernodes of at most this many rows are joined, whatever their zeros.
const SMALL: usize = 4;

/// No column.
const NONE: usize = usize::MAX;

impl Tree {
    /// `order` holds each block once.
    pub(super) fn new(order: &[usize], couplings: &Couplings) -> Self {
        let postorder = postorder(&elimination_tree(order, couplings));
        let order: Vec<usize> = postorder.iter().map(|&at| order[at]).collect();
        let place = inverse(&order);
        let (rows, starts) = rows(&order, &place, couplings);
        let mut tree = Self {
            order,
            place,
            rows,
            starts,
            ..Self::default()
        };
        tree.join();
        tree
    }

    /// Rows of a column below the diagonal, ascending.
    pub(super) fn rows(&self, column: usize) -> &[usize] {
        &self.rows[self.starts[column]..self.starts[column + 1]]
    }

    /// Rows below the columns of a supernode, ascending.
    pub(super) fn below(&self, node: &Supernode) -> &[usize] {
        self.rows(node.first + node.width - 1)
    }

    /// The supernode that receives what this one leaves.
    pub(super) fn parent(&self, node: &Supernode) -> Option<usize> {
        let first = self.below(node).first();
        first.map(|&row| self.of_column[row])
    }

    /// Blocks of the factor below the diagonal.
    pub(super) fn fill(&self) -> usize {
        self.rows.len()
    }

    /// Joins columns into supernodes, from the leaves up.
    fn join(&mut self) {
        // Each with its number of nonzero blocks.
        let mut done: Vec<(Supernode, usize)> = vec![];
        for column in 0..self.order.len() {
            let below = self.starts[column + 1] - self.starts[column];
            let (mut first, mut used) = (column, 1 + below);
            // The last child ends just before.
            while let Some(&(child, filled)) = done.last() {
                if self.below(&child).first() != Some(&first) {
                    break;
                }
                let width = column + 1 - child.first;
                let area = width * (width + 1) / 2 + width * below;
                let zeros = area - used - filled;
                if width + below > SMALL && zeros as f64 > MOST_ZEROS * area as f64 {
                    break;
                }
                first = child.first;
                used += filled;
                done.pop();
            }
            let width = column + 1 - first;
            done.push((Supernode { first, width }, used));
        }
        self.supernodes = done.into_iter().map(|(node, _)| node).collect();
        self.of_column = vec![0; self.order.len()];
        for (index, node) in self.supernodes.iter().enumerate() {
            self.of_column[node.first..node.first + node.width].fill(index);
        }
    }
}

/// Parent of each column; [`NONE`] of a root.
fn elimination_tree(order: &[usize], couplings: &Couplings) -> Vec<usize> {
    let place = inverse(order);
    let mut parents = vec![NONE; order.len()];
    // The highest known ancestor, with paths compressed.
    let mut ancestors = vec![NONE; order.len()];
    for (column, &block) in order.iter().enumerate() {
        for &other in couplings.of(block) {
            let mut at = place[other];
            while at < column {
                let next = std::mem::replace(&mut ancestors[at], column);
                if next == NONE {
                    parents[at] = column;
                    break;
                }
                at = next;
            }
        }
    }
    parents
}

/// The columns in an order in which each follows its descendants, which are contiguous.
fn postorder(parents: &[usize]) -> Vec<usize> {
    let count = parents.len();
    let mut sizes = vec![1; count];
    for (column, &parent) in parents.iter().enumerate() {
        if parent != NONE {
            sizes[parent] += sizes[column];
        }
    }
    // Where each subtree ends: after it come its parent's other children and its parent. The
    // largest child takes the last place.
    let mut largest = vec![NONE; count];
    for (column, &parent) in parents.iter().enumerate() {
        if parent != NONE && (largest[parent] == NONE || sizes[column] >= sizes[largest[parent]]) {
            largest[parent] = column;
        }
    }
    let mut places = vec![0; count];
    let mut free_ends: Vec<usize> = vec![0; count];
    let mut end_of_roots = count;
    for column in (0..count).rev() {
        let parent = parents[column];
        let end = if parent == NONE {
            let end = end_of_roots;
            end_of_roots -= sizes[column];
            end
        } else if largest[parent] == column {
            places[parent]
        } else {
            let end = free_ends[parent];
            free_ends[parent] -= sizes[column];
            end
        };
        places[column] = end - 1;
        let large = largest[column];
        free_ends[column] = end - 1 - if large == NONE { 0 } else { sizes[large] };
    }
    inverse(&places)
}

/// Rows of each column below the diagonal, ascending, and where those of each column begin.
fn rows(order: &[usize], place: &[usize], couplings: &Couplings) -> (Vec<usize>, Vec<usize>) {
    let count = order.len();
    // The children of a column, as a list linked through them.
    let mut first_child = vec![NONE; count];
    let mut next_child = vec![NONE; count];
    let mut seen = vec![NONE; count];
    let mut all: Vec<usize> = Vec::with_capacity(8 * count);
    let mut starts = Vec::with_capacity(count + 1);
    starts.push(0);
    for (column, &block) in order.iter().enumerate() {
        let start = all.len();
        for &other in couplings.of(block) {
            let row = place[other];
            if row > column {
                seen[row] = column;
                all.push(row);
            }
        }
        let mut child = first_child[column];
        while child != NONE {
            for at in starts[child]..starts[child + 1] {
                let row = all[at];
                if row > column && seen[row] != column {
                    seen[row] = column;
                    all.push(row);
                }
            }
            child = next_child[child];
        }
        all[start..].sort_unstable();
        if let Some(&parent) = all.get(start) {
            next_child[column] = std::mem::replace(&mut first_child[parent], column);
        }
        starts.push(all.len());
    }
    (all, starts)
}

/// The place of each block.
fn inverse(order: &[usize]) -> Vec<usize> {
    let mut place = vec![0; order.len()];
    for (at, &block) in order.iter().enumerate() {
        place[block] = at;
    }
    place
}

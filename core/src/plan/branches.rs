//! Parents and children in a tree that is rewired, and the length of the way from the root.
//!
//! In: new vertices, and new parents for existing ones. Out: parents, and the length of the way to
//! every vertex, kept up to date.

const NONE: u32 = u32::MAX;

#[derive(Clone, Copy, Debug)]
struct Branch {
    parent: u32,
    first_child: u32,
    next_sibling: u32,
    /// Length of the way from the root, m.
    way: f64,
}

/// Parents, children and ways; vertex 0 is the root.
#[derive(Clone, Debug)]
pub(super) struct Branches {
    branches: Vec<Branch>,
    /// Vertices whose ways have still to be shortened.
    todo: Vec<u32>,
}

impl Branches {
    pub(super) fn new() -> Self {
        let root = Branch {
            parent: NONE,
            first_child: NONE,
            next_sibling: NONE,
            way: 0.0,
        };
        Self {
            branches: vec![root],
            todo: vec![],
        }
    }

    pub(super) fn way_to(&self, vertex: usize) -> f64 {
        self.branches[vertex].way
    }

    pub(super) fn parent(&self, vertex: usize) -> Option<usize> {
        let parent = self.branches[vertex].parent;
        (parent != NONE).then_some(parent as usize)
    }

    /// Adds a vertex with its way from the root.
    pub(super) fn grow(&mut self, parent: usize, way: f64) -> usize {
        let vertex = self.branches.len();
        self.branches.push(Branch {
            parent: NONE,
            first_child: NONE,
            next_sibling: NONE,
            way,
        });
        self.adopt(parent, vertex);
        vertex
    }

    /// Gives a vertex a new parent, over which the way to it is `way`, and shortens the ways to all
    /// its descendants by as much.
    pub(super) fn hang(&mut self, vertex: usize, parent: usize, way: f64) {
        self.leave(vertex);
        self.adopt(parent, vertex);
        let gain = self.branches[vertex].way - way;
        self.todo.push(vertex as u32);
        while let Some(at) = self.todo.pop() {
            self.branches[at as usize].way -= gain;
            let mut child = self.branches[at as usize].first_child;
            while child != NONE {
                self.todo.push(child);
                child = self.branches[child as usize].next_sibling;
            }
        }
    }

    fn adopt(&mut self, parent: usize, vertex: usize) {
        let first = std::mem::replace(&mut self.branches[parent].first_child, vertex as u32);
        self.branches[vertex].next_sibling = first;
        self.branches[vertex].parent = parent as u32;
    }

    fn leave(&mut self, vertex: usize) {
        let Some(parent) = self.parent(vertex) else {
            return;
        };
        let next = self.branches[vertex].next_sibling;
        let mut at = self.branches[parent].first_child;
        if at == vertex as u32 {
            self.branches[parent].first_child = next;
            return;
        }
        while at != NONE {
            let sibling = &mut self.branches[at as usize];
            if sibling.next_sibling == vertex as u32 {
                sibling.next_sibling = next;
                return;
            }
            at = sibling.next_sibling;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_hangs_on_a_vertex_moves_with_it() {
        let mut tree = Branches::new();
        let a = tree.grow(0, 5.0);
        let b = tree.grow(a, 7.0);
        let c = tree.grow(b, 8.0);
        let d = tree.grow(b, 9.0);
        let near = tree.grow(0, 1.0);
        tree.hang(b, near, 2.0);
        assert_eq!(
            [a, b, c, d, near].map(|v| tree.way_to(v)),
            [5.0, 2.0, 3.0, 4.0, 1.0]
        );
        assert_eq!(tree.parent(b), Some(near));
        tree.hang(c, a, 2.5);
        tree.hang(b, 0, 1.0);
        // `c` has left `b`, so it stays; `d` moves.
        assert_eq!([b, c, d].map(|v| tree.way_to(v)), [1.0, 2.5, 3.0]);
    }
}

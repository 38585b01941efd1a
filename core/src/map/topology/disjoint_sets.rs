//! Disjoint sets with union (union-find with path halving).
//!
//! Source: Tarjan & van Leeuwen (1984), "Worst-case analysis of set union algorithms".

/// Each number is in one set, named by one of its members.
pub(super) struct DisjointSets {
    parents: Vec<u32>,
}

impl DisjointSets {
    /// One set for each of the first `count` numbers.
    pub(super) fn of(count: usize) -> Self {
        Self {
            parents: (0..count as u32).collect(),
        }
    }

    /// Adds a new number in a set of its own.
    pub(super) fn add(&mut self) -> u32 {
        let number = self.parents.len() as u32;
        self.parents.push(number);
        number
    }

    /// The name of the set of a number.
    pub(super) fn name_of(&mut self, mut number: u32) -> u32 {
        while self.parents[number as usize] != number {
            let above = self.parents[self.parents[number as usize] as usize];
            self.parents[number as usize] = above;
            number = above;
        }
        number
    }

    /// Merges the set named `goes` into the one named `stays`.
    pub(super) fn unite(&mut self, stays: u32, goes: u32) {
        self.parents[goes as usize] = stays;
    }
}

//! Doors in operation.
//!
//! In: the time, orders from outside, and what stands in the way. Out: which doors are open. A door
//! waits to shut until the doorway is clear, like one with a light barrier.

use super::{Door, Wall};
use crate::geom::Segment;
use crate::sim::Material;

/// There is no door with that index.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no door {index}; the world has {count}")]
pub struct NoDoor {
    /// The index, from 0.
    pub index: usize,
    /// How many doors there are.
    pub count: usize,
}

/// All doors of a world.
#[derive(Clone, Debug)]
pub(super) struct Doors(Vec<Leaf>);

#[derive(Clone, Debug)]
struct Leaf {
    door: Door,
    is_open: bool,
    is_to_be_open: bool,
    /// Index of its next switch.
    next: usize,
}

impl Doors {
    pub(super) fn new(doors: &[Door]) -> Self {
        let leaf = |door: &Door| Leaf {
            is_open: door.is_open,
            is_to_be_open: door.is_open,
            next: 0,
            door: door.clone(),
        };
        Self(doors.iter().map(leaf).collect())
    }

    /// Orders a door to open or shut, until its next switch.
    ///
    /// # Errors    [`NoDoor`].
    pub(super) fn order(&mut self, index: usize, open: bool) -> Result<(), NoDoor> {
        let count = self.0.len();
        let leaf = self.0.get_mut(index).ok_or(NoDoor { index, count })?;
        leaf.is_to_be_open = open;
        Ok(())
    }

    /// Moves the doors that are due at `seconds`; returns whether any moved.
    pub(super) fn step(&mut self, seconds: f64, is_clear: impl Fn(&Segment) -> bool) -> bool {
        let mut has_moved = false;
        for leaf in &mut self.0 {
            while leaf
                .door
                .switches
                .get(leaf.next)
                .is_some_and(|&at| at <= seconds)
            {
                leaf.next += 1;
                leaf.is_to_be_open = leaf.door.is_open ^ (leaf.next % 2 == 1);
            }
            let moves = leaf.is_open != leaf.is_to_be_open
                && (leaf.is_to_be_open || is_clear(&leaf.door.leaf));
            if moves {
                leaf.is_open = leaf.is_to_be_open;
                has_moved = true;
            }
        }
        has_moved
    }

    /// Whether each is open, in the order of the world's doors.
    pub(super) fn are_open(&self) -> impl Iterator<Item = bool> + '_ {
        self.0.iter().map(|leaf| leaf.is_open)
    }

    /// Whether each should be open, in the same order; a door that should shut waits while somebody
    /// stands in it.
    pub(super) fn are_to_be_open(&self) -> impl Iterator<Item = bool> + '_ {
        self.0.iter().map(|leaf| leaf.is_to_be_open)
    }

    /// The shut doors, as walls.
    pub(super) fn shut(&self) -> impl Iterator<Item = Wall> + '_ {
        let shut = self.0.iter().filter(|leaf| !leaf.is_open);
        shut.map(|leaf| Wall {
            segment: leaf.door.leaf,
            material: Material::Opaque,
        })
    }
}

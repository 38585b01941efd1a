//! Theta*: a search over cells with legs in any direction.
//!
//! In: a [`Lattice`] over a configuration space and a query, cell by cell. Out: a path whose
//! corners are centres of cells, or the result that there is none over the cells.
//!
//! 1. As A*, but the parent of a cell may be any cell from which it can be reached in a straight
//!    line: a neighbour gets the parent of the cell from which it was found.
//! 2. Whether the straight leg is free is tested only when the cell is expanded (Lazy Theta*); if
//!    it is not, the cell gets the best of its expanded neighbours as parent.
//!
//! The path is not always the shortest over the centres, but nearly, and it has no corner in the
//! open.
//!
//! Source: Nash, Daniel, Koenig & Felner (2007), "Theta*: any-angle path planning on grids"; Nash,
//! Koenig & Tovey (2010), "Lazy Theta*: any-angle path planning and path length analysis in 3D",
//! algorithm 3.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use nalgebra::Point2;
use rand::Rng;

use super::cspace::ConfigSpace;
use super::lattice::{Lattice, Trail};
use super::path::Path;
use super::query::Query;
use super::search::Planning;
use crate::geom::{Length, Segment};

/// Cells that wait to be expanded: sum of way and remainder, way, cell. Lengths are stored as bits,
/// because the bits of non-negative numbers sort like the numbers. The least sum comes first, of
/// equal sums the longest way.
type Open = BinaryHeap<Reverse<(u64, Reverse<u64>, u32)>>;

/// A search over cells with legs in any direction.
#[derive(Debug)]
pub(super) struct ThetaStar {
    trail: Trail,
    goal: Point2<f64>,
    ways: Vec<f64>,
    is_closed: Vec<bool>,
    open: Open,
}

impl ThetaStar {
    /// Begins at the cell of the start.
    pub(super) fn new(lattice: Lattice, query: &Query) -> Self {
        let mut search = Self {
            goal: query.goal,
            ways: vec![f64::INFINITY; lattice.len()],
            is_closed: vec![false; lattice.len()],
            trail: Trail::new(lattice, query),
            open: Open::new(),
        };
        if let Some((start, _)) = search.trail.ends {
            search.offer(start, start, 0.0);
        }
        search
    }

    fn next(&mut self) -> Option<usize> {
        while let Some(Reverse((_, Reverse(way), cell))) = self.open.pop() {
            let cell = cell as usize;
            if !self.is_closed[cell] && self.ways[cell].to_bits() == way {
                return Some(cell);
            }
        }
        None
    }

    fn offer(&mut self, cell: usize, parent: usize, way: f64) {
        self.ways[cell] = way;
        self.trail.from[cell] = parent as u32;
        let sum = way + (self.goal - self.trail.lattice.point(cell)).length();
        let entry = (sum.to_bits(), Reverse(way.to_bits()), cell as u32);
        self.open.push(Reverse(entry));
    }

    /// Step 2.
    fn make_sure(&mut self, space: &dyn ConfigSpace, at: usize) {
        let Trail { lattice, from, .. } = &mut self.trail;
        let point = lattice.point(at);
        let parent = &mut from[at];
        if space.leg_is_free(&Segment::new(lattice.point(*parent as usize), point)) {
            return;
        }
        let mut best = f64::INFINITY;
        lattice.each_step(space, at, |to, _| {
            let through = self.ways[to] + (lattice.point(to) - point).length();
            if self.is_closed[to] && through < best {
                (best, *parent) = (through, to as u32);
            }
        });
        self.ways[at] = best;
    }
}

impl Planning for ThetaStar {
    fn iterate(&mut self, space: &dyn ConfigSpace, _rng: &mut dyn Rng) -> bool {
        let Some((start, goal)) = self.trail.ends.filter(|_| !self.trail.is_found) else {
            return false;
        };
        let Some(at) = self.next() else {
            return false;
        };
        if at != start {
            self.make_sure(space, at);
            self.trail.expanded.push(at as u32);
        }
        if at == goal {
            self.trail.is_found = true;
            return false;
        }
        self.is_closed[at] = true;
        let lattice = &self.trail.lattice;
        let parent = self.trail.from[at] as usize;
        let (before, way) = (lattice.point(parent), self.ways[parent]);
        let mut found = [(0, 0.0); 8];
        let mut count = 0;
        lattice.each_step(space, at, |to, _| {
            found[count] = (to, way + (lattice.point(to) - before).length());
            count += 1;
        });
        for &(to, through) in &found[..count] {
            if !self.is_closed[to] && through < self.ways[to] {
                self.offer(to, parent, through);
            }
        }
        true
    }

    fn is_found(&self) -> bool {
        self.trail.is_found
    }

    fn path(&self) -> Option<Path> {
        let cells = self.trail.way()?.into_iter();
        let points = cells.map(|cell| self.trail.lattice.point(cell)).collect();
        Some(Path { points })
    }

    fn edges(&self) -> Vec<Segment> {
        self.trail.edges()
    }

    fn edge_count(&self) -> usize {
        self.trail.expanded.len()
    }
}

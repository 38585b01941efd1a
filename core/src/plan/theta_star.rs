//! Theta*: a search over cells whose legs point anywhere.
//!
//! In: a [`Lattice`] over a configuration space and a query, cell by cell. Out: a path whose corners are centres of cells,
//! or that there is none over the cells.
//!
//! 1. As A*, but the parent of a cell may be any cell that it can be reached from straight: a neighbour gets the parent of
//!    the cell it was found from.
//! 2. Whether the straight leg is free is asked only when the cell is expanded (Lazy Theta*); if it is not, the cell gets
//!    the best of its expanded neighbours as parent.
//!
//! Not always the shortest path over the centres, but nearly, and no corner lies in the open.
//!
//! Source: Nash, Daniel, Koenig & Felner (2007), "Theta*: any-angle path planning on grids"; Nash, Koenig & Tovey (2010),
//! "Lazy Theta*: any-angle path planning and path length analysis in 3D", algorithm 3.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use super::cspace::ConfigSpace;
use super::lattice::Lattice;
use super::path::Path;
use super::query::Query;
use crate::geom::Segment;

/// A cell that waits to be expanded; the greatest one is that with the least way and rest.
#[derive(Clone, Copy, Debug)]
struct Waiting {
    sum: f64,
    way: f64,
    cell: u32,
}

impl Ord for Waiting {
    fn cmp(&self, other: &Self) -> Ordering {
        let sum = other.sum.total_cmp(&self.sum);
        sum.then(self.way.total_cmp(&other.way))
            .then(other.cell.cmp(&self.cell))
    }
}

impl PartialOrd for Waiting {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Waiting {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Waiting {}

/// A search over cells with legs in any direction.
#[derive(Clone, Debug)]
pub struct ThetaStar {
    lattice: Lattice,
    query: Query,
    ends: Option<(usize, usize)>,
    ways: Vec<f64>,
    from: Vec<u32>,
    is_closed: Vec<bool>,
    open: BinaryHeap<Waiting>,
    expanded: Vec<u32>,
    is_found: bool,
}

impl ThetaStar {
    /// Begins at the cell of the start.
    #[must_use]
    pub fn new(lattice: Lattice, query: Query) -> Self {
        let ends = lattice.ends(&query);
        let mut search = Self {
            ways: vec![f64::INFINITY; lattice.len()],
            from: vec![0; lattice.len()],
            is_closed: vec![false; lattice.len()],
            lattice,
            query,
            ends,
            open: BinaryHeap::new(),
            expanded: vec![],
            is_found: false,
        };
        if let Some((start, _)) = ends.filter(|&(start, _)| search.lattice.is_open(start)) {
            search.offer(start, start, 0.0);
        }
        search
    }

    /// Expands the next cell; `false` when the search is over.
    pub fn iterate<S: ConfigSpace + ?Sized>(&mut self, space: &S) -> bool {
        let Some((start, goal)) = self.ends.filter(|_| !self.is_found) else {
            return false;
        };
        let Some(at) = self.next() else {
            return false;
        };
        if at != start {
            self.make_sure(space, at);
            self.expanded.push(at as u32);
        }
        if at == goal {
            self.is_found = true;
            return false;
        }
        self.is_closed[at] = true;
        let parent = self.from[at] as usize;
        let (before, way) = (self.lattice.point(parent), self.ways[parent]);
        let mut found = [(0, 0.0); 8];
        let mut count = 0;
        self.lattice.each_step(space, at, |to, _| {
            found[count] = (to, way + (self.lattice.point(to) - before).norm());
            count += 1;
        });
        for &(to, through) in &found[..count] {
            if !self.is_closed[to] && through < self.ways[to] {
                self.offer(to, parent, through);
            }
        }
        true
    }

    fn next(&mut self) -> Option<usize> {
        while let Some(next) = self.open.pop() {
            let cell = next.cell as usize;
            if !self.is_closed[cell] && self.ways[cell] == next.way {
                return Some(cell);
            }
        }
        None
    }

    fn offer(&mut self, cell: usize, parent: usize, way: f64) {
        self.ways[cell] = way;
        self.from[cell] = parent as u32;
        self.open.push(Waiting {
            sum: way + (self.query.goal - self.lattice.point(cell)).norm(),
            way,
            cell: cell as u32,
        });
    }

    /// Step 2.
    fn make_sure<S: ConfigSpace + ?Sized>(&mut self, space: &S, at: usize) {
        let (point, parent) = (self.lattice.point(at), self.from[at] as usize);
        let leg = Segment::new(self.lattice.point(parent), point);
        if space.leg_is_free(&leg) {
            return;
        }
        let (mut best, mut from) = (f64::INFINITY, parent);
        self.lattice.each_step(space, at, |to, _| {
            let through = self.ways[to] + (self.lattice.point(to) - point).norm();
            if self.is_closed[to] && through < best {
                (best, from) = (through, to);
            }
        });
        self.ways[at] = best;
        self.from[at] = from as u32;
    }

    /// Whether the goal was reached.
    #[must_use]
    pub fn is_found(&self) -> bool {
        self.is_found
    }

    /// The path, if the goal was reached.
    #[must_use]
    pub fn path(&self) -> Option<Path> {
        let (start, goal) = self.ends.filter(|_| self.is_found)?;
        let mut points = vec![self.query.goal];
        let mut at = goal;
        while at != start {
            at = self.from[at] as usize;
            points.push(self.lattice.point(at));
        }
        points.reverse();
        Some(Path { points })
    }

    /// The legs over which cells were reached.
    #[must_use]
    pub fn edges(&self) -> Vec<Segment> {
        let leg = |&cell: &u32| {
            let from = self.from[cell as usize] as usize;
            Segment::new(self.lattice.point(from), self.lattice.point(cell as usize))
        };
        self.expanded.iter().map(leg).collect()
    }

    /// How many [`Self::edges`] are.
    #[must_use]
    pub fn edge_count(&self) -> usize {
        self.expanded.len()
    }
}

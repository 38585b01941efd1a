//! A* over cells.
//!
//! In: a [`Lattice`] and a query, cell by cell. Out: the shortest way over its cells in eight
//! directions, or that there is none.
//!
//! 1. Lengths are whole numbers, 70 for a straight step and 99 for a diagonal one: their ratio is
//!    √2 to 5·10⁻⁵, and whole numbers give the same order on every machine.
//! 2. The remaining way to the goal is at least the octile distance. The sum of way and remainder
//!    never falls along a way, and rises by no more than twice a diagonal step: open cells wait in
//!    a ring of buckets (Dial 1969) instead of a heap.
//! 3. Of equal sums the last one found comes first: it is nearest to the goal.
//!
//! Source: Hart, Nilsson & Raphael (1968), "A formal basis for the heuristic determination of
//! minimum cost paths".

use rand::Rng;

use super::cspace::ConfigSpace;
use super::lattice::{Lattice, Trail};
use super::path::Path;
use super::query::Query;
use super::search::Planning;
use crate::geom::Segment;

const STRAIGHT: u32 = 70;
const DIAGONAL: u32 = 99;
const UNREACHED: u32 = u32::MAX;
/// More than the sum of way and remainder can rise in a step.
const BUCKETS: usize = 256;

/// A search over cells, shortest way first.
#[derive(Debug)]
pub struct AStar {
    trail: Trail,
    ways: Vec<u32>,
    /// Cells and their ways, by the sum of way and remainder.
    buckets: Vec<Vec<(u32, u32)>>,
    sum: u32,
    waiting: usize,
}

impl AStar {
    /// Begins at the cell of the start.
    #[must_use]
    pub fn new(lattice: Lattice, query: &Query) -> Self {
        let mut search = Self {
            ways: vec![UNREACHED; lattice.len()],
            trail: Trail::new(lattice, query),
            buckets: vec![vec![]; BUCKETS],
            sum: 0,
            waiting: 0,
        };
        if let Some((start, goal)) = search.trail.ends {
            let lattice = &search.trail.lattice;
            search.ways[start] = 0;
            search.sum = octile(lattice.place(start), lattice.place(goal));
            search.buckets[search.sum as usize % BUCKETS].push((start as u32, 0));
            search.waiting = 1;
        }
        search
    }

    /// Expands the next cell; `false` when the search is over.
    pub fn iterate(&mut self, space: &dyn ConfigSpace) -> bool {
        let Some((start, goal)) = self.trail.ends.filter(|_| !self.trail.is_found) else {
            return false;
        };
        let Some(at) = self.next() else {
            return false;
        };
        if at == goal {
            self.trail.is_found = true;
            return false;
        }
        if at != start {
            self.trail.expanded.push(at as u32);
        }
        self.expand(space, at, goal);
        true
    }

    /// The open cell with the least sum, skipping entries that are out of date.
    fn next(&mut self) -> Option<usize> {
        while self.waiting > 0 {
            let Some((at, way)) = self.buckets[self.sum as usize % BUCKETS].pop() else {
                self.sum += 1;
                continue;
            };
            self.waiting -= 1;
            if self.ways[at as usize] == way {
                return Some(at as usize);
            }
        }
        None
    }

    fn expand(&mut self, space: &dyn ConfigSpace, at: usize, goal: usize) {
        let way = self.ways[at];
        let Trail { lattice, from, .. } = &mut self.trail;
        let goal_place = lattice.place(goal);
        lattice.each_step(space, at, |to, is_diagonal| {
            let through = way + if is_diagonal { DIAGONAL } else { STRAIGHT };
            if through < self.ways[to] {
                self.ways[to] = through;
                from[to] = at as u32;
                let sum = through + octile(lattice.place(to), goal_place);
                self.buckets[sum as usize % BUCKETS].push((to as u32, through));
                self.waiting += 1;
            }
        });
    }

    /// The path over the corners of the way, if the goal was reached.
    #[must_use]
    pub fn path(&self) -> Option<Path> {
        let cells = self.trail.way()?;
        Some(corners(&self.trail.lattice, &cells))
    }
}

impl Planning for AStar {
    fn iterate(&mut self, space: &dyn ConfigSpace, _rng: &mut dyn Rng) -> bool {
        self.iterate(space)
    }

    fn is_found(&self) -> bool {
        self.trail.is_found
    }

    fn path(&self) -> Option<Path> {
        self.path()
    }

    fn edges(&self) -> Vec<Segment> {
        self.trail.edges()
    }

    fn edge_count(&self) -> usize {
        self.trail.expanded.len()
    }
}

/// Lower bound of the length of a way between cells, as if without walls.
#[inline]
fn octile(a: (i32, i32), b: (i32, i32)) -> u32 {
    let (dx, dy) = (a.0.abs_diff(b.0), a.1.abs_diff(b.1));
    STRAIGHT * dx.max(dy) + (DIAGONAL - STRAIGHT) * dx.min(dy)
}

/// The points of cells at which a way turns. The steps from the start and to the goal are legs of
/// their own, because those points lie anywhere in their cells.
fn corners(lattice: &Lattice, cells: &[usize]) -> Path {
    let last = cells.len() - 1;
    let is_corner = |i: usize| {
        i <= 1
            || i + 1 >= last
            || cells[i + 1].wrapping_sub(cells[i]) != cells[i].wrapping_sub(cells[i - 1])
    };
    let points = (0..=last).filter(|&i| is_corner(i));
    Path {
        points: points.map(|i| lattice.point(cells[i])).collect(),
    }
}

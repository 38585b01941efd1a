//! A* over cells.
//!
//! In: a [`Lattice`] and a query, cell by cell. Out: the shortest way over its cells in eight directions, or that there is
//! none over them.
//!
//! 1. Lengths are whole numbers, 70 for a straight step and 99 for a diagonal one: their ratio is √2 to 5·10⁻⁵, and whole
//!    numbers give the same order everywhere.
//! 2. The rest of the way to the goal is at least the octile distance. The sum of way and rest never falls along a way, and rises
//!    by no more than twice a diagonal step: open cells wait in a ring of buckets (Dial 1969) instead of a heap.
//! 3. Of equal sums the last one found comes first: it is nearest to the goal.
//!
//! Source: Hart, Nilsson & Raphael (1968), "A formal basis for the heuristic determination of minimum cost paths".

use nalgebra::Point2;

use super::cspace::ConfigSpace;
use super::lattice::Lattice;
use super::path::Path;
use super::query::Query;
use crate::geom::Segment;

const STRAIGHT: u32 = 70;
const DIAGONAL: u32 = 99;
const UNREACHED: u32 = u32::MAX;
/// More than the sum of way and rest can rise by in a step.
const BUCKETS: usize = 256;

/// A search over cells, shortest way first.
#[derive(Clone, Debug)]
pub struct AStar {
    lattice: Lattice,
    ends: Option<(usize, usize)>,
    ways: Vec<u32>,
    from: Vec<u32>,
    /// Cells and their ways, by the sum of way and rest.
    buckets: Vec<Vec<(u32, u32)>>,
    sum: u32,
    waiting: usize,
    expanded: Vec<u32>,
    is_found: bool,
}

impl AStar {
    /// Begins at the cell of the start.
    #[must_use]
    pub fn new(lattice: Lattice, query: &Query) -> Self {
        let ends = lattice.ends(query);
        let mut search = Self {
            ways: vec![UNREACHED; lattice.len()],
            from: vec![0; lattice.len()],
            lattice,
            ends,
            buckets: vec![vec![]; BUCKETS],
            sum: 0,
            waiting: 0,
            expanded: vec![],
            is_found: false,
        };
        if let Some((start, goal)) = ends.filter(|&(start, _)| search.lattice.is_open(start)) {
            search.ways[start] = 0;
            search.sum = search.rest(start, goal);
            search.buckets[search.sum as usize % BUCKETS].push((start as u32, 0));
            search.waiting = 1;
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
        if at == goal {
            self.is_found = true;
            return false;
        }
        if at != start {
            self.expanded.push(at as u32);
        }
        self.expand(space, at, goal);
        true
    }

    /// The open cell with the least sum that is not out of date.
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

    fn expand<S: ConfigSpace + ?Sized>(&mut self, space: &S, at: usize, goal: usize) {
        let way = self.ways[at];
        let (ways, from) = (&mut self.ways, &mut self.from);
        let (buckets, waiting) = (&mut self.buckets, &mut self.waiting);
        let goal_place = self.lattice.place(goal);
        let lattice = &self.lattice;
        lattice.each_step(space, at, |to, is_diagonal| {
            let through = way + if is_diagonal { DIAGONAL } else { STRAIGHT };
            if through < ways[to] {
                ways[to] = through;
                from[to] = at as u32;
                let sum = through + octile(lattice.place(to), goal_place);
                buckets[sum as usize % BUCKETS].push((to as u32, through));
                *waiting += 1;
            }
        });
    }

    fn rest(&self, cell: usize, goal: usize) -> u32 {
        octile(self.lattice.place(cell), self.lattice.place(goal))
    }

    /// Whether the goal was reached.
    #[must_use]
    pub fn is_found(&self) -> bool {
        self.is_found
    }

    /// The path over corners of the way, if the goal was reached.
    #[must_use]
    pub fn path(&self) -> Option<Path> {
        let (start, goal) = self.ends.filter(|_| self.is_found)?;
        let mut cells = vec![goal];
        let mut at = goal;
        while at != start {
            at = self.from[at] as usize;
            cells.push(at);
        }
        cells.reverse();
        Some(corners(&self.lattice, &cells))
    }

    /// The steps over which cells were reached.
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

/// Least length of a way over cells without walls.
#[inline]
fn octile(a: (i32, i32), b: (i32, i32)) -> u32 {
    let (dx, dy) = (a.0.abs_diff(b.0), a.1.abs_diff(b.1));
    STRAIGHT * dx.max(dy) + (DIAGONAL - STRAIGHT) * dx.min(dy)
}

/// The points of cells in which a way turns. The steps from the start and to the goal are legs of their own: those points
/// lie anywhere in their cells.
fn corners(lattice: &Lattice, cells: &[usize]) -> Path {
    let last = cells.len() - 1;
    let is_corner = |i: usize| {
        i <= 1
            || i + 1 >= last
            || cells[i + 1].wrapping_sub(cells[i]) != cells[i].wrapping_sub(cells[i - 1])
    };
    let points: Vec<Point2<f64>> = (0..=last)
        .filter(|&i| is_corner(i))
        .map(|i| lattice.point(cells[i]))
        .collect();
    Path { points }
}

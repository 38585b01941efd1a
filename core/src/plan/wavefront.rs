//! Cheapest ways over the cells of a [`GridSpace`], from one start to all other cells.
//!
//! In: a configuration space over a grid, and a start. Out: the cost of every reachable cell, and
//! the way to it.
//!
//! 1. A cell is free if the room at its centre is not negative. Diagonal steps need both cells
//!    beside them, so that a way over cells is also free everywhere in between.
//! 2. A step costs its length, and more near walls, so that ways keep to the middle of doors.
//! 3. Dijkstra's algorithm with buckets for small whole costs: Dial (1969), "Algorithm 360:
//!    shortest-path forest with topological ordering". Linear in cells, and whole numbers give the
//!    same order on every machine.

use nalgebra::Point2;

use super::cspace::GridSpace;
use super::path::Path;

const STRAIGHT: u32 = 10;
const DIAGONAL: u32 = 14;
/// Beside a wall a step costs this many times its length.
const NEAR_WALL: u32 = 4;
/// With this much room or more a step costs its length, m.
const COMFORT: f64 = 0.3;
const UNREACHED: u32 = u32::MAX;

/// Costs from one start over a grid.
#[derive(Clone, Debug)]
pub struct Wavefront {
    costs: Vec<u32>,
    weights: Vec<u8>,
    width: usize,
    metres: f64,
    start: usize,
}

impl Wavefront {
    /// Spreads from the cell of `start`; reaches nothing if that is not free.
    #[must_use]
    pub fn new(space: &GridSpace, start: Point2<f64>) -> Self {
        let width = space.rect().width();
        let count = space.states().len();
        let weights = weights(space);
        let start = space
            .index_at(start)
            .and_then(|s| nearest_open(s, &weights, width));
        let mut wave = Self {
            costs: vec![UNREACHED; count],
            weights,
            width,
            metres: space.resolution() / f64::from(STRAIGHT),
            start: start.unwrap_or(usize::MAX),
        };
        if let Some(start) = start {
            wave.spread(start);
        }
        wave
    }

    fn spread(&mut self, start: usize) {
        let mut buckets: Vec<Vec<u32>> = vec![vec![]; (DIAGONAL * NEAR_WALL + 1) as usize];
        let (mut cost, mut waiting) = (0_u32, 1_usize);
        self.costs[start] = 0;
        buckets[0].push(start as u32);
        while waiting > 0 {
            let bucket = cost as usize % buckets.len();
            while let Some(at) = buckets[bucket].pop() {
                waiting -= 1;
                let at = at as usize;
                if self.costs[at] != cost {
                    continue;
                }
                for (to, step) in steps(at, &self.weights, self.width) {
                    let through = cost + step * u32::from(self.weights[to]);
                    if through < self.costs[to] {
                        self.costs[to] = through;
                        buckets[through as usize % (DIAGONAL * NEAR_WALL + 1) as usize]
                            .push(to as u32);
                        waiting += 1;
                    }
                }
            }
            cost += 1;
        }
    }

    /// Number of the cell that it spread from; `None` if that is not free.
    #[must_use]
    pub fn start(&self) -> Option<usize> {
        Some(self.start).filter(|start| *start < self.costs.len())
    }

    /// Cost of the way to a cell, in metres of open floor; `None` if no way leads there.
    #[must_use]
    pub fn cost(&self, index: usize) -> Option<f64> {
        let cost = *self.costs.get(index)?;
        (cost != UNREACHED).then(|| f64::from(cost) * self.metres)
    }

    /// The floor that was reached, in squares of `side` by `side` cells.
    #[must_use]
    pub(super) fn in_squares(&self, side: usize) -> Squares {
        let height = self.costs.len() / self.width.max(1);
        // With a closed border all round.
        let width = self.width.div_ceil(side) + 2;
        let mut squares = Squares {
            weights: vec![0; width * (height.div_ceil(side) + 2)],
            width,
            side,
            cells_width: self.width,
            metres: self.metres * side as f64,
        };
        for (cell, (cost, weight)) in self.costs.iter().zip(&self.weights).enumerate() {
            if *cost == UNREACHED {
                continue;
            }
            let square = squares.square_of(cell);
            let least = &mut squares.weights[square];
            *least = if *least == 0 {
                *weight
            } else {
                (*least).min(*weight)
            };
        }
        squares
    }

    /// Numbers of all cells that a way leads to.
    #[must_use]
    pub fn reached(&self) -> Vec<usize> {
        let costs = self.costs.iter().enumerate();
        costs
            .filter(|(_, c)| **c != UNREACHED)
            .map(|(i, _)| i)
            .collect()
    }

    /// The way over cell centres from the start to the cell; `None` if no way leads there. Corners
    /// only: cells in the middle of a straight run are skipped.
    #[must_use]
    pub fn path_to(&self, space: &GridSpace, index: usize) -> Option<Path> {
        self.cost(index)?;
        let mut cells = vec![index];
        let mut at = index;
        while at != self.start {
            let step_back = |&(from, step): &(usize, u32)| {
                self.costs[from] != UNREACHED
                    && self.costs[from] + step * u32::from(self.weights[at]) == self.costs[at]
            };
            at = steps(at, &self.weights, self.width).find(step_back)?.0;
            cells.push(at);
        }
        cells.reverse();
        let is_corner = |i: usize| {
            i == 0
                || i + 1 == cells.len()
                || cells[i + 1].wrapping_sub(cells[i]) != cells[i].wrapping_sub(cells[i - 1])
        };
        let corners = (0..cells.len()).filter(|&i| is_corner(i));
        Some(Path {
            points: corners.map(|i| space.centre_of(cells[i])).collect(),
        })
    }
}

/// The floor of a wavefront in larger squares, for many rough wavefronts over it. A square is open
/// if any of its cells was reached: for two floors to stay separate, the wall between them,
/// including the robot's room on each side, must be thicker than two squares.
#[derive(Clone, Debug)]
pub(super) struct Squares {
    weights: Vec<u8>,
    width: usize,
    /// Side of a square, in cells.
    side: usize,
    cells_width: usize,
    metres: f64,
}

impl Squares {
    /// Number of the square of a cell.
    pub(super) fn square_of(&self, cell: usize) -> usize {
        let (col, row) = (cell % self.cells_width, cell / self.cells_width);
        (row / self.side + 1) * self.width + col / self.side + 1
    }

    /// Costs from a cell to all squares, by their numbers.
    pub(super) fn costs_from(&self, cell: usize) -> Wavefront {
        let start = self.square_of(cell);
        let mut wave = Wavefront {
            costs: vec![UNREACHED; self.weights.len()],
            weights: self.weights.clone(),
            width: self.width,
            metres: self.metres,
            start,
        };
        wave.spread(start);
        wave
    }
}

/// How many times its length a step onto each cell costs; 0 if the cell is not free, and at the
/// border.
fn weights(space: &GridSpace) -> Vec<u8> {
    let (width, height) = (space.rect().width(), space.rect().height());
    let weight = |index: usize| {
        let (col, row) = (index % width, index / width);
        if col == 0 || row == 0 || col + 1 == width || row + 1 == height {
            return 0;
        }
        let room = space.room_of(index);
        if room < 0.0 {
            0
        } else {
            let near = (1.0 - room / COMFORT).max(0.0);
            (1.0 + (f64::from(NEAR_WALL) - 1.0) * near).round() as u8
        }
    };
    (0..space.states().len()).map(weight).collect()
}

/// The cell itself, or a free neighbour: a free point may lie in a cell whose centre is not free.
fn nearest_open(index: usize, weights: &[u8], width: usize) -> Option<usize> {
    let row = width as isize;
    let around = [0, 1, -1, row, -row, row + 1, row - 1, 1 - row, -row - 1];
    let mut cells = around
        .into_iter()
        .filter_map(|d| index.checked_add_signed(d));
    cells.find(|&i| weights.get(i).is_some_and(|&w| w > 0))
}

/// The open neighbours of a cell with the length of the step. Cells at the border are never open,
/// so neighbours exist.
fn steps(at: usize, weights: &[u8], width: usize) -> impl Iterator<Item = (usize, u32)> + '_ {
    let (east, west, north, south) = (at + 1, at - 1, at + width, at - width);
    let open = |i: usize| weights[i] > 0;
    let straight = [east, west, north, south].map(|i| (open(i), i, STRAIGHT));
    let diagonal = [
        (north + 1, north, east),
        (north - 1, north, west),
        (south + 1, south, east),
        (south - 1, south, west),
    ]
    .map(|(i, a, b)| (open(i) && open(a) && open(b), i, DIAGONAL));
    straight
        .into_iter()
        .chain(diagonal)
        .filter(|(is_open, ..)| *is_open)
        .map(|(_, i, step)| (i, step))
}

//! The sums pair by pair in single precision, if the error allowed is large enough. This takes a
//! third of the time.
//!
//! In units in which a pair has 2^-d², a coordinate is rounded by half of [`EPSILON`] times itself.
//! So d errs by less than √2 ε a for coordinates up to a, and 2^-d², whose slope is nowhere above
//! 0.72, by less than 1.02 ε a. Computing 2^-d² adds a relative error below 3e-7, and d² times ε,
//! at most another 3e-7 of one. Summing [`BLOCK`] numbers, whose lanes are added up in double
//! precision, adds less than `BLOCK` times ε of all. Together: ε (1.02 a + BLOCK + 8).

use std::f32::consts::LOG2_E;
use std::ops::Range;

use nalgebra::{Point2, Vector2};

use super::Cells;
use super::exp::exp2_of_minus;
use crate::lanes::{EIGHT, Eight, Kernel, Lanes, total_of_eight};

/// The distance from 1 to the next number.
const EPSILON: f64 = f32::EPSILON as f64;
/// Numbers added in single precision, one after the other.
const BLOCK: usize = 64;
/// Part of the allowed error that single precision may use.
pub(super) const SHARE: f64 = 0.2;
/// Cost of a pair, relative to one in double precision.
pub(in crate::registration) const COST: f64 = 0.35;
/// Larger weights are not summed in single precision: their sums might overflow.
const MOST_WEIGHT: f64 = 1e30;
/// A place so far away that it adds nothing.
const FAR: f32 = 1e12;

/// How coordinates are scaled to numbers of about 1.
#[derive(Clone, Copy)]
pub(super) struct Single {
    origin: Point2<f64>,
    root: f64,
}

impl Single {
    /// `None` if single precision is not enough for this error, in parts of Σ|q|.
    pub(super) fn of<const K: usize>(
        sources: &[Point2<f64>],
        weights: &[[f64; K]],
        targets: &[Point2<f64>],
        scale: f64,
        error: f64,
    ) -> Option<Self> {
        let most_away = (SHARE * error / EPSILON - (BLOCK + 8) as f64) / 1.02;
        let origin = *sources.first()?;
        let root = (scale * f64::from(LOG2_E)).sqrt();
        let is_near = |point: &Point2<f64>| {
            let off = (point - origin).abs();
            root * off.x.max(off.y) <= most_away
        };
        let is_small = |weight: &f64| weight.abs() <= MOST_WEIGHT;
        let is_enough = most_away > 0.0
            && sources.iter().all(is_near)
            && targets.iter().all(is_near)
            && weights.iter().flatten().all(is_small);
        is_enough.then_some(Self { origin, root })
    }

    fn place(&self, point: &Point2<f64>) -> Vector2<f32> {
        ((point - self.origin) * self.root).cast()
    }
}

/// Sources by columns.
struct Columns<const K: usize> {
    x: Vec<f32>,
    y: Vec<f32>,
    weights: [Vec<f32>; K],
}

/// All pairs, or those of the cells near each target.
pub(super) struct Pairs<'a, const K: usize> {
    columns: Columns<K>,
    single: Single,
    cells: Option<&'a Cells>,
    targets: &'a [Point2<f64>],
}

impl<'a, const K: usize> Pairs<'a, K> {
    /// `sources` in the order of the cells, if there are cells.
    pub(super) fn of(
        sources: impl Iterator<Item = (Point2<f64>, [f64; K])>,
        targets: &'a [Point2<f64>],
        single: Single,
        cells: Option<&'a Cells>,
    ) -> Self {
        let mut columns = Columns {
            x: vec![],
            y: vec![],
            weights: [const { vec![] }; K],
        };
        for (source, row) in sources {
            let place = single.place(&source);
            columns.x.push(place.x);
            columns.y.push(place.y);
            for (column, weight) in columns.weights.iter_mut().zip(row) {
                column.push(weight as f32);
            }
        }
        Self {
            columns,
            single,
            cells,
            targets,
        }
    }
}

/// The sums at a target so far.
struct Sum<L: Lanes, const K: usize> {
    machine: L::Machine,
    target: [L::Eight; 2],
    block: [L::Eight; K],
    in_block: usize,
    total: [f64; K],
}

impl<L: Lanes, const K: usize> Sum<L, K> {
    #[inline(always)]
    fn at(machine: L::Machine, target: Vector2<f32>) -> Self {
        let splat = |value| L::Eight::splat(machine, value);
        Self {
            machine,
            target: [splat(target.x), splat(target.y)],
            block: [splat(0.0); K],
            in_block: 0,
            total: [0.0; K],
        }
    }

    #[inline(always)]
    fn add(&mut self, x: &[f32; EIGHT], y: &[f32; EIGHT], weights: [&[f32; EIGHT]; K]) {
        let load = |numbers: &[f32; EIGHT]| L::Eight::load(self.machine, numbers);
        let (dx, dy) = (load(x) - self.target[0], load(y) - self.target[1]);
        let value = exp2_of_minus(self.machine, dx * dx + dy * dy);
        for (sum, weights) in self.block.iter_mut().zip(weights) {
            *sum += value * load(weights);
        }
        self.in_block += 1;
        if self.in_block == BLOCK {
            self.end_block();
        }
    }

    #[inline(always)]
    fn end_block(&mut self) {
        for (total, block) in self.total.iter_mut().zip(&mut self.block) {
            *total += f64::from(total_of_eight(*block));
            *block = L::Eight::splat(self.machine, 0.0);
        }
        self.in_block = 0;
    }
}

impl<const K: usize> Columns<K> {
    /// Adds the sources of a run.
    #[inline(always)]
    fn add<L: Lanes>(&self, run: Range<usize>, sum: &mut Sum<L, K>) {
        let ((xs, x_rest), (ys, y_rest)) = (
            self.x.get(run.clone()).unwrap_or_default().as_chunks(),
            self.y.get(run.clone()).unwrap_or_default().as_chunks(),
        );
        let columns = self.weights.each_ref().map(|column| {
            let column = column.get(run.clone()).unwrap_or_default();
            column.as_chunks()
        });
        for (at, (x, y)) in xs.iter().zip(ys).enumerate() {
            let weights = columns.map(|(column, _)| column.get(at).unwrap_or(&[0.0; EIGHT]));
            sum.add(x, y, weights);
        }
        if !x_rest.is_empty() {
            let whole = |rest: &[f32], beyond: f32| {
                let mut whole = [beyond; EIGHT];
                for (to, from) in whole.iter_mut().zip(rest) {
                    *to = *from;
                }
                whole
            };
            let weights = columns.map(|(_, rest)| whole(rest, 0.0));
            sum.add(&whole(x_rest, FAR), &whole(y_rest, FAR), weights.each_ref());
        }
    }
}

impl<const K: usize> Kernel for Pairs<'_, K> {
    type Output = Vec<[f64; K]>;

    #[inline(always)]
    fn run<L: Lanes>(self, machine: L::Machine) -> Vec<[f64; K]> {
        let mut sums = Vec::with_capacity(self.targets.len());
        for target in self.targets {
            let mut sum = Sum::<L, K>::at(machine, self.single.place(target));
            match self.cells {
                None => self.columns.add(0..self.columns.x.len(), &mut sum),
                Some(cells) => {
                    for run in cells.near(target) {
                        self.columns.add(run, &mut sum);
                    }
                }
            }
            sum.end_block();
            sums.push(sum.total);
        }
        sums
    }
}

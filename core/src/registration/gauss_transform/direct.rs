//! The sums pair by pair: G(t) = Σ q exp(-scale |t - s|²), over all sources or over the near ones.

use std::ops::Range;

use nalgebra::Point2;
use pulp::NullaryFnOnce;

use super::Cells;
use super::exp::exp_f64;
use crate::lanes::widened;

/// Sources summed side by side, in the same order on every machine.
const SIDE_BY_SIDE: usize = 8;

/// Over all sources.
pub(super) fn all<const K: usize>(
    sources: &[Point2<f64>],
    weights: &[[f64; K]],
    targets: &[Point2<f64>],
    scale: f64,
) -> Vec<[f64; K]> {
    let columns = Columns::of(sources.iter().copied().zip(weights.iter().copied()));
    widened(Sums {
        columns: &columns,
        cells: None,
        targets,
        scale,
    })
}

/// Over the sources in the cells near each target.
pub(super) fn near<const K: usize>(
    sources: &[Point2<f64>],
    weights: &[[f64; K]],
    targets: &[Point2<f64>],
    scale: f64,
    cells: &Cells,
) -> Vec<[f64; K]> {
    let columns = Columns::of(cells.sorted(sources, weights));
    widened(Sums {
        columns: &columns,
        cells: Some(cells),
        targets,
        scale,
    })
}

/// Sources by columns.
struct Columns<const K: usize> {
    x: Vec<f64>,
    y: Vec<f64>,
    weights: [Vec<f64>; K],
}

impl<const K: usize> Columns<K> {
    fn of(sources: impl Iterator<Item = (Point2<f64>, [f64; K])>) -> Self {
        let (mut x, mut y, mut weights) = (vec![], vec![], [const { vec![] }; K]);
        for (source, row) in sources {
            x.push(source.x);
            y.push(source.y);
            for (column, weight) in weights.iter_mut().zip(row) {
                column.push(weight);
            }
        }
        Self { x, y, weights }
    }

    /// The sums over a run of sources, added to `total`.
    #[inline(always)]
    fn add(&self, run: Range<usize>, target: &Point2<f64>, scale: f64, total: &mut [f64; K]) {
        let (Some(x), Some(y)) = (self.x.get(run.clone()), self.y.get(run.clone())) else {
            return;
        };
        let (xs, ys) = (x.chunks_exact(SIDE_BY_SIDE), y.chunks_exact(SIDE_BY_SIDE));
        let rest = xs.remainder().len();
        let mut lanes = [[0.0; SIDE_BY_SIDE]; K];
        let mut at = run.start;
        let kernel = |x: f64, y: f64| {
            let (dx, dy) = (x - target.x, y - target.y);
            exp_f64(-scale * (dx * dx + dy * dy))
        };
        for (x, y) in xs.zip(ys) {
            let mut values = [0.0; SIDE_BY_SIDE];
            for ((value, x), y) in values.iter_mut().zip(x).zip(y) {
                *value = kernel(*x, *y);
            }
            for (lane, weights) in lanes.iter_mut().zip(&self.weights) {
                let weights = weights.get(at..at + SIDE_BY_SIDE).unwrap_or(&[]);
                for ((sum, weight), value) in lane.iter_mut().zip(weights).zip(values) {
                    *sum += weight * value;
                }
            }
            at += SIDE_BY_SIDE;
        }
        for (sum, lane) in total.iter_mut().zip(&lanes) {
            let [a, b, c, d, e, f, g, h] = *lane;
            *sum += ((a + e) + (c + g)) + ((b + f) + (d + h));
        }
        for index in at..at + rest {
            let (Some(x), Some(y)) = (self.x.get(index), self.y.get(index)) else {
                return;
            };
            let value = kernel(*x, *y);
            for (sum, weights) in total.iter_mut().zip(&self.weights) {
                *sum += value * weights.get(index).copied().unwrap_or(0.0);
            }
        }
    }
}

struct Sums<'a, const K: usize> {
    columns: &'a Columns<K>,
    cells: Option<&'a Cells>,
    targets: &'a [Point2<f64>],
    scale: f64,
}

impl<const K: usize> NullaryFnOnce for Sums<'_, K> {
    type Output = Vec<[f64; K]>;

    #[inline(always)]
    fn call(self) -> Self::Output {
        let mut sums = vec![[0.0; K]; self.targets.len()];
        for (sum, target) in sums.iter_mut().zip(self.targets) {
            match self.cells {
                None => self
                    .columns
                    .add(0..self.columns.x.len(), target, self.scale, sum),
                Some(cells) => {
                    for run in cells.near(target) {
                        self.columns.add(run, target, self.scale, sum);
                    }
                }
            }
        }
        sums
    }
}

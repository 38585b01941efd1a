//! Votes for centres of circles, in one layer for each radius.

use std::f64::consts::PI;
use std::ops::Range;

use nalgebra::{Point2, Vector2};

use super::{Circle, CircleConfig};
use crate::features::columns::Columns;
use crate::geom::unit_vector;

/// Most cells of a layer; if the run is wider, cells are larger.
const MOST_CELLS: f64 = 65_536.0;
/// Most layers.
const MOST_LAYERS: f64 = 256.0;

/// The accumulator of one run.
#[derive(Clone, Debug, Default)]
pub(super) struct Votes {
    layers: Vec<Layer>,
    low: Point2<f64>,
    cell: f64,
    n_columns: usize,
    n_rows: usize,
    /// Whether a point of the run is on no circle yet.
    free: Vec<bool>,
}

#[derive(Clone, Debug)]
struct Layer {
    radius: f64,
    /// The half circle ahead of a beam along the x axis, in steps of at most a cell, m.
    arc: Vec<Vector2<f64>>,
    votes: Vec<u32>,
    /// The votes to expect: the number of beams that would hit something of this width plus one
    /// cell.
    expected: f64,
    /// The first of the cells with the most votes, and their number; `None` once votes have
    /// changed.
    most: Option<(usize, u32)>,
}

impl Layer {
    fn most(&mut self) -> (usize, u32) {
        let votes = &self.votes;
        *self.most.get_or_insert_with(|| {
            let most = votes.iter().copied().max().unwrap_or(0);
            (votes.iter().position(|v| *v == most).unwrap_or(0), most)
        })
    }
}

impl Layer {
    fn new(radius: f64, cell: f64) -> Self {
        let n = (PI * radius / cell).ceil().max(2.0);
        let steps = 0..=n as u32;
        Self {
            radius,
            arc: steps
                .map(|step| unit_vector(PI * (f64::from(step) / n - 0.5)) * radius)
                .collect(),
            votes: vec![],
            expected: 0.0,
            most: None,
        }
    }
}

impl Votes {
    /// Room for runs of any size.
    pub(super) fn new(config: &CircleConfig) -> Self {
        let span = config.max_radius - config.min_radius;
        let n_layers = (span / config.cell).ceil().clamp(1.0, MOST_LAYERS);
        let radius = |i: u32| config.min_radius + span * f64::from(i) / n_layers;
        let layers = (0..=n_layers as u32).map(|i| Layer::new(radius(i), config.cell));
        Self {
            layers: layers.collect(),
            ..Self::default()
        }
    }

    pub(super) fn begin(&mut self, columns: &Columns, run: &Range<usize>, config: &CircleConfig) {
        let reach = config.max_radius;
        let (mut low, mut high) = (Point2::from([f64::MAX; 2]), Point2::from([f64::MIN; 2]));
        for p in run.clone().map(|index| columns.point(index)) {
            (low, high) = (low.inf(&p), high.sup(&p));
        }
        self.low = low - Vector2::repeat(reach);
        let size = high - low + Vector2::repeat(2.0 * reach);
        self.cell = config.cell.max((size.x * size.y / MOST_CELLS).sqrt());
        [self.n_columns, self.n_rows] =
            [size.x, size.y].map(|side| (side / self.cell) as usize + 1);
        let spacing = spacing(columns, run);
        for layer in &mut self.layers {
            layer.votes.clear();
            layer.votes.resize(self.n_columns * self.n_rows, 0);
            layer.expected = 2.0 * (layer.radius + self.cell) / spacing;
        }
        self.free.clear();
        self.free.resize(run.len(), true);
        for index in run.clone() {
            self.vote(columns, index, u32::wrapping_add);
        }
    }

    /// A point votes once for each cell that its arc of centres enters: those behind it, on either
    /// side of its beam.
    fn vote(&mut self, columns: &Columns, index: usize, count: fn(u32, u32) -> u32) {
        let (p, ahead) = (columns.point(index), columns.direction(index));
        let across = Vector2::new(-ahead.y, ahead.x);
        let per_cell = 1.0 / self.cell;
        for layer in &mut self.layers {
            layer.most = None;
            let mut last = usize::MAX;
            for step in &layer.arc {
                let at = (p + ahead * step.x + across * step.y - self.low) * per_cell;
                let (column, row) = (at.x as usize, at.y as usize);
                let cell = row * self.n_columns + column;
                let is_inside = column < self.n_columns && row < self.n_rows;
                if let Some(votes) = layer.votes.get_mut(cell)
                    && is_inside
                    && cell != last
                {
                    *votes = count(*votes, 1);
                    last = cell;
                }
            }
        }
    }

    /// The circle for which the greatest part of its points voted, and where its votes are; of
    /// equal ones, the first.
    pub(super) fn highest(&mut self, few: usize) -> Option<([usize; 2], Circle)> {
        let mut best = (0.0, None);
        for (place, layer) in self.layers.iter_mut().enumerate() {
            let (cell, votes) = layer.most();
            let part = f64::from(votes) / layer.expected;
            if votes as usize >= few && part > best.0 {
                best = (part, Some((place, layer.radius, cell)));
            }
        }
        let (place, radius, cell) = best.1?;
        let (column, row) = (cell % self.n_columns, cell / self.n_columns);
        let at = Vector2::new(column as f64 + 0.5, row as f64 + 0.5);
        let middle = self.low + at * self.cell;
        Some(([place, cell], Circle { middle, radius }))
    }

    /// Clears votes that led to nothing.
    pub(super) fn clear(&mut self, [place, cell]: [usize; 2]) {
        let Some(layer) = self.layers.get_mut(place) else {
            return;
        };
        if let Some(votes) = layer.votes.get_mut(cell) {
            (*votes, layer.most) = (0, None);
        }
    }

    pub(super) fn is_free(&self, place: usize) -> bool {
        self.free.get(place).is_some_and(|free| *free)
    }

    /// Removes the votes of a circle's points.
    pub(super) fn take_back(&mut self, columns: &Columns, run: &Range<usize>, taken: Range<usize>) {
        for index in taken {
            let free = self.free.get_mut(index - run.start);
            if free.is_some_and(std::mem::take) {
                self.vote(columns, index, u32::saturating_sub);
            }
        }
    }
}

/// Distance between adjacent beams, across them, at the range of the run, m.
fn spacing(columns: &Columns, run: &Range<usize>) -> f64 {
    let (first, last) = (run.start, run.end - 1);
    let direction = columns.direction(first);
    let wide = direction
        .perp(&(columns.point(last) - columns.point(first)))
        .abs();
    let steps = (last - first).max(1) as f64;
    (wide / steps).max(f64::MIN_POSITIVE)
}

#[cfg(test)]
mod tests {
    use crate::features::columns::Noise;
    use crate::geom::Length;
    use crate::points::fixture::hit;

    use super::*;

    fn columns() -> Columns {
        // The near side of a post of 20 cm radius, 2 m ahead.
        let beams: Vec<_> = (0..15)
            .map(|i| {
                let out = unit_vector(PI + 0.2 * (f64::from(i) - 7.0)) * 0.2;
                hit(i as usize, Point2::new(2.0, 0.0) + out)
            })
            .collect();
        let mut columns = Columns::default();
        columns.load(&beams, std::iter::once(0..15), Noise::default());
        columns
    }

    #[test]
    fn most_votes_are_for_the_true_circle() {
        let columns = columns();
        let mut votes = Votes::new(&CircleConfig::default());
        votes.begin(&columns, &(0..15), &CircleConfig::default());
        let (at, found) = votes.highest(6).unwrap();
        assert!(
            (found.middle - Point2::new(2.0, 0.0)).length() < 0.05,
            "{found:?}"
        );
        assert!((found.radius - 0.2).abs() < 0.05, "{found:?}");
        assert_eq!(votes.highest(16), None);
        votes.clear(at);
        assert_ne!(votes.highest(6).unwrap().0, at);
    }

    #[test]
    fn a_point_votes_only_for_middles_at_its_radius_behind_it() {
        let columns = columns();
        let mut votes = Votes::new(&CircleConfig::default());
        votes.begin(&columns, &(0..15), &CircleConfig::default());
        let mut alone = votes.clone();
        alone
            .layers
            .iter_mut()
            .for_each(|layer| layer.votes.fill(0));
        alone.vote(&columns, 4, u32::wrapping_add);
        let p = columns.point(4);
        for layer in &alone.layers {
            assert!(layer.votes.iter().sum::<u32>() >= 2);
            for cell in (0..layer.votes.len()).filter(|&cell| layer.votes[cell] > 0) {
                let (column, row) = (cell % alone.n_columns, cell / alone.n_columns);
                let at = Vector2::new(column as f64 + 0.5, row as f64 + 0.5) * alone.cell;
                let to = alone.low + at - p;
                let half_diagonal = 0.5 * alone.cell * 2.0_f64.sqrt() + 1e-9;
                assert!((to.length() - layer.radius).abs() <= half_diagonal);
                assert!(to.dot(&columns.direction(4)) >= -half_diagonal);
            }
        }
        // After taking back, all votes are those of the others.
        votes.take_back(&columns, &(0..15), 0..15);
        assert!(
            votes
                .layers
                .iter()
                .all(|layer| layer.votes.iter().all(|v| *v == 0))
        );
    }
}

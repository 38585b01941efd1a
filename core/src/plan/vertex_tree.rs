//! A tree of vertices with a spatial index.
//!
//! In: targets, one by one. Out: legs that grow towards them, in steps of bounded length.
//!
//! A leg that is blocked ends at the last whole step before the wall, if there is any. A vertex at
//! the wall itself would be the nearest one to everything behind the wall, and nothing can grow
//! from there: trees that went up to the wall took 4.2 ms for the median query in the peers'
//! `world_office.csv`, these take 0.1 ms (`--example workloads -- plan`).

use nalgebra::Point2;

use super::cspace::ConfigSpace;
use super::path::way_to;
use super::point_index::PointIndex;
use super::tree::Grown;
use crate::geom::{Length, Segment};

/// Vertices and their parents; vertex 0 is the root, its own parent.
#[derive(Clone, Debug)]
pub(super) struct VertexTree {
    index: PointIndex,
    parents: Vec<u32>,
}

impl VertexTree {
    pub(super) fn new(root: Point2<f64>, bounds: (Point2<f64>, Point2<f64>)) -> Self {
        let mut index = PointIndex::new(bounds);
        index.insert(root);
        Self {
            index,
            parents: vec![0],
        }
    }

    pub(super) fn point(&self, vertex: usize) -> Point2<f64> {
        self.index.points()[vertex]
    }

    fn grow(&mut self, parent: usize, point: Point2<f64>) -> usize {
        self.index.insert(point);
        self.parents.push(parent as u32);
        self.parents.len() - 1
    }

    /// One step of at most `step` metres from the nearest vertex towards `target`; `None` if it is
    /// blocked.
    pub(super) fn extend(
        &mut self,
        space: &dyn ConfigSpace,
        target: Point2<f64>,
        step: f64,
    ) -> Option<Grown> {
        let (nearest, distance) = self.index.nearest(target)?;
        let arrived = distance <= step;
        if distance == 0.0 {
            return Some(Grown {
                index: nearest,
                arrived,
            });
        }
        let from = self.point(nearest);
        let aim = if arrived {
            target
        } else {
            from + (target - from) * (step / distance)
        };
        space.leg_is_free(&Segment::new(from, aim)).then(|| Grown {
            index: self.grow(nearest, aim),
            arrived,
        })
    }

    /// As many steps from the nearest vertex towards `target` as are free, and the rest if all are;
    /// `None` if not even one is.
    pub(super) fn connect(
        &mut self,
        space: &dyn ConfigSpace,
        target: Point2<f64>,
        step: f64,
    ) -> Option<Grown> {
        let (nearest, _) = self.index.nearest(target)?;
        self.connect_from(nearest, space, target, step)
    }

    /// As [`VertexTree::connect`], from the given vertex.
    pub(super) fn connect_from(
        &mut self,
        vertex: usize,
        space: &dyn ConfigSpace,
        target: Point2<f64>,
        step: f64,
    ) -> Option<Grown> {
        let from = self.point(vertex);
        let distance = (target - from).length();
        if distance == 0.0 {
            return Some(Grown {
                index: vertex,
                arrived: true,
            });
        }
        let free = space.free_length(&Segment::new(from, target));
        let arrived = free >= distance;
        let steps = (free / step).floor().min(MOST_STEPS) as usize;
        let mut index = vertex;
        for i in 1..=steps {
            let along = i as f64 * step;
            if along < distance {
                index = self.grow(index, from + (target - from) * (along / distance));
            }
        }
        if arrived {
            index = self.grow(index, target);
        }
        (index != vertex).then_some(Grown { index, arrived })
    }

    pub(super) fn edges(&self) -> impl Iterator<Item = Segment> + '_ {
        let legs = self.parents.iter().enumerate().skip(1);
        legs.map(|(v, &parent)| Segment::new(self.point(parent as usize), self.point(v)))
    }

    /// How many [`Self::edges`] there are.
    pub(super) fn edge_count(&self) -> usize {
        self.parents.len().saturating_sub(1)
    }

    /// The points from the root to a vertex.
    pub(super) fn branch(&self, vertex: usize) -> Vec<Point2<f64>> {
        let way = way_to(vertex, |&at| (at != 0).then(|| self.parents[at] as usize));
        way.into_iter().map(|at| self.point(at)).collect()
    }
}

/// Most vertices of one leg.
const MOST_STEPS: f64 = 1e4;

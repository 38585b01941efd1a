//! A tree of straight legs with a spatial index.
//!
//! In: legs, one by one. Out: the point of the tree nearest to any other, on a vertex or on an
//! edge.
//!
//! Edges are registered in all cells of a coarse raster that they cross; the nearest edge is
//! searched for in growing rings of that raster, until no ring farther out can hold a nearer one.
//! An edge that is split leaves its old entries behind: they point to its shortened remainder,
//! whose current geometry is measured, so they cost a little time but cause no error.

use nalgebra::Point2;

use super::cspace::ConfigSpace;
use super::path::way_to;
use super::point_index::ring_around;
use crate::geom::{Length, Segment};
use crate::map::cells_on_ray;

/// Growth shorter than this is dropped, m, so that trees do not crowd along walls.
pub(super) const MIN_GROWTH: f64 = 0.02;

/// A point of the tree, and its parent.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Vertex {
    point: Point2<f64>,
    /// The root is its own parent.
    parent: usize,
}

/// A growing tree of legs.
#[derive(Clone, Debug)]
pub(super) struct Tree {
    vertices: Vec<Vertex>,
    raster: Raster,
}

/// The point of a tree nearest to a given point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Nearest {
    /// The nearest point.
    pub(super) point: Point2<f64>,
    /// The edge that it lies on, named by its outer vertex.
    pub(super) edge: usize,
    /// Distance, m.
    pub(super) distance: f64,
}

/// The result of an extension.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Grown {
    /// The new vertex, or the one that existed already.
    pub(super) index: usize,
    /// Whether the target itself was reached.
    pub(super) arrived: bool,
}

impl Tree {
    /// A tree of one point; points outside `bounds` are found more slowly.
    pub(super) fn new(root: Point2<f64>, bounds: (Point2<f64>, Point2<f64>)) -> Self {
        let mut tree = Self {
            vertices: vec![Vertex {
                point: root,
                parent: 0,
            }],
            raster: Raster::new(bounds),
        };
        tree.raster.register(0, root, root);
        tree
    }

    /// The legs of the tree, for display.
    pub(super) fn edges(&self) -> impl Iterator<Item = Segment> + '_ {
        self.vertices.iter().skip(1).map(|v| self.edge_of(v))
    }

    /// How many [`Self::edges`] there are.
    pub(super) fn edge_count(&self) -> usize {
        self.vertices.len().saturating_sub(1)
    }

    fn edge_of(&self, vertex: &Vertex) -> Segment {
        Segment::new(self.vertices[vertex.parent].point, vertex.point)
    }

    /// The point of the tree nearest to `point`.
    pub(super) fn nearest(&self, point: Point2<f64>) -> Nearest {
        let mut best = Nearest {
            point: self.vertices[0].point,
            edge: 0,
            distance: f64::INFINITY,
        };
        self.raster.search(point, |edge| {
            let on_edge = self.edge_of(&self.vertices[edge]).closest_point(point);
            let distance = (on_edge - point).length();
            // Ties go to the older edge, whatever the order of the search.
            if distance < best.distance || (distance == best.distance && edge < best.edge) {
                best = Nearest {
                    point: on_edge,
                    edge,
                    distance,
                };
            }
            best.distance
        });
        best
    }

    /// Makes a vertex of a place found by [`Tree::nearest`], splitting its edge if it lies inside
    /// one.
    pub(super) fn split(&mut self, at: &Nearest) -> usize {
        let outer = self.vertices[at.edge];
        if at.point == outer.point {
            return at.edge;
        }
        if at.point == self.vertices[outer.parent].point {
            return outer.parent;
        }
        let middle = self.vertices.len();
        self.vertices.push(Vertex {
            point: at.point,
            parent: outer.parent,
        });
        self.vertices[at.edge].parent = middle;
        let start = self.vertices[outer.parent].point;
        self.raster.register(middle, start, at.point);
        middle
    }

    /// Adds a leg from a vertex; returns the new vertex.
    pub(super) fn grow(&mut self, parent: usize, point: Point2<f64>) -> usize {
        let vertex = self.vertices.len();
        self.vertices.push(Vertex { point, parent });
        self.raster
            .register(vertex, self.vertices[parent].point, point);
        vertex
    }

    /// Grows from the nearest point of the tree to the last collision-free one towards `target`;
    /// `None` if that is less than [`MIN_GROWTH`].
    pub(super) fn extend(&mut self, space: &dyn ConfigSpace, target: Point2<f64>) -> Option<Grown> {
        let nearest = self.nearest(target);
        if nearest.distance == 0.0 {
            let index = self.split(&nearest);
            return Some(Grown {
                index,
                arrived: true,
            });
        }
        let leg = Segment::new(nearest.point, target);
        let free = space.free_length(&leg);
        let arrived = free >= leg.length();
        if !arrived && free < MIN_GROWTH {
            return None;
        }
        let point = if arrived {
            target
        } else {
            leg.a + leg.vector() * (free / leg.length())
        };
        let vertex = self.split(&nearest);
        let index = self.grow(vertex, point);
        Some(Grown { index, arrived })
    }

    /// Grows from a vertex to `target`, if the whole leg is free; returns the new vertex.
    pub(super) fn reach(
        &mut self,
        space: &dyn ConfigSpace,
        from: usize,
        target: Point2<f64>,
    ) -> Option<usize> {
        let leg = Segment::new(self.vertices[from].point, target);
        space.leg_is_free(&leg).then(|| self.grow(from, target))
    }

    /// The points from the root to a vertex.
    pub(super) fn branch(&self, vertex: usize) -> Vec<Point2<f64>> {
        let before = |&at: &usize| Some(self.vertices[at].parent).filter(|parent| *parent != at);
        let way = way_to(vertex, before).into_iter();
        way.map(|at| self.vertices[at].point).collect()
    }
}

/// Edges by the coarse cells that they cross.
#[derive(Clone, Debug)]
struct Raster {
    low: Point2<f64>,
    side: f64,
    cols: i32,
    rows: i32,
    /// The last entry of each cell; [`NONE`] if it has none.
    heads: Vec<u32>,
    /// An edge, and the entry before it in the same cell.
    entries: Vec<(u32, u32)>,
}

const NONE: u32 = u32::MAX;

/// Cells along the longer side of the raster.
const RASTER_CELLS: f64 = 48.0;

impl Raster {
    fn new((low, high): (Point2<f64>, Point2<f64>)) -> Self {
        let extent = high - low;
        let side = (extent.max() / RASTER_CELLS).max(0.05);
        let count = |length: f64| (length / side).ceil().clamp(1.0, RASTER_CELLS) as i32;
        let (cols, rows) = (count(extent.x), count(extent.y));
        Self {
            low,
            side,
            cols,
            rows,
            heads: vec![NONE; (cols * rows) as usize],
            entries: vec![],
        }
    }

    /// Position of a point, in raster cells; points outside are moved to the border.
    fn at(&self, point: Point2<f64>) -> Point2<f64> {
        let at = (point - self.low) / self.side;
        Point2::new(
            at.x.clamp(0.0, f64::from(self.cols) - 1e-9),
            at.y.clamp(0.0, f64::from(self.rows) - 1e-9),
        )
    }

    fn register(&mut self, edge: usize, a: Point2<f64>, b: Point2<f64>) {
        let (a, b) = (self.at(a), self.at(b));
        let (cols, heads, entries) = (self.cols, &mut self.heads, &mut self.entries);
        cells_on_ray(a, b, |cell| {
            if let Some(head) = heads.get_mut((cell.row * cols + cell.col) as usize) {
                entries.push((edge as u32, *head));
                *head = entries.len() as u32 - 1;
            }
        });
    }

    /// Shows edges ring by ring around `point` to `visit`, which returns the least distance so far.
    fn search(&self, point: Point2<f64>, mut visit: impl FnMut(usize) -> f64) {
        let at = self.at(point);
        let (col, row) = (at.x.floor() as i32, at.y.floor() as i32);
        let mut least = f64::INFINITY;
        for ring in 0..self.cols.max(self.rows) {
            // Every edge that the rings so far do not contain lies at least this far away.
            let covered = f64::from(ring - 1) * self.side
                + self.side * border_distance(at.x).min(border_distance(at.y));
            if least <= covered {
                return;
            }
            ring_around((col, row), ring, (self.cols, self.rows), |c, r| {
                let mut at = self.heads[(r * self.cols + c) as usize];
                while at != NONE {
                    let (edge, before) = self.entries[at as usize];
                    least = visit(edge as usize);
                    at = before;
                }
            });
        }
    }
}

/// Distance from the nearer border of the raster cell, in cells.
fn border_distance(at: f64) -> f64 {
    let inside = at - at.floor();
    inside.min(1.0 - inside)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn index_finds_what_a_scan_of_all_edges_finds(
            points in proptest::collection::vec((0.0..10.0_f64, 0.0..6.0_f64), 1..80),
            queries in proptest::collection::vec((0.0..10.0_f64, 0.0..6.0_f64), 20),
        ) {
            let bounds = (Point2::new(0.0, 0.0), Point2::new(10.0, 6.0));
            let mut tree = Tree::new(Point2::new(5.0, 3.0), bounds);
            for &(x, y) in &points {
                let nearest = tree.nearest(Point2::new(x, y));
                let vertex = tree.split(&nearest);
                tree.grow(vertex, Point2::new(x, y));
            }
            for &(x, y) in &queries {
                let q = Point2::new(x, y);
                let brute = tree.edges().map(|e| e.distance(q)).fold(f64::INFINITY, f64::min);
                prop_assert!((tree.nearest(q).distance - brute).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn splitting_keeps_every_branch_connected_to_the_root() {
        let bounds = (Point2::new(0.0, 0.0), Point2::new(4.0, 4.0));
        let mut tree = Tree::new(Point2::new(1.0, 1.0), bounds);
        let end = tree.grow(0, Point2::new(3.0, 1.0));
        let nearest = tree.nearest(Point2::new(2.0, 2.0));
        let middle = tree.split(&nearest);
        let top = tree.grow(middle, Point2::new(2.0, 2.0));
        let xs = |v: usize| {
            tree.branch(v)
                .iter()
                .map(|p| (p.x, p.y))
                .collect::<Vec<_>>()
        };
        assert_eq!(xs(end), [(1.0, 1.0), (2.0, 1.0), (3.0, 1.0)]);
        assert_eq!(xs(top), [(1.0, 1.0), (2.0, 1.0), (2.0, 2.0)]);
    }
}

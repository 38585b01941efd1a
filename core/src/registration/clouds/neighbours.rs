//! The nearest points of a cloud, by a k-d tree.

use std::num::NonZero;

use kiddo::{ImmutableKdTree, SquaredEuclidean};
use nalgebra::Point2;

/// The points of a cloud in a tree.
pub(super) struct Neighbours {
    /// `None` if there are no points.
    tree: Option<ImmutableKdTree<f64, 2>>,
}

impl Neighbours {
    pub(super) fn of(points: &[Point2<f64>]) -> Self {
        let entries: Vec<[f64; 2]> = points.iter().map(|p| [p.x, p.y]).collect();
        let tree = (!entries.is_empty())
            .then(|| ImmutableKdTree::new_from_slice(&entries).ok())
            .flatten();
        Self { tree }
    }

    /// The nearest point to `place`, and its squared distance.
    pub(super) fn nearest(&self, place: Point2<f64>) -> Option<(usize, f64)> {
        let tree = self.tree.as_ref()?;
        let place = [place.x, place.y];
        let found = tree
            .query(&place)
            .nearest_one::<SquaredEuclidean<f64>>()
            .execute();
        Some((found.item as usize, found.distance))
    }

    /// The `count` points nearest to `place`, the nearest first.
    pub(super) fn nearest_few(&self, place: Point2<f64>, count: usize) -> Vec<usize> {
        let (Some(tree), Some(count)) = (&self.tree, NonZero::new(count)) else {
            return vec![];
        };
        let place = [place.x, place.y];
        let found = tree
            .query(&place)
            .nearest_n::<SquaredEuclidean<f64>>(count)
            .execute();
        found.into_iter().map(|near| near.item as usize).collect()
    }
}

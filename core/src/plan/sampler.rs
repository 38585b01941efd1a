//! The areas from which trees draw their points.

use nalgebra::Point2;
use rand::{Rng, RngExt};

use super::cspace::ConfigSpace;
use super::guide::{Guide, Guided};
use super::query::Query;
use super::squares::squares_within_reach;

/// Number of points that a tree draws from anywhere before it is worth computing where it can go at
/// all, which takes as long as drawing some thousands.
const PATIENCE: usize = 2000;
/// Number of squares that are then examined.
const SQUARES: f64 = 1e5;

/// A source of random points.
#[derive(Clone, Debug)]
pub enum Sampler {
    /// Anywhere in a rectangle, uniformly, as in TDK 2016 §5.2.
    Anywhere {
        /// Lower left corner.
        low: Point2<f64>,
        /// Upper right corner.
        high: Point2<f64>,
    },
    /// Anywhere in some squares, uniformly: fewer points are needed if the free space is known.
    Squares {
        /// Their centres, at least one.
        centres: Vec<Point2<f64>>,
        /// Their side, m.
        side: f64,
    },
}

impl Sampler {
    /// Anywhere within the bounds of a space.
    #[must_use]
    pub fn anywhere(space: &dyn ConfigSpace) -> Self {
        let (low, high) = space.bounds();
        Self::Anywhere { low, high }
    }

    /// Draws a point.
    pub fn draw(&self, rng: &mut dyn Rng) -> Point2<f64> {
        match self {
            Self::Anywhere { low, high } => {
                let (x, y) = (rng.random::<f64>(), rng.random::<f64>());
                Point2::new(low.x + (high.x - low.x) * x, low.y + (high.y - low.y) * y)
            }
            Self::Squares { centres, side } => {
                let at = (rng.random::<f64>() * centres.len() as f64) as usize;
                let centre = centres.get(at).copied().unwrap_or_default();
                let shift = |u: f64| (u - 0.5) * side;
                let (dx, dy) = (shift(rng.random()), shift(rng.random()));
                Point2::new(centre.x + dx, centre.y + dy)
            }
        }
    }

    /// Area drawn from, m².
    #[must_use]
    pub fn area(&self) -> f64 {
        match self {
            Self::Anywhere { low, high } => (high.x - low.x) * (high.y - low.y),
            Self::Squares { centres, side } => centres.len() as f64 * side * side,
        }
    }
}

/// The sampler of a tree, with what helps it after many unsuccessful points.
#[derive(Clone, Debug)]
pub(super) struct Draws {
    sampler: Sampler,
    count: usize,
    guide: Option<Guide>,
}

impl Draws {
    pub(super) fn new(sampler: Sampler) -> Self {
        Self {
            sampler,
            count: 0,
            guide: None,
        }
    }

    /// Draws a point. After [`PATIENCE`] unsuccessful points from anywhere, a way over free discs
    /// is searched for, to guide the tree from the start; if none is found, points are only drawn
    /// from what can be reached at all. Points behind walls or outside the building are wasted, and
    /// a strip of a few centimetres is found the sooner the smaller the area drawn from.
    pub(super) fn draw(
        &mut self,
        space: &dyn ConfigSpace,
        query: &Query,
        rng: &mut dyn Rng,
    ) -> Point2<f64> {
        self.count += 1;
        if self.count == PATIENCE && matches!(self.sampler, Sampler::Anywhere { .. }) {
            self.guide = Guide::new(space, query);
            if self.guide.is_none() {
                let (centres, side) = squares_within_reach(space, query.start, SQUARES);
                self.sampler = Sampler::Squares { centres, side };
            }
        }
        self.sampler.draw(rng)
    }

    /// The next leg for the tree from the start; `None` while it draws from anywhere.
    pub(super) fn guided(&self, rng: &mut dyn Rng) -> Option<Guided> {
        self.guide.as_ref()?.draw(rng)
    }

    /// Takes the result: the vertex at the guide's point, or none.
    pub(super) fn take(&mut self, grown: Option<usize>) {
        if let Some(guide) = &mut self.guide {
            guide.take(grown);
        }
    }
}

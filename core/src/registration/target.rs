//! What points can be matched against.

use std::borrow::Cow;

use nalgebra::Point2;

use super::SearchConfig;
use crate::map::{FixedSurfels, LikelihoodPyramid, Surfel, SurfelMap, SurfelTiles};

/// A map or another cloud that points are matched against: surfaces to match, and a likelihood to
/// search.
pub trait Target {
    /// The surface nearest to `place` (m, frame of the target); `None` if none is within reach.
    fn nearest(&self, place: Point2<f64>) -> Option<&Surfel>;

    /// How likely a point lies at each place; `None` if nothing was seen, or it spans too large an
    /// area.
    fn likelihood(&self, config: &SearchConfig) -> Option<Cow<'_, LikelihoodPyramid>>;
}

// `into_iter` accepts what either gives, a slice or an iterator.
macro_rules! target {
    ($kind:ty) => {
        impl Target for $kind {
            #[inline]
            fn nearest(&self, place: Point2<f64>) -> Option<&Surfel> {
                Self::nearest(self, place)
            }

            fn likelihood(&self, config: &SearchConfig) -> Option<Cow<'_, LikelihoodPyramid>> {
                let places = self.surfels().into_iter().map(|surfel| surfel.position);
                config.likelihood_of(&places).map(Cow::Owned)
            }
        }
    };
}
target!(SurfelMap);
target!(FixedSurfels);
target!(SurfelTiles);

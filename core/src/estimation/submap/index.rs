//! Lookup structures of a closed submap: built on first use, and kept for submaps that are compared
//! repeatedly.
//!
//! In: a closed submap. Out: the surfel nearest to a place, and the likelihood for searches.
//!
//! A closed submap never changes, and while the robot passes a place, the same earlier submaps are
//! compared with one new submap after the other. Those used last are kept, within [`MOST_BYTES`].

use std::borrow::Cow;
use std::sync::{Arc, OnceLock};

use nalgebra::Point2;

use super::ClosedSubmap;
use crate::map::{FixedSurfels, LikelihoodPyramid, Surfel, SurfelConfig};
use crate::registration::{SearchConfig, Target};

/// The most memory of all kept indexes together.
const MOST_BYTES: usize = 16 << 20;

/// The parts of one index, as far as they were requested.
#[derive(Debug, Default)]
pub(in crate::estimation) struct Index {
    surfels: OnceLock<FixedSurfels>,
    likelihood: OnceLock<Option<LikelihoodPyramid>>,
}

impl Index {
    fn bytes(&self) -> usize {
        let surfels = self.surfels.get().map_or(0, FixedSurfels::bytes);
        let likelihood = self.likelihood.get().and_then(Option::as_ref);
        surfels + likelihood.map_or(0, LikelihoodPyramid::bytes)
    }
}

/// A closed submap with its index. All searches in it use one configuration.
#[derive(Clone, Copy, Debug)]
pub(in crate::estimation) struct Indexed<'a> {
    pub(super) submap: &'a ClosedSubmap,
    index: &'a Index,
    config: &'a SurfelConfig,
}

impl<'a> Indexed<'a> {
    pub(in crate::estimation) fn new(
        submap: &'a ClosedSubmap,
        index: &'a Index,
        config: &'a SurfelConfig,
    ) -> Self {
        Self {
            submap,
            index,
            config,
        }
    }

    /// Its surfels, indexed by place.
    #[inline]
    pub(super) fn map(&self) -> &'a FixedSurfels {
        match self.index.surfels.get() {
            Some(surfels) => surfels,
            None => self.make_map(),
        }
    }

    /// A separate function, so that looking up what is already built needs no call.
    #[cold]
    fn make_map(&self) -> &'a FixedSurfels {
        let made = || self.submap.indexed(self.config).fixed();
        self.index.surfels.get_or_init(made)
    }
}

impl Target for Indexed<'_> {
    #[inline]
    fn nearest(&self, place: Point2<f64>) -> Option<&Surfel> {
        self.map().nearest(place)
    }

    fn likelihood(&self, config: &SearchConfig) -> Option<Cow<'_, LikelihoodPyramid>> {
        let made = || config.likelihood_of(&self.submap.surfaces());
        let likelihood = self.index.likelihood.get_or_init(made);
        likelihood.as_ref().map(Cow::Borrowed)
    }
}

/// The indexes of the submaps that were last compared, by submap number.
#[derive(Clone, Debug, Default)]
pub(in crate::estimation) struct Indexes {
    kept: Vec<Kept>,
}

#[derive(Clone, Debug)]
struct Kept {
    submap: usize,
    /// The new submap for which it was last used.
    used_for: usize,
    index: Arc<Index>,
}

impl Indexes {
    /// The index of `submap`, to be compared with submap `new`, or of `new` itself.
    pub(in crate::estimation) fn of(&mut self, submap: usize, new: usize) -> Arc<Index> {
        if let Some(kept) = self.kept.iter_mut().find(|kept| kept.submap == submap) {
            kept.used_for = new;
            return Arc::clone(&kept.index);
        }
        self.make_room(new);
        let index = Arc::default();
        self.kept.push(Kept {
            submap,
            used_for: new,
            index: Arc::clone(&index),
        });
        index
    }

    /// Drops what was not used lately. If all were, the newest is dropped: the next submap needs
    /// the same ones in the same order, and would find none of them in a queue that is too short.
    fn make_room(&mut self, new: usize) {
        let mut bytes: usize = self.kept.iter().map(|kept| kept.index.bytes()).sum();
        while bytes > MOST_BYTES {
            let is_stale = |kept: &Kept| kept.used_for.abs_diff(new) > 1;
            let is_other = |kept: &Kept| kept.submap != new;
            let stale = self.kept.iter().position(is_stale);
            let Some(at) = stale.or_else(|| self.kept.iter().rposition(is_other)) else {
                break;
            };
            bytes -= self.kept.remove(at).index.bytes();
        }
    }
}

//! A stretch of the way with its own map, and whether two of them show the same place.
//!
//! In: two closed submaps and how well their relative pose is known. Out: a [`Closure`], or
//! nothing.
//!
//! 1. Where the relative pose is known to within the reach of matching, the surfaces of one are
//!    matched to the other at once; else the whole window of three standard deviations is searched
//!    first ([`search_and_match`]).
//! 2. The match must hold both ways: surfaces of one must lie on surfaces of the other, and must
//!    not stand where the other saw through. What the other never saw says nothing.
//! 3. A window wide enough to need a search must end in a pose that is fixed in all directions: a
//!    corridor fits itself anywhere.

use nalgebra::{Matrix3, Point2, Vector3};

use super::pose_graph::information_at_end;
use crate::bounds::{Bounds, config};
use crate::geom::{Pose2, pose_cov};
use crate::map::{Surfel, SurfelConfig, SurfelMap, cells_on_ray};
use crate::points::OrientedPoint;
use crate::registration::{
    MatchConfig, Prior, SearchConfig, SearchWindow, Verdict, register, search_and_match,
};

config! {
    /// When two submaps are one place.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct ClosureConfig {
        /// Widest search to either side, m. Default 8.
        pub max_shift: f64 = 8.0,
        /// Widest search to either side, rad. Default 0.6.
        pub max_turn: f64 = 0.6,
        /// The window is so many standard deviations of what is known of the pose, to either side.
        /// Default 3; larger finds loops after worse drives, and more wrong ones.
        pub doubt_sigmas: f64 = 3.0,
        /// In a window no wider than this the submaps are matched without a search: matching pulls
        /// them in from as far. Default 0.3 m and 0.06 rad.
        pub match_reach: SearchWindow = SearchWindow {
            shift: 0.3,
            turn: 0.06,
        },
        /// How poses are searched for. Default [`SearchConfig::BETWEEN_SUBMAPS`].
        pub search: SearchConfig = SearchConfig::BETWEEN_SUBMAPS,
        /// Matched without a search, the relative pose is never believed better beforehand than
        /// this, m. Default 0.02.
        pub prior_sigma: f64 = 0.02,
        /// The same, rad. Default 0.005.
        pub prior_turn_sigma: f64 = 0.005,
        /// A surface agrees that lies nearer than this to one of the other submap, m, across it.
        /// Default 0.08: larger takes the two sides of a thin wall for one.
        pub agree_within: f64 = 0.08,
        /// Cosine of the largest angle between surfaces that agree. Default 0.5.
        pub agree_cosine: f64 = 0.5,
        /// Least number of surfaces that agree. Default 80.
        pub min_agreeing: usize = 80,
        /// Least part that agrees, of all that could. Default 0.75.
        pub min_agreement: f64 = 0.75,
        /// The same where the pose had to be searched for. Default 0.85.
        pub min_agreement_searched: f64 = 0.85,
        /// A closure is never believed better than this, m. Default 0.015.
        pub sigma: f64 = 0.015,
        /// A closure is never believed better than this, rad. Default 0.003.
        pub turn_sigma: f64 = 0.003,
        /// What a closure says at least, 1/m² and 1/rad²: nothing is known worse than to ten metres
        /// and ten radians. Default 0.01.
        pub min_information: f64 = 0.01,
        /// Scale of the Cauchy kernel by which wrong closures lose their say, in standard
        /// deviations. Default 3; larger listens to more.
        pub kernel: f64 = 3.0,
        /// Most iterations of the optimisation after a closure. Default 30.
        pub max_iterations: usize = 30,
        /// Earlier submaps that are tried for each new one. Default 10.
        pub candidates: usize = 10,
    }
}

impl ClosureConfig {
    /// What [`Self::max_shift`] may be, m.
    pub const MAX_SHIFT: Bounds = [0.1, 50.0];
    /// What [`Self::min_agreement`] may be.
    pub const MIN_AGREEMENT: Bounds = [0.1, 1.0];
}

impl ClosureConfig {
    /// Where to search for a submap whose relative pose is this certain.
    pub(super) fn window(&self, doubt: &Doubt) -> SearchWindow {
        SearchWindow {
            shift: (self.doubt_sigmas * doubt.shift).min(self.max_shift),
            turn: (self.doubt_sigmas * doubt.turn).min(self.max_turn),
        }
    }
}

/// What is kept of a submap that is closed.
#[derive(Clone, Debug, Default)]
pub(super) struct ClosedSubmap {
    surfels: Vec<Surfel>,
    free: FreeCells,
    /// Mean of the surfels, in the submap.
    pub(super) centre: Point2<f64>,
    /// Root mean square distance of the surfels from their mean, m.
    pub(super) radius: f64,
}

/// Two submaps show the same place.
#[derive(Clone, Copy, Debug)]
pub(super) struct Closure {
    /// `old_from_new`.
    pub(super) motion: Pose2,
    /// In the frame of the new submap, as an edge of a pose graph takes it.
    pub(super) information: Matrix3<f64>,
}

/// How well a relative pose is known beforehand.
#[derive(Clone, Copy, Debug)]
pub(super) struct Doubt {
    /// Standard deviation, m.
    pub(super) shift: f64,
    /// Standard deviation, rad.
    pub(super) turn: f64,
}

impl Doubt {
    fn prior(&self, guess: &Pose2, config: &ClosureConfig) -> Prior {
        let shift = self.shift.max(config.prior_sigma);
        let turn = self.turn.max(config.prior_turn_sigma);
        let shift = 1.0 / (shift * shift);
        let information = Vector3::new(shift, shift, 1.0 / (turn * turn));
        Prior {
            pose: *guess,
            information: Matrix3::from_diagonal(&information),
        }
    }
}

impl ClosedSubmap {
    /// Closes a submap; `rays` are the beams that drew it, in its frame.
    pub(super) fn new(surfels: Vec<Surfel>, rays: impl Iterator<Item = [Point2<f64>; 2]>) -> Self {
        let count = surfels.len().max(1) as f64;
        let mean = surfels
            .iter()
            .fold(Vector3::zeros().xy(), |sum, s| sum + s.position.coords)
            / count;
        let centre = Point2::from(mean);
        let squares: f64 = surfels
            .iter()
            .map(|s| (s.position - centre).norm_squared())
            .sum();
        let free = FreeCells::new(&surfels, rays);
        Self {
            surfels,
            free,
            centre,
            radius: (squares / count).sqrt(),
        }
    }

    /// Searches for the new submap `other` in this one; `guess` is `self_from_other`.
    pub(super) fn find(
        &self,
        other: &Self,
        guess: &Pose2,
        doubt: &Doubt,
        surfels: &SurfelConfig,
        matching: &MatchConfig,
        config: &ClosureConfig,
    ) -> Option<Closure> {
        let window = config.window(doubt);
        let reach = &config.match_reach;
        let searched = window.shift > reach.shift || window.turn > reach.turn;
        let map = SurfelMap::from_surfels(*surfels, self.surfels.clone());
        let points = other.points();
        let found = if searched {
            let believed = doubt.prior(guess, config);
            let (pivot, search) = (other.centre, &config.search);
            search_and_match(&points, pivot, &map, &believed, &window, search, matching)?
        } else {
            let found = register(&points, &map, guess, &doubt.prior(guess, config), matching);
            if !matches!(
                found.verdict,
                Verdict::Converged | Verdict::Degenerate { .. }
            ) {
                return None;
            }
            found
        };
        let motion = found.estimate.pose;
        let least = if searched {
            config.min_agreement_searched
        } else {
            config.min_agreement
        };
        let reverse = SurfelMap::from_surfels(*surfels, other.surfels.clone());
        let agree = self.agrees_with(&map, other, &motion, least, config)
            && other.agrees_with(&reverse, self, &motion.inverse(), least, config);
        if !agree {
            return None;
        }
        let floor = pose_cov(config.sigma, config.turn_sigma);
        let weak = Matrix3::from_diagonal_element(config.min_information);
        let cov = (found.information + weak).try_inverse()? + floor;
        Some(Closure {
            motion,
            information: information_at_end(&motion, &cov.try_inverse()?),
        })
    }

    fn points(&self) -> Vec<OrientedPoint> {
        self.surfels
            .iter()
            .map(|s| OrientedPoint {
                position: s.position,
                normal: s.normal,
            })
            .collect()
    }

    /// Whether of the surfels of `other` at least this part agree with what this submap, indexed in
    /// `map`, saw there.
    fn agrees_with(
        &self,
        map: &SurfelMap,
        other: &Self,
        self_from_other: &Pose2,
        least: f64,
        config: &ClosureConfig,
    ) -> bool {
        let (mut agree, mut contradict) = (0, 0);
        for surfel in &other.surfels {
            let place = *self_from_other * surfel.position;
            let on_surface = map.nearest(place).is_some_and(|s| {
                s.normal.dot(&(place - s.position)).abs() < config.agree_within
                    && s.normal.dot(&self_from_other.rotate(surfel.normal)) > config.agree_cosine
            });
            if on_surface {
                agree += 1;
            } else if self.free.contains(place) {
                contradict += 1;
            }
        }
        agree >= config.min_agreeing && agree as f64 >= least * (agree + contradict) as f64
    }
}

/// Places that beams went through, in cells of 0.2 m, one bit each.
#[derive(Clone, Debug, Default)]
struct FreeCells {
    bits: Vec<u64>,
}

/// Of each beam, the end that says nothing about free places, m.
const UNSURE_END: f64 = 0.3;
/// Side of a cell, m: coarse, since submaps drift by centimetres.
const FREE_CELL: f64 = 0.2;
/// Cells along a side, a submap's origin in their middle: 100 m.
const FREE_SIDE: i32 = 512;

impl FreeCells {
    fn new(surfels: &[Surfel], rays: impl Iterator<Item = [Point2<f64>; 2]>) -> Self {
        let size = (FREE_SIDE * FREE_SIDE) as usize;
        let mut cells = Self {
            bits: vec![0; size / 64],
        };
        for [from, to] in rays {
            let way = to - from;
            let length = way.norm();
            // The end of the beam may belong to the wall, or to an edge that it touches.
            let part = (length - UNSURE_END) / length;
            if part.is_nan() || part <= 0.0 {
                continue;
            }
            let end = from + way * part;
            cells_on_ray(from / FREE_CELL, end / FREE_CELL, |cell| {
                if let Some((word, bit)) = Self::bit((cell.col, cell.row)) {
                    cells.bits[word] |= bit;
                }
            });
        }
        for surfel in surfels {
            let (col, row) = Self::cell_of(surfel.position);
            for (dc, dr) in [(0, 0), (1, 0), (-1, 0), (0, 1), (0, -1)] {
                if let Some((word, bit)) = Self::bit((col + dc, row + dr)) {
                    cells.bits[word] &= !bit;
                }
            }
        }
        cells
    }

    fn cell_of(place: Point2<f64>) -> (i32, i32) {
        let at = |v: f64| (v / FREE_CELL).floor().clamp(-1e6, 1e6) as i32;
        (at(place.x), at(place.y))
    }

    fn bit((col, row): (i32, i32)) -> Option<(usize, u64)> {
        let (c, r) = (col + FREE_SIDE / 2, row + FREE_SIDE / 2);
        if !(0..FREE_SIDE).contains(&c) || !(0..FREE_SIDE).contains(&r) {
            return None;
        }
        let at = (r * FREE_SIDE + c) as usize;
        Some((at / 64, 1 << (at % 64)))
    }

    fn contains(&self, place: Point2<f64>) -> bool {
        Self::bit(Self::cell_of(place))
            .and_then(|(word, bit)| Some(self.bits.get(word)? & bit != 0))
            .unwrap_or(false)
    }
}

#[cfg(test)]
mod tests;

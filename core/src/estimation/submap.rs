//! A stretch of the trajectory with its own map, and whether two of them show the same place.
//!
//! In: two closed submaps and how well their relative pose is known. Out: a [`Closure`], or
//! nothing.
//!
//! 1. If the relative pose is known to within the reach of matching, the surfaces of one are
//!    matched to the other directly; otherwise the whole window of three standard deviations is
//!    searched first ([`search_turned_and_match`]).
//! 2. The match must hold in both directions: surfaces of one must lie on surfaces of the other,
//!    and must not stand where the other saw free space. Where the other saw nothing, a surface
//!    counts as neither.
//! 3. A window wide enough to need a search must end in a pose that is constrained in all
//!    directions: a corridor fits itself anywhere.
//!
//! `overlap` judges whether two submaps agree with one another at their present poses.

mod index;
mod overlap;
mod saved;

use std::f64::consts::PI;

use nalgebra::{Matrix3, Point2, Vector3};

use super::agreement::Agreement;
use super::facing::Facing;
use super::free_space::FreeSpace;
use super::pose_graph::information_at_end;
use crate::bounds::{Bounds, config};
use crate::geom::{Pose2, pose_cov};
use crate::map::{Surfel, SurfelConfig, SurfelMap};
use crate::points::OrientedPoint;
use crate::registration::{
    MatchConfig, Prior, Registration, SearchConfig, SearchWindow, Verdict, register,
    search_turned_and_match,
};

config! {
    /// When two submaps are one place.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct ClosureConfig {
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
        /// What is asked for of evidence that a place was seen before, as a part of the usual.
        /// Default 1; larger: fewer, later and safer closures.
        pub proof: f64 = 1.0,
        /// Earlier submaps that are tried for each new one, at most. Default 40.
        pub candidates: usize = 40,
        /// Where the way to earlier submaps is known worse than this, m, not all of those are tried
        /// that lie near each other. Default 0.7.
        pub wide: f64 = 0.7,
        /// How far apart those lie that are tried then, m. Default 3; larger is quicker and misses
        /// more.
        pub apart: f64 = 3.0,
        /// The way through submaps may err by this part of it, to the same side in all. Default
        /// 0.02: what is searched is wider by it.
        pub drift: f64 = 0.02,
        /// The same of the turn through a submap, rad. Default 0.015.
        pub drift_turn: f64 = 0.015,
    }
}

impl ClosureConfig {
    /// What [`Self::min_agreement`] may be.
    pub const MIN_AGREEMENT: Bounds = [0.1, 1.0];
    /// What [`Self::proof`] may be.
    pub const PROOF: Bounds = [0.2, 10.0];

    /// Where to search for a submap whose relative pose has this uncertainty.
    pub(super) fn window(&self, doubt: &Doubt) -> SearchWindow {
        SearchWindow {
            shift: self.doubt_sigmas * doubt.shift,
            turn: (self.doubt_sigmas * doubt.turn).min(PI),
        }
    }
}

pub(super) use self::index::{Indexed, Indexes};
pub(super) use self::overlap::{Laid, Said};

/// With the first overlap two submaps prove nothing, with the second one unit of proof; the same
/// for the part that agrees.
const PROVES_OVERLAP: [f64; 2] = [0.35, 0.7];
const PROVES_PART: [f64; 2] = [0.7, 0.9];
/// A larger overlap proves more, up to this.
const MOST_PROOF: f64 = 1.5;
/// Submaps whose centres are farther apart than this many times their radii do not overlap.
pub(super) const REACH: f64 = 1.5;

/// What is kept of a closed submap.
#[derive(Clone, Debug, Default)]
pub(super) struct ClosedSubmap {
    surfels: Vec<Surfel>,
    free: FreeSpace,
    facing: Facing,
    /// Mean of the surfels, in the frame of the submap.
    pub(super) centre: Point2<f64>,
    /// Root mean square distance of the surfels from their mean, m.
    pub(super) radius: f64,
}

/// The finding that two submaps show the same place.
#[derive(Clone, Copy, Debug)]
pub(super) struct Closure {
    /// `old_from_new`.
    pub(super) motion: Pose2,
    /// In the frame of the new submap, as for an edge of a pose graph.
    pub(super) information: Matrix3<f64>,
    /// Whether it had to be searched for.
    pub(super) is_searched: bool,
    /// The part of the surfels of one that lies on those of the other; the larger of the two parts.
    pub(super) overlap: f64,
    /// The part of what is compared that agrees; the smaller of the two directions.
    pub(super) part: f64,
}

impl Closure {
    /// Its evidence by itself.
    pub(super) fn proof(&self) -> f64 {
        let [none, one] = PROVES_OVERLAP;
        let overlap = ((self.overlap - none) / (one - none)).clamp(0.0, MOST_PROOF);
        let [none, one] = PROVES_PART;
        overlap * ((self.part - none) / (one - none)).clamp(0.0, 1.0)
    }
}

/// The prior uncertainty of a relative pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Doubt {
    /// Standard deviation, m.
    pub shift: f64,
    /// Standard deviation, rad.
    pub turn: f64,
}

impl Doubt {
    /// The doubt that corresponds to a covariance of (x, y, θ), in any axes.
    pub(super) fn of(cov: &Matrix3<f64>) -> Self {
        Self {
            shift: (cov[(0, 0)] + cov[(1, 1)]).max(0.0).sqrt(),
            turn: cov[(2, 2)].max(0.0).sqrt(),
        }
    }

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

impl Indexed<'_> {
    /// Where the new submap `other` lies in this one; `guess` is `self_from_other`.
    pub(super) fn find(
        &self,
        other: &Self,
        guess: &Pose2,
        doubt: &Doubt,
        matching: &MatchConfig,
        config: &ClosureConfig,
    ) -> Option<Closure> {
        let window = config.window(doubt);
        let reach = &config.match_reach;
        let searched = window.shift > reach.shift || window.turn > reach.turn;
        let points = other.submap.points();
        let found = if searched {
            self.search(other.submap, guess, doubt, &points, matching, config)
        } else {
            let found = register(
                &points,
                self.map(),
                guess,
                &doubt.prior(guess, config),
                matching,
            );
            let is_fixed = matches!(
                found.verdict,
                Verdict::Converged | Verdict::Degenerate { .. }
            );
            is_fixed.then_some(found)
        }?;
        self.closure(other, &found, &points, searched, config)
    }

    /// The best place of `other` within the window of the doubt, matched.
    fn search(
        &self,
        other: &ClosedSubmap,
        guess: &Pose2,
        doubt: &Doubt,
        points: &[OrientedPoint],
        matching: &MatchConfig,
        config: &ClosureConfig,
    ) -> Option<Registration> {
        let mut believed = doubt.prior(guess, config);
        let mut window = config.window(doubt);
        let reach = REACH * (self.submap.radius + other.radius);
        if window.shift > reach {
            // Farther away they would not overlap.
            let turned = guess.rotate(other.centre.coords);
            let place = self.submap.centre - turned;
            believed.pose = Pose2::new(place.x, place.y, guess.heading());
            window.shift = reach;
        }
        let turns = self.submap.facing.turns(&other.facing);
        let heading = guess.heading();
        let admits = |turn: f64| turns.admit(heading + turn);
        let (pivot, search) = (other.centre, &config.search);
        search_turned_and_match(
            points, pivot, self, &believed, &window, admits, search, matching,
        )
    }

    /// Judges a match in both directions; `None` if too little agrees.
    fn closure(
        &self,
        other: &Self,
        found: &Registration,
        points: &[OrientedPoint],
        is_searched: bool,
        config: &ClosureConfig,
    ) -> Option<Closure> {
        let motion = found.estimate.pose;
        let least = if is_searched {
            config.min_agreement_searched
        } else {
            config.min_agreement
        };
        let (old, new) = (self.submap, other.submap);
        let agrees = |way: &Agreement| way.agree >= config.min_agreeing && way.part() >= least;
        let forth = Some(Agreement::of(points, &motion, self.map(), &old.free)).filter(agrees)?;
        let back = Agreement::of(&old.points(), &motion.inverse(), other.map(), &new.free);
        let back = Some(back).filter(agrees)?;
        let floor = pose_cov(config.sigma, config.turn_sigma);
        let weak = Matrix3::from_diagonal_element(config.min_information);
        let cov = (found.information + weak).try_inverse()? + floor;
        Some(Closure {
            motion,
            information: information_at_end(&motion, &cov.try_inverse()?),
            is_searched,
            overlap: forth.overlap().max(back.overlap()),
            part: forth.part().min(back.part()),
        })
    }
}

impl ClosedSubmap {
    /// Closes a submap; `free` is the space seen as free, in its frame.
    pub(super) fn new(surfels: Vec<Surfel>, free: FreeSpace) -> Self {
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
        Self {
            facing: Facing::of(surfels.iter().map(|s| s.normal)),
            surfels,
            free,
            centre,
            radius: (squares / count).sqrt(),
        }
    }

    /// Its surfels, indexed by place.
    fn indexed(&self, config: &SurfelConfig) -> SurfelMap {
        SurfelMap::from_surfels(*config, self.surfels.clone())
    }

    /// Its surfaces, in its frame.
    pub(super) fn surfaces(&self) -> impl ExactSizeIterator<Item = Point2<f64>> + Clone + '_ {
        self.surfels.iter().map(|surfel| surfel.position)
    }

    /// The space that beams passed through.
    pub(super) fn free(&self) -> &FreeSpace {
        &self.free
    }

    /// Its surfaces with their directions, in its frame.
    pub(super) fn oriented(&self) -> impl Iterator<Item = OrientedPoint> + '_ {
        self.surfels.iter().map(|surfel| OrientedPoint {
            position: surfel.position,
            normal: surfel.normal,
        })
    }

    fn points(&self) -> Vec<OrientedPoint> {
        self.oriented().collect()
    }
}

#[cfg(test)]
mod tests;

//! Settings of scan matching, and why it may refuse to start.

use super::super::submap::ClosureConfig;
use crate::bounds::{Bounds, OutOfBounds, check, config};
use crate::map::{EvidenceConfig, GridConfig, GridError, SurfelConfig};
use crate::registration::{MatchConfig, SearchConfig, SearchWindow};

config! {
    /// How scan matching works.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct ScanMatcherConfig {
        /// How submaps are kept.
        pub surfels: SurfelConfig = SurfelConfig::default(),
        /// How scans are matched to them, and submaps to one another.
        pub matching: MatchConfig = MatchConfig::default(),
        /// Where no motion puts more than this part of a scan on the submap, the pose is searched
        /// for, 0 to 1. Default 0.55; larger: more searches.
        pub search_below: f64 = 0.55,
        /// How far is searched beyond what a fast robot goes and turns from scan to scan. Default
        /// 0.3 m and 0.2 rad.
        pub least_window: SearchWindow = SearchWindow {
            shift: 0.3,
            turn: 0.2,
        },
        /// How it is searched for. Default [`SearchConfig::IN_SUBMAP`].
        pub search: SearchConfig = SearchConfig::IN_SUBMAP,
        /// The map that is drawn. By default a crossing beam counts for more than elsewhere (`miss`
        /// 0.3): keyframes are few, and what one of them saw through is to be free.
        pub grid: GridConfig = GridConfig {
            miss: 0.3,
            ..GridConfig::default()
        },
        /// How sure a keyframe has to be of what it draws.
        pub evidence: EvidenceConfig = EvidenceConfig::default(),
        /// A scan becomes a keyframe after this way, m. Default 0.25.
        pub keyframe_distance: f64 = 0.25,
        /// A scan becomes a keyframe after this turn, rad. Default 0.2.
        pub keyframe_turn: f64 = 0.2,
        /// A scan of which a smaller part than this lies on the map becomes a keyframe after
        /// `new_part` of that way and turn. Default 0.6.
        pub new_below: f64 = 0.6,
        /// See `new_below`. Default 0.3; smaller maps new rooms sooner, with more keyframes.
        pub new_part: f64 = 0.3,
        /// Keyframes of one submap, those of the overlap not counted. Default 15; larger drifts
        /// more inside, smaller makes more work.
        pub submap_keyframes: usize = 15,
        /// Keyframes that the next submap takes over from the last. Default 15.
        pub overlap_keyframes: usize = 15,
        /// A submap ends where the robot is farther than this from where it began, and takes over
        /// no keyframes from farther away, m. Default 6: more than fifteen keyframes span unless
        /// scans are far apart, as in a log of which only every metre one was kept. A submap of
        /// several rooms overlaps too little with one of another way through some of them.
        pub submap_reach: f64 = 6.0,
        /// When two submaps are one place.
        pub closure: ClosureConfig = ClosureConfig::default(),
        /// Whether loops are closed. Default true.
        pub close_loops: bool = true,
        /// Keyframes that are redrawn at each scan after a loop closure, at least. Default 3.
        pub redraw_keyframes: usize = 3,
        /// A long map is redrawn within so many scans, however many keyframes each of them has to
        /// draw then. Default 500.
        pub redraw_scans: usize = 500,
        /// The map is redrawn when a submap has moved by this, m. Default 0.1; larger shows closed
        /// loops later.
        pub redraw_shift: f64 = 0.1,
        /// The same for a turn, rad for each metre of `redraw_shift`. Default 0.1: as far as walls
        /// 10 m away move.
        pub redraw_turn: f64 = 0.1,
        /// At the end of a run, what has moved by this part of both is redrawn. Default 0.2.
        pub last_redraw: f64 = 0.2,
        /// Odometry is never believed better than this, m between scans. Default 0.02.
        pub odometry_sigma: f64 = 0.02,
        /// Odometry is never believed better than this, rad between scans. Default 0.02.
        pub odometry_turn_sigma: f64 = 0.02,
        /// The way through a submap is never believed better than this, m. Default 0.01; larger
        /// lets loop closures move more.
        pub submap_sigma: f64 = 0.01,
        /// The turn through a submap is never believed better than this, rad. Default 0.005.
        pub submap_turn_sigma: f64 = 0.005,
    }
}

impl ScanMatcherConfig {
    /// What [`Self::keyframe_distance`] may be, m.
    pub const KEYFRAME_DISTANCE: Bounds = [0.02, 5.0];
    /// What [`Self::keyframe_turn`] may be, rad.
    pub const KEYFRAME_TURN: Bounds = [0.02, 3.0];
    /// What [`Self::submap_keyframes`] may be.
    pub const SUBMAP_KEYFRAMES: Bounds = [2.0, 200.0];

    /// Checks all values.
    ///
    /// # Errors   [`ScanMatcherError`], naming the first one out of its bounds.
    pub fn validate(&self) -> Result<(), ScanMatcherError> {
        let (way, turn) = (self.keyframe_distance, self.keyframe_turn);
        let keyframes = self.submap_keyframes as f64;
        let (proof, least) = (self.closure.proof, self.closure.min_agreement);
        Ok(check(&[
            ("keyframe_distance", way, Self::KEYFRAME_DISTANCE),
            ("keyframe_turn", turn, Self::KEYFRAME_TURN),
            ("submap_keyframes", keyframes, Self::SUBMAP_KEYFRAMES),
            ("closure.proof", proof, ClosureConfig::PROOF),
            ("closure.min_agreement", least, ClosureConfig::MIN_AGREEMENT),
        ])?)
    }
}

/// Why scan matching cannot start.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ScanMatcherError {
    /// A grid setting that is not allowed.
    #[error(transparent)]
    Grid(#[from] GridError),
    /// A value of [`ScanMatcherConfig`] that is out of its bounds.
    #[error("scan matching: {0}")]
    Bounds(#[from] OutOfBounds),
}

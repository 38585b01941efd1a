//! How scan matching works, and why it cannot begin.

use super::super::submap::ClosureConfig;
use crate::map::{EvidenceConfig, GridConfig, GridError, SurfelConfig};
use crate::points::OrientedConfig;
use crate::registration::{LocateConfig, LocateError};

/// How scan matching works.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScanMatcherConfig {
    /// How surfaces are found in it.
    pub oriented: OrientedConfig,
    /// How submaps are kept.
    pub surfels: SurfelConfig,
    /// How scans are located in them, and submaps in one another. Default
    /// [`LocateConfig::in_submap`].
    pub locate: LocateConfig,
    /// The map that is drawn. By default a crossing beam counts for more than elsewhere (`miss`
    /// 0.3): keyframes are few, and what one of them saw through is to be free.
    pub grid: GridConfig,
    /// How sure a keyframe has to be of what it draws.
    pub evidence: EvidenceConfig,
    /// A scan becomes a keyframe after this way, m. Default 0.25.
    pub keyframe_distance: f64,
    /// A scan becomes a keyframe after this turn, rad. Default 0.2.
    pub keyframe_turn: f64,
    /// A scan of which a smaller part than this lies on the map becomes a keyframe after `new_part`
    /// of that way and turn. Default 0.6.
    pub new_below: f64,
    /// See `new_below`. Default 0.3; smaller maps new rooms sooner, with more keyframes.
    pub new_part: f64,
    /// Keyframes of one submap, those of the overlap not counted. Default 15; larger drifts more
    /// inside, smaller makes more work.
    pub submap_keyframes: usize,
    /// Keyframes that the next submap takes over from the last. Default 15.
    pub overlap_keyframes: usize,
    /// When two submaps are one place.
    pub closure: ClosureConfig,
    /// Whether loops are closed. Default true.
    pub close_loops: bool,
    /// Keyframes that are drawn anew at each scan after a loop closure, at least. Default 3.
    pub redraw_keyframes: usize,
    /// A long map is drawn anew within so many scans, however many keyframes each of them has to
    /// draw then. Default 500.
    pub redraw_scans: usize,
    /// The map is drawn anew when a submap has moved by this, m. Default 0.1; larger shows closed
    /// loops later.
    pub redraw_shift: f64,
    /// The same for a turn, rad for each metre of `redraw_shift`. Default 0.1: as far as walls 10 m
    /// away move.
    pub redraw_turn: f64,
    /// At the end of a run, what has moved by this part of both is drawn anew. Default 0.2.
    pub last_redraw: f64,
    /// How far a beam without a return is believed to be free, m. Default 5: glass and black walls
    /// return nothing either.
    pub no_return_clears: f64,
    /// Odometry is never believed better than this, m between scans. Default 0.02.
    pub odometry_sigma: f64,
    /// Odometry is never believed better than this, rad between scans. Default 0.02.
    pub odometry_turn_sigma: f64,
    /// The way through a submap is never believed better than this, m. Default 0.01; larger lets
    /// loop closures move more.
    pub submap_sigma: f64,
    /// The turn through a submap is never believed better than this, rad. Default 0.005.
    pub submap_turn_sigma: f64,
}

impl Default for ScanMatcherConfig {
    fn default() -> Self {
        Self {
            oriented: OrientedConfig::default(),
            surfels: SurfelConfig::default(),
            locate: LocateConfig::in_submap(),
            grid: GridConfig {
                miss: 0.3,
                ..GridConfig::default()
            },
            evidence: EvidenceConfig::default(),
            keyframe_distance: 0.25,
            keyframe_turn: 0.2,
            new_below: 0.6,
            new_part: 0.3,
            submap_keyframes: 15,
            overlap_keyframes: 15,
            closure: ClosureConfig::default(),
            close_loops: true,
            redraw_keyframes: 3,
            redraw_scans: 500,
            redraw_shift: 0.1,
            redraw_turn: 0.1,
            last_redraw: 0.2,
            no_return_clears: 5.0,
            odometry_sigma: 0.02,
            odometry_turn_sigma: 0.02,
            submap_sigma: 0.01,
            submap_turn_sigma: 0.005,
        }
    }
}

impl ScanMatcherConfig {
    /// Checks the figures.
    ///
    /// # Errors   [`ScanMatcherError`], naming the first field out of range.
    pub fn validate(&self) -> Result<(), ScanMatcherError> {
        self.locate.validate()?;
        self.closure.search.validate()?;
        let check = |field, value: f64, low: f64, high: f64, expected| {
            if value >= low && value <= high {
                Ok(())
            } else {
                Err(ScanMatcherError::Config {
                    field,
                    value,
                    expected,
                })
            }
        };
        check(
            "keyframe_distance",
            self.keyframe_distance,
            0.01,
            10.0,
            "from 0.01 to 10 m",
        )?;
        check(
            "keyframe_turn",
            self.keyframe_turn,
            0.01,
            3.2,
            "from 0.01 to 3.2 rad",
        )?;
        check(
            "surfels.cell",
            self.surfels.cell,
            0.01,
            0.5,
            "from 0.01 to 0.5 m",
        )?;
        check(
            "surfels.reach",
            self.surfels.reach,
            0.01,
            2.0,
            "from 0.01 to 2 m",
        )?;
        check(
            "submap_keyframes",
            self.submap_keyframes as f64,
            2.0,
            1e4,
            "from 2 to 10000",
        )
    }
}

/// Why scan matching cannot begin.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ScanMatcherError {
    /// The grid's figures.
    #[error(transparent)]
    Grid(#[from] GridError),
    /// How scans are located.
    #[error("scan matching: {0}")]
    Locate(#[from] LocateError),
    /// A field outside of its range.
    #[error("scan matching: {field} is {value}, expected {expected}")]
    Config {
        /// The field.
        field: &'static str,
        /// What stands there.
        value: f64,
        /// What may stand there.
        expected: &'static str,
    },
}

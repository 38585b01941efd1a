//! Sonars beside the sensor that gives the pose: they have a grid of their own, drawn by their own
//! model.
//!
//! Their scans do not change the pose. Each is moved into the robot's frame by odometry and drawn
//! as cones at the pose that is believed at that moment. When a scan matcher redraws its map after
//! a loop closure, this grid is not redrawn.

use super::{Slam, SlamError};
use crate::bounds::config;
use crate::map::{Evidence, EvidenceConfig, Grid, GridConfig, Layer, Layers};
use crate::points::Points;
use crate::robot::Scan;

config! {
    /// What sonars beside the main sensor draw, and which map is shown.
    #[derive(Clone, Debug, PartialEq)]
    pub struct SonarsConfig {
        /// How their echoes change their grid. Default: hit 0.6, miss 0.45, for an echo says less
        /// than a beam of light; the cells are as large as those of the main grid whatever stands
        /// here.
        pub grid: GridConfig = GridConfig {
            hit: 0.6,
            miss: 0.45,
            ..GridConfig::default()
        },
        /// Their cones. Default: half an opening of 15°.
        pub evidence: EvidenceConfig = EvidenceConfig::cones(0.262),
        /// Which map is shown. Default the main one.
        pub shown: Layer = Layer::Main,
    }
}

impl Slam {
    /// Takes one round of the sonars, whose last ping was at or before the end of the newest
    /// odometry.
    ///
    /// # Errors    [`SlamError::Scan`] for a scan that breaks its invariants; [`SlamError::Grid`]
    /// for a setting out of range.
    pub fn sonar_scan(&mut self, scan: &Scan) -> Result<(), SlamError> {
        scan.validate()?;
        let config = &self.config.sonars;
        let points = Points::from_rolling_scan(scan, &self.history, &self.config.points);
        let pose = self.estimate().pose;
        let resolution = self.grid().resolution();
        let grid = match &mut self.sonar_grid {
            Some(grid) => grid,
            none => none.insert(Grid::new(GridConfig {
                resolution,
                ..config.grid
            })?),
        };
        grid.draw(
            &Evidence::certain(&points, &[], resolution, &config.evidence),
            &pose,
        );
        Ok(())
    }

    /// The grids, and which of them is shown.
    #[must_use]
    pub fn layers(&self) -> Layers<'_> {
        Layers {
            main: self.grid(),
            sonar: self.sonar_grid.as_ref(),
            shown: self.config.sonars.shown,
        }
    }

    /// Changes when the shown grid was redrawn or replaced.
    #[must_use]
    pub fn shown_version(&self) -> u64 {
        let count = Layer::ALL.len() as u64;
        // Before the first sonar scan only the main map can be shown.
        let shown = (self.sonar_grid.as_ref()).map_or(Layer::Main, |_| self.config.sonars.shown);
        let at = Layer::ALL.iter().position(|(_, layer, _)| *layer == shown);
        self.grid_version() * count + at.unwrap_or(0) as u64
    }
}

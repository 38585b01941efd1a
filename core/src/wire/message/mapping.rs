//! What a bridge that maps reports of its map and of the robot's pose in it.

use serde::{Deserialize, Serialize};

use super::names::named;
use crate::format::map_server::{MOST_CELLS, NOTHING_KNOWN, OccupancyMap};
use crate::geom::{Pose2, PoseEstimate};

named! {
    /// Whether the bridge's pose is to be believed.
    #[derive(Default)]
    pub enum PoseState {
        /// It has not seen enough to say.
        #[default]
        Unknown = "unknown",
        /// To be believed.
        Localised = "localised",
        /// One of several.
        Ambiguous = "ambiguous",
        /// Not to be believed.
        Lost = "lost",
        /// It is known where the robot is in what was mapped since the start, and not where that
        /// lies in the saved map.
        Unplaced = "unplaced",
    }
}

/// Where the robot is in the bridge's map.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PoseBody {
    /// End of the newest odometry in the pose, µs of the robot's clock.
    pub stamp: u64,
    /// `map_from_robot`: x, y (m), heading (rad).
    pub pose: [f64; 3],
    /// xx, xy, xθ, yy, yθ, θθ.
    pub cov: [f64; 6],
    /// Whether it is to be believed.
    pub state: PoseState,
}

impl PoseBody {
    /// To the wire.
    #[must_use]
    pub fn new(stamp: u64, estimate: &PoseEstimate, state: PoseState) -> Self {
        let (pose, c) = (&estimate.pose, &estimate.cov);
        let (xx, xy, xt) = (c[(0, 0)], c[(0, 1)], c[(0, 2)]);
        let (yy, yt, tt) = (c[(1, 1)], c[(1, 2)], c[(2, 2)]);
        Self {
            stamp,
            pose: [pose.x(), pose.y(), pose.heading()],
            cov: [xx, xy, xt, yy, yt, tt],
            state,
        }
    }

    /// From the wire; `None` if a number is not finite.
    #[must_use]
    pub fn estimate(&self) -> Option<PoseEstimate> {
        let [x, y, heading] = self.pose;
        let [xx, xy, xt, yy, yt, tt] = self.cov;
        let is_finite = self.pose.iter().chain(&self.cov).all(|n| n.is_finite());
        is_finite.then(|| PoseEstimate {
            pose: Pose2::new(x, y, heading),
            cov: nalgebra::Matrix3::new(xx, xy, xt, xy, yy, yt, xt, yt, tt),
        })
    }
}

/// The bridge's whole map: the state of each cell of a rectangle.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MapBody {
    /// Increases with each new map.
    pub revision: u64,
    /// Side of a cell, m.
    pub cell: f64,
    /// The lower left corner of the lower left cell, map frame: x, y, m.
    pub corner: [f64; 2],
    /// Cells in a row.
    pub width: u32,
    /// Rows; 0 if no cell of the map is known.
    pub height: u32,
    /// The cells row by row, the lowest first, as runs of equal cells: four times their number,
    /// plus 0 for unknown, 1 for free, 2 for occupied.
    pub runs: Vec<u32>,
}

/// Why a map from the wire is invalid.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MapBodyError {
    /// More cells than a map may have.
    #[error("the map has {width} x {height} cells; {MOST_CELLS} are possible")]
    TooLarge {
        /// Cells in a row.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// The size or the place of the cells is invalid.
    #[error(
        "the map's cells are of {cell} m, from ({x}, {y}) on: expected finite numbers, and a size above 0"
    )]
    Cell {
        /// Side of a cell.
        cell: f64,
        /// Of the corner.
        x: f64,
        /// Of the corner.
        y: f64,
    },
    /// A run of cells of an unknown kind.
    #[error("run {at} of the map is of cells of kind {kind}; expected 0 to 2")]
    Kind {
        /// Number of the run, from 0.
        at: usize,
        /// Kind of its cells.
        kind: u32,
    },
    /// More or fewer cells than the rectangle has.
    #[error("the map's runs have {found} cells; expected {expected}")]
    Count {
        /// Cells in the runs.
        found: u64,
        /// Cells of the rectangle.
        expected: u64,
    },
}

const UNKNOWN: u32 = 0;
const FREE: u32 = 1;
const OCCUPIED: u32 = 2;

impl MapBody {
    /// To the wire. A cell is occupied if its probability of being occupied is above one half.
    #[must_use]
    pub fn new(revision: u64, map: &OccupancyMap) -> Self {
        let kinds = map.cells.iter().map(|&cell| match cell {
            NOTHING_KNOWN => UNKNOWN,
            ..=50 => FREE,
            _ => OCCUPIED,
        });
        let mut runs: Vec<u32> = vec![];
        for kind in kinds {
            match runs.last_mut() {
                Some(run) if *run % 4 == kind => *run += 4,
                _ => runs.push(4 + kind),
            }
        }
        Self {
            revision,
            cell: map.resolution,
            corner: [map.origin.x(), map.origin.y()],
            width: map.width as u32,
            height: map.height as u32,
            runs,
        }
    }

    /// From the wire.
    ///
    /// # Errors    [`MapBodyError`]; memory is allocated only for a valid map.
    pub fn map(&self) -> Result<OccupancyMap, MapBodyError> {
        let (width, height) = (self.width, self.height);
        let expected = u64::from(width) * u64::from(height);
        if expected > MOST_CELLS as u64 {
            return Err(MapBodyError::TooLarge { width, height });
        }
        let ([x, y], cell) = (self.corner, self.cell);
        if !(x.is_finite() && y.is_finite() && cell.is_finite() && cell > 0.0) {
            return Err(MapBodyError::Cell { cell, x, y });
        }
        let mut found = 0;
        for (at, run) in self.runs.iter().enumerate() {
            let kind = run % 4;
            if kind > OCCUPIED {
                return Err(MapBodyError::Kind { at, kind });
            }
            found += u64::from(run / 4);
        }
        if found != expected {
            return Err(MapBodyError::Count { found, expected });
        }
        let mut cells = Vec::with_capacity(expected as usize);
        for run in &self.runs {
            let cell = match run % 4 {
                FREE => 0,
                OCCUPIED => 100,
                _ => NOTHING_KNOWN,
            };
            cells.resize(cells.len() + (run / 4) as usize, cell);
        }
        Ok(OccupancyMap {
            width: width as usize,
            height: height as usize,
            resolution: cell,
            origin: Pose2::new(x, y, 0.0),
            cells,
        })
    }
}

/// State of a bridge that maps.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MappingBody {
    /// Name of the method.
    pub method: String,
    /// Scans processed since the map began in this run.
    pub scans: u64,
    /// Name of the file that holds the map, without its folder; empty for none.
    pub file: String,
    /// Scans that are in the file.
    pub saved: u64,
    /// Why the file is older than it should be; none while all is well.
    pub fault: Option<String>,
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn map(width: usize, cells: Vec<i8>) -> OccupancyMap {
        OccupancyMap {
            width,
            height: cells.len() / width,
            resolution: 0.05,
            origin: Pose2::new(-1.0, 2.0, 0.0),
            cells,
        }
    }

    #[test]
    fn runs_go_on_from_row_to_row() {
        let body = MapBody::new(3, &map(3, vec![-1, -1, 0, 0, 0, 100]));
        assert_eq!(body.runs, [2 * 4, 3 * 4 + 1, 4 + 2]);
        assert_eq!((body.width, body.height, body.revision), (3, 2, 3));
    }

    #[test]
    fn what_is_no_map_is_refused_with_its_place() {
        let good = MapBody::new(1, &map(2, vec![0, 100, -1, -1]));
        let check = |spoil: &dyn Fn(&mut MapBody), expect: &str| {
            let mut body = good.clone();
            spoil(&mut body);
            let error = body.map().unwrap_err().to_string();
            assert!(error.contains(expect), "{error}");
        };
        check(&|map| map.width = u32::MAX, "4294967295 x 2 cells");
        check(&|map| map.cell = 0.0, "cells are of 0 m");
        check(&|map| map.cell = f64::NAN, "cells are of NaN m");
        check(&|map| map.corner[1] = f64::INFINITY, "(-1, inf)");
        check(
            &|map| map.runs[1] = 7,
            "run 1 of the map is of cells of kind 3",
        );
        check(&|map| map.runs[0] = u32::MAX - 2, "expected 4");
        check(&|map| map.runs.truncate(1), "have 1 cells; expected 4");
    }

    proptest! {
        #[test]
        fn every_map_comes_back(width in 1_usize..9, rows in prop::collection::vec(0_u8..3, 0..9)) {
            let kind = |kind: &u8| match kind { 0 => NOTHING_KNOWN, 1 => 0, _ => 100 };
            let cells = rows.iter().flat_map(|row| vec![kind(row); width]).collect();
            let map = map(width, cells);
            prop_assert_eq!(MapBody::new(1, &map).map().unwrap(), map);
        }

        #[test]
        fn whatever_comes_is_a_map_of_its_size_or_an_error(
            width in any::<u32>(),
            height in any::<u32>(),
            cell in any::<f64>(),
            runs in prop::collection::vec(any::<u32>(), 0..20),
        ) {
            let body = MapBody { revision: 0, cell, corner: [0.0; 2], width, height, runs };
            if let Ok(map) = body.map() {
                prop_assert_eq!(map.cells.len(), width as usize * height as usize);
            }
        }
    }
}

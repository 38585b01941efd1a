//! A submap of points as a grid, to drive in or to be localised in.
//!
//! 1. A cell in which a point lies is occupied.
//! 2. What the robot could reach from its path without crossing an occupied cell is free: a submap
//!    does not record what was seen to be free. Without a path, every other cell is free.

use nalgebra::Point2;

use super::{BuildingError, MOST_CELLS};
use crate::format::map_server::{NOTHING_KNOWN, OccupancyMap};
use crate::format::smap::Smap;
use crate::geom::Pose2;

/// Side of a cell, m: the same as in the program's own grids, so a map that was saved comes back as
/// it was.
const RESOLUTION: f64 = 0.05;
/// Margin around all points and the path, in cells.
const MARGIN: f64 = 1.0;
const OCCUPIED: i8 = 100;
const FREE: i8 = 0;

/// The cells of a submap, in its frame.
///
/// # Errors    [`BuildingError::NoWalls`], [`BuildingError::TooLarge`].
pub(super) fn map_of(submap: &Smap) -> Result<OccupancyMap, BuildingError> {
    if submap.points.is_empty() {
        return Err(BuildingError::NoWalls);
    }
    let cell = |place: &Point2<f64>| place.map(|metres| (metres / RESOLUTION).floor());
    let all = || submap.points.iter().chain(&submap.path).map(cell);
    let first = all().fold([f64::INFINITY; 2], |[x, y], at| [x.min(at.x), y.min(at.y)]);
    let last = all().fold([f64::NEG_INFINITY; 2], |[x, y], at| {
        [x.max(at.x), y.max(at.y)]
    });
    let [x, y] = first.map(|low| low - MARGIN);
    let [width, height] = [last[0] - x, last[1] - y].map(|cells| cells + MARGIN + 1.0);
    let most = MOST_CELLS;
    if width * height > most as f64 {
        let cells = (width * height) as usize;
        return Err(BuildingError::TooLarge { cells, most });
    }
    let mut map = OccupancyMap {
        width: width as usize,
        height: height as usize,
        resolution: RESOLUTION,
        origin: Pose2::new(x * RESOLUTION, y * RESOLUTION, 0.0),
        cells: vec![NOTHING_KNOWN; width as usize * height as usize],
    };
    let index = |at: Point2<f64>| (at.y - y) as usize * map.width + (at.x - x) as usize;
    for at in submap.points.iter().map(cell).map(index) {
        map.cells[at] = OCCUPIED;
    }
    let reached = match submap.path.is_empty() {
        true => (0..map.cells.len()).collect(),
        false => submap.path.iter().map(cell).map(index).collect(),
    };
    flood(&mut map, reached);
    Ok(map)
}

/// Step 2.
fn flood(map: &mut OccupancyMap, mut reached: Vec<usize>) {
    let width = map.width;
    while let Some(at) = reached.pop() {
        let Some(cell) = map.cells.get_mut(at).filter(|cell| **cell == NOTHING_KNOWN) else {
            continue;
        };
        *cell = FREE;
        // After the end of a row comes the margin of the next, which is outside as well.
        reached.extend([
            at.wrapping_sub(1),
            at + 1,
            at.wrapping_sub(width),
            at + width,
        ]);
    }
}

//! What a map shows: where walls stand, and what can be seen along a trajectory.

use std::f64::consts::TAU;

use nalgebra::Point2;

use crate::geom::{Length, Pose2, unit_vector};
use crate::map::{Evidence, Grid, GridConfig, GridError};
use crate::points::thinned;

/// At most this many positions of a trajectory are used, ...
const MOST_PLACES: usize = 60;
/// ... with this many directions, ...
const DIRECTIONS: i32 = 360;
/// ... up to this distance, m. ...
const SIGHT: f64 = 8.0;
/// ... A wall point hides what is behind it up to this far to either side, m: wall points are this
/// close together. ...
const HIDES: f64 = 0.1;
/// ... This much in front of it may belong to the wall, m.
const BEFORE: f64 = 0.2;

/// The space visible from the positions of a trajectory, up to the nearest wall in each direction.
pub(super) fn seen_from(way: &[Point2<f64>], walls: &[Point2<f64>]) -> Result<Grid, GridError> {
    let per_direction = TAU / f64::from(DIRECTIONS);
    let mut free = vec![];
    for place in thinned(way, MOST_PLACES, 0) {
        let mut nearest = [f64::INFINITY; DIRECTIONS as usize];
        for wall in walls {
            let off = wall - place;
            let range = off.length();
            if !(HIDES..SIGHT).contains(&range) {
                continue;
            }
            let middle = (libm::atan2(off.y, off.x) / per_direction).round() as i32;
            let wide = (HIDES / range / per_direction).ceil() as i32;
            for direction in middle - wide..=middle + wide {
                let direction = direction.rem_euclid(DIRECTIONS) as usize;
                nearest[direction] = nearest[direction].min(range);
            }
        }
        let seen = nearest
            .iter()
            .enumerate()
            .filter(|(_, range)| range.is_finite());
        free.extend(
            seen.filter(|(_, range)| **range > BEFORE)
                .map(|(direction, range)| {
                    let along = unit_vector(direction as f64 * per_direction);
                    [place, place + along * (range - BEFORE)]
                }),
        );
    }
    let evidence = Evidence {
        free,
        hits: walls.to_vec(),
    };
    let mut grid = Grid::new(GridConfig::default())?;
    // A cell is believed only if it was seen repeatedly.
    for _ in 0..3 {
        grid.draw(&evidence, &Pose2::identity());
    }
    Ok(grid)
}

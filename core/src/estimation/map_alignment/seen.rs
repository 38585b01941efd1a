//! What a map shows: where walls stand, and what can be seen from a way.

use std::f64::consts::TAU;

use nalgebra::Point2;

use crate::geom::{Length, Pose2, unit_vector};
use crate::map::{Evidence, Grid, GridConfig, GridError};
use crate::points::thinned;

/// From so many places of a way is looked around at most, ...
const MOST_PLACES: usize = 60;
/// ... in so many directions, ...
const DIRECTIONS: i32 = 360;
/// ... this far, m. ...
const SIGHT: f64 = 8.0;
/// ... A point of a wall hides what is behind it this far to either side, m: points of a wall stand
/// so close. ...
const HIDES: f64 = 0.1;
/// ... Before it, this much may be the wall's, m.
const BEFORE: f64 = 0.2;

/// What can be seen from the places of a way, as far as the nearest wall in each direction.
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
    // A cell is believed that was seen again.
    for _ in 0..3 {
        grid.draw(&evidence, &Pose2::identity());
    }
    Ok(grid)
}

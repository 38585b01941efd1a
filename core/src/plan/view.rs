//! The area visible from a place: the gain of the next best view.
//!
//! In: the states of the grid, a place, the sensor's range. Out: the unknown area that the sensor
//! would see from there.
//!
//! 1. Rays all round, one cell apart at their far ends, walk from cell to cell until they meet an
//!    occupied one.
//! 2. Unknown cells on their way are counted once each. Whatever lies behind unknown cells may be
//!    hidden, so a ray ends after [`DEPTH`] of them.
//!
//! Source: González-Baños & Latombe (2002), "Navigation strategies for exploring indoor
//! environments", §4.2: the candidate's gain is the area that could be visible through the free
//! borders of what is known.

use std::f64::consts::TAU;

use super::cspace::GridSpace;
use crate::geom::sin_cos;
use crate::map::CellState;

/// Length of unknown way up to which a ray is taken to see, m.
const DEPTH: f64 = 1.0;

/// The unknown area, m², that a sensor of `sight` (m) would see from the centre of a cell; 0 for a
/// sight of less than a cell.
pub(super) fn view_gain(space: &GridSpace, from: usize, sight: f64) -> f64 {
    let resolution = space.resolution();
    let (width, states) = (space.rect().width(), space.states());
    let height = states.len() / width.max(1);
    let cells = sight / resolution;
    let rays = (TAU * cells).ceil() as usize;
    let middle = ((from % width) as f64 + 0.5, (from / width) as f64 + 0.5);
    let mut seen = vec![];
    for ray in 0..rays {
        let (sin, cos) = sin_cos(TAU * ray as f64 / rays as f64);
        let mut unknown = 0.0;
        for step in 1..=cells as usize {
            let (x, y) = (middle.0 + cos * step as f64, middle.1 + sin * step as f64);
            if x < 0.0 || y < 0.0 || x >= width as f64 || y >= height as f64 {
                break;
            }
            let at = y as usize * width + x as usize;
            match states[at] {
                CellState::Occupied => break,
                CellState::Free => {}
                CellState::Unknown => {
                    seen.push(at);
                    unknown += resolution;
                }
            }
            if unknown >= DEPTH {
                break;
            }
        }
    }
    seen.sort_unstable();
    seen.dedup();
    seen.len() as f64 * resolution * resolution
}

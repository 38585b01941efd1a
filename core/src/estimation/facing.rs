//! In which directions the surfaces of a place face: which rotations between two maps are possible.
//!
//! In: the normals of surfaces. Out: a histogram of their directions, and for each rotation between
//! two histograms how well they agree. Buildings have few wall directions, so most rotations are
//! ruled out without looking at the positions of the surfaces.
//!
//! Source: Weiss & von Puttkamer (1995), "A map based on laserscans without geometric
//! interpretation" (angle histograms).

use std::f64::consts::TAU;

use nalgebra::Vector2;

/// Number of directions that are distinguished.
const BINS: usize = 120;
/// Rotations with less than this part of the best agreement are ruled out.
const LEAST_PART: f64 = 0.6;

/// How many surfaces face each way, smoothed, normalised to length 1.
#[derive(Clone, Debug)]
pub(super) struct Facing {
    bins: [f32; BINS],
}

impl Default for Facing {
    fn default() -> Self {
        Self { bins: [0.0; BINS] }
    }
}

impl Facing {
    pub(super) fn of(normals: impl Iterator<Item = Vector2<f64>>) -> Self {
        let mut counts = [0.0_f32; BINS];
        for normal in normals {
            counts[bin(libm::atan2(normal.y, normal.x))] += 1.0;
        }
        let mut bins = [0.0; BINS];
        for (at, out) in bins.iter_mut().enumerate() {
            let near = |by: usize| counts[(at + by) % BINS];
            // A normal is only known to a few degrees.
            *out = near(BINS - 2) + 2.0 * near(BINS - 1) + 3.0 * near(0) + 2.0 * near(1) + near(2);
        }
        let length = bins.iter().map(|b| b * b).sum::<f32>().sqrt();
        if length > 0.0 {
            bins.iter_mut().for_each(|b| *b /= length);
        }
        Self { bins }
    }

    /// The rotations of `other` relative to this one that may be right.
    pub(super) fn turns(&self, other: &Self) -> Turns {
        let mut agreement = [0.0_f32; BINS];
        for (turn, out) in agreement.iter_mut().enumerate() {
            let pairs = (0..BINS).map(|b| self.bins[(b + turn) % BINS] * other.bins[b]);
            *out = pairs.sum();
        }
        let best = agreement.iter().copied().fold(0.0, f32::max);
        Turns {
            admitted: agreement.map(|a| f64::from(a) >= LEAST_PART * f64::from(best)),
        }
    }
}

/// The rotations that may be right.
#[derive(Clone, Debug)]
pub(super) struct Turns {
    admitted: [bool; BINS],
}

impl Turns {
    /// Whether a rotation, rad, may be right.
    pub(super) fn admit(&self, turn: f64) -> bool {
        self.admitted[bin(turn)]
    }
}

fn bin(angle: f64) -> usize {
    let turns = angle / TAU;
    let part = turns - turns.floor();
    ((part * BINS as f64 + 0.5) as usize) % BINS
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::unit_vector;

    #[test]
    fn a_room_may_be_turned_by_quarters_and_nothing_between() {
        let room = |turn: f64| {
            let walls = [
                (0.0, 60),
                (TAU / 4.0, 40),
                (TAU / 2.0, 60),
                (-TAU / 4.0, 40),
            ];
            let normals = walls
                .into_iter()
                .flat_map(move |(angle, count)| (0..count).map(move |_| unit_vector(angle + turn)));
            Facing::of(normals)
        };
        for turn in [0.0, 0.3, 1.1, -2.0, 3.0] {
            let turns = room(turn).turns(&room(0.0));
            assert!(turns.admit(turn) && turns.admit(turn + TAU / 2.0), "{turn}");
            assert!(!turns.admit(turn + TAU / 8.0), "{turn}");
        }
    }
}

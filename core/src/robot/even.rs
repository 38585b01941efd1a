//! Beams at equal angles, for files and messages that store no other angles.
//!
//! In: the bearings of a scan, in any order. Out: a first direction, a step, and the beam for each
//! direction.
//!
//! 1. Bearings that rise or fall evenly are kept, in rising order.
//! 2. For others, the fan begins after the widest gap between neighbours, because a sensor may look
//!    backwards, over ±π. If beams lie all round, no gap is wider than the one at the back by two
//!    steps, and the fan begins there.
//! 3. It has as many directions as there are beams. A beam is assigned to the nearest direction, at
//!    most half a step away. Of two, the nearer reading counts, and a number goes before none.

use std::f64::consts::TAU;

use crate::geom::wrap;

/// Steps between beams that differ by more than this part of a step are uneven.
const EVEN: f64 = 1e-3;

/// Beams of a scan at equal angles, counter-clockwise.
#[derive(Clone, Debug, PartialEq)]
pub struct EvenBeams {
    /// First direction, rad, wrapped.
    pub first: f64,
    /// Angle between adjacent directions, rad, at least 0.
    pub step: f64,
    /// Index of the beam for each direction; `None` if no beam is near enough.
    pub beams: Vec<Option<usize>>,
}

impl EvenBeams {
    /// The beams of a scan with these bearings (rad, finite) and ranges (m).
    #[must_use]
    pub fn of(bearings: &[f64], ranges: &[f32]) -> Self {
        Self::in_order(bearings).unwrap_or_else(|| Self::by_direction(bearings, ranges))
    }

    /// The values of a column of the scan, in order of direction; `none` where no beam is near
    /// enough.
    #[must_use]
    pub fn pick<T: Copy>(&self, column: &[T], none: T) -> Vec<T> {
        let of = |beam: &Option<usize>| beam.and_then(|beam| column.get(beam)).copied();
        self.beams.iter().map(|b| of(b).unwrap_or(none)).collect()
    }

    /// Step 1.
    fn in_order(bearings: &[f64]) -> Option<Self> {
        let steps = || bearings.windows(2).map(|pair| wrap(pair[1] - pair[0]));
        let count = bearings.len();
        let step = steps().sum::<f64>() / count.saturating_sub(1).max(1) as f64;
        if !steps().all(|s| (s - step).abs() <= EVEN * step.abs()) {
            return None;
        }
        let (first, beams) = match step < 0.0 {
            true => (bearings.last(), (0..count).rev().map(Some).collect()),
            false => (bearings.first(), (0..count).map(Some).collect()),
        };
        Some(Self {
            first: first.map_or(0.0, |first| wrap(*first)),
            step: step.abs(),
            beams,
        })
    }

    /// Steps 2 and 3.
    fn by_direction(bearings: &[f64], ranges: &[f32]) -> Self {
        let (first, span) = fan(bearings);
        let count = bearings.len();
        let step = span / count.saturating_sub(1).max(1) as f64;
        let mut beams: Vec<Option<usize>> = vec![None; count];
        for (beam, (bearing, range)) in bearings.iter().zip(ranges).enumerate() {
            let from_first = wrap(*bearing) - first;
            let turned = if from_first < 0.0 {
                from_first + TAU
            } else {
                from_first
            };
            // If all bearings are equal, there is no step.
            let at = if step > 0.0 {
                (turned / step).round() as usize
            } else {
                0
            };
            let Some(known) = beams.get_mut(at) else {
                continue;
            };
            let before = known.and_then(|known| ranges.get(known));
            if before.is_none_or(|before| before.is_nan() || range < before) {
                *known = Some(beam);
            }
        }
        Self { first, step, beams }
    }
}

/// First direction (wrapped) of the narrowest fan that holds all of them, and its width; if they
/// lie all round, it begins at -π.
fn fan(bearings: &[f64]) -> (f64, f64) {
    let mut sorted: Vec<f64> = bearings.iter().map(|bearing| wrap(*bearing)).collect();
    sorted.sort_by(f64::total_cmp);
    let (Some(&least), Some(&most)) = (sorted.first(), sorted.last()) else {
        return (0.0, 0.0);
    };
    let gaps = sorted.windows(2).map(|pair| (pair[1] - pair[0], pair));
    let widest = gaps.max_by(|a, b| a.0.total_cmp(&b.0));
    let at_back = least + TAU - most;
    match widest {
        Some((gap, &[before, behind])) if gap > at_back + 2.0 * TAU / sorted.len() as f64 => {
            (behind, before + TAU - behind)
        }
        _ => (least, most - least),
    }
}

#[cfg(test)]
mod tests;

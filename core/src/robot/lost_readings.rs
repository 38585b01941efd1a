//! Where a turning sensor has lost readings. A [`super::Scan`] is evenly spaced in time, so a
//! missing reading needs a place of its own; otherwise the others would seem to be taken at other
//! instants.
//!
//! In: how far the sensor had turned at each reading of one revolution. Out: the places of the
//! revolution in order, each with its reading or lost.
//!
//! The usual step is the median of the steps between neighbours. A step of [`GAP`] times that or
//! more is filled with places at equal angles; a smaller one is the sensor's own unevenness. The
//! revolution begins and ends half a step beyond its outermost places.

use std::f64::consts::{PI, TAU};

/// Readings were lost if a step is this many times the usual one. Greater: short losses are
/// mistaken for unevenness.
const GAP: f64 = 5.0;
/// Least median step of a turning sensor, rad: a hundredth of a degree. No sensor is finer, and it
/// bounds the number of places in a revolution.
const LEAST_STEP: f64 = 0.01 * PI / 180.0;

/// A place in a revolution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Place {
    /// Holds the reading with this index.
    Taken(usize),
    /// Its reading was lost; the sensor had turned this far, rad.
    Lost(f64),
}

/// All places of a revolution.
///
/// # Units    `turned`: from the beginning of the revolution to each reading, rad, rising from 0 to
/// less than 2π apart from jitter. If the median step is below a hundredth of a degree, no place is
/// lost.
#[must_use]
pub fn places_of_revolution(turned: &[f64]) -> Vec<Place> {
    let taken = (0..turned.len()).map(Place::Taken);
    let Some(spacing) = median_step(turned) else {
        return taken.collect();
    };
    let mut places = Vec::with_capacity(turned.len());
    let mut before = -0.5 * spacing;
    for (reading, &at) in taken.zip(turned) {
        places.extend(lost(before, at, spacing));
        places.push(reading);
        before = at;
    }
    places.extend(lost(before, TAU + 0.5 * spacing, spacing));
    places
}

/// The places that were lost between two angles.
fn lost(from: f64, to: f64, spacing: f64) -> impl Iterator<Item = Place> {
    let steps = (to - from) / spacing;
    let missing = match steps < GAP {
        true => 0,
        false => steps.round() as usize - 1,
    };
    let at = move |k: usize| from + (to - from) * k as f64 / (missing + 1) as f64;
    (1..=missing).map(move |k| Place::Lost(at(k)))
}

/// The usual angle from one reading to the next; `None` if the sensor does not turn.
fn median_step(turned: &[f64]) -> Option<f64> {
    let mut steps: Vec<f64> = turned.windows(2).map(|pair| pair[1] - pair[0]).collect();
    steps.sort_by(f64::total_cmp);
    let median = steps.get(steps.len() / 2).copied();
    median.filter(|&step| step > LEAST_STEP)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const READINGS: usize = 360;

    fn angle(reading: usize) -> f64 {
        TAU * (reading as f64 + 0.5) / READINGS as f64
    }

    proptest! {
        /// Whichever stretch is lost, each reading keeps its place, and so its instant.
        #[test]
        fn the_others_stay_in_their_places(first in 0..READINGS, count in 5..300_usize) {
            let is_lost = |reading: usize| (first..first + count).contains(&reading);
            let kept: Vec<usize> = (0..READINGS).filter(|r| !is_lost(*r)).collect();
            prop_assume!(kept.len() > 10 && kept.len() < READINGS - 5);
            let turned: Vec<f64> = kept.iter().map(|r| angle(*r)).collect();
            let places = places_of_revolution(&turned);
            prop_assert_eq!(places.len(), READINGS);
            for (at, place) in places.iter().enumerate() {
                match place {
                    Place::Taken(reading) => prop_assert_eq!(kept[*reading], at),
                    Place::Lost(turned) => {
                        prop_assert!(is_lost(at));
                        prop_assert!((turned - angle(at)).abs() < 0.5 * TAU / READINGS as f64);
                    }
                }
            }
        }

        #[test]
        fn whatever_comes_each_reading_stands_there_once_and_in_order(
            turned in proptest::collection::vec(-10.0..10.0_f64, 0..40),
        ) {
            let places = places_of_revolution(&turned);
            let taken = places.iter().filter_map(|place| match place {
                Place::Taken(reading) => Some(*reading),
                Place::Lost(_) => None,
            });
            prop_assert!(taken.eq(0..turned.len()));
        }
    }

    #[test]
    fn a_sensor_that_does_not_turn_or_turns_the_other_way_lost_nothing() {
        let taken = [0, 1, 2].map(Place::Taken);
        for turned in [[1.0, 1.0, 1.0], [3.0, 2.0, 1.0]] {
            assert_eq!(places_of_revolution(&turned), taken);
        }
        assert_eq!(places_of_revolution(&[]), []);
    }
}

//! How much more a robot has turned than its odometry reports, from two scans.
//!
//! In: the hits of two scans, both from the same place and in the same frame according to odometry.
//! Out: the turn by which the older one fits the newer one best.
//!
//! 1. Each scan becomes a profile: the range of the nearest hit in each degree.
//! 2. One profile is shifted against the other, degree by degree; the mean difference of their
//!    ranges, each capped at [`FAR`], is least at the turn. A parabola through the minimum and its
//!    neighbours gives the turn to a fraction of a degree.
//! 3. Walkers differ between the scans, but they are few.
//!
//! Source: Diosi & Kleeman (2005), "Laser scan matching in polar coordinates with application to
//! SLAM", orientation step.

use std::f64::consts::TAU;

use nalgebra::Vector2;

use crate::geom::Length;

/// Bins of a profile: one for each degree.
const BINS: usize = 360;
/// Greatest difference of two ranges that counts, m.
const FAR: f64 = 0.3;
/// Least number of bins that both scans have to fill.
const OVERLAP: usize = BINS / 4;

/// The turn (rad, at most `most` to either side) that takes `before` onto `now`; both are vectors
/// from the sensor, m. 0 if too little is seen.
pub(super) fn between(
    before: impl Iterator<Item = Vector2<f64>>,
    now: impl Iterator<Item = Vector2<f64>>,
    most: f64,
) -> f64 {
    let bin = TAU / BINS as f64;
    let shifts = (most / bin).floor() as i32;
    if shifts < 1 {
        return 0.0;
    }
    let (before, now) = (profile(before), profile(now));
    // One more on each side, for the parabola.
    let tried = -shifts - 1..=shifts + 1;
    let off: Vec<f64> = tried.map(|s| difference(&before, &now, s)).collect();
    let inner = 1..off.len() - 1;
    // Of turns that fit equally well, the smallest.
    let (none, shifts) = (shifts as usize + 1, f64::from(shifts + 1));
    let by_difference = |a: &usize, b: &usize| {
        let turns = a.abs_diff(none).cmp(&b.abs_diff(none));
        off[*a].total_cmp(&off[*b]).then(turns)
    };
    let best = inner.min_by(by_difference).unwrap_or(none);
    let (left, middle, right) = (off[best - 1], off[best], off[best + 1]);
    let bend = left - 2.0 * middle + right;
    let part = match bend.is_finite() && bend > 0.0 {
        true => (0.5 * (left - right) / bend).clamp(-0.5, 0.5),
        false => 0.0,
    };
    match middle.is_finite() {
        true => (best as f64 + part - shifts) * bin,
        false => 0.0,
    }
}

/// Ranges by direction; infinite if nothing was hit.
fn profile(hits: impl Iterator<Item = Vector2<f64>>) -> Vec<f64> {
    let mut ranges = vec![f64::INFINITY; BINS];
    for hit in hits {
        let part = libm::atan2(hit.y, hit.x) / TAU;
        let bin = (part * BINS as f64).round() as i32;
        let bin = bin.rem_euclid(BINS as i32) as usize;
        ranges[bin] = ranges[bin].min(hit.length());
    }
    ranges
}

/// Mean difference with `before` turned by `shift` bins, m; infinite if too few bins have both.
fn difference(before: &[f64], now: &[f64], shift: i32) -> f64 {
    let shift = shift.rem_euclid(BINS as i32) as usize;
    let (mut sum, mut count) = (0.0, 0);
    for (a, b) in before.iter().zip(now.iter().cycle().skip(shift)) {
        if a.is_finite() && b.is_finite() {
            sum += (a - b).abs().min(FAR);
            count += 1;
        }
    }
    match count >= OVERLAP {
        true => sum / count as f64,
        false => f64::INFINITY,
    }
}

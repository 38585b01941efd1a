//! In: the beams of a scan. Out: places that stand out in range: table legs, posts, edges.
//!
//! | form | a beam is one where |
//! |---|---|
//! | [`SpikeForm::Jump`] | the range to a neighbour jumps by more than a threshold; the nearer of the two |
//! | [`SpikeForm::Sum`] | of three neighbours A, B, C, \|A - B\| + \|C - B\| is greater than it, and none is nearer than B |
//!
//! Source: Pilch 2016 §1.2.1, after Riisgaard & Blas (2005), "SLAM for Dummies", §8. The sum uses
//! distances between points, as Pilch does. So it is not misled by a wall along the beams, but only
//! if that wall is sampled densely. Both forms find the edges of boxes and doors too. People who
//! walk about are spikes as well, as the source says.
//!
//! 1. A beam without a return does not show what stands there, so it makes no jump.
//! 2. An edge lies between the near beam and the far one. Its position is half a step of bearing
//!    beyond the near end, with the variance of a uniform distribution, step²/12, across the beam.
//!    Along the beam, the variance is that of the range plus that of a surface that continues to
//!    the edge at 45°. An object hit by only one beam is narrower than two steps, and its middle is
//!    within half a step of the beam: the same variance, no shift.
//! 3. Neighbouring spikes of one form are united if they are one object: nearer to each other than
//!    half the threshold.

use nalgebra::{Matrix2, Vector2};

use super::point::{PointFeature, PointKind, probability_within};
use crate::bounds::config;
use crate::geom::Length;
use crate::points::{Beam, Points};

/// What counts as a spike.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SpikeForm {
    /// A jump of the range between two neighbours.
    #[default]
    Jump,
    /// Three neighbours of which the middle one stands out.
    Sum,
}

impl SpikeForm {
    /// All of them, with their names in settings and for people.
    pub const ALL: [(&'static str, Self, &'static str); 2] = [
        ("jump", Self::Jump, "a jump of the range"),
        ("sum", Self::Sum, "the middle one of three"),
    ];
}

config! {
    /// Which points stand out.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct SpikeConfig {
        /// Whether they are looked for. Default yes.
        pub is_on: bool = true,
        /// By what. Default [`SpikeForm::Jump`].
        pub form: SpikeForm = SpikeForm::Jump,
        /// Smallest jump, or sum of distances, m. Default 0.5, as Riisgaard & Blas have it. Larger:
        /// fewer, clearer ones.
        pub threshold: f64 = 0.5,
        /// Widest step between neighbours in bearing, rad. Default 0.12: across lost beams nothing
        /// is known. Larger: spikes beside lost beams too.
        pub max_step: f64 = 0.12,
    }
}

/// The spikes of a scan, added to `found` in the order of the beams.
pub(super) fn spikes(points: &Points, config: &SpikeConfig, found: &mut Vec<PointFeature>) {
    let beams = &points.beams;
    let n = beams.len();
    if n < 3 {
        return;
    }
    let first = found.len();
    for (index, beam) in beams.iter().enumerate().filter(|(_, beam)| beam.is_hit) {
        let [before, after] = [n - 1, 1].map(|step| {
            let next = beams.get((index + step) % n)?;
            Side::of(beam, next, config.max_step)
        });
        let spike = match config.form {
            SpikeForm::Jump => by_jump([before, after], config),
            SpikeForm::Sum => by_sum([before, after], config),
        };
        if let Some(spike) = spike {
            found.push(spike.feature(beam, points.bearing_sigma));
        }
    }
    unite(found, first, 0.5 * config.threshold);
}

/// A neighbour, as a beam sees it.
#[derive(Clone, Copy)]
struct Side {
    /// How much farther it ends, m.
    farther: f64,
    /// The distance between their ends, m.
    apart: f64,
    /// Variance of either, m².
    var: f64,
    /// Half the distance to the neighbouring beam at the range of this one.
    half_step: Vector2<f64>,
}

impl Side {
    fn of(beam: &Beam, next: &Beam, max_step: f64) -> Option<Self> {
        let [own, other] = [beam, next].map(|b| b.end_in_robot - b.origin_in_robot);
        let (sin, cos) = (own.perp(&other), own.dot(&other));
        let step = libm::atan2(sin, cos);
        if !next.is_hit || step == 0.0 || step.abs() > max_step {
            return None;
        }
        let across = Vector2::new(-own.y, own.x);
        Some(Self {
            farther: next.range - beam.range,
            apart: (next.end_in_robot - beam.end_in_robot).length(),
            var: beam.sigma * beam.sigma + next.sigma * next.sigma,
            half_step: across * (0.5 * step),
        })
    }
}

/// What makes a beam a spike.
struct Spike {
    shift: Vector2<f64>,
    half_step: f64,
    confidence: f64,
}

fn by_jump(sides: [Option<Side>; 2], config: &SpikeConfig) -> Option<Spike> {
    let jumps = sides.map(|side| side.filter(|side| side.farther > config.threshold));
    let above = |side: &Side| {
        probability_within(
            side.farther,
            side.var.sqrt(),
            [config.threshold, f64::INFINITY],
        )
    };
    match jumps {
        [Some(a), Some(b)] => Some(Spike {
            shift: Vector2::zeros(),
            half_step: a.half_step.length().max(b.half_step.length()),
            confidence: above(&a).max(above(&b)),
        }),
        [Some(side), None] | [None, Some(side)] => Some(Spike {
            shift: side.half_step,
            half_step: side.half_step.length(),
            confidence: above(&side),
        }),
        [None, None] => None,
    }
}

fn by_sum(sides: [Option<Side>; 2], config: &SpikeConfig) -> Option<Spike> {
    let [Some(a), Some(b)] = sides else {
        return None;
    };
    let sum = a.apart + b.apart;
    if a.farther < 0.0 || b.farther < 0.0 || sum <= config.threshold {
        return None;
    }
    // The error of B affects both distances.
    let sigma = (2.0 * (a.var + b.var)).sqrt();
    let above = probability_within(sum, sigma, [config.threshold, f64::INFINITY]);
    // If one neighbour is on the same object, it is the object's edge.
    let is_far = |side: &Side| side.apart > 0.5 * config.threshold;
    let shift = match [is_far(&a), is_far(&b)] {
        [true, false] => a.half_step,
        [false, true] => b.half_step,
        _ => Vector2::zeros(),
    };
    Some(Spike {
        shift,
        half_step: a.half_step.length().max(b.half_step.length()),
        confidence: above,
    })
}

impl Spike {
    /// Step 2.
    fn feature(&self, beam: &Beam, bearing_sigma: f64) -> PointFeature {
        let along = (beam.end_in_robot - beam.origin_in_robot) / beam.range;
        let across = Vector2::new(-along.y, along.x);
        let by_bearing = bearing_sigma * beam.range;
        // A uniform distribution as wide as a step: (2 h)² / 12.
        let var_across = self.half_step * self.half_step / 3.0 + by_bearing * by_bearing;
        // The same on a slope of 45°, about the near end: (2 h)² / 3.
        let var_along = beam.sigma * beam.sigma + 4.0 * self.half_step * self.half_step / 3.0;
        let cov: Matrix2<f64> =
            along * along.transpose() * var_along + across * across.transpose() * var_across;
        PointFeature {
            position: beam.end_in_robot + self.shift,
            cov,
            kind: PointKind::Spike,
            confidence: self.confidence,
            beams: [beam.beam_idx; 2],
        }
    }
}

/// Step 3: neighbouring spikes of one object become one in their middle. An object hit by two beams
/// reaches at least from one to the other, so the variance remains that of an edge.
fn unite(found: &mut Vec<PointFeature>, first: usize, most: f64) {
    let mut kept = first;
    for index in first..found.len() {
        let next = found[index];
        let joined = found[first..kept].last_mut().filter(|last| {
            last.beams[1].abs_diff(next.beams[0]) == 1
                && (last.position - next.position).length() < most
        });
        if let Some(last) = joined {
            last.position = nalgebra::center(&last.position, &next.position);
            last.confidence = last.confidence.max(next.confidence);
            last.beams[1] = next.beams[1];
        } else {
            found[kept] = next;
            kept += 1;
        }
    }
    found.truncate(kept);
}

#[cfg(test)]
mod tests;

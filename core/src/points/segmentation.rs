//! In: [`Points`]. Out: [`Run`]s of neighbouring beams that may lie on one surface.
//!
//! 1. A beam without a return, or a step in bearing beyond `max_step`, ends a run.
//! 2. Two neighbours belong together while the [`BreakRule`] says so.
//! 3. On a full circle, if the robot stood, the last run is joined to the first by the same rule. A
//!    circle without any break starts at the farthest beam: along a straight wall the range has no
//!    interior maximum, so that beam is at a corner.
//!
//! Angles between beams come from cross and dot products: no transcendental call per beam. Most
//! neighbours clearly belong together; those are found four at a time.

mod rules;

pub use rules::BreakRule;

use std::ops::Range;

use super::{Beam, Points};
use crate::geom::Length;
use rules::{Joins, Ray};

use crate::bounds::config;

config! {
    /// Where one surface may end and another begin.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct SegmentationConfig {
        /// When two neighbours do not belong together. Default [`BreakRule::Adaptive`] with 10° and
        /// 3 σ.
        pub rule: BreakRule = BreakRule::default(),
        /// Largest step in bearing within a run, rad. Default 0.12: three beams of 2° may be
        /// missing, no more.
        pub max_step: f64 = 0.12,
    }
}

/// Neighbouring beams of [`Points`], counted around the circle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Run {
    /// Index of the first beam in [`Points::beams`].
    pub first: usize,
    /// Number of beams; after the last beam it continues with beam 0.
    pub len: usize,
}

impl Run {
    /// The beams of the run, in order.
    pub fn beams<'a>(&self, points: &'a Points) -> impl Iterator<Item = &'a Beam> + use<'a> {
        let [head, tail] = self.ranges(points.beams.len());
        points.beams[head].iter().chain(&points.beams[tail])
    }

    /// The beams of the run in two pieces: up to the end of a scan of `n_beams`, and from beam 0
    /// on.
    #[must_use]
    pub fn ranges(&self, n_beams: usize) -> [Range<usize>; 2] {
        let first = self.first.min(n_beams);
        let n_head = self.len.min(n_beams - first);
        let n_tail = (self.len - n_head).min(first);
        [first..first + n_head, 0..n_tail]
    }
}

/// Breaks `points` into runs, written to `runs` (cleared first), in the order of the beams.
///
/// # Source    See [`BreakRule`].
pub fn segment(points: &Points, config: &SegmentationConfig, runs: &mut Vec<Run>) {
    runs.clear();
    match &config.rule {
        BreakRule::Adaptive {
            grazing_angle,
            n_sigmas,
        } => {
            let rule = rules::Adaptive::new(*grazing_angle, *n_sigmas, config.max_step);
            collect(&points.beams, &rule, runs);
        }
        BreakRule::Spacing { spacing, ratio } => {
            let rule = rules::Spaced::new(*spacing, *ratio, config.max_step);
            collect(&points.beams, &rule, runs);
        }
        BreakRule::MeanRatio { ratio } => {
            collect(&points.beams, &rules::Step::new(config.max_step), runs);
            rules::break_by_mean(points, *ratio, runs);
        }
    }
}

/// Beams examined together.
const CHUNK: usize = 64;

/// Steps 1 to 3 by one rule.
fn collect(beams: &[Beam], rule: &impl Joins, runs: &mut Vec<Run>) {
    // No run is open while its length is 0.
    let mut open = Run { first: 0, len: 0 };
    let mut surely = [0.0; CHUNK];
    for start in (0..beams.len()).step_by(CHUNK) {
        let own = start..(start + CHUNK).min(beams.len());
        rule.join_surely(beams, own.clone(), &mut surely);
        for (index, surely) in own.zip(&surely) {
            let beam = &beams[index];
            let joins = || rule.joins(&Ray::of(&beams[index - 1]), &Ray::of(beam));
            if open.len > 0 && beam.is_hit && (*surely > 0.0 || joins()) {
                open.len += 1;
            } else {
                runs.extend((open.len > 0).then_some(open));
                open = Run {
                    first: index,
                    len: usize::from(beam.is_hit),
                };
            }
        }
    }
    runs.extend((open.len > 0).then_some(open));
    close_circle(beams, rule, runs);
}

/// Joins the last run to the first if the scan is a full circle.
fn close_circle(beams: &[Beam], rule: &impl Joins, runs: &mut Vec<Run>) {
    let (Some(first_beam), Some(second), Some(last_beam)) =
        (beams.first(), beams.get(1), beams.last())
    else {
        return;
    };
    let turn = |a: &Beam, b: &Beam| {
        (a.end_in_robot - a.origin_in_robot).perp(&(b.end_in_robot - b.origin_in_robot))
    };
    let goes_on = turn(last_beam, first_beam) * turn(first_beam, second) > 0.0;
    // A moving robot saw both sides of the seam a whole sweep apart: no wall is known well enough
    // across it.
    let stood = (last_beam.origin_in_robot - first_beam.origin_in_robot).length() < 1e-3;
    let is_seen = first_beam.is_hit && last_beam.is_hit;
    if beams.len() < 3
        || !goes_on
        || !stood
        || !is_seen
        || !rule.joins(&Ray::of(last_beam), &Ray::of(first_beam))
    {
        return;
    }
    match runs.as_mut_slice() {
        [whole] => whole.first = farthest(beams),
        [first, .., last] => {
            first.first = last.first;
            first.len += last.len;
            runs.pop();
        }
        [] => {}
    }
}

fn farthest(beams: &[Beam]) -> usize {
    let mut best = (0, 0.0);
    for (index, beam) in beams.iter().enumerate() {
        if beam.range > best.1 {
            best = (index, beam.range);
        }
    }
    best.0
}

#[cfg(test)]
mod tests;

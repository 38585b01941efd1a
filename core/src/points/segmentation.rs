//! In: [`Points`]. Out: [`Run`]s of neighbouring beams that may lie on one surface.
//!
//! 1. A beam without a return, or a step in bearing beyond `max_step`, ends a run.
//! 2. Two neighbours belong together while their distance is at most
//!    `D = ρ sin Δφ / sin(λ - Δφ) + n σ`: what a surface seen at the grazing angle λ would give, plus noise (Borges &
//!    Aldon 2004, "Line extraction in 2D range images for mobile robotics", eq. (3)). ρ is the shorter of both ranges
//!    so that the order of the beams does not matter, σ² the sum of both variances.
//! 3. If asked, runs are broken where the distance exceeds ν times the mean of the run (TDK 2016 §4.2, for doors that
//!    the ranger sees with evenly spaced points).
//! 4. On a full circle, if the robot stood, the last run is joined to the first by the same test. A circle without any break starts at the
//!    farthest beam: along a straight wall the range has no inner maximum, so that is a corner.
//!
//! Angles between beams come from cross and dot products: no transcendental call per beam.

use super::{Beam, Points};

/// Where one surface may end and another begin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SegmentationConfig {
    /// Grazing angle λ below which a surface is not followed, rad. Default 0.17 (10°). Growing: more breaks on walls
    /// seen at a flat angle, fewer walls joined across a depth step.
    pub grazing_angle: f64,
    /// Noise allowed on top, in standard deviations of the difference of two ranges. Default 3.
    pub n_sigmas: f64,
    /// Largest step in bearing within a run, rad. Default 0.12: three beams of 2° may be missing, no more.
    pub max_step: f64,
    /// ν of the mean rule; `None` leaves it out. Default `None`: the spacing on a long wall is far from even. TDK
    /// uses 4 to 5.
    pub mean_ratio: Option<f64>,
}

impl Default for SegmentationConfig {
    fn default() -> Self {
        Self {
            grazing_angle: 0.17,
            n_sigmas: 3.0,
            max_step: 0.12,
            mean_ratio: None,
        }
    }
}

/// Neighbouring beams of [`Points`], counted around the circle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Run {
    /// Index of the first beam in [`Points::beams`].
    pub first: usize,
    /// Number of beams; past the last beam it goes on with beam 0.
    pub len: usize,
}

impl Run {
    /// The beams of the run, in order.
    pub fn beams<'a>(&self, points: &'a Points) -> impl Iterator<Item = &'a Beam> + use<'a> {
        let (head, tail) = points.beams.split_at(self.first.min(points.beams.len()));
        tail.iter().chain(head).take(self.len)
    }
}

/// Breaks `points` into runs, written to `runs` (cleared first), in the order of the beams.
///
/// # Source    Borges & Aldon (2004), eq. (3); TDK 2016 §4.2. See the module for where we differ.
pub fn segment(points: &Points, config: &SegmentationConfig, runs: &mut Vec<Run>) {
    runs.clear();
    let limits = Limits::new(config);
    let beams = &points.beams;
    let mut open: Option<Run> = None;
    let mut last: Option<&Beam> = None;
    for (index, beam) in beams.iter().enumerate() {
        let follows = last.is_some_and(|last| limits.joins(last, beam));
        match &mut open {
            Some(run) if follows => run.len += 1,
            _ => {
                runs.extend(open.take());
                open = beam.is_hit.then_some(Run {
                    first: index,
                    len: 1,
                });
            }
        }
        last = Some(beam);
    }
    runs.extend(open);
    close_circle(beams, &limits, runs);
    if let Some(ratio) = config.mean_ratio {
        break_by_mean(points, ratio, runs);
    }
}

/// The constants of the breakpoint test.
struct Limits {
    sin_grazing: f64,
    cos_grazing: f64,
    sin_max_step: f64,
    n_sigmas: f64,
}

impl Limits {
    fn new(config: &SegmentationConfig) -> Self {
        Self {
            sin_grazing: libm::sin(config.grazing_angle),
            cos_grazing: libm::cos(config.grazing_angle),
            sin_max_step: libm::sin(config.max_step),
            n_sigmas: config.n_sigmas,
        }
    }

    fn joins(&self, a: &Beam, b: &Beam) -> bool {
        if !(a.is_hit && b.is_hit) {
            return false;
        }
        let (to_a, to_b) = (
            a.end_in_robot - a.origin_in_robot,
            b.end_in_robot - b.origin_in_robot,
        );
        let scale = 1.0 / (a.range * b.range);
        let (sin_step, cos_step) = (to_a.perp(&to_b).abs() * scale, to_a.dot(&to_b) * scale);
        if !(cos_step > 0.0 && sin_step <= self.sin_max_step) {
            return false;
        }
        // sin(λ - Δφ); a coarse sensor's Δφ may come near λ, where the rule would let everything through.
        let sin_rest =
            (self.sin_grazing * cos_step - self.cos_grazing * sin_step).max(0.5 * self.sin_grazing);
        let noise = self.n_sigmas * (a.sigma * a.sigma + b.sigma * b.sigma).sqrt();
        let allowed = a.range.min(b.range) * sin_step / sin_rest + noise;
        (b.end_in_robot - a.end_in_robot).norm_squared() <= allowed * allowed
    }
}

/// Joins the last run to the first where the scan is a full circle.
fn close_circle(beams: &[Beam], limits: &Limits, runs: &mut Vec<Run>) {
    let (Some(first_beam), Some(second), Some(last_beam)) =
        (beams.first(), beams.get(1), beams.last())
    else {
        return;
    };
    let turn = |a: &Beam, b: &Beam| {
        (a.end_in_robot - a.origin_in_robot).perp(&(b.end_in_robot - b.origin_in_robot))
    };
    let goes_on = turn(last_beam, first_beam) * turn(first_beam, second) > 0.0;
    // A moving robot saw both sides of the seam a whole sweep apart: no wall is known that well across it.
    let stood = (last_beam.origin_in_robot - first_beam.origin_in_robot).norm() < 1e-3;
    if beams.len() < 3 || !goes_on || !stood || !limits.joins(last_beam, first_beam) {
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

/// TDK 2016 §4.2: breaks each run where the neighbours are farther apart than `ratio` times the mean of that run.
fn break_by_mean(points: &Points, ratio: f64, runs: &mut Vec<Run>) {
    let n_beams = points.beams.len();
    let whole = std::mem::take(runs);
    for run in whole {
        let steps = || {
            run.beams(points)
                .zip(run.beams(points).skip(1))
                .map(|(a, b)| (b.end_in_robot - a.end_in_robot).norm())
        };
        let mean = steps().sum::<f64>() / (run.len.max(2) - 1) as f64;
        let mut part = Run {
            first: run.first,
            len: 1,
        };
        for (index, step) in steps().enumerate() {
            if step > ratio * mean {
                runs.push(part);
                part = Run {
                    first: (run.first + index + 1) % n_beams,
                    len: 0,
                };
            }
            part.len += 1;
        }
        runs.push(part);
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Point2, Vector2};
    use proptest::prelude::*;

    use super::*;
    use crate::geom::Segment;
    use crate::robot::Stamp;

    /// `n` beams from the origin around the circle (or the arc `from..to`, degrees) against walls.
    fn look(walls: &[Segment], n: usize, from: f64, to: f64) -> Points {
        let beams = (0..n).map(|i| {
            let bearing = (from + (to - from) * i as f64 / n as f64).to_radians();
            let direction = Vector2::new(libm::cos(bearing), libm::sin(bearing));
            let range = walls
                .iter()
                .filter_map(|w| w.hit_by_ray(Point2::origin(), direction))
                .fold(12.0, f64::min);
            Beam {
                beam_idx: i,
                origin_in_robot: Point2::origin(),
                end_in_robot: Point2::from(direction * range),
                range,
                sigma: 0.01,
                is_hit: range < 12.0,
            }
        });
        Points {
            stamp: Stamp(0),
            sensor_in_robot: Point2::origin(),
            bearing_sigma: 0.0,
            beams: beams.collect(),
        }
    }

    fn wall(ax: f64, ay: f64, bx: f64, by: f64) -> Segment {
        Segment::new(Point2::new(ax, ay), Point2::new(bx, by))
    }

    fn room() -> Vec<Segment> {
        vec![
            wall(-2.0, -1.5, 3.0, -1.5),
            wall(3.0, -1.5, 3.0, 2.0),
            wall(3.0, 2.0, -2.0, 2.0),
            wall(-2.0, 2.0, -2.0, -1.5),
        ]
    }

    fn runs(points: &Points, config: &SegmentationConfig) -> Vec<Run> {
        let mut runs = vec![];
        segment(points, config, &mut runs);
        runs
    }

    #[test]
    fn closed_room_is_one_run_that_starts_in_a_corner() {
        let points = look(&room(), 360, 0.0, 360.0);
        let runs = runs(&points, &SegmentationConfig::default());
        assert_eq!(runs.len(), 1);
        assert_eq!(runs[0].len, 360);
        let start = runs[0].beams(&points).next().unwrap().end_in_robot;
        assert!((start - Point2::new(3.0, 2.0)).norm() < 0.06, "{start}");
    }

    #[test]
    fn wall_across_the_first_beam_is_one_run() {
        // Beam 0 looks at the middle of the only wall.
        let points = look(&[wall(2.0, -1.0, 2.0, 1.0)], 360, 0.0, 360.0);
        let runs = runs(&points, &SegmentationConfig::default());
        assert_eq!(runs.len(), 1);
        let ends: Vec<_> = runs[0].beams(&points).map(|b| b.end_in_robot.y).collect();
        assert!(ends.windows(2).all(|w| w[0] < w[1]) && ends.len() == runs[0].len);
    }

    #[test]
    fn half_circle_is_not_closed() {
        let points = look(&room(), 180, -90.0, 90.0);
        let runs = runs(&points, &SegmentationConfig::default());
        assert_eq!(runs, [Run { first: 0, len: 180 }]);
    }

    #[test]
    fn box_in_front_of_a_wall_is_a_run_of_its_own() {
        let walls = [wall(4.0, -3.0, 4.0, 3.0), wall(2.0, -0.3, 2.0, 0.3)];
        let points = look(&walls, 360, -180.0, 180.0);
        let runs = runs(&points, &SegmentationConfig::default());
        assert_eq!(runs.len(), 3, "{runs:?}");
        assert!(
            runs[1]
                .beams(&points)
                .all(|b| (b.end_in_robot.x - 2.0).abs() < 1e-9)
        );
    }

    #[test]
    fn no_return_breaks_a_wall() {
        let mut points = look(&[wall(2.0, -2.0, 2.0, 2.0)], 360, -180.0, 180.0);
        points.beams[180].is_hit = false;
        assert_eq!(runs(&points, &SegmentationConfig::default()).len(), 2);
    }

    #[test]
    fn each_rule_fails_where_the_other_holds() {
        let by_mean = SegmentationConfig {
            mean_ratio: Some(4.0),
            ..SegmentationConfig::default()
        };
        // A narrow slit between two walls on one line, seen head on: two beams go through it and are lost. The
        // adaptive rule follows the wall across; the mean rule finds the door.
        let walls = [wall(1.0, -1.0, 1.0, -0.04), wall(1.0, 0.04, 1.0, 1.0)];
        let mut points = look(&walls, 360, -90.0, 90.0);
        points.beams.retain(|b| b.is_hit);
        let adaptive = SegmentationConfig::default();
        assert_eq!(runs(&points, &adaptive).len(), 1);
        assert_eq!(runs(&points, &by_mean).len(), 2);
        // A long wall beside the robot: far beams are far apart, and the mean rule tears a whole wall.
        let points = look(&[wall(-1.0, 1.0, 5.0, 1.0)], 360, -180.0, 180.0);
        assert_eq!(runs(&points, &adaptive).len(), 1);
        assert!(runs(&points, &by_mean).len() > 1);
    }

    #[test]
    fn nothing_to_see_gives_no_run() {
        assert!(runs(&look(&[], 360, 0.0, 360.0), &SegmentationConfig::default()).is_empty());
        assert!(
            runs(
                &look(&room(), 0, 0.0, 360.0),
                &SegmentationConfig::default()
            )
            .is_empty()
        );
        assert_eq!(
            runs(
                &look(&room(), 1, 0.0, 360.0),
                &SegmentationConfig::default()
            )
            .len(),
            1
        );
    }

    proptest! {
        #[test]
        fn every_hit_is_in_exactly_one_run(
            ranges in prop::collection::vec((0.1..12.0_f64, prop::bool::weighted(0.9)), 0..80), ratio in prop::option::of(1.5..6.0_f64),
        ) {
            let mut points = look(&[], ranges.len(), 0.0, 360.0);
            for (beam, (range, is_hit)) in points.beams.iter_mut().zip(&ranges) {
                let direction = beam.end_in_robot.coords / beam.range;
                beam.range = *range;
                beam.end_in_robot = Point2::from(direction * *range);
                beam.is_hit = *is_hit;
            }
            let config = SegmentationConfig { mean_ratio: ratio, ..SegmentationConfig::default() };
            let mut seen: Vec<_> = runs(&points, &config).iter().flat_map(|r| r.beams(&points).map(|b| b.beam_idx).collect::<Vec<_>>()).collect();
            seen.sort_unstable();
            let hits: Vec<_> = points.hits().map(|b| b.beam_idx).collect();
            prop_assert_eq!(seen, hits);
        }
    }
}

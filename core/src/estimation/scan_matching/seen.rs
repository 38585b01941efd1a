//! What was seen since the last match, and its correction if seeing it took time.
//!
//! In: the points of a scan, or of several gathered scans, moved by odometry to the robot frame at
//! the end. Out: the same as the robot saw it if odometry had a given error.

use crate::geom::Pose2;
use crate::points::{OrientedPoint, Points, oriented_beams, oriented_cloud};
use crate::registration::{MotionError, Part};
use nalgebra::Point2;

/// Points within this share of the motion count as seen at the same time.
const PART: f64 = 1.0 / 32.0;
/// A scan seen entirely within this share of the motion is rigid.
const RIGID: f64 = 1e-3;

/// What was seen since the last match.
pub(super) struct Seen {
    pub(super) points: Points,
    /// Standard deviation of each beam's direction, rad.
    pub(super) sigmas: Vec<f64>,
    pub(super) surfaces: Vec<OrientedPoint>,
    /// The motion since the last match, by which the points were moved to its end.
    pub(super) motion: Pose2,
    /// The share of the motion since the last match that was still to come when each beam was
    /// taken; empty if all were taken at once.
    left: Vec<f64>,
    /// The same for each surface.
    surfaces_left: Vec<f64>,
    /// For each surface, the index of its beam in `points.beams`.
    surface_beams: Vec<usize>,
}

impl Seen {
    /// A scan, moved to the end of `motion`; `seconds` have passed since the last match.
    pub(super) fn scan(points: &Points, sigmas: &[f64], motion: Pose2, seconds: f64) -> Self {
        let share = |age: f64| (age / seconds).clamp(0.0, 1.0);
        let left = match seconds > 0.0 {
            true => points.beams.iter().map(|beam| share(beam.age)).collect(),
            false => vec![],
        };
        Self::new(
            points.clone(),
            sigmas.to_vec(),
            motion,
            left,
            oriented_beams(points),
        )
    }

    /// Scans of few beams that were gathered, moved to the end of `motion`; the points seen
    /// `before` help to detect surfaces.
    pub(super) fn gathered(
        points: Points,
        sigmas: Vec<f64>,
        motion: Pose2,
        left: Vec<f64>,
        before: &[Point2<f64>],
    ) -> Self {
        let surfaces = oriented_cloud(&points, before);
        Self::new(points, sigmas, motion, left, surfaces)
    }

    fn new(
        points: Points,
        sigmas: Vec<f64>,
        motion: Pose2,
        left: Vec<f64>,
        surfaces: Vec<(usize, OrientedPoint)>,
    ) -> Self {
        let least = left.iter().copied().fold(f64::INFINITY, f64::min);
        let most = left.iter().copied().fold(0.0, f64::max);
        let left = if most - least > RIGID { left } else { vec![] };
        let of_beam = |(beam, _): &(usize, OrientedPoint)| left.get(*beam).copied();
        Self {
            surfaces_left: surfaces.iter().filter_map(of_beam).collect(),
            surface_beams: surfaces.iter().map(|(beam, _)| *beam).collect(),
            surfaces: surfaces.into_iter().map(|(_, surface)| surface).collect(),
            points,
            sigmas,
            motion,
            left,
        }
    }

    /// Whether seeing it took time.
    pub(super) fn is_rolling(&self) -> bool {
        !self.surfaces_left.is_empty()
    }

    /// The surfaces on which these beams end; `beams` are ascending indices into the list.
    pub(super) fn surfaces_of(&self, beams: &[usize]) -> impl Iterator<Item = &OrientedPoint> {
        let is_of = |(_, beam): &(&OrientedPoint, &usize)| beams.binary_search(beam).is_ok();
        let of_beams = self.surfaces.iter().zip(&self.surface_beams);
        of_beams.filter(is_of).map(|(surface, _)| surface)
    }

    /// All except what these beams saw; `beams` are ascending indices into the list.
    pub(super) fn without(&self, beams: &[usize]) -> Self {
        let keeps = |at: &usize| beams.binary_search(at).is_err();
        let by_beam = |list: &[f64]| kept(list, (0..list.len()).map(|at| keeps(&at)));
        let of_surfaces = || self.surface_beams.iter().map(keeps);
        let beams_before = |at: &usize| at - beams.partition_point(|beam| beam < at);
        Self {
            points: Points {
                beams: kept(
                    &self.points.beams,
                    (0..self.points.beams.len()).map(|at| keeps(&at)),
                ),
                ..self.points
            },
            sigmas: by_beam(&self.sigmas),
            surfaces: kept(&self.surfaces, of_surfaces()),
            motion: self.motion,
            left: by_beam(&self.left),
            surfaces_left: kept(&self.surfaces_left, of_surfaces()),
            surface_beams: kept(&self.surface_beams, of_surfaces())
                .iter()
                .map(beams_before)
                .collect(),
        }
    }

    /// The surfaces, grouped by when they were seen.
    pub(super) fn parts(&self) -> Vec<Part<'_>> {
        let bin = |left: &f64| libm::floor(left / PART);
        let bins = self.surfaces_left.chunk_by(|a, b| bin(a) == bin(b));
        let mut from = 0;
        bins.map(|lefts| {
            let to = from + lefts.len();
            let points = self.surfaces.get(from..to).unwrap_or_default();
            from = to;
            let left = lefts.iter().sum::<f64>() / lefts.len() as f64;
            Part { points, left }
        })
        .collect()
    }

    /// The surfaces as they would have been seen if the motion that ended at `end` had this
    /// `error`.
    pub(super) fn surfaces_after(&self, end: &Pose2, error: &MotionError) -> Vec<OrientedPoint> {
        let moved = |(surface, left): (&OrientedPoint, &f64)| {
            let by = error.correction(end, *left);
            OrientedPoint {
                position: by * surface.position,
                normal: by.rotate(surface.normal),
            }
        };
        self.surfaces
            .iter()
            .zip(&self.surfaces_left)
            .map(moved)
            .collect()
    }

    /// Corrects everything by the error of the motion that ended at `end`.
    pub(super) fn correct(&mut self, end: &Pose2, error: &MotionError) {
        if !self.is_rolling() {
            return;
        }
        self.surfaces = self.surfaces_after(end, error);
        for (beam, left) in self.points.beams.iter_mut().zip(&self.left) {
            *beam = beam.moved(&error.correction(end, *left));
        }
    }
}

/// The elements of a list that are to be kept.
fn kept<T: Copy>(list: &[T], keeps: impl Iterator<Item = bool>) -> Vec<T> {
    let both = list.iter().zip(keeps);
    both.filter_map(|(item, keep)| keep.then_some(*item))
        .collect()
}

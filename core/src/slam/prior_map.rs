//! Localisation in a prior map: its lines, where the robot begins in it, and whether what is seen
//! stands in it.
//!
//! A drawn map is not exact: walls of a grid are off by up to half a cell. The filter takes its map
//! for exact, so that what is not known of the map is added to what is not known of each line seen:
//! σ of the offset, and √12 σ over its length of the direction, as if both ends were off by
//! independent errors of about that size.

use std::collections::VecDeque;

use crate::bounds::config;
use crate::features::LineFeature;
use crate::geom::{Pose2, PoseEstimate, Segment, pose_cov, sin_cos};
use crate::points::Points;

/// Scans over which it is judged whether the map fits.
const JUDGED_SCANS: usize = 30;
/// Fewer hits in them say nothing.
const JUDGED_HITS: usize = 300;
/// One hit in so many is compared.
const EVERY: usize = 6;
/// A hit belongs to a wall up to here, m, and three times what is not known of map and reading:
/// what stands at a wall hides it.
const AT_WALL: f64 = 0.05;
/// Less of what is hit than this part stands in the map: it is another, or the robot is elsewhere
/// in it. Furniture and people leave more of a map that fits.
const FITS_ABOVE: f64 = 0.5;

/// What of a scan is found in the map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PriorMapMatching {
    /// Each of its lines, by the filter of TDK 2016 §3.2.
    Lines,
    /// All of its surfaces at once, by scan matching.
    #[default]
    Surfaces,
}

impl PriorMapMatching {
    /// All of them, with the names used by settings, and what a person calls them.
    pub const ALL: [(&'static str, Self, &'static str); 2] = [
        ("lines", Self::Lines, "lines (TDK 2016)"),
        ("surfaces", Self::Surfaces, "whole scans"),
    ];
}

config! {
    /// A map to be localised in.
    #[derive(Clone, Debug, PartialEq)]
    pub struct PriorMap {
        /// The faces of its walls, map frame, with what is free to the left of the way from `a` to
        /// `b`; the robot begins at the origin.
        pub faces: Vec<Segment> = vec![],
        /// How far its walls may be off, m: standard deviation. Default 0.01; of a grid, a third of
        /// its cells.
        pub sigma: f64 = 0.01,
        /// How far off the robot's first pose may be, m and rad: standard deviations. Default 0:
        /// the map is placed by where the robot is.
        pub start_sigmas: [f64; 2] = [0.0; 2],
        /// Whether the robot may begin anywhere in it, so that its place has to be found. Default
        /// false.
        pub anywhere: bool = false,
    }
}

impl PriorMap {
    /// A map in a frame of its own, in which the robot begins at `file_from_robot`; `faces` as in
    /// [`Self::faces`], `sigma` as in [`Self::sigma`].
    #[must_use]
    pub fn of_faces(faces: &[Segment], sigma: f64, file_from_robot: &Pose2) -> Self {
        let to = file_from_robot.inverse();
        let moved = faces.iter().map(|face| to * *face);
        Self {
            faces: moved.filter(has_length).collect(),
            sigma,
            ..Self::default()
        }
    }

    /// Both faces of thin walls, where the robot begins at `world_from_robot`.
    #[must_use]
    pub fn of_walls(walls: impl Iterator<Item = Segment>, world_from_robot: &Pose2) -> Self {
        let both = walls.flat_map(|wall| [wall, Segment::new(wall.b, wall.a)]);
        let sigma = Self::default().sigma;
        Self::of_faces(&both.collect::<Vec<_>>(), sigma, world_from_robot)
    }

    /// Where the robot begins.
    pub(super) fn start(&self) -> PoseEstimate {
        let [way, turn] = self.start_sigmas;
        PoseEstimate {
            pose: Pose2::identity(),
            cov: pose_cov(way, turn),
        }
    }

    /// A line of a scan, as uncertain as scan, map and the heading since it was seen are together:
    /// `heading_variances` by beam, rad².
    pub(super) fn loosened(&self, feature: &LineFeature, heading_variances: &[f64]) -> LineFeature {
        let mut loose = *feature;
        // Seen from where the robot was then, the line was turned about it, and no nearer.
        let since = |beam| heading_variances.get(beam).copied().unwrap_or(0.0);
        let (first, last) = (feature.first_beam, feature.last_beam);
        loose.cov[(0, 0)] += since(usize::midpoint(first, last));
        // While it was swept over, the heading walked at random from the middle beam to either end.
        let walked = 0.5 * (since(first) - since(last)).abs();
        for by_heading in feature.by_heading {
            loose.cov += by_heading * by_heading.transpose() * walked;
        }
        let variance = self.sigma * self.sigma;
        let length = feature.length().max(self.sigma);
        // The direction errs about the middle of the piece; r is that of the foot point, as far
        // along the line.
        let middle = nalgebra::center(&feature.ends[0], &feature.ends[1]);
        let (sin, cos) = sin_cos(feature.line.alpha());
        let along = cos * middle.y - sin * middle.x;
        let turned = 12.0 * variance / (length * length);
        loose.cov[(0, 0)] += turned;
        loose.cov[(0, 1)] += along * turned;
        loose.cov[(1, 0)] += along * turned;
        loose.cov[(1, 1)] += variance + along * along * turned;
        loose
    }
}

fn has_length(face: &Segment) -> bool {
    face.length() > 0.0 && face.length().is_finite()
}

/// How much of what was hit lately is a wall of the prior map.
#[derive(Clone, Debug, Default)]
pub struct PriorMapFit {
    /// Of each of the last scans: hits that were compared, and those on walls.
    scans: VecDeque<[usize; 2]>,
}

impl PriorMapFit {
    /// The part of what was hit that stands in the map, 0 to 1; `None` while too little was seen.
    #[must_use]
    pub fn part(&self) -> Option<f64> {
        let add = |[hits, found]: [usize; 2], scan: &[usize; 2]| [hits + scan[0], found + scan[1]];
        let [hits, found] = self.scans.iter().fold([0, 0], add);
        (self.scans.len() == JUDGED_SCANS && hits >= JUDGED_HITS)
            .then(|| found as f64 / hits as f64)
    }

    /// Whether the map is of another place, or the robot elsewhere in it than was said.
    #[must_use]
    pub fn is_misfit(&self) -> bool {
        self.part().is_some_and(|part| part < FITS_ABOVE)
    }

    /// Takes in a scan from the pose that is believed.
    pub(super) fn push(&mut self, points: &Points, map_from_robot: &Pose2, known: &PriorMap) {
        let hits = points.beams.iter().filter(|beam| beam.is_hit);
        let mut scan = [0; 2];
        for beam in hits.step_by(EVERY) {
            let at = *map_from_robot * beam.end_in_robot;
            let near = AT_WALL + 3.0 * libm::hypot(known.sigma, beam.sigma);
            scan[0] += 1;
            scan[1] += usize::from(known.faces.iter().any(|face| face.distance(at) <= near));
        }
        if self.scans.len() == JUDGED_SCANS {
            self.scans.pop_front();
        }
        self.scans.push_back(scan);
    }
}

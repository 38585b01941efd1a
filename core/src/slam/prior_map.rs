//! Localisation in a prior map: its lines, where the robot begins in it, and whether what is seen
//! stands in it.
//!
//! A drawn map is not exact: walls of a grid are off by up to half a cell. The filter takes its map
//! for exact, so the uncertainty of the map is added to that of each line seen: σ to its offset,
//! and √12 σ over its length to its direction, as if both ends had independent errors of about that
//! size.

use std::collections::VecDeque;

use crate::bounds::config;
use crate::features::LineFeature;
use crate::geom::{Pose2, PoseEstimate, Segment, pose_cov, sin_cos};
use crate::points::Points;

/// Number of scans over which the fit of the map is judged.
const JUDGED_SCANS: usize = 30;
/// With fewer hits in them there is no judgement.
const JUDGED_HITS: usize = 300;
/// One in this many hits is compared.
const EVERY: usize = 6;
/// A hit belongs to a wall up to this distance, m, plus three times the uncertainty of map and
/// reading: what stands at a wall hides it.
const AT_WALL: f64 = 0.05;
/// If a smaller fraction of the hits lies on walls of the map, it is another map, or the robot is
/// elsewhere in it. In a map that fits, more than this remains in spite of furniture and people.
const FITS_ABOVE: f64 = 0.5;

/// Which parts of a scan are matched to the map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PriorMapMatching {
    /// Each of its lines, by the filter of TDK 2016 §3.2.
    Lines,
    /// All its surfaces at once, by scan matching.
    #[default]
    Surfaces,
}

impl PriorMapMatching {
    /// All variants, with their names in settings and their names for people.
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

    /// The two faces of each thin wall, for a robot that begins at `world_from_robot`.
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

    /// A line of a scan with the uncertainty of scan, map and the heading since it was seen:
    /// `heading_variances` by beam, rad².
    pub(super) fn loosened(&self, feature: &LineFeature, heading_variances: &[f64]) -> LineFeature {
        let mut loose = *feature;
        // Seen from where the robot was then, the line was turned about it; its distance did not
        // change.
        let since = |beam| heading_variances.get(beam).copied().unwrap_or(0.0);
        let (first, last) = (feature.first_beam, feature.last_beam);
        loose.cov[(0, 0)] += since(usize::midpoint(first, last));
        // While the line was swept over, the heading walked at random from the middle beam to
        // either end.
        let walked = 0.5 * (since(first) - since(last)).abs();
        for by_heading in feature.by_heading {
            loose.cov += by_heading * by_heading.transpose() * walked;
        }
        let variance = self.sigma * self.sigma;
        let length = feature.length().max(self.sigma);
        // The direction errs about the middle of the piece, but r belongs to the foot point, at
        // some distance along the line.
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

/// Which part of the recent hits lies on walls of the prior map.
#[derive(Clone, Debug, Default)]
pub struct PriorMapFit {
    /// For each of the last scans: hits that were compared, and those on walls.
    scans: VecDeque<[usize; 2]>,
}

impl PriorMapFit {
    /// The fraction of the hits that lie on walls of the map, 0 to 1; `None` while too little was
    /// seen.
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

    /// Takes in a scan from the believed pose.
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

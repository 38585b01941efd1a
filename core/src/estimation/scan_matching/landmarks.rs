//! Corners and round objects of a map of submaps: what keyframes show repeatedly in one place.
//!
//! In: the keyframes, as kept for drawing the map, and their current poses. Out: [`MapLandmark`]s.
//! They are computed on request, to save them or to recognise a place by them; neither pose nor map
//! depends on them, and no scan waits for them.
//!
//! 1. Corners and circles are found in each keyframe's points on surfaces ([`find_points`]).
//! 2. They are compared with the landmarks of the submap so far, all by one gate
//!    ([`match_points`]). A landmark that is found again gains 1 in confidence, and its position
//!    becomes the information-weighted mean of both. Any other becomes a new landmark.
//! 3. What no second keyframe shows is not a landmark.
//! 4. The landmarks of the submaps become those of the map in the same way.
//!
//! Source: Pilch 2016 §3.3 and §3.5.2: a submap keeps landmarks, and their confidence grows by 1
//! each time they are found again. Pilch gives the new sighting more weight; here covariances
//! decide.

use nalgebra::{Matrix2, Matrix3, Point2, Vector3};

use super::ScanMatcher;
use crate::association::{PointMatchConfig, match_points};
use crate::features::{LineConfig, PointFeature, PointFeatureConfig, PointKind, find_points};
use crate::geom::{Pose2, PoseEstimate};

/// A corner or round object that was found again.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapLandmark {
    /// Position in the requested frame, m.
    pub position: Point2<f64>,
    /// Covariance of the position in that frame, m².
    pub cov: Matrix2<f64>,
    /// Its kind.
    pub kind: PointKind,
    /// How often it was found again.
    pub confidence: u32,
}

/// Uncertainty of a keyframe's pose in its submap, m and rad.
const KEYFRAME_SIGMAS: [f64; 3] = [0.02, 0.02, 0.005];
/// Uncertainty of a submap's pose in the map, relative to others nearby, m and rad.
const SUBMAP_SIGMAS: [f64; 3] = [0.05, 0.05, 0.01];
/// How much two sightings of one corner differ beside their noise, m: where the legs of a corner
/// begin depends on the viewpoint.
const SIGHTING_SIGMA: f64 = 0.02;

impl ScanMatcher {
    /// The landmarks of the whole map, map frame.
    #[must_use]
    pub fn landmarks(&self) -> Vec<MapLandmark> {
        let of_submaps: Vec<_> = (0..self.submaps.len())
            .map(|submap| self.landmarks_in(submap))
            .collect();
        self.landmarks_of(&of_submaps)
    }

    /// The same from the landmarks of its submaps ([`Self::landmarks_in`]), of which the first are
    /// given.
    #[must_use]
    pub fn landmarks_of(&self, of_submaps: &[Vec<MapLandmark>]) -> Vec<MapLandmark> {
        let mut known = Known::default();
        for (submap, landmarks) in self.submaps.iter().zip(of_submaps) {
            let seen: Vec<_> = landmarks.iter().map(MapLandmark::sighting).collect();
            let again: Vec<_> = landmarks.iter().map(|found| found.confidence).collect();
            known.take_in(&seen, &again, &submap.map_from_submap, &SUBMAP_SIGMAS);
        }
        known.found_again()
    }

    /// The poses of a submap's keyframes in its frame, in the order of the drive. They move as the
    /// map is refined, and landmarks found in them move along.
    pub fn keyframes_in(&self, submap: usize) -> impl Iterator<Item = Pose2> {
        let own = self.keyframes.iter().filter(move |k| k.submap == submap);
        own.map(|keyframe| keyframe.submap_from_robot)
    }

    /// The landmarks of one submap alone, in its frame; none if there is no such submap.
    #[must_use]
    pub fn landmarks_in(&self, submap: usize) -> Vec<MapLandmark> {
        let mut known = Known::default();
        let (lines, config) = (
            LineConfig::default(),
            PointFeatureConfig::default().of_landmarks(),
        );
        for keyframe in self.keyframes.iter().filter(|k| k.submap == submap) {
            let points = keyframe.points(self.config.matching.sigma);
            // What a keyframe keeps is finite; if it were not, it would show nothing.
            let mut seen = find_points(&points, &[], &lines, &config).unwrap_or_default();
            for point in &mut seen {
                point.cov += Matrix2::identity() * (SIGHTING_SIGMA * SIGHTING_SIGMA);
            }
            let again = vec![0; seen.len()];
            known.take_in(&seen, &again, &keyframe.submap_from_robot, &KEYFRAME_SIGMAS);
        }
        known.found_again()
    }
}

impl MapLandmark {
    fn sighting(&self) -> PointFeature {
        PointFeature {
            position: self.position,
            cov: self.cov,
            kind: self.kind,
            confidence: 1.0,
            beams: [0; 2],
        }
    }
}

/// The landmarks so far, in one frame, with how often each was found again.
#[derive(Default)]
struct Known {
    places: Vec<PointFeature>,
    again: Vec<u32>,
}

impl Known {
    /// Takes in what was seen in a frame that lies at `frame_from_seen`, with uncertainty `sigmas`;
    /// `again` tells how often each was found again there.
    fn take_in(
        &mut self,
        seen: &[PointFeature],
        again: &[u32],
        frame_from_seen: &Pose2,
        sigmas: &[f64; 3],
    ) {
        let variances = Vector3::from(*sigmas).map(|sigma| sigma * sigma);
        let seen_from_frame = PoseEstimate {
            pose: frame_from_seen.inverse(),
            cov: Matrix3::from_diagonal(&variances),
        };
        let matching = PointMatchConfig::default();
        let matches = match_points(&self.places, seen, &seen_from_frame, &matching);
        let mut partners = vec![None; seen.len()];
        for pair in matches {
            partners[pair.now] = Some(pair.before);
        }
        for ((point, again), partner) in seen.iter().zip(again).zip(partners) {
            let here = placed(point, frame_from_seen);
            let known = partner.and_then(|at| self.places.get_mut(at).zip(self.again.get_mut(at)));
            if let Some((known, count)) = known {
                merge(known, &here);
                *count += again + 1;
            } else {
                self.places.push(here);
                self.again.push(*again);
            }
        }
    }

    fn found_again(self) -> Vec<MapLandmark> {
        let all = self.places.into_iter().zip(self.again);
        all.filter(|(_, confidence)| *confidence > 0)
            .map(|(point, confidence)| MapLandmark {
                position: point.position,
                cov: point.cov,
                kind: point.kind,
                confidence,
            })
            .collect()
    }
}

/// A sighting in the frame of the landmarks.
fn placed(seen: &PointFeature, frame_from_seen: &Pose2) -> PointFeature {
    let (cos, sin) = frame_from_seen.cos_sin();
    let turn = Matrix2::new(cos, -sin, sin, cos);
    PointFeature {
        position: *frame_from_seen * seen.position,
        cov: turn * seen.cov * turn.transpose(),
        ..*seen
    }
}

/// The information-weighted mean of both.
fn merge(known: &mut PointFeature, seen: &PointFeature) {
    let Some(gain) = (known.cov + seen.cov).try_inverse() else {
        return;
    };
    let gain = known.cov * gain;
    known.position += gain * (seen.position - known.position);
    known.cov -= gain * known.cov;
    known.cov = (known.cov + known.cov.transpose()) * 0.5;
    known.kind.refine(&seen.kind);
}

#[cfg(test)]
mod tests;

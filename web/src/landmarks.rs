//! Landmarks, for the page: those of a filter, and those found in a map of submaps.

use nalgebra::{Matrix2, Point2};
use slamlab_core::estimation::{Landmark, MapLandmark, PointLandmark, ScanMatcher};
use slamlab_core::features::PointKind;
use slamlab_core::geom::Pose2;
use slamlab_core::pilot::Stage;
use wasm_bindgen::prelude::wasm_bindgen;

use crate::border::{LandmarkName, LandmarkRow, flat};
use crate::run::WebRun;
use crate::view::flag;

/// Landmarks of a map of submaps. Each complete submap is searched once, and again when its
/// keyframes were moved; the landmarks of the map are derived from these whenever the map grew or
/// was redrawn.
#[derive(Debug, Default)]
pub(crate) struct FoundLandmarks {
    of_submaps: Vec<Vec<MapLandmark>>,
    /// The poses of each submap's keyframes when it was searched.
    seen_from: Vec<Vec<Pose2>>,
    /// Number of complete submaps and version of the grid that `of_map` belongs to.
    known: (usize, u64),
    of_map: Vec<MapLandmark>,
}

impl FoundLandmarks {
    fn of(&mut self, matcher: &ScanMatcher) -> &[MapLandmark] {
        let complete = matcher.submaps().len().saturating_sub(1);
        if complete < self.of_submaps.len() {
            *self = Self::default();
        }
        let known = (complete, matcher.grid_version());
        if known != self.known {
            self.of_submaps.resize_with(complete, Vec::new);
            self.seen_from.resize_with(complete, Vec::new);
            let all = self.of_submaps.iter_mut().zip(&mut self.seen_from);
            for (submap, (landmarks, seen_from)) in all.enumerate() {
                let now: Vec<Pose2> = matcher.keyframes_in(submap).collect();
                if have_moved(seen_from, &now) {
                    *landmarks = matcher.landmarks_in(submap);
                    *seen_from = now;
                }
            }
            self.of_map = matcher.landmarks_of(&self.of_submaps);
            self.known = known;
        }
        &self.of_map
    }

    /// To be called when submaps are renumbered.
    pub(crate) fn forget(&mut self) {
        *self = Self::default();
    }
}

/// Whether any keyframe has moved, or their number has changed.
fn have_moved(before: &[Pose2], now: &[Pose2]) -> bool {
    /// Smaller shifts keep every corner inside the gate in which it is found again, m and rad.
    const STILL: [f64; 2] = [0.01, 0.003];
    let is_elsewhere = |(before, now): (&Pose2, &Pose2)| {
        let off = before.minus(now);
        off.x.abs().max(off.y.abs()) > STILL[0] || off.z.abs() > STILL[1]
    };
    before.len() != now.len() || before.iter().zip(now).any(is_elsewhere)
}

#[wasm_bindgen]
impl WebRun {
    /// Landmarks with their confidence, see `LANDMARK`: those of the filter, or those of the
    /// complete submaps. None for other methods.
    #[must_use]
    pub fn landmarks(&mut self) -> Vec<f32> {
        if self.session().stages().awaits(Stage::Localise) {
            return vec![];
        }
        let mut landmarks = std::mem::take(&mut self.landmarks);
        let view = self.slam().view();
        let found = view.map.map_or(&[][..], |matcher| landmarks.of(matcher));
        let found = (0_u32..).zip(found).map(LandmarkRow::of_found);
        let walls = view.landmarks.iter().map(LandmarkRow::of_wall);
        let points = view.point_landmarks.iter().map(LandmarkRow::of_point);
        let rows = flat(walls.chain(points).chain(found));
        self.landmarks = landmarks;
        rows
    }
}

impl LandmarkRow {
    fn of_wall(wall: &Landmark) -> Self {
        let [a, b] = wall.ends;
        Self {
            id: wall.id.0 as f32,
            kind: f32::from(LandmarkName::Wall as u8),
            x: (0.5 * (a.x + b.x)) as f32,
            y: (0.5 * (a.y + b.y)) as f32,
            var_x: f32::NAN,
            cov_xy: f32::NAN,
            var_y: f32::NAN,
            radius: 0.0,
            confidence: wall.confidence() as f32,
            confirmed: flag(wall.is_confirmed) as f32,
        }
    }

    fn of_point(point: &PointLandmark) -> Self {
        Self {
            id: point.id.0 as f32,
            confidence: point.confidence() as f32,
            confirmed: flag(point.is_confirmed) as f32,
            ..Self::at(&point.position, &point.cov, &point.kind)
        }
    }

    /// Its number is its index in the map. Since it was found again, it counts as confirmed.
    fn of_found((id, found): (u32, &MapLandmark)) -> Self {
        Self {
            id: id as f32,
            confidence: found.confidence as f32,
            ..Self::at(&found.position, &found.cov, &found.kind)
        }
    }

    fn at(position: &Point2<f64>, cov: &Matrix2<f64>, kind: &PointKind) -> Self {
        let (kind, radius) = match kind {
            PointKind::Circle { radius, .. } => (LandmarkName::Post, *radius),
            _ => (LandmarkName::Corner, 0.0),
        };
        Self {
            id: f32::NAN,
            kind: f32::from(kind as u8),
            x: position.x as f32,
            y: position.y as f32,
            var_x: cov[(0, 0)] as f32,
            cov_xy: cov[(0, 1)] as f32,
            var_y: cov[(1, 1)] as f32,
            radius: radius as f32,
            confidence: 0.0,
            confirmed: 1.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use slamlab_core::estimation::LandmarkId;

    use super::*;

    #[test]
    fn a_post_keeps_its_number_size_and_confidence() {
        let post = PointLandmark {
            id: LandmarkId(7),
            kind: PointKind::Circle {
                radius: 0.25,
                var_radius: 0.01,
            },
            position: Point2::new(1.0, -2.0),
            cov: Matrix2::new(4.0, 1.0, 1.0, 9.0),
            sightings: 6,
            is_confirmed: true,
        };
        let row: [f32; LandmarkRow::STRIDE] = LandmarkRow::of_point(&post).into();
        assert_eq!(row, [7.0, 2.0, 1.0, -2.0, 4.0, 1.0, 9.0, 0.25, 5.0, 1.0]);
    }
}

//! A wall in the state and in the map; steps 4 and 6: how it enters the state, grows, and leaves
//! it.

use nalgebra::{Matrix2, Matrix2x3, Point2, Vector2};

use super::super::line_model::place;
use super::sighting::from_anchor;
use super::{EkfSlam, POSE};
use crate::features::LineFeature;
use crate::geom::{Line, Pose2, sin_cos, symmetrize};

/// Name of a landmark, the same for its whole life and never reused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct LandmarkId(pub u32);

/// A wall in the map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Landmark {
    /// Its name.
    pub id: LandmarkId,
    /// The line in the map frame.
    pub line: Line,
    /// Covariance of (α, r).
    pub cov: Matrix2<f64>,
    /// Where the part seen so far begins and ends, map frame.
    pub ends: [Point2<f64>; 2],
    /// How often it was seen.
    pub sightings: u32,
    /// Whether that is often enough to be a wall.
    pub is_confirmed: bool,
}

impl Landmark {
    /// How often it was found again.
    ///
    /// # Source   Pilch 2016 §3.5.2: the confidence of a landmark grows by 1 each time.
    #[must_use]
    pub fn confidence(&self) -> u32 {
        self.sightings.saturating_sub(1)
    }
}

/// A wall in the state.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Entry {
    pub(super) id: LandmarkId,
    /// The state's row of α; that of r is the next.
    pub(super) row: usize,
    /// Where r counts from, map frame; never moves.
    pub(super) anchor: Point2<f64>,
    /// (α, r), r signed.
    pub(super) line: [f64; 2],
    /// α at the first sighting.
    pub(super) first_alpha: f64,
    /// The interval in which it was seen, m along (-sin α, cos α) from the foot of the anchor on
    /// the line.
    pub(super) extent: [f64; 2],
    /// The part of it that was seen by the last scan that saw it.
    pub(super) seen_now: [f64; 2],
    pub(super) sightings: u32,
    pub(super) last_seen: u32,
}

impl Entry {
    pub(super) fn tangent(&self) -> Vector2<f64> {
        let (sin, cos) = sin_cos(self.line[0]);
        Vector2::new(-sin, cos)
    }

    pub(super) fn ends(&self) -> [Point2<f64>; 2] {
        let tangent = self.tangent();
        let foot = self.anchor + Vector2::new(tangent.y, -tangent.x) * self.line[1];
        self.extent.map(|along| foot + tangent * along)
    }

    /// The interval on it of a line seen from `pose`.
    pub(super) fn extent_of(&self, seen: &LineFeature, pose: &Pose2) -> [f64; 2] {
        let tangent = self.tangent();
        let along = |end: Point2<f64>| tangent.dot(&(*pose * end - self.anchor));
        let [a, b] = seen.ends.map(along);
        [a.min(b), a.max(b)]
    }

    /// The line and its covariance with r counted from the origin of the map, r ≥ 0.
    pub(super) fn in_map(&self, cov: &Matrix2<f64>) -> (Line, Matrix2<f64>) {
        let tangent = self.tangent();
        let normal = Vector2::new(tangent.y, -tangent.x);
        let r = self.line[1] + normal.dot(&self.anchor.coords);
        let sign = if r < 0.0 { -1.0 } else { 1.0 };
        let jacobian = Matrix2::new(1.0, 0.0, sign * tangent.dot(&self.anchor.coords), sign);
        let mut cov = jacobian * cov * jacobian.transpose();
        symmetrize(&mut cov);
        (Line::new(self.line[0], r), cov)
    }
}

/// The smallest interval that contains both.
pub(super) fn hull(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0].min(b[0]), a[1].max(b[1])]
}

impl EkfSlam {
    /// Counts a sighting and widens the known part of the wall.
    pub(super) fn extend(&mut self, landmark: usize, seen: &LineFeature) {
        let (pose, scans) = (self.pose, self.scans);
        let entry = &mut self.landmarks[landmark];
        let seen = entry.extent_of(seen, &pose);
        entry.extent = hull(entry.extent, seen);
        if entry.last_seen == scans {
            // Another part of the wall, behind an object in front of it.
            entry.seen_now = hull(entry.seen_now, seen);
        } else {
            entry.seen_now = seen;
            entry.sightings += 1;
            entry.last_seen = scans;
        }
    }

    /// Step 4.
    pub(super) fn augment(&mut self, seen: &LineFeature) -> LandmarkId {
        let oriented = self.oriented(seen);
        let anchor = self.pose * nalgebra::center(&seen.ends[0], &seen.ends[1]);
        let (line, by_pose, by_seen) = place(
            &from_anchor(&self.pose, &anchor),
            [oriented.alpha, oriented.r],
            self.linearised_at() - anchor.coords,
        );
        let corner = by_pose * self.pose_cov() * by_pose.transpose()
            + by_seen * oriented.cov * by_seen.transpose();
        let (id, row) = self.append(&by_pose, &corner);
        self.landmarks.push(Entry {
            id,
            row,
            anchor,
            line,
            first_alpha: line[0],
            extent: [f64::INFINITY, f64::NEG_INFINITY],
            seen_now: [f64::INFINITY, f64::NEG_INFINITY],
            sightings: 0,
            last_seen: 0,
        });
        self.extend(self.landmarks.len() - 1, seen);
        id
    }

    /// Appends two rows for a landmark that follows from the pose and a sighting: given its
    /// derivative with respect to the pose, and its own covariance. Returns its name and the first
    /// of its rows.
    pub(super) fn append(
        &mut self,
        by_pose: &Matrix2x3<f64>,
        own: &Matrix2<f64>,
    ) -> (LandmarkId, usize) {
        // Eq. (3.31): the new rows are G_x times the rows of the pose.
        let cov = &self.cov;
        let element = |h: usize, column: usize| -> f64 {
            (0..POSE)
                .map(|k| by_pose[(h, k)] * cov.get(k, column))
                .sum()
        };
        let row = |h: usize| (0..cov.n()).map(move |column| element(h, column));
        let first: Vec<f64> = row(0).chain([own[(0, 0)]]).collect();
        let mixed = 0.5 * (own[(0, 1)] + own[(1, 0)]);
        let second: Vec<f64> = row(1).chain([mixed, own[(1, 1)]]).collect();
        let place = self.cov.n();
        self.cov.push_pair([first, second]);
        let id = LandmarkId(self.next_id);
        self.next_id += 1;
        (id, place)
    }

    /// Removes the two rows of a landmark; what remains is the marginal.
    pub(super) fn remove_rows(&mut self, first: usize) {
        self.cov.remove_pair(first);
        let walls = self.landmarks.iter_mut().map(|entry| &mut entry.row);
        let points = self.points.iter_mut().map(|entry| &mut entry.row);
        for row in walls.chain(points).filter(|row| **row > first) {
            *row -= 2;
        }
    }

    /// Step 6.
    pub(super) fn forget(&mut self) {
        let (confirmed, patience) = (self.config.confirm_sightings, self.config.patience);
        let (scans, mut rows) = (self.scans, vec![]);
        let mut is_kept = |id, row, sightings: u32, last_seen: u32| {
            let is_kept = sightings >= confirmed || scans - last_seen <= patience;
            if !is_kept {
                self.report.forgotten.push(id);
                rows.push(row);
            }
            is_kept
        };
        (self.landmarks).retain(|e| is_kept(e.id, e.row, e.sightings, e.last_seen));
        (self.points).retain(|e| is_kept(e.id, e.row, e.sightings, e.last_seen));
        // From the last on, so that the remaining indices stay valid.
        rows.sort_unstable();
        for row in rows.into_iter().rev() {
            self.remove_rows(row);
        }
    }
}

//! Step 3 for all lines and points of a scan together: which landmark each one is, such that no two
//! contradict each other.
//!
//! In: the lines and points of a scan. Out: for each its landmark, by its row in the state, or none
//! that agrees with the others.
//!
//! Lines and points that a turning lidar sees one after another are moved to the instant of the
//! first of them: back by the odometry, with the odometry's covariance added to each separately.
//! That several of them share this part is neglected, which makes the test slightly more
//! permissive. The updates that follow are still made one by one, each at its own instant.

use nalgebra::{Matrix2, Matrix2x3};

use super::EkfSlam;
use super::point_model::moved_with;
use super::sighting::Jacobian;
use super::sweep::{SweepTiming, as_seen, point_as_seen};
use crate::association::{Candidate, Innovation, JointSearch, Paired, Pairing, gap, plausible};
use crate::features::{LineFeature, PointFeature};

/// Buffers of the search, kept from scan to scan to avoid allocations.
#[derive(Clone, Debug, Default)]
pub(super) struct JointScratch {
    /// What each line, then each point, was matched to, if all of a scan are matched together.
    pub(super) paired: Vec<Paired>,
    search: JointSearch,
    seen: Vec<LineFeature>,
    seen_points: Vec<PointFeature>,
    candidates: Vec<Candidate>,
    pairings: Vec<Pairing>,
    /// The Jacobians of all landmarks that some sighting may be, sorted by row.
    jacobians: Vec<Jacobian>,
}

impl JointScratch {
    fn jacobian(&self, row: usize) -> Option<&Jacobian> {
        self.jacobians.get(self.place(row).ok()?)
    }

    /// The index of a landmark in `jacobians`, or where it should be inserted.
    fn place(&self, row: usize) -> Result<usize, usize> {
        self.jacobians.binary_search_by_key(&row, |known| known.row)
    }

    /// The candidates, nearest first, in the memory of `candidates`, which must be given back.
    fn sorted(&mut self, compared: impl Iterator<Item = Candidate>) -> Vec<Candidate> {
        let mut candidates = std::mem::take(&mut self.candidates);
        candidates.clear();
        candidates.extend(compared);
        candidates.sort_unstable_by(|a, b| a.d2.total_cmp(&b.d2).then(a.index.cmp(&b.index)));
        candidates
    }

    fn pair(&mut self, sighting: usize, jacobian: Jacobian, innovation: &Innovation) {
        self.pairings.push(Pairing {
            sighting,
            landmark: jacobian.row,
            v: innovation.v,
            cov: innovation.cov,
        });
        if let Err(place) = self.place(jacobian.row) {
            self.jacobians.insert(place, jacobian);
        }
    }
}

impl EkfSlam {
    /// For each of `lines`, then each of `points`, what it is. The state is at the instant of the
    /// first of them.
    pub(super) fn pair_jointly(
        &self,
        lines: &[LineFeature],
        points: &[PointFeature],
        sweep: &SweepTiming,
        scratch: &mut JointScratch,
    ) {
        scratch.seen.clear();
        scratch
            .seen
            .extend(lines.iter().map(|f| self.seen_now(f, sweep)));
        scratch.seen_points.clear();
        scratch
            .seen_points
            .extend(points.iter().map(|p| self.point_seen_now(p, sweep)));
        scratch.jacobians.clear();
        let mut search = std::mem::take(&mut scratch.search);
        search.clear();
        for sighting in 0..lines.len() {
            self.pairings(sighting, scratch);
            search.sight(scratch.pairings.iter().copied());
        }
        for point in 0..points.len() {
            self.point_pairings(point, lines.len() + point, scratch);
            search.sight(scratch.pairings.iter().copied());
        }
        let shared = self.config.merge.shared;
        let cross = |a: &Pairing, b: &Pairing| {
            let [seen_a, seen_b] = [a, b].map(|pairing| scratch.seen.get(pairing.sighting));
            // Two parts of one wall hardly overlap; a point is seen once.
            if a.landmark == b.landmark && gap(seen_a?.ends, seen_b?) <= -shared {
                return None;
            }
            Some(self.cross(scratch.jacobian(a.landmark)?, scratch.jacobian(b.landmark)?))
        };
        let found = search.run(cross, &self.config.association);
        scratch.paired.extend_from_slice(found);
        scratch.search = search;
    }

    /// A line of the sweep as it would be seen from the present state.
    fn seen_now(&self, feature: &LineFeature, sweep: &SweepTiming) -> LineFeature {
        let end = sweep.stamp.seconds();
        let mut line = as_seen(feature, &self.motion_until(end), sweep);
        let beams = [feature.first_beam, feature.last_beam];
        let until = self.motion_until(end - sweep.age_of(beams));
        let normal = line.line.normal();
        let by_motion = Matrix2x3::new(0.0, 0.0, 1.0, normal.x, normal.y, 0.0);
        line.cov += by_motion * until.cov * by_motion.transpose();
        line
    }

    /// The landmarks that a line may be when considered alone, the nearest first.
    fn pairings(&self, sighting: usize, scratch: &mut JointScratch) {
        scratch.pairings.clear();
        let Some(seen) = scratch.seen.get(sighting).copied() else {
            return;
        };
        let compared = (0..self.landmarks.len()).filter_map(|l| Some(self.compare(l, &seen)?.0));
        let candidates = scratch.sorted(compared);
        for candidate in plausible(&candidates, self.config.association.gate) {
            let expectation = self.expect(candidate.index);
            if let Some(innovation) = self.innovation(&expectation, &seen) {
                scratch.pair(sighting, expectation.jacobian, &innovation);
            }
        }
        scratch.candidates = candidates;
    }

    /// A point of the sweep as it would be seen from the present state.
    fn point_seen_now(&self, point: &PointFeature, sweep: &SweepTiming) -> PointFeature {
        let end = sweep.stamp.seconds();
        let mut seen = point_as_seen(point, &self.motion_until(end), sweep);
        let until = self.motion_until(end - sweep.age_of(point.beams));
        let by_motion = moved_with(seen.position - until.motion.position());
        seen.cov += by_motion * until.cov * by_motion.transpose();
        seen
    }

    /// The landmarks that a point may be when considered alone, the nearest first.
    fn point_pairings(&self, point: usize, sighting: usize, scratch: &mut JointScratch) {
        scratch.pairings.clear();
        let Some(seen) = scratch.seen_points.get(point).copied() else {
            return;
        };
        let compared = (0..self.points.len()).filter_map(|l| Some(self.compare_point(l, &seen)?.0));
        let candidates = scratch.sorted(compared);
        for candidate in plausible(&candidates, self.config.association.gate) {
            let Some(entry) = self.points.get(candidate.index) else {
                continue;
            };
            let expected = self.expect_point(entry);
            if let Some(innovation) = self.point_innovation(&expected, &seen) {
                scratch.pair(sighting, expected.jacobian, &innovation);
            }
        }
        scratch.candidates = candidates;
    }

    /// Cross-covariance of the expected sightings of two landmarks: H_a P H_bᵀ.
    fn cross(&self, of_a: &Jacobian, of_b: &Jacobian) -> Matrix2<f64> {
        let (a, b) = (of_a.row, of_b.row);
        let with_pose =
            |first: usize| Matrix2x3::from_fn(|row, column| self.cov.get(first + row, column));
        let between = Matrix2::from_fn(|row, column| self.cov.get(a + row, b + column));
        of_a.by_pose * self.pose_cov() * of_b.by_pose.transpose()
            + of_a.by_pose * with_pose(b).transpose() * of_b.by_own.transpose()
            + of_a.by_own * with_pose(a) * of_b.by_pose.transpose()
            + of_a.by_own * between * of_b.by_own.transpose()
    }
}

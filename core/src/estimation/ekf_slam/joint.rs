//! Step 3 for all lines of a scan together: which landmark each is, so that no two contradict each
//! other.
//!
//! In: the lines of a scan. Out: for each its landmark, or none that agrees with the others.
//!
//! Lines that a turning lidar sees one after another are taken to the instant of the first of them:
//! back by the odometry, with the odometry's covariance added to each by itself. That this part is
//! common to several lines is left out, which makes the test a little more generous. The updates
//! that follow are still made one by one, each at its own instant.

use nalgebra::{Matrix2, Matrix2x3};

use super::sighting::Expectation;
use super::sweep::{SweepTiming, as_seen};
use super::{EkfSlam, ROBOT};
use crate::association::{Candidate, JointSearch, Paired, Pairing, gap, plausible};
use crate::features::LineFeature;

/// What the search keeps from scan to scan, so that none of it is allocated again.
#[derive(Clone, Debug, Default)]
pub(super) struct JointScratch {
    /// What each line is, where all of a scan are matched together.
    pub(super) paired: Vec<Paired>,
    search: JointSearch,
    seen: Vec<LineFeature>,
    candidates: Vec<Candidate>,
    pairings: Vec<Pairing>,
    /// Of each landmark that some line may be, by its index.
    expected: Vec<(usize, Expectation)>,
}

impl JointScratch {
    fn expected(&self, landmark: usize) -> Option<&Expectation> {
        let place = self.place(landmark).ok()?;
        self.expected.get(place).map(|(_, expected)| expected)
    }

    /// Where a landmark stands in `expected`, or should.
    fn place(&self, landmark: usize) -> Result<usize, usize> {
        let known = |(known, _): &(usize, Expectation)| *known;
        self.expected.binary_search_by_key(&landmark, known)
    }
}

impl EkfSlam {
    /// For each of `features` what it is. The state stands at the first of them.
    pub(super) fn pair_jointly(
        &self,
        features: &[LineFeature],
        sweep: &SweepTiming,
        scratch: &mut JointScratch,
    ) {
        scratch.seen.clear();
        scratch
            .seen
            .extend(features.iter().map(|f| self.seen_now(f, sweep)));
        scratch.expected.clear();
        let mut search = std::mem::take(&mut scratch.search);
        search.clear();
        for sighting in 0..features.len() {
            self.pairings(sighting, scratch);
            search.sight(scratch.pairings.iter().copied());
        }
        let shared = self.config.merge.shared;
        let cross = |a: &Pairing, b: &Pairing| {
            let [seen_a, seen_b] = [a, b].map(|pairing| scratch.seen.get(pairing.sighting));
            // Two parts of one wall overlap by little.
            if a.landmark == b.landmark && gap(seen_a?.ends, seen_b?) <= -shared {
                return None;
            }
            Some(self.cross(
                (a.landmark, scratch.expected(a.landmark)?),
                (b.landmark, scratch.expected(b.landmark)?),
            ))
        };
        let found = search.run(cross, &self.config.association);
        scratch.paired.extend_from_slice(found);
        scratch.search = search;
    }

    /// A line of the sweep as it would be seen from where the state stands.
    fn seen_now(&self, feature: &LineFeature, sweep: &SweepTiming) -> LineFeature {
        let end = sweep.stamp.seconds();
        let mut line = as_seen(feature, &self.motion_until(end), sweep);
        let until = self.motion_until(end - sweep.age_of(feature));
        let normal = line.line.normal();
        let by_motion = Matrix2x3::new(0.0, 0.0, 1.0, normal.x, normal.y, 0.0);
        line.cov += by_motion * until.cov * by_motion.transpose();
        line
    }

    /// The landmarks that a line may be by itself, the nearest first.
    fn pairings(&self, sighting: usize, scratch: &mut JointScratch) {
        scratch.pairings.clear();
        scratch.candidates.clear();
        let Some(seen) = scratch.seen.get(sighting) else {
            return;
        };
        let compared = (0..self.landmarks.len()).filter_map(|l| Some(self.compare(l, seen)?.0));
        scratch.candidates.extend(compared);
        scratch
            .candidates
            .sort_unstable_by(|a, b| a.d2.total_cmp(&b.d2).then(a.index.cmp(&b.index)));
        for candidate in plausible(&scratch.candidates, self.config.association.gate) {
            let landmark = candidate.index;
            let expectation = self.expect(landmark);
            let Some(innovation) = self.innovation(&expectation, seen) else {
                continue;
            };
            scratch.pairings.push(Pairing {
                sighting,
                landmark,
                v: innovation.v,
                cov: innovation.cov,
            });
            if let Err(place) = scratch.place(landmark) {
                scratch.expected.insert(place, (landmark, expectation));
            }
        }
    }

    /// Covariance of what is expected of two landmarks: H_a P H_bᵀ.
    fn cross(&self, a: (usize, &Expectation), b: (usize, &Expectation)) -> Matrix2<f64> {
        let ((a, of_a), (b, of_b)) = ((ROBOT + 2 * a.0, a.1), (ROBOT + 2 * b.0, b.1));
        let with_pose =
            |first: usize| Matrix2x3::from_fn(|row, column| self.cov.get(first + row, column));
        let between = Matrix2::from_fn(|row, column| self.cov.get(a + row, b + column));
        of_a.by_pose * self.pose_cov() * of_b.by_pose.transpose()
            + of_a.by_pose * with_pose(b).transpose() * of_b.by_line.transpose()
            + of_a.by_line * with_pose(a) * of_b.by_pose.transpose()
            + of_a.by_line * between * of_b.by_line.transpose()
    }
}

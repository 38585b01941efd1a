//! Step 3 for all lines of a scan together: which landmark each is, so that no two contradict each other.
//!
//! In: the lines of a scan. Out: for each its landmark, or none that agrees with the others.
//!
//! Lines that a turning lidar sees one after another are taken to the instant of the first of them: back by the odometry, with the
//! odometry's covariance added to each by itself. That this part is common to several lines is left out, which makes the test
//! a little more generous. The updates that follow are still made one by one, each at its own instant.

use std::collections::BTreeMap;

use nalgebra::{Matrix2, Matrix2x3};

use super::expect::Expectation;
use super::merge::SHARED;
use super::sweep::{SweepTiming, as_seen};
use super::{EkfSlam, ROBOT};
use crate::association::{ExpectedLine, JointConfig, Pairing, joint_matches};
use crate::features::LineFeature;

/// More sets of pairings than this are not looked at; a scan of twenty lines needs some hundred.
const MOST_SETS: usize = 5_000;

impl EkfSlam {
    /// For each of `features` the index of its landmark. The state stands at the first of them.
    pub(super) fn pair_jointly(
        &self,
        features: &[LineFeature],
        sweep: &SweepTiming,
    ) -> Vec<Option<usize>> {
        let seen: Vec<LineFeature> = features.iter().map(|f| self.seen_now(f, sweep)).collect();
        let mut expected: BTreeMap<usize, Expectation> = BTreeMap::new();
        let candidates: Vec<Vec<Pairing>> = seen
            .iter()
            .enumerate()
            .map(|(sighting, line)| self.pairings(sighting, line, &mut expected))
            .collect();
        let cross = |a: &Pairing, b: &Pairing| {
            if a.landmark == b.landmark
                && !are_two_parts(seen.get(a.sighting)?, seen.get(b.sighting)?)
            {
                return None;
            }
            Some(self.cross(
                (a.landmark, expected.get(&a.landmark)?),
                (b.landmark, expected.get(&b.landmark)?),
            ))
        };
        let config = JointConfig {
            gate: self.config.association.gate,
            most_sets: MOST_SETS,
        };
        let found = joint_matches(&candidates, cross, &config);
        found
            .chosen
            .iter()
            .zip(&candidates)
            .map(|(place, own)| Some(own.get((*place)?)?.landmark))
            .collect()
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

    fn pairings(
        &self,
        sighting: usize,
        seen: &LineFeature,
        expected: &mut BTreeMap<usize, Expectation>,
    ) -> Vec<Pairing> {
        let config = &self.config.association;
        let mut pairings = vec![];
        for landmark in 0..self.landmarks.len() {
            let Some((candidate, _)) = self.compare(landmark, seen) else {
                continue;
            };
            if candidate.d2 > config.gate || candidate.gap > config.max_gap {
                continue;
            }
            let expectation = self.expect(landmark);
            if let Some(innovation) = self.innovation(&expectation, seen) {
                pairings.push(Pairing {
                    sighting,
                    landmark,
                    v: innovation.v,
                    cov: innovation.cov,
                });
                expected.insert(landmark, expectation);
            }
        }
        pairings.sort_by(|a, b| {
            let d2 = |p: &Pairing| {
                p.cov
                    .cholesky()
                    .map_or(f64::INFINITY, |c| p.v.dot(&c.solve(&p.v)))
            };
            d2(a).total_cmp(&d2(b))
        });
        pairings
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

/// Whether two lines of a scan may be parts of one wall: they do not overlap.
fn are_two_parts(a: &LineFeature, b: &LineFeature) -> bool {
    let first = ExpectedLine {
        alpha: a.line.alpha(),
        r: a.line.r(),
        cov: a.cov,
        ends: a.ends,
    };
    first.gap(b) > -SHARED
}

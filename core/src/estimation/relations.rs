//! How far a trajectory is from reference motions between its scans.
//!
//! In: a trajectory stamped in seconds, reference motions. Out: [`RelationErrors`].
//!
//! The error of a relation is the motion from the true to the estimated motion, δ*⁻¹ δ: its length
//! and its rotation. A measure over relations does not penalise one wrong turn early in the run
//! over and over, as one over absolute poses does.
//!
//! Source: Kümmerle et al. (2009), "On measuring the accuracy of SLAM algorithms", Autonomous
//! Robots 27, eq. (3)-(5).

use super::stamps::PosesByStamp;
use crate::geom::{Length, Pose2};

/// Errors over a set of relations: absolute and squared, of shift and rotation.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RelationErrors {
    /// Relations whose two scans are both in the trajectory.
    pub count: usize,
    /// Relations with a missing scan.
    pub left_out: usize,
    /// Mean length of the error, m.
    pub trans_abs_mean: f64,
    /// Standard deviation of the length, m.
    pub trans_abs_std: f64,
    /// Mean squared length, m².
    pub trans_sq_mean: f64,
    /// The part of the relations whose error is longer than half a metre.
    pub wrong_part: f64,
    /// Mean size of the turn, rad.
    pub rot_abs_mean: f64,
    /// Standard deviation of the size of the turn, rad.
    pub rot_abs_std: f64,
    /// Mean squared turn, rad².
    pub rot_sq_mean: f64,
}

/// An error longer than this is wrong, whatever the noise of the reference, m.
const WRONG: f64 = 0.5;

/// A true motion between two scans: stamps of both, s, and the pose at the second in the frame of
/// the first.
pub type StampedMotion = (f64, f64, Pose2);

/// Measures a trajectory, sorted by stamp, at relations.
/// Their stamps may be rounded to fewer decimals than those of the log.
#[must_use]
pub fn relation_errors(
    relations: impl IntoIterator<Item = StampedMotion>,
    trajectory: &[(f64, Pose2)],
) -> RelationErrors {
    let relations: Vec<_> = relations.into_iter().collect();
    let stamps = relations.iter().flat_map(|&(from, to, _)| [from, to]);
    let poses = PosesByStamp::new(trajectory, &stamps);
    let errors: Vec<(f64, f64)> = relations
        .iter()
        .filter_map(|&(from, to, truth)| {
            let from = poses.at(from)?;
            let error = truth.delta_to(&from.delta_to(&poses.at(to)?));
            Some((error.position().coords.length(), error.heading().abs()))
        })
        .collect();
    let (trans_abs_mean, trans_abs_std, trans_sq_mean) = moments(errors.iter().map(|e| e.0));
    let wrong = errors.iter().filter(|(length, _)| *length > WRONG).count();
    let (rot_abs_mean, rot_abs_std, rot_sq_mean) = moments(errors.iter().map(|e| e.1));
    RelationErrors {
        count: errors.len(),
        left_out: relations.len() - errors.len(),
        trans_abs_mean,
        trans_abs_std,
        trans_sq_mean,
        wrong_part: wrong as f64 / errors.len().max(1) as f64,
        rot_abs_mean,
        rot_abs_std,
        rot_sq_mean,
    }
}

/// Mean, standard deviation and mean square; zeros if there are no values.
fn moments(values: impl Iterator<Item = f64> + Clone) -> (f64, f64, f64) {
    let count = values.clone().count().max(1) as f64;
    let mean = values.clone().sum::<f64>() / count;
    let square = values.clone().map(|v| v * v).sum::<f64>() / count;
    let variance = values.map(|v| (v - mean) * (v - mean)).sum::<f64>() / count;
    (mean, variance.sqrt(), square)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_errors_give_known_figures() {
        // Two relations: one off by (3, 4) cm, one by a turn of 0.2 rad in the opposite direction.
        let trajectory = [
            (1.0, Pose2::new(0.0, 0.0, 1.0)),
            (2.0, Pose2::new(0.0, 0.0, 1.0) * Pose2::new(1.03, 0.04, 0.0)),
            (
                3.0,
                Pose2::new(0.0, 0.0, 1.0) * Pose2::new(1.03, 0.04, -0.2),
            ),
        ];
        let truth = [
            (1.0, 2.0, Pose2::new(1.0, 0.0, 0.0)),
            (2.0, 3.0, Pose2::identity()),
            (2.0, 9.0, Pose2::identity()),
        ];
        let e = relation_errors(truth, &trajectory);
        assert_eq!(e.count, 2);
        for (got, expect) in [
            (e.trans_abs_mean, 0.025),
            (e.trans_abs_std, 0.025),
            (e.trans_sq_mean, 0.00125),
            (e.rot_abs_mean, 0.1),
            (e.rot_abs_std, 0.1),
            (e.rot_sq_mean, 0.02),
        ] {
            assert!((got - expect).abs() < 1e-9, "{e:?}");
        }
    }

    #[test]
    fn stamps_with_fewer_decimals_find_their_scans_and_the_missing_are_counted() {
        let stamps = [
            1_172_771_123.123_456,
            1_172_771_123.333_459,
            1_172_771_123.543_21,
        ];
        let trajectory = stamps.map(|s| (s, Pose2::new(s - stamps[0], 0.0, 0.0)));
        let motion = |a: usize, b: usize| Pose2::new(stamps[b] - stamps[a], 0.0, 0.0);
        let cut = |s: f64| (s * 1e5).floor() / 1e5;
        let truth = [
            (cut(stamps[0]), cut(stamps[1]), motion(0, 1)),
            (cut(stamps[1]), cut(stamps[2]), motion(1, 2)),
            (cut(stamps[1]), cut(stamps[2]) + 5e-5, motion(1, 2)),
        ];
        let e = relation_errors(truth, &trajectory);
        assert_eq!((e.count, e.left_out), (2, 1));
        assert!(e.trans_abs_mean < 1e-9, "{e:?}");
        // With all decimals written, a nearby stamp is not enough.
        let exact = truth.map(|(from, to, motion)| (from, to + 1e-6, motion));
        assert_eq!(relation_errors(exact, &trajectory).count, 0);
    }

    #[test]
    fn moving_the_whole_trajectory_changes_nothing_and_nothing_gives_zeros() {
        let trajectory: Vec<_> = (0..10)
            .map(|i| {
                (
                    f64::from(i),
                    Pose2::new(f64::from(i), 0.3, 0.1 * f64::from(i)),
                )
            })
            .collect();
        let moved: Vec<_> = trajectory
            .iter()
            .map(|&(t, p)| (t, Pose2::new(5.0, -2.0, 2.0) * p))
            .collect();
        let truth = [
            (1.0, 4.0, Pose2::new(3.1, 0.0, 0.2)),
            (2.0, 3.0, Pose2::identity()),
        ];
        let (a, b) = (
            relation_errors(truth, &trajectory),
            relation_errors(truth, &moved),
        );
        assert!((a.trans_abs_mean - b.trans_abs_mean).abs() < 1e-12);
        assert!((a.rot_sq_mean - b.rot_sq_mean).abs() < 1e-12);
        assert_eq!(relation_errors([], &trajectory), RelationErrors::default());
    }

    /// Raw odometry of the Intel log against its reference: the figures stated in the data's own
    /// description.
    #[test]
    fn raw_odometry_of_intel_gives_the_stated_figures() {
        use crate::format::{carmen::CarmenLog, recorded, relations};
        let (Some(log), Some(truth)) = (
            recorded("intel/intel.clf"),
            recorded("intel/intel.relations"),
        ) else {
            return;
        };
        let log = CarmenLog::parse(&log).unwrap();
        assert_eq!(log.scans.len(), 13_631);
        let mut trajectory: Vec<_> = log
            .scans
            .iter()
            .map(|s| (s.ipc_seconds, s.odom_from_robot))
            .collect();
        // Its stamps run backwards here and there.
        trajectory.sort_by(|a, b| a.0.total_cmp(&b.0));
        let truth = relations::parse(&truth).unwrap();
        let part = |long: bool| {
            let chosen = truth
                .iter()
                .filter(|r| ((r.to_seconds - r.from_seconds).abs() >= 20.0) == long)
                .map(|r| (r.from_seconds, r.to_seconds, r.motion));
            relation_errors(chosen, &trajectory)
        };
        let (short, long) = (part(false), part(true));
        assert_eq!(short.count + long.count, truth.len());
        assert!((short.trans_abs_mean - 0.0235).abs() < 0.0005, "{short:?}");
        assert!((long.trans_abs_mean - 18.1).abs() < 0.1, "{long:?}");
    }
}

//! How far a trajectory is from a reference trajectory of the same scans.
//!
//! In: both, stamped in seconds. Out: [`AbsoluteErrors`], or motions of the reference, which
//! [`super::relation_errors`] compares with those of the trajectory.
//!
//! 1. Absolute: distances of positions after the rigid motion that aligns them best. One wrong turn
//!    early in the run affects all that follows.
//! 2. Relative, over a distance: from each pose to the first one at least this far along the path.
//! 3. At revisits: from each pose to the first much later one at the same place. This shows whether
//!    loops close, and needs no alignment; a reference that is good only to some centimetres is
//!    most informative there.
//!
//! Source: Sturm et al. (2012), "A benchmark for the evaluation of RGB-D SLAM systems", §V; motions
//! over a distance as in Geiger et al. (2012), "Are we ready for autonomous driving?", §3.

use nalgebra::Point2;

use super::measures::align;
use super::relations::StampedMotion;
use super::stamps::PosesByStamp;
use crate::geom::{Length, Pose2};

/// Poses are at the same place up to this distance, m.
const SAME_PLACE: f64 = 2.0;
/// Poses with fewer poses than this between them belong to one visit.
const ONE_VISIT: usize = 50;

/// Distances of positions after alignment, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AbsoluteErrors {
    /// Poses of the reference that the trajectory has too.
    pub count: usize,
    /// Poses of the reference that the trajectory lacks.
    pub left_out: usize,
    /// Root of the mean squared distance, m.
    pub rmse: f64,
    /// The largest distance, m.
    pub max: f64,
}

/// Distances of a trajectory from a reference, both sorted by stamp, after rigid alignment (Umeyama
/// without scale). `None` where they have fewer than two poses in common.
#[must_use]
pub fn absolute_errors(
    reference: &[(f64, Pose2)],
    trajectory: &[(f64, Pose2)],
) -> Option<AbsoluteErrors> {
    let poses = PosesByStamp::new(trajectory, &reference.iter().map(|(stamp, _)| *stamp));
    let both = reference
        .iter()
        .filter_map(|(stamp, truth)| Some((truth.position(), poses.at(*stamp)?.position())));
    let (truth, estimate): (Vec<Point2<f64>>, Vec<Point2<f64>>) = both.unzip();
    let reference_from_map = align(&truth, &estimate)?;
    let pairs = truth.iter().zip(&estimate);
    let squares = pairs.map(|(t, e)| (t - reference_from_map * *e).norm_squared());
    Some(AbsoluteErrors {
        count: truth.len(),
        left_out: reference.len() - truth.len(),
        rmse: (squares.clone().sum::<f64>() / truth.len() as f64).sqrt(),
        max: squares.fold(0.0, f64::max).sqrt(),
    })
}

/// Motions of a reference over a distance, m: from each pose to the first one at least this far
/// along the path.
#[must_use]
pub fn motions_over(reference: &[(f64, Pose2)], distance: f64) -> Vec<StampedMotion> {
    let step = |pair: &[(f64, Pose2)]| (pair[1].1.position() - pair[0].1.position()).length();
    let mut ways = vec![0.0];
    for pair in reference.windows(2) {
        ways.push(ways[ways.len() - 1] + step(pair));
    }
    let from_each = reference.iter().zip(&ways);
    from_each
        .filter_map(|(from, way)| {
            let to = ways.partition_point(|other| *other < way + distance);
            Some(motion(from, reference.get(to)?))
        })
        .collect()
}

/// Motions of a reference between two visits of one place: from each pose to the first within 2 m
/// that comes at least 50 poses later.
#[must_use]
pub fn revisits(reference: &[(f64, Pose2)]) -> Vec<StampedMotion> {
    let from_each = reference.iter().enumerate();
    from_each
        .filter_map(|(index, from)| {
            let place = from.1.position();
            let mut later = reference.iter().skip(index + ONE_VISIT);
            let to = later.find(|(_, pose)| (pose.position() - place).length() < SAME_PLACE)?;
            Some(motion(from, to))
        })
        .collect()
}

fn motion(from: &(f64, Pose2), to: &(f64, Pose2)) -> StampedMotion {
    (from.0, to.0, from.1.delta_to(&to.1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimation::relation_errors;

    /// Along the x axis, one metre per second.
    fn straight(poses: u32) -> Vec<(f64, Pose2)> {
        let at = |i: u32| (f64::from(i), Pose2::new(f64::from(i), 0.0, 0.0));
        (0..poses).map(at).collect()
    }

    fn changed(reference: &[(f64, Pose2)], change: impl Fn(&Pose2) -> Pose2) -> Vec<(f64, Pose2)> {
        reference.iter().map(|(t, p)| (*t, change(p))).collect()
    }

    #[test]
    fn a_moved_trajectory_has_no_error_and_a_scaled_one_that_of_its_scale() {
        let reference = straight(101);
        let motion = Pose2::new(5.0, -3.0, 2.0);
        let moved = changed(&reference, |pose| motion * *pose);
        let errors = absolute_errors(&reference, &moved).unwrap();
        assert_eq!((errors.count, errors.left_out), (101, 0));
        assert!(errors.rmse < 1e-9 && errors.max < 1e-9, "{errors:?}");
        // A tenth too long: aligned at the middle, the error is a tenth of the distance from it,
        // at most 5 m; the mean square of -50 … 50 is 50 · 51 / 3.
        let scaled = changed(&moved, |pose| {
            let from = motion.inverse() * *pose;
            motion * Pose2::new(1.1 * from.x(), from.y(), from.heading())
        });
        let errors = absolute_errors(&reference, &scaled).unwrap();
        assert!((errors.max - 5.0).abs() < 1e-9, "{errors:?}");
        assert!((errors.rmse - 0.1 * 850.0_f64.sqrt()).abs() < 1e-9);
        for (distance, count) in [(1.0, 100), (10.0, 91)] {
            let motions = motions_over(&reference, distance);
            let errors = relation_errors(motions, &scaled);
            assert_eq!((errors.count, errors.left_out), (count, 0));
            assert!((errors.trans_abs_mean - 0.1 * distance).abs() < 1e-9);
            assert!(errors.rot_abs_mean < 1e-9);
        }
    }

    #[test]
    fn a_wrong_turn_counts_once_over_a_distance_and_ever_after_in_the_absolute() {
        let reference = straight(21);
        // From x = 10 on it goes to the left.
        let turned = changed(&reference, |pose| match pose.x() {
            x if x <= 10.0 => *pose,
            x => Pose2::new(10.0, x - 10.0, std::f64::consts::FRAC_PI_2),
        });
        let errors = relation_errors(motions_over(&reference, 1.0), &turned);
        assert!((errors.rot_abs_mean - std::f64::consts::FRAC_PI_2 / 20.0).abs() < 1e-9);
        assert!((errors.trans_abs_mean - 2.0_f64.sqrt() / 20.0).abs() < 1e-9);
        assert!((errors.wrong_part - 0.05).abs() < 1e-9);
        assert!(absolute_errors(&reference, &turned).unwrap().rmse > 1.0);
    }

    #[test]
    fn a_revisit_is_the_first_much_later_pose_at_the_same_place() {
        // Out 60 m and back: 50 poses lie between two visits only from 26 m before the end on.
        let way = |i: u32| Pose2::new(60.0 - (60.0 - f64::from(i)).abs(), 0.0, 0.0);
        let reference: Vec<_> = (0..121).map(|i| (f64::from(i), way(i))).collect();
        let found = revisits(&reference);
        // A pose at x meets the way back at x + 1, 1 m before it is there again.
        assert_eq!(found.len(), 36);
        for (from, to, motion) in &found {
            let after = if *from <= 34.0 {
                119.0 - from
            } else {
                from + 50.0
            };
            assert!((to - after).abs() < 1e-9, "{from} {to}");
            assert!((motion.x() - (way(*to as u32).x() - from)).abs() < 1e-9);
        }
        assert_eq!(revisits(&straight(200)), []);
    }

    #[test]
    fn what_the_trajectory_has_not_is_counted_and_stamps_may_be_cut_off() {
        let reference: Vec<_> = straight(10)
            .into_iter()
            .map(|(t, pose)| (t + 0.123, pose))
            .collect();
        let mut trajectory: Vec<_> = reference.iter().map(|(t, p)| (t + 0.000_4, *p)).collect();
        trajectory.remove(4);
        let errors = absolute_errors(&reference, &trajectory).unwrap();
        assert_eq!((errors.count, errors.left_out), (9, 1));
        assert_eq!(absolute_errors(&reference, &trajectory[..1]), None);
        assert_eq!(absolute_errors(&[], &trajectory), None);
    }
}

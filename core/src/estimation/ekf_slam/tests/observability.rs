//! What no sighting can observe, the filter must not learn: robot and walls may be moved and
//! rotated together.
//!
//! Source: Huang, Mourikis & Roumeliotis (2010), "Observability-based rules for designing
//! consistent EKF SLAM estimators": the observability matrix of the filter's own Jacobians must
//! have the three directions of a common motion in its null space. That of the textbook's filter
//! loses the heading; with lines instead of points it loses the shifts too, because a shift moves
//! each line along its normal, which is evaluated at ever new estimates of α.

use nalgebra::{DMatrix, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::super::robot_state::Step;
use super::super::*;
use super::{ONCE, feature, odometry, plain};

const FORMS: [Consistency; 2] = [Consistency::FirstEstimates, Consistency::Plain];

fn filter(consistency: Consistency) -> EkfSlam {
    EkfSlam::new(EkfConfig {
        consistency,
        ..plain()
    })
    .unwrap()
}

/// Three walls as the filter expects them, off by up to 3 σ or so, as noise might make them.
fn seen(slam: &EkfSlam, landmark: usize, rng: &mut ChaCha8Rng) -> LineFeature {
    let line = slam.expect(landmark).line;
    let mut off = || rng.random_range(-0.04..0.04_f64);
    feature(line.alpha + off(), line.r + off())
}

#[test]
fn observability_matrix_of_first_estimates_lacks_three_ranks_and_that_of_the_textbook_none() {
    for (consistency, unobservable) in FORMS.into_iter().zip([3, 0]) {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let mut slam = filter(consistency);
        let walls = [feature(0.2, 5.0), feature(1.8, 6.0), feature(-2.0, 7.0)];
        slam.update(&walls, &ONCE).unwrap();
        let n = POSE + 2 * walls.len();
        let mut transition = DMatrix::<f64>::identity(n, n);
        let mut rows = vec![];
        for _ in 0..10 {
            let noise = Matrix3::from_diagonal(&Vector3::new(1e-3, 1e-3, 1e-3));
            let motion = odometry(Pose2::new(0.3, 0.1, 0.2), noise);
            let from = match consistency {
                Consistency::Plain => slam.pose.position(),
                Consistency::FirstEstimates => slam.predicted,
            };
            let step = Step::new(&slam.pose, &slam.errors, &motion, from);
            slam.advance(&motion);
            let mut f = DMatrix::identity(n, n);
            f.view_mut((0, 0), (POSE, POSE))
                .copy_from(&step.by_robot.fixed_columns::<POSE>(0));
            transition = f * transition;
            for landmark in 0..walls.len() {
                let expected = slam.expect(landmark);
                let mut h = DMatrix::zeros(2, n);
                h.view_mut((0, 0), (2, POSE))
                    .copy_from(&expected.jacobian.by_pose);
                h.view_mut((0, POSE + 2 * landmark), (2, 2))
                    .copy_from(&expected.jacobian.by_own);
                rows.push(h * &transition);
                let seen = seen(&slam, landmark, &mut rng);
                assert!(slam.correct(landmark, &seen));
            }
        }
        let matrix = DMatrix::from_fn(2 * rows.len(), n, |i, j| rows[i / 2][(i % 2, j)]);
        let singular = matrix.singular_values();
        let nothing = singular.iter().filter(|s| **s < 1e-9 * singular[0]).count();
        assert_eq!(nothing, unobservable, "{consistency:?}: {singular}");
    }
}

#[test]
fn standing_robot_learns_nothing_of_its_heading_from_first_estimates() {
    let lost = 0.1;
    for consistency in FORMS {
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        let mut slam = filter(consistency);
        let turned = Matrix3::from_diagonal(&Vector3::new(1e-6, 1e-6, lost * lost));
        slam.predict(&odometry(Pose2::identity(), turned)).unwrap();
        let walls = [feature(0.2, 2.0), feature(1.8, 3.0), feature(-2.0, 4.0)];
        slam.update(&walls, &ONCE).unwrap();
        for _ in 0..200 {
            for landmark in 0..walls.len() {
                let seen = seen(&slam, landmark, &mut rng);
                slam.correct(landmark, &seen);
            }
        }
        let sigma = slam.pose_cov()[(2, 2)].sqrt();
        match consistency {
            Consistency::FirstEstimates => assert!((sigma - lost).abs() < 1e-9, "{sigma}"),
            // From noise alone.
            Consistency::Plain => assert!(sigma < 0.8 * lost, "{sigma}"),
        }
    }
}

//! What was known of a path just before a loop was closed over it, and how far off it then was.
//!
//! In: the pose graph before it follows a new closure, and that closure. Out: a [`LoopError`].
//!
//! 1. The graph without the closure gives the pose of one end in the other, and by its marginals
//!    the covariance C of that pose.
//! 2. The closure gives the same pose from what both ends show, with covariance Σ. The error is the
//!    difference e.
//! 3. If both are honest, eᵀ (C + Σ)⁻¹ e is χ² of 3 degrees of freedom. Its root over √3 is the
//!    ratio: 1 in the mean of squares, and more if the covariances were too small.
//!
//! Closures of one loop that are accepted together have similar errors, because they close one
//! path. Nothing is decided by these figures.
//!
//! Source of step 3: Bar-Shalom, Li & Kirubarajan (2001), "Estimation with Applications to Tracking
//! and Navigation", §5.4, the normalised innovation squared.

use nalgebra::Matrix3;

use super::pose_graph::{Edge, Marginals, PoseGraph};
use super::submap::Doubt;
use crate::geom::Length;
use crate::snapshot::snapshot;

/// Degrees of freedom of a motion.
const FREEDOM: f64 = 3.0;

/// What was known of a path before a loop was closed over it, and how far off it was.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoopError {
    /// The uncertainty of the pose of one end in the other, by the pose graph.
    pub doubt: Doubt,
    /// How far off it was found to be, m.
    pub shift: f64,
    /// The same, rad, not negative.
    pub turn: f64,
    /// The error relative to the uncertainty of the path and of the closure.
    pub ratio: f64,
}

impl LoopError {
    /// Of a closure that is not in the graph yet, whose marginals are `known`; `None` if the graph
    /// does not hold both ends.
    pub(super) fn of(closure: &Edge, graph: &PoseGraph, known: &Marginals) -> Option<Self> {
        let poses = graph.poses();
        let (from, to) = (poses.get(closure.from)?, poses.get(closure.to)?);
        let error = closure.motion.minus(&from.delta_to(to));
        let doubt = known.relative_cov(closure.from, closure.to)?;
        // The information is that of an error in the frame of the end.
        let turned = closure.motion.rotation();
        let own = closure.information.try_inverse()?;
        let own: Matrix3<f64> = turned * own * turned.transpose();
        let chi2 = error.dot(&((doubt + own).try_inverse()? * error));
        Some(Self {
            doubt: Doubt::of(&doubt),
            shift: error.xy().length(),
            turn: error.z.abs(),
            ratio: (chi2.max(0.0) / FREEDOM).sqrt(),
        })
    }
}

snapshot!(
    LoopError {
        doubt,
        shift,
        turn,
        ratio,
    },
    |error| [error.shift, error.turn, error.ratio]
        .iter()
        .all(|n| *n >= 0.0),
    "no error of a way"
);

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    use super::super::pose_graph::information_at_end;
    use super::*;
    use crate::geom::Pose2;
    use crate::points::fixture::normal;

    /// σ of x, y (m) and heading (rad) of each motion, and of placements.
    const STEP: [f64; 3] = [0.1, 0.05, 0.01];
    const PLACED: [f64; 3] = [0.02, 0.02, 0.005];

    fn cov(sigmas: [f64; 3]) -> Matrix3<f64> {
        Matrix3::from_diagonal(&Vector3::from(sigmas.map(|sigma| sigma * sigma)))
    }

    fn information(motion: &Pose2, sigmas: [f64; 3]) -> Matrix3<f64> {
        information_at_end(motion, &cov(sigmas).try_inverse().unwrap())
    }

    /// A path made of these motions.
    fn way(motions: &[Pose2]) -> PoseGraph {
        let mut graph = PoseGraph::default();
        let mut pose = Pose2::identity();
        graph.add_pose(pose);
        for (from, motion) in motions.iter().enumerate() {
            pose = pose * *motion;
            graph.add_pose(pose);
            graph.add_edge(Edge {
                from,
                to: from + 1,
                motion: *motion,
                information: information(motion, STEP),
                cauchy: None,
            });
        }
        graph
    }

    fn placed(to: usize, motion: Pose2) -> Edge {
        Edge {
            from: 0,
            to,
            motion,
            information: information(&motion, PLACED),
            cauchy: None,
        }
    }

    /// Two metres straight on, twice. An error of the first heading moves the end by 2 m times
    /// itself, so the variance of y is 2 · 0.05² + (2 · 0.01)².
    #[test]
    fn doubt_and_ratio_of_a_straight_way_are_those_of_the_closed_form() {
        let graph = way(&[Pose2::new(2.0, 0.0, 0.0); 2]);
        let known = graph.marginals().unwrap();
        let closure = placed(2, Pose2::new(4.3, 0.0, 0.0));
        let error = LoopError::of(&closure, &graph, &known).unwrap();
        let (x, y) = (2.0 * 0.1 * 0.1, 2.0 * 0.05 * 0.05 + 0.02 * 0.02);
        assert!(
            (error.doubt.shift - f64::sqrt(x + y)).abs() < 1e-9,
            "{error:?}"
        );
        assert!((error.doubt.turn - f64::sqrt(2.0 * 0.01 * 0.01)).abs() < 1e-9);
        assert!((error.shift - 0.3).abs() < 1e-9 && error.turn < 1e-9);
        let expected = f64::sqrt(0.3 * 0.3 / (x + 0.02 * 0.02) / 3.0);
        assert!((error.ratio - expected).abs() < 1e-6, "{error:?}");
    }

    /// A path round three corners, with errors as claimed, and one placement with its own: squares
    /// of the ratio have mean 1. With half the claimed standard deviations, 4.
    #[test]
    fn the_ratio_of_an_honest_way_is_one() {
        let mut rng = ChaCha8Rng::seed_from_u64(11);
        let mut drawn =
            |sigmas: [f64; 3]| Vector3::from(sigmas.map(|sigma| sigma * normal(&mut rng)));
        let step = Pose2::new(2.0, 0.3, 1.5);
        let truth = step * step * step;
        let trials = 3000;
        let mut sums = [0.0; 2];
        for _ in 0..trials {
            let off = [(); 3].map(|()| drawn(STEP));
            let found = truth.plus(&drawn(PLACED));
            for (sum, scale) in sums.iter_mut().zip([1.0, 2.0]) {
                let motions = off.map(|off| step.plus(&(off * scale)));
                let graph = way(&motions);
                let known = graph.marginals().unwrap();
                let error = LoopError::of(&placed(3, found), &graph, &known).unwrap();
                *sum += error.ratio * error.ratio / f64::from(trials);
            }
        }
        assert!((sums[0] - 1.0).abs() < 0.06, "{sums:?}");
        assert!((3.3..4.2).contains(&sums[1]), "{sums:?}");
    }
}

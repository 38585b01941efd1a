//! Points that were seen one after the other, matched while the motion between them is corrected.
//!
//! In: points in the robot frame at the end of a motion, moved there by odometry, in parts by the
//! time when they were seen; a [`Target`]; the priors of the pose and of the error of that motion.
//! Out: a [`Rolling`]: the pose at the end, and the error.
//!
//! One turn of a lidar takes a good part of a second. If odometry is wrong by some part of the
//! motion, the scan is bent: matched as a whole, it lies where the middle of the sweep puts it, off
//! by half of the error from the pose at the end.
//!
//! 1. The motion is divided into pieces, and its error e into one for each piece. When a part was
//!    seen, a share w_i of each piece was still to come: all or some of the last piece, some or
//!    nothing of the first. With the pose T at the end, the robot then stood at T - Σ w_i e_i.
//! 2. Gauss-Newton on T and all e_i together. Matching a part at its own pose gives the sums H and
//!    g of rigid matching. With w_0 = -1 for T, their share in the equations is w_i w_j H and -w_i
//!    g.
//! 3. The prior: T is where the uncorrected motion leads, plus Σ e_i, to within the uncertainty of
//!    the pose at the beginning; and Σ e_i is as large as odometry errs, each piece independently.
//!
//! Source of step 1: Dellenbach et al. (2022), "CT-ICP: real-time elastic LiDAR odometry with loop
//! closure".

use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

use super::gauss_newton::{
    MatchConfig, Sums, free_direction, is_settled, outcome, verdict_of, weight_of,
};
use super::{Prior, Registration, Target, Verdict, sums};
use crate::geom::{Pose2, symmetrize};
use crate::points::OrientedPoint;

/// Pieces of a motion, each with an error of its own.
const PIECES: usize = 4;
/// Coordinates of the pose and of all errors.
const COORDINATES: usize = 3 * (PIECES + 1);
type Hessian = SMatrix<f64, COORDINATES, COORDINATES>;
type Gradient = SVector<f64, COORDINATES>;

/// Points that were seen at about the same time.
#[derive(Clone, Copy, Debug)]
pub struct Part<'a> {
    /// In the robot frame at the end of the motion, by odometry.
    pub points: &'a [OrientedPoint],
    /// The share of the motion that was still to come, 0 to 1.
    pub left: f64,
}

/// The prior of the pose at the end, and of the error of the motion that led there.
#[derive(Clone, Copy, Debug)]
pub struct RollingPrior {
    /// Where the motion leads by odometry, and how well the pose at its beginning is known.
    pub by_odometry: Prior,
    /// The expected error: (x, y, θ), in the axes of the target, m and rad.
    pub error: Vector3<f64>,
    /// Inverse of its covariance.
    pub error_information: Matrix3<f64>,
}

/// The error of a motion by its pieces, the last one first: each (x, y, θ), in the axes of the
/// target, m and rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionError([Vector3<f64>; PIECES]);

impl MotionError {
    /// The error, spread evenly over the motion.
    #[must_use]
    pub fn even(error: &Vector3<f64>) -> Self {
        Self([error / PIECES as f64; PIECES])
    }

    /// Where points lie that were seen with the share `left` of the motion still to come, in the
    /// robot frame at the `end` of the motion: the correction to where odometry put them.
    #[must_use]
    pub fn correction(&self, end: &Pose2, left: f64) -> Pose2 {
        end.delta_to(&self.pose(end, left))
    }

    /// Where the robot was, relative to where odometry put it.
    fn pose(&self, end: &Pose2, left: f64) -> Pose2 {
        let shares = shares(left);
        let still: Vector3<f64> = self.0.iter().zip(shares).map(|(e, w)| e * w).sum();
        end.plus(&-still)
    }

    fn sum(&self) -> Vector3<f64> {
        self.0.iter().sum()
    }
}

/// For each piece the share that was still to come, the last piece first.
fn shares(left: f64) -> [f64; PIECES] {
    let pieces = left * PIECES as f64;
    std::array::from_fn(|piece| (pieces - piece as f64).clamp(0.0, 1.0))
}

/// The result of such a match.
#[derive(Clone, Copy, Debug)]
pub struct Rolling {
    /// Of the pose at the end. Its information is what the points say about that pose while the
    /// error is known no better than from the prior.
    pub found: Registration,
    /// The error of the motion.
    pub error: MotionError,
}

/// Matches `parts` to `target`, from `start` and the expected error.
#[must_use]
pub fn register_rolling<T: Target>(
    parts: &[Part<'_>],
    target: &T,
    start: &Pose2,
    prior: &RollingPrior,
    config: &MatchConfig,
) -> Rolling {
    let total: usize = parts.iter().map(|part| part.points.len()).sum();
    let accumulate = |pose: &Pose2, error: &MotionError, kernel: f64| {
        Together::of(parts.iter().map(|part| {
            let pose = error.pose(pose, part.left);
            (part.left, sums(part.points, target, &pose, kernel, config))
        }))
    };
    let (mut pose, mut error) = (*start, MotionError::even(&prior.error));
    let mut kernel = config.first_kernel.max(config.last_kernel);
    let (mut settled, mut iterations) = (false, 0);
    while iterations < config.max_iterations && !settled {
        iterations += 1;
        let mut together = accumulate(&pose, &error, kernel);
        if together.sums.matched < config.min_points {
            break;
        }
        if let Some(free) = free_direction(&together.sums.hessian, config.min_share) {
            together.silence(&free);
        }
        let weight = weight_of(&together.sums, total, config);
        together.weigh(weight);
        together.believe(prior, &pose, &error);
        let Some(cholesky) = together.hessian.cholesky() else {
            break;
        };
        let step = -cholesky.solve(&together.gradient);
        let of_pose = step.fixed_rows::<3>(0).into_owned();
        pose = pose.plus(&of_pose);
        for (piece, error) in error.0.iter_mut().enumerate() {
            *error += step.fixed_rows::<3>(3 * (piece + 1));
        }
        settled = kernel <= config.last_kernel && is_settled(&of_pose, config);
        kernel = (config.kernel_shrink * kernel).max(config.last_kernel);
    }
    let mut together = accumulate(&pose, &error, config.last_kernel);
    let free = free_direction(&together.sums.hessian, config.min_share);
    if let Some(free) = &free {
        together.silence(free);
    }
    let weight = weight_of(&together.sums, total, config);
    together.weigh(weight);
    let information = together.said_of_pose(&prior.error_information);
    together.believe(prior, &pose, &error);
    let cov = together.hessian.cholesky().map(|cholesky| {
        let cov = cholesky.inverse();
        cov.fixed_view::<3, 3>(0, 0).into_owned()
    });
    let verdict: Verdict = verdict_of(&together.sums, free.as_ref(), settled, config);
    let counted = (&together.sums, total);
    let found = outcome(pose, cov, information, counted, iterations, verdict);
    Rolling { found, error }
}

/// The sums of all parts, and the equations that they make.
struct Together {
    /// As if all had been seen at the end.
    sums: Sums,
    hessian: Hessian,
    gradient: Gradient,
}

impl Together {
    fn of(parts: impl Iterator<Item = (f64, Sums)>) -> Self {
        let mut all = Self {
            sums: Sums::default(),
            hessian: Hessian::zeros(),
            gradient: Gradient::zeros(),
        };
        for (left, sums) in parts {
            let shares = shares(left);
            // The derivative of the part's pose by each of the coordinates.
            let by = |at: usize| match at.checked_sub(1) {
                None => 1.0,
                Some(piece) => -shares[piece],
            };
            for row in 0..=PIECES {
                for col in (0..=PIECES).filter(|&col| by(row) * by(col) != 0.0) {
                    all.add_block(row, col, &(sums.hessian * (by(row) * by(col))));
                }
                all.add_rows(row, &(sums.gradient * by(row)));
            }
            all.sums.hessian += sums.hessian;
            all.sums.gradient += sums.gradient;
            all.sums.matched += sums.matched;
            all.sums.inliers += sums.inliers;
            all.sums.squares += sums.squares;
        }
        all
    }

    fn add_block(&mut self, row: usize, col: usize, block: &Matrix3<f64>) {
        let mut view = self.hessian.fixed_view_mut::<3, 3>(3 * row, 3 * col);
        view += block;
    }

    fn add_rows(&mut self, row: usize, rows: &Vector3<f64>) {
        let mut view = self.gradient.fixed_rows_mut::<3>(3 * row);
        view += rows;
    }

    /// Removes all information along the motion `free`, about the pose and about the errors alike.
    fn silence(&mut self, free: &Vector3<f64>) {
        let push = self.sums.hessian * free;
        let said = free.dot(&push);
        if said <= 0.0 {
            return;
        }
        let rest = Matrix3::identity() - free * push.transpose() / said;
        self.sums.hessian = rest.transpose() * self.sums.hessian * rest;
        for row in 0..=PIECES {
            let at = 3 * row;
            let rows = self.gradient.fixed_rows::<3>(at).into_owned();
            let rows = rest.transpose() * rows;
            self.gradient.fixed_rows_mut::<3>(at).copy_from(&rows);
            for col in 0..=PIECES {
                let block = self.hessian.fixed_view::<3, 3>(at, 3 * col).into_owned();
                let block = rest.transpose() * block * rest;
                let mut view = self.hessian.fixed_view_mut::<3, 3>(at, 3 * col);
                view.copy_from(&block);
            }
        }
    }

    fn weigh(&mut self, weight: f64) {
        self.hessian *= weight;
        self.gradient *= weight;
    }

    /// Adds the prior.
    fn believe(&mut self, prior: &RollingPrior, pose: &Pose2, error: &MotionError) {
        let begin = &prior.by_odometry.information;
        let at_begin = begin * (pose.minus(&prior.by_odometry.pose) - error.sum());
        let sign = |at: usize| if at == 0 { 1.0 } else { -1.0 };
        for row in 0..=PIECES {
            for col in 0..=PIECES {
                self.add_block(row, col, &(begin * (sign(row) * sign(col))));
            }
            self.add_rows(row, &(at_begin * sign(row)));
        }
        // The variances of independent errors add up.
        let information = prior.error_information * PIECES as f64;
        let expected = prior.error / PIECES as f64;
        for (piece, error) in error.0.iter().enumerate() {
            self.add_block(piece + 1, piece + 1, &information);
            self.add_rows(piece + 1, &(information * (error - expected)));
        }
    }

    /// What the points say about the pose at the end while the errors are known only from the
    /// prior: the Schur complement.
    fn said_of_pose(&self, error_information: &Matrix3<f64>) -> Matrix3<f64> {
        const ERRORS: usize = 3 * PIECES;
        let whole = self.hessian.fixed_view::<3, 3>(0, 0).into_owned();
        let mixed = self.hessian.fixed_view::<3, ERRORS>(0, 3).into_owned();
        let mut of_errors = self.hessian.fixed_view::<ERRORS, ERRORS>(3, 3).into_owned();
        for piece in 0..PIECES {
            let mut view = of_errors.fixed_view_mut::<3, 3>(3 * piece, 3 * piece);
            view += error_information * PIECES as f64;
        }
        let Some(cholesky) = of_errors.cholesky() else {
            return whole;
        };
        let mut said = whole - mixed * cholesky.solve(&mixed.transpose());
        symmetrize(&mut said);
        said
    }
}

#[cfg(test)]
mod tests;

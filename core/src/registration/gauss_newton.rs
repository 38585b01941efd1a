//! Points matched to the surfaces of a map, from a start that is nearly right.
//!
//! In: oriented points, a [`Target`], a start and a prior of the pose. Out: a [`Registration`].
//!
//! 1. Each point is paired with the surfel nearest to it at the current pose, if the two surfaces
//!    face the same way.
//! 2. The method turns each pair into residuals. A Cauchy kernel gives distant pairs little weight.
//!    Its scale shrinks from iteration to iteration, so a bad start is pulled in and outliers lose
//!    their weight.
//! 3. Gauss-Newton on (x, y, θ), with the prior as one more residual, until the step is negligible.
//! 4. In each iteration, a direction that the points hardly constrain is left to the prior alone.
//!    What little they seem to say along a corridor comes from noisy normals, and pulls towards
//!    where the map was seen from.
//! 5. The covariance is the inverse of the information of points and prior together. The verdict
//!    considers the points alone: if a corridor does not constrain the pose along it, the verdict
//!    says so.
//!
//! Step 4: Zhang, Kaess & Singh (2016), "On degeneracy of optimization-based state
//! estimation problems".

use nalgebra::{Matrix2, Matrix3, Point2, SymmetricEigen, Vector2, Vector3};

use super::{Prior, Registration, RegistrationMethod, Target, Verdict};
use crate::bounds::config;
use crate::geom::{Pose2, PoseEstimate, symmetrize};
use crate::map::Surfel;
use crate::points::OrientedPoint;

config! {
    /// How to match.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct MatchConfig {
        /// What is made as small as possible. Default: distances of points to lines.
        pub method: RegistrationMethod = RegistrationMethod::default(),
        /// Most iterations. Default 20.
        pub max_iterations: usize = 20,
        /// Scale of the kernel at the first iteration, m. Default 0.15.
        pub first_kernel: f64 = 0.15,
        /// Scale of the kernel at the end, m. Default 0.03; larger listens to more, smaller to
        /// less.
        pub last_kernel: f64 = 0.03,
        /// What is left of the kernel's scale after an iteration. Default 0.5; larger forgives
        /// worse starts and takes longer.
        pub kernel_shrink: f64 = 0.5,
        /// Points within so many of the kernel's scales of their surface lie on it. Default 2.
        pub inlier_kernels: f64 = 2.0,
        /// Standard deviation of a residual, m: a point's noise and the map's. Default 0.03.
        pub sigma: f64 = 0.03,
        /// Points that say one thing, since neighbours err alike. Default 3; larger gives larger
        /// covariances.
        pub redundancy: f64 = 3.0,
        /// Cosine of the largest angle between surfaces that may be the same. Default 0.7.
        pub min_cosine: f64 = 0.7,
        /// Whether a surface is met from behind as well: walls of a drawing have no thickness.
        /// Default false.
        pub two_sided: bool = false,
        /// Fewer matched points than this are too few. Default 12.
        pub min_points: usize = 12,
        /// Where fewer of the points than this part lie on the map, the points' say is lowered with
        /// the square of the part: what little matches there may match by chance. Default 0.5.
        pub full_overlap: f64 = 0.5,
        /// A direction is degenerate where it gets less than this part of the points' say. Default
        /// 0.02.
        pub min_share: f64 = 0.02,
        /// A step smaller than this is nothing, m. Default 2e-4: a hundredth of the noise of a
        /// lidar.
        pub shift_tolerance: f64 = 2e-4,
        /// A step smaller than this is nothing, rad. Default 1e-4.
        pub turn_tolerance: f64 = 1e-4,
    }
}

/// Variance where neither points nor prior give information, m² and rad².
pub(super) const UNKNOWN: f64 = 1e6;

/// The sums of one iteration: what a method computes from all pairs.
#[derive(Default)]
pub(super) struct Sums {
    /// J^T W J of the residuals.
    pub(super) hessian: Matrix3<f64>,
    /// J^T W r.
    pub(super) gradient: Vector3<f64>,
    /// Points that have a partner.
    pub(super) matched: usize,
    /// Those close to their partner.
    pub(super) inliers: usize,
    /// Sum of the inliers' squared distances, m².
    pub(super) squares: f64,
}

/// A point at a pose, and the surfel that it is paired with.
pub(super) struct Pair<'a> {
    /// From the robot to the point, in the target's axes, m.
    pub(super) arm: Vector2<f64>,
    /// Where the point lies, target frame, m.
    pub(super) place: Point2<f64>,
    pub(super) surfel: &'a Surfel,
}

/// The pairs of all points that have a partner at `pose`.
pub(super) fn pairs<'a, T: Target>(
    points: &'a [OrientedPoint],
    target: &'a T,
    pose: &'a Pose2,
    config: &'a MatchConfig,
) -> impl Iterator<Item = Pair<'a>> {
    let (cos, sin) = pose.cos_sin();
    points.iter().filter_map(move |point| {
        let (px, py) = (point.position.x, point.position.y);
        let arm = Vector2::new(cos * px - sin * py, sin * px + cos * py);
        let place = Point2::new(arm.x + pose.x(), arm.y + pose.y());
        let surfel = target.nearest(place)?;
        let normal = surfel.normal;
        let (nx, ny) = (point.normal.x, point.normal.y);
        let cosine = normal.x * (cos * nx - sin * ny) + normal.y * (sin * nx + cos * ny);
        let cosine = if config.two_sided {
            cosine.abs()
        } else {
            cosine
        };
        (cosine >= config.min_cosine).then_some(Pair { arm, place, surfel })
    })
}

/// Matches `points` to `target`, from `start`; `accumulate` computes the sums for a pose and a
/// scale of the kernel, m.
pub(super) fn register(
    points: &[OrientedPoint],
    start: &Pose2,
    prior: &Prior,
    config: &MatchConfig,
    accumulate: impl Fn(&Pose2, f64) -> Sums,
) -> Registration {
    let mut pose = *start;
    let mut kernel = config.first_kernel.max(config.last_kernel);
    let mut settled = false;
    let mut iterations = 0;
    while iterations < config.max_iterations && !settled {
        iterations += 1;
        let mut sums = accumulate(&pose, kernel);
        if sums.matched < config.min_points {
            break;
        }
        if let Some(free) = free_direction(&sums.hessian, config.min_share) {
            sums.silence(&free);
        }
        let weight = weight_of(&sums, points.len(), config);
        let off = pose.minus(&prior.pose);
        let hessian = sums.hessian * weight + prior.information;
        let gradient = sums.gradient * weight + prior.information * off;
        let Some(cholesky) = hessian.cholesky() else {
            break;
        };
        let step = -cholesky.solve(&gradient);
        pose = pose.plus(&step);
        let at_end = kernel <= config.last_kernel;
        settled = at_end && is_settled(&step, config);
        kernel = (config.kernel_shrink * kernel).max(config.last_kernel);
    }
    let mut sums = accumulate(&pose, config.last_kernel);
    let free = free_direction(&sums.hessian, config.min_share);
    if let Some(free) = &free {
        sums.silence(free);
    }
    let information = sums.hessian * weight_of(&sums, points.len(), config);
    let verdict = verdict_of(&sums, free.as_ref(), settled, config);
    let cov = (information + prior.information).try_inverse();
    let counted = (&sums, points.len());
    outcome(pose, cov, information, counted, iterations, verdict)
}

/// The weight of one residual among this many points.
pub(super) fn weight_of(sums: &Sums, points: usize, config: &MatchConfig) -> f64 {
    let full = 1.0 / (config.sigma * config.sigma * config.redundancy);
    let overlap = sums.inliers as f64 / points.max(1) as f64;
    let part = (overlap / config.full_overlap).min(1.0);
    full * part * part
}

/// Whether a step is negligible.
pub(super) fn is_settled(step: &Vector3<f64>, config: &MatchConfig) -> bool {
    step.x.abs().max(step.y.abs()) < config.shift_tolerance && step.z.abs() < config.turn_tolerance
}

/// The verdict on a match with these sums; `free` is the direction that the points do not
/// constrain.
pub(super) fn verdict_of(
    sums: &Sums,
    free: Option<&Vector3<f64>>,
    settled: bool,
    config: &MatchConfig,
) -> Verdict {
    if sums.inliers < config.min_points {
        Verdict::TooFewPoints {
            found: sums.inliers,
        }
    } else if let Some(free) = free {
        Verdict::Degenerate {
            direction: free.xy().normalize(),
        }
    } else if settled {
        Verdict::Converged
    } else {
        Verdict::NotConverged
    }
}

/// The result of a match of this many points.
pub(super) fn outcome(
    pose: Pose2,
    cov: Option<Matrix3<f64>>,
    information: Matrix3<f64>,
    (sums, points): (&Sums, usize),
    iterations: usize,
    verdict: Verdict,
) -> Registration {
    let mut cov = cov.unwrap_or_else(|| Matrix3::from_diagonal_element(UNKNOWN));
    symmetrize(&mut cov);
    Registration {
        estimate: PoseEstimate { pose, cov },
        information,
        inliers: sums.inliers,
        overlap: sums.inliers as f64 / points.max(1) as f64,
        residual: (sums.squares / sums.inliers.max(1) as f64).sqrt(),
        iterations,
        verdict,
    }
}

impl Sums {
    /// Adds a distance `off` of a point `arm` from the moving origin; `information` says how well
    /// each direction of it is known.
    pub(super) fn add_off(
        &mut self,
        information: &Matrix2<f64>,
        arm: &Vector2<f64>,
        off: &Vector2<f64>,
        weight: f64,
    ) {
        let push = information * off;
        let by_turn = Vector2::new(-arm.y, arm.x);
        let turned = information * by_turn;
        let [xx, xy, yy] = [(0, 0), (0, 1), (1, 1)].map(|at| information[at]);
        let (xt, yt, tt) = (turned.x, turned.y, by_turn.dot(&turned));
        self.hessian += weight * Matrix3::new(xx, xy, xt, xy, yy, yt, xt, yt, tt);
        self.gradient += weight * push.push(by_turn.dot(&push));
    }

    /// The step to the minimum, (x, y, θ), that leaves the motion `free` unchanged.
    pub(super) fn step(mut self, free: Option<&Vector3<f64>>) -> Option<Vector3<f64>> {
        if let Some(free) = free {
            self.silence(free);
            // Held fast, otherwise the system has no solution.
            self.hessian += free * free.transpose() * self.hessian.trace();
        }
        Some(-self.hessian.cholesky()?.solve(&self.gradient))
    }

    /// Removes all information along the motion `free` (x, y, θ), and none about the rest.
    pub(super) fn silence(&mut self, free: &Vector3<f64>) {
        let push = self.hessian * free;
        let said = free.dot(&push);
        // Nothing to remove where there is no information. It can even be negative where the
        // normals of two clouds are multiplied: noise then has either sign.
        if said.abs() > 0.0 {
            self.gradient -= push * (free.dot(&self.gradient) / said);
            self.hessian -= push * push.transpose() / said;
        }
    }
}

/// The motion that the points constrain least, with the heading free to follow.
pub(super) struct Weakest {
    /// x, y, θ; its shift of length 1.
    pub(super) motion: Vector3<f64>,
    /// The points' information about it.
    least: f64,
    /// Their information about it and about the shift across it, together.
    total: f64,
}

impl Weakest {
    pub(super) fn of(hessian: &Matrix3<f64>) -> Self {
        let cross = Vector2::new(hessian[(0, 2)], hessian[(1, 2)]);
        let turn = hessian[(2, 2)].max(1e-12);
        let shift: Matrix2<f64> =
            hessian.fixed_view::<2, 2>(0, 0).into_owned() - cross * cross.transpose() / turn;
        let eigen = SymmetricEigen::new(shift);
        let (least, _) = eigen.eigenvalues.argmin();
        let direction: Vector2<f64> = eigen.eigenvectors.column(least).into_owned();
        Self {
            motion: direction.push(-cross.dot(&direction) / turn),
            least: eigen.eigenvalues[least],
            total: hessian[(0, 0)] + hessian[(1, 1)],
        }
    }

    /// The motion, if the points hardly constrain it: less than this part of the total.
    pub(super) fn if_free(&self, min_share: f64) -> Option<Vector3<f64>> {
        (self.least < min_share * self.total).then_some(self.motion)
    }
}

/// The motion (x, y, θ; its shift of length 1) that the points hardly constrain, with the heading
/// free to follow.
pub(super) fn free_direction(hessian: &Matrix3<f64>, min_share: f64) -> Option<Vector3<f64>> {
    Weakest::of(hessian).if_free(min_share)
}

#[cfg(test)]
pub(super) mod tests;

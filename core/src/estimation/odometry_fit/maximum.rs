//! The likeliest noise coefficients, and with them the likeliest tracks.

use nalgebra::{Matrix3, SMatrix, SVector};

use super::drive::Leg;
use super::likelihood::{Chance, Likeliest, LinearLeg, likeliest};
use crate::robot::{RobotModel, TrackWear};

/// Number of coefficients.
const N: usize = 5;
/// Prior standard deviation of the logarithm of each: a factor of 20 in either direction.
const LOG_PRIOR: f64 = 3.0;
/// Prior variances of the poses: 5 mm, 2 mrad.
const POSE_VARIANCES: [f64; 2] = [2.5e-5, 4e-6];
/// Step of the logarithms for finite differences.
const DIFFERENCE: f64 = 0.03;
/// Longest Newton step in each logarithm.
const LONGEST: f64 = 1.5;
const MOST_STEPS: usize = 40;
/// A step that changes the logarithms by less than this is the last.
const CONVERGED: f64 = 1e-4;
/// How often motions are counted again, at most; each time, the error left is the square of the
/// previous one.
const MOST_ROUNDS: usize = 12;
/// A leg is left out beyond this: χ² with three degrees of freedom exceeds it with a probability of
/// 10⁻⁵.
const MOST_SQUARED: f64 = 25.9;

/// If tracks differ from the model by more than this, they or the poses belong to another robot:
/// the range of the settings.
const WORST: f64 = 0.5;

type Logs = SVector<f64, N>;

/// The maximum of the likelihood.
pub(super) struct Found {
    pub(super) wear: TrackWear,
    pub(super) wear_cov: Matrix3<f64>,
    pub(super) chance: Chance,
    /// Standard errors of the logarithms of the first three coefficients.
    pub(super) noise_log_sigmas: [f64; 3],
    pub(super) left_out: usize,
}

/// `None` if there is no maximum.
pub(super) fn find(legs: &[Option<Leg>], model: &RobotModel) -> Option<Found> {
    let beforehand = beforehand(model);
    let mut used: Vec<bool> = legs.iter().map(Option::is_some).collect();
    let all = used.iter().filter(|used| **used).count();
    let mut wear = TrackWear::default();
    let mut logs = beforehand;
    for _ in 0..MOST_ROUNDS {
        let of_leg = |(leg, used): (&Option<Leg>, &bool)| {
            let leg = leg.as_ref().filter(|_| *used)?;
            Some(LinearLeg::new(leg, &wear, model.track_width))
        };
        let linear: Vec<Option<LinearLeg>> = legs.iter().zip(&used).map(of_leg).collect();
        let problem = Problem {
            legs: &linear,
            wear,
            beforehand,
        };
        logs = problem.maximum(logs)?;
        let best = problem.likeliest(&logs)?;
        wear = TrackWear {
            left: wear.left + best.change[0],
            right: wear.right + best.change[1],
            track_width: wear.track_width + best.change[2],
        };
        if [wear.left, wear.right, wear.track_width]
            .iter()
            .any(|part| part.abs() > WORST)
        {
            return None;
        }
        let dropped = leave_out(&mut used, &best);
        if !dropped && best.change.amax() < 1e-6 {
            let cov = (-problem.hessian(&logs)?).cholesky()?.inverse();
            return Some(Found {
                wear,
                wear_cov: best.cov,
                chance: chance_of(&logs),
                noise_log_sigmas: [0, 1, 2].map(|i: usize| cov[(i, i)].sqrt()),
                left_out: all - used.iter().filter(|used| **used).count(),
            });
        }
    }
    None
}

/// Leaves out legs that cannot be explained, but of two in a row only the first, because it spoils
/// the one after it; returns whether there was any.
fn leave_out(used: &mut [bool], best: &Likeliest) -> bool {
    let mut dropped = false;
    let mut was_dropped = false;
    for (used, innovation) in used.iter_mut().zip(&best.innovations) {
        let squared = innovation.as_ref().map(|i| i.squared(&best.change));
        let is_beyond = squared.is_some_and(|d2| d2 > MOST_SQUARED);
        let drop = is_beyond && !was_dropped;
        if drop {
            *used = false;
            dropped = true;
        }
        was_dropped = drop;
    }
    dropped
}

fn beforehand(model: &RobotModel) -> Logs {
    let noise = &model.odometry_noise;
    let [position, heading] = POSE_VARIANCES;
    // If the model says "no noise", the drive may still show some.
    let log = |value: f64| libm::log(value.max(1e-6));
    Logs::from([
        log(noise.per_metre),
        log(noise.lateral_per_metre),
        log(noise.heading_per_radian),
        log(position),
        log(heading),
    ])
}

fn chance_of(logs: &Logs) -> Chance {
    Chance(std::array::from_fn(|i| libm::exp(logs[i])))
}

/// Maximum of the logarithm of the likelihood over the logarithms of the coefficients.
struct Problem<'a> {
    legs: &'a [Option<LinearLeg>],
    wear: TrackWear,
    beforehand: Logs,
}

impl Problem<'_> {
    fn likeliest(&self, logs: &Logs) -> Option<Likeliest> {
        likeliest(self.legs, &self.wear, &chance_of(logs))
    }

    fn at(&self, logs: &Logs) -> Option<f64> {
        let off = (logs - self.beforehand) / LOG_PRIOR;
        Some(self.likeliest(logs)?.log - 0.5 * off.norm_squared())
    }

    /// Newton's method, damped: where the likelihood is not concave, the absolute value of its
    /// curvature is used.
    fn maximum(&self, start: Logs) -> Option<Logs> {
        let mut logs = start;
        let mut value = self.at(&logs)?;
        let mut damping = 1e-3;
        for _ in 0..MOST_STEPS {
            let (gradient, hessian) = (self.gradient(&logs)?, self.hessian(&logs)?);
            let eigen = (-hessian).symmetric_eigen();
            let curvatures = eigen.eigenvalues.map(|c| c.abs().max(1e-3));
            loop {
                let along = eigen.eigenvectors.transpose() * gradient;
                let scaled = along.zip_map(&curvatures, |g, c| g / (c * (1.0 + damping)));
                let step = (eigen.eigenvectors * scaled).map(|s| s.clamp(-LONGEST, LONGEST));
                if step.amax() < CONVERGED {
                    return Some(logs);
                }
                let next = logs + step;
                if let Some(better) = self.at(&next).filter(|v| *v >= value) {
                    (logs, value) = (next, better);
                    damping = (0.1 * damping).max(1e-6);
                    break;
                }
                damping *= 10.0;
                if damping > 1e9 {
                    // No step increases it: this is the maximum, as far as differences can tell.
                    return Some(logs);
                }
            }
        }
        None
    }

    fn gradient(&self, logs: &Logs) -> Option<Logs> {
        let mut gradient = Logs::zeros();
        for i in 0..N {
            let nudge = unit(i);
            gradient[i] =
                (self.at(&(logs + nudge))? - self.at(&(logs - nudge))?) / (2.0 * DIFFERENCE);
        }
        Some(gradient)
    }

    fn hessian(&self, logs: &Logs) -> Option<SMatrix<f64, N, N>> {
        let mut hessian = SMatrix::<f64, N, N>::zeros();
        for i in 0..N {
            for j in 0..=i {
                let (a, b) = (unit(i), unit(j));
                let second = self.at(&(logs + a + b))?
                    - self.at(&(logs + a - b))?
                    - self.at(&(logs - a + b))?
                    + self.at(&(logs - a - b))?;
                let value = second / (4.0 * DIFFERENCE * DIFFERENCE);
                (hessian[(i, j)], hessian[(j, i)]) = (value, value);
            }
        }
        Some(hessian)
    }
}

fn unit(i: usize) -> Logs {
    let mut unit = Logs::zeros();
    unit[i] = DIFFERENCE;
    unit
}

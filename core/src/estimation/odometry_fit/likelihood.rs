//! The likelihood of the poses of a drive for given noise, and the tracks that maximise it.
//!
//! Let Z_i be the reference poses, X_i = Z_i exp(ε_i) the true ones and m_i the counted motion. To
//! first order in small errors, all of them in the robot's frame at the end of the leg,
//!
//! ```text
//! ε_i = Ad(m_i⁻¹) ε_(i-1) + ρ_i + B_i δ + w_i,   ρ_i = Z_i⁻¹ Z_(i-1) m_i,   w_i ~ N(0, Q_i)
//! 0   = ε_i + v_i,                                                           v_i ~ N(0, R)
//! ```
//!
//! with δ the change of the tracks (left, right, width) and B_i, Q_i accumulated over the small
//! motions of the leg. The innovations of the Kalman filter of this system are white; they depend
//! on δ linearly, ν_i(δ) = ν_i + N_i δ.

use nalgebra::{Matrix3, Vector3};

use super::PRIOR;
use super::drive::Leg;
use crate::geom::{Pose2, sin_cos, symmetrize};
use crate::robot::{OdometryNoise, TrackWear, Tracks};

/// Noise coefficients: per metre, lateral, per radian; variances of the poses' positions and
/// headings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Chance(pub(super) [f64; 5]);

impl Chance {
    pub(super) fn noise(&self) -> OdometryNoise {
        let [per_metre, lateral_per_metre, heading_per_radian, ..] = self.0;
        OdometryNoise {
            per_metre,
            lateral_per_metre,
            heading_per_radian,
        }
    }

    pub(super) fn pose_sigmas(&self) -> [f64; 2] {
        [self.0[3].sqrt(), self.0[4].sqrt()]
    }

    fn pose_cov(&self) -> Matrix3<f64> {
        Matrix3::from_diagonal(&Vector3::new(self.0[3], self.0[3], self.0[4]))
    }
}

/// A leg, linearised in the errors of the tracks.
#[derive(Clone, Debug)]
pub(super) struct LinearLeg {
    /// Ad(m⁻¹).
    carried: Matrix3<f64>,
    /// ρ.
    residual: Vector3<f64>,
    /// B: columns left, right, width.
    by_wear: Matrix3<f64>,
    /// Q for each coefficient of 1.
    by_noise: [Matrix3<f64>; 3],
}

impl LinearLeg {
    /// Linearised about `wear`, for a robot whose model has `track_width`.
    pub(super) fn new(leg: &Leg, wear: &TrackWear, track_width: f64) -> Self {
        let width = wear.width(track_width);
        let mut motion = Pose2::identity();
        let mut by_wear = Matrix3::zeros();
        let mut by_noise = [Matrix3::zeros(); 3];
        for step in &leg.steps {
            let counted = Tracks::of(step, track_width);
            let ran = wear.ran(&counted);
            let moved = ran.motion(width);
            let back = moved.inverse().adjoint();
            let (advance, turn) = (0.5 * (ran.left + ran.right), (ran.right - ran.left) / width);
            let (sin, cos) = sin_cos(0.5 * turn);
            // The effect of a longer distance and of a larger turn, in the frame at the end of the
            // step.
            let by_way = Vector3::new(cos, -sin, 0.0);
            let by_turn = Vector3::new(0.5 * advance * sin, 0.5 * advance * cos, 1.0);
            let sideways = Vector3::new(sin, cos, 0.0);
            let by_left = 0.5 * by_way - by_turn / width;
            let by_right = 0.5 * by_way + by_turn / width;
            by_wear = back * by_wear
                + Matrix3::from_columns(&[
                    by_left * counted.left,
                    by_right * counted.right,
                    -by_turn * (turn / (1.0 + wear.track_width)),
                ]);
            let fresh = [
                square(&by_left) * ran.left.abs() + square(&by_right) * ran.right.abs(),
                square(&sideways) * advance.abs(),
                square(&by_turn) * turn.abs(),
            ];
            for (cov, fresh) in by_noise.iter_mut().zip(fresh) {
                *cov = back * *cov * back.transpose() + fresh;
            }
            motion = motion * moved;
        }
        let off = leg.by_poses.inverse() * motion;
        Self {
            carried: motion.inverse().adjoint(),
            residual: Vector3::new(off.x(), off.y(), off.heading()),
            by_wear,
            by_noise,
        }
    }

    fn noise(&self, chance: &Chance) -> Matrix3<f64> {
        let [k, l, h, ..] = chance.0;
        self.by_noise[0] * k + self.by_noise[1] * l + self.by_noise[2] * h
    }
}

fn square(v: &Vector3<f64>) -> Matrix3<f64> {
    v * v.transpose()
}

/// The likeliest change of the tracks, and its likelihood.
#[derive(Clone, Debug)]
pub(super) struct Likeliest {
    /// Logarithm of the likelihood at its maximum over the tracks, without a constant.
    pub(super) log: f64,
    /// What to add to the tracks about which was linearised.
    pub(super) change: Vector3<f64>,
    pub(super) cov: Matrix3<f64>,
    /// For each leg, the part that could not be predicted.
    pub(super) innovations: Vec<Option<Innovation>>,
}

/// ν, N and the inverse of its covariance C.
#[derive(Clone, Debug)]
pub(super) struct Innovation {
    by_chance: Vector3<f64>,
    by_wear: Matrix3<f64>,
    inverse: Matrix3<f64>,
}

impl Innovation {
    /// d² after this change of the tracks, with three degrees of freedom.
    pub(super) fn squared(&self, change: &Vector3<f64>) -> f64 {
        let off = self.by_chance + self.by_wear * change;
        off.dot(&(self.inverse * off))
    }
}

/// `legs`: `None` restarts the filter. `wear`: the tracks about which they were linearised. Returns
/// `None` if a covariance is singular.
pub(super) fn likeliest(
    legs: &[Option<LinearLeg>],
    wear: &TrackWear,
    chance: &Chance,
) -> Option<Likeliest> {
    let seen = chance.pose_cov();
    let beforehand = Matrix3::identity() / (PRIOR * PRIOR);
    let about = Vector3::new(wear.left, wear.right, wear.track_width);
    let mut normal = beforehand;
    let mut right = -beforehand * about;
    let mut log = -0.5 * about.dot(&(beforehand * about));
    let mut state = State::begun(&seen);
    let mut innovations = Vec::with_capacity(legs.len());
    for leg in legs {
        let Some(leg) = leg else {
            state = State::begun(&seen);
            innovations.push(None);
            continue;
        };
        let (innovation, log_volume) = state.step(leg, &leg.noise(chance), &seen)?;
        let weighted = innovation.inverse * innovation.by_chance;
        log -= 0.5 * (log_volume + innovation.by_chance.dot(&weighted));
        normal += innovation.by_wear.transpose() * innovation.inverse * innovation.by_wear;
        right -= innovation.by_wear.transpose() * weighted;
        innovations.push(Some(innovation));
    }
    symmetrize(&mut normal);
    let cov = normal.cholesky()?.inverse();
    let change = cov * right;
    log += 0.5 * right.dot(&change);
    log.is_finite().then_some(Likeliest {
        log,
        change,
        cov,
        innovations,
    })
}

/// Mean of ε, its derivative with respect to δ, and its covariance.
struct State {
    mean: Vector3<f64>,
    by_wear: Matrix3<f64>,
    cov: Matrix3<f64>,
}

impl State {
    /// The first pose is as uncertain as any other.
    fn begun(seen: &Matrix3<f64>) -> Self {
        Self {
            mean: Vector3::zeros(),
            by_wear: Matrix3::zeros(),
            cov: *seen,
        }
    }

    /// Predicts and corrects; returns the innovation, and the logarithm of the determinant of its
    /// covariance.
    fn step(
        &mut self,
        leg: &LinearLeg,
        noise: &Matrix3<f64>,
        seen: &Matrix3<f64>,
    ) -> Option<(Innovation, f64)> {
        self.mean = leg.carried * self.mean + leg.residual;
        self.by_wear = leg.carried * self.by_wear + leg.by_wear;
        self.cov = leg.carried * self.cov * leg.carried.transpose() + noise;
        let mut of_innovation = self.cov + seen;
        symmetrize(&mut of_innovation);
        let root = of_innovation.cholesky()?;
        let inverse = root.inverse();
        let log_volume: f64 = root
            .l()
            .diagonal()
            .iter()
            .map(|d| 2.0 * libm::log(*d))
            .sum();
        let gain = self.cov * inverse;
        let innovation = Innovation {
            by_chance: -self.mean,
            by_wear: -self.by_wear,
            inverse,
        };
        self.mean += gain * innovation.by_chance;
        self.by_wear += gain * innovation.by_wear;
        self.cov -= gain * self.cov;
        symmetrize(&mut self.cov);
        Some((innovation, log_volume))
    }
}

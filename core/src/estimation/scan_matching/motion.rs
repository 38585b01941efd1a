//! How the odometry of this robot errs, learned while matches are sure.
//!
//! In: odometry between keyframes, and what the matches made of it. Out: odometry with its bias
//! taken out, and with a covariance as large as its errors really are.
//!
//! 1. Wheels err by a bias: the way by a part of itself, the turn by a part of itself and by
//!    something for each metre (unequal wheels). The three are a state that wanders slowly, and a
//!    Kalman filter follows it.
//! 2. What the bias leaves is noise: the covariance that comes with the odometry is scaled until it
//!    explains the errors. Noise alone would explain a bias as well, but not help along a corridor,
//!    where nothing but the wheels tells how far the robot went.
//!
//! Source of the model: Borenstein & Feng (1996), "Measurement and correction of systematic
//! odometry errors in mobile robots".

use std::collections::VecDeque;

use nalgebra::{Matrix2, Matrix2x3, Matrix3, Vector2, Vector3};

use crate::geom::{Pose2, symmetrize};
use crate::robot::{Odometry, Stamp};
use crate::snapshot::snapshot;

/// What is known beforehand of the bias: of the way, 1; of the turn for each metre, rad/m; of the
/// turn, 1.
const FIRST_SIGMAS: [f64; 3] = [0.05, 0.05, 0.1];
/// How far each wanders with every keyframe.
const WANDER: [f64; 3] = [0.001, 0.001, 0.002];
/// What a match is known to at each end, m and rad.
const MATCH_SHIFT: f64 = 0.015;
const MATCH_TURN: f64 = 0.004;
/// The covariance that comes with odometry is believed to be wrong by these factors beforehand.
const FIRST_NOISE: f64 = 10.0;
/// The part that a new error has in what is known of the noise.
const NOISE_GAIN: f64 = 0.03;
/// Noise is never believed smaller or larger than by these factors.
const NOISE_BOUNDS: [f64; 2] = [0.1, 30.0];
/// What is not known of the bias counts as if each motion were one of so many metres with the same
/// bias. That is much for a short way: a prior that is held to be exact, and is not, harms every
/// match, and one that is held to be loose harms none that sees walls.
const BIAS_LENGTH: f64 = 20.0;
/// An error of more than this many standard deviations is that of a slip, or of a match.
const MOST_SIGMAS: f64 = 4.0;

/// The part of motions of which odometry is grossly wrong: beforehand, and the least that is
/// believed.
const FIRST_SLIPS: f64 = 0.05;
const SELDOM: f64 = 0.003;
/// The part that a new motion has in what is known of it.
const SLIP_GAIN: f64 = 0.02;
/// What an e-fold of it is worth, in parts of the points of a scan.
const MISTRUST: f64 = 0.06;

/// An earlier scan, as far as late odometry needs it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Past {
    pub(super) stamp: Stamp,
    pub(super) submap_from_robot: Pose2,
    /// Odometry, summed since the beginning.
    pub(super) odom_from_robot: Pose2,
}

/// Earlier scans that late odometry may belong to.
const PASTS: usize = 8;

/// How the robot moved, by its odometry and by the matches.
#[derive(Clone, Debug, Default)]
pub(super) struct Motion {
    pub(super) model: OdometryModel,
    /// Odometry as it came, since the last keyframe.
    since_keyframe: Option<Odometry>,
    /// Whether the last keyframe surely lies where it was matched.
    keyframe_is_sure: bool,
    /// Odometry without its bias, summed since the beginning.
    pub(super) odom_from_robot: Pose2,
    /// The scans before this one, the newest last.
    pub(super) pasts: VecDeque<Past>,
    /// The motion between the last two scans, and the seconds it took.
    pub(super) speed: Option<(f64, Pose2)>,
}

impl Motion {
    /// Takes odometry as it came, and gives it without its bias.
    pub(super) fn moved(&mut self, odometry: Odometry) -> Odometry {
        self.since_keyframe = Some(match self.since_keyframe {
            Some(so_far) => so_far.then(&odometry),
            None => odometry,
        });
        let corrected = self.model.corrected(&odometry);
        self.odom_from_robot = self.odom_from_robot * corrected.motion;
        corrected
    }

    /// Remembers where a scan was placed.
    pub(super) fn remember(&mut self, stamp: Stamp, submap_from_robot: Pose2) {
        if let Some(past) = self.pasts.back() {
            let motion = past.submap_from_robot.delta_to(&submap_from_robot);
            self.speed = Some((stamp.since(past.stamp), motion));
        }
        self.pasts.push_back(Past {
            stamp,
            submap_from_robot,
            odom_from_robot: self.odom_from_robot,
        });
        if self.pasts.len() > PASTS {
            self.pasts.pop_front();
        }
    }

    /// Another submap runs from here on.
    pub(super) fn rebase(&mut self, new_from_old: &Pose2) {
        for past in &mut self.pasts {
            past.submap_from_robot = *new_from_old * past.submap_from_robot;
        }
    }

    /// A scan becomes a keyframe, so far from the last one by the matches. Odometry is learned from
    /// it where both are sure; `sees_way` says whether the match fixes the way ahead.
    pub(super) fn keyframe(&mut self, matched: Option<Pose2>, is_sure: bool, sees_way: bool) {
        let was_sure = std::mem::replace(&mut self.keyframe_is_sure, is_sure);
        let odometry = self.since_keyframe.take();
        if let (Some(odometry), Some(matched)) = (odometry, matched)
            && was_sure
            && is_sure
        {
            self.model.learn(&odometry, &matched, sees_way);
        }
    }
}

/// What is known of the errors of odometry.
#[derive(Clone, Debug)]
pub(super) struct OdometryModel {
    bias: Vector3<f64>,
    cov: Matrix3<f64>,
    /// Factors on the variance of the way and of the turn.
    noise: [f64; 2],
    /// How often it was grossly wrong.
    slips: f64,
}

impl Default for OdometryModel {
    fn default() -> Self {
        let variances = Vector3::from(FIRST_SIGMAS).map(|s| s * s);
        Self {
            bias: Vector3::zeros(),
            cov: Matrix3::from_diagonal(&variances),
            noise: [FIRST_NOISE; 2],
            slips: FIRST_SLIPS,
        }
    }
}

impl OdometryModel {
    /// The odometry without its bias, with the covariance of its errors.
    fn corrected(&self, odometry: &Odometry) -> Odometry {
        let raw = &odometry.motion;
        let (way, turn) = (raw.x(), raw.heading());
        let [shift, angle] = self.noise;
        let scale = Matrix3::from_diagonal(&Vector3::new(shift.sqrt(), shift.sqrt(), angle.sqrt()));
        let mut cov = scale * odometry.cov * scale;
        let length = raw.position().coords.norm();
        let squares = length * BIAS_LENGTH;
        cov[(0, 0)] += self.cov[(0, 0)] * squares;
        cov[(2, 2)] += self.cov[(1, 1)] * squares + self.cov[(2, 2)] * turn * turn;
        symmetrize(&mut cov);
        let stretched = 1.0 + self.bias.x;
        Odometry {
            motion: Pose2::new(
                raw.x() * stretched,
                raw.y() * stretched,
                turn * (1.0 + self.bias.z) + self.bias.y * way,
            ),
            cov,
            ..*odometry
        }
    }

    /// What is to be said against a motion that odometry does not report, in parts of the points of
    /// a scan: the more, the seldomer odometry was grossly wrong.
    pub(super) fn mistrust(&self) -> f64 {
        -MISTRUST * libm::log(self.slips.max(SELDOM))
    }

    /// Notes whether odometry was `right` about a motion that is sure by now.
    pub(super) fn note(&mut self, right: bool) {
        self.slips += SLIP_GAIN * (f64::from(!right) - self.slips);
    }

    /// Learns from odometry that should have been `matched`. Where the match says nothing of the
    /// way ahead, `sees_way` is false.
    pub(super) fn learn(&mut self, odometry: &Odometry, matched: &Pose2, sees_way: bool) {
        let raw = &odometry.motion;
        let (way, turn) = (raw.x(), raw.heading());
        for (axis, wander) in WANDER.into_iter().enumerate() {
            self.cov[(axis, axis)] = (self.cov[(axis, axis)] + wander * wander)
                .min(FIRST_SIGMAS[axis] * FIRST_SIGMAS[axis]);
        }
        let error = Vector2::new(
            matched.x() - raw.x() * (1.0 + self.bias.x),
            matched.heading() - turn * (1.0 + self.bias.z) - way * self.bias.y,
        );
        let by_bias = Matrix2x3::new(way, 0.0, 0.0, 0.0, way, turn);
        let own = Vector2::new(odometry.cov[(0, 0)], odometry.cov[(2, 2)]);
        let match_variance = Vector2::new(
            2.0 * MATCH_SHIFT * MATCH_SHIFT,
            2.0 * MATCH_TURN * MATCH_TURN,
        );
        let known = by_bias * self.cov * by_bias.transpose();
        let mut noise = Matrix2::zeros();
        for axis in 0..2 {
            noise[(axis, axis)] = self.noise[axis] * own[axis] + match_variance[axis];
            let expected = noise[(axis, axis)] + known[(axis, axis)];
            let square = error[axis] * error[axis];
            if axis == 0 && !sees_way {
                noise[(0, 0)] = 1e6;
                continue;
            }
            let ratio = (square / expected).min(MOST_SIGMAS * MOST_SIGMAS);
            // A slip says little of the bias.
            noise[(axis, axis)] *= ratio.max(1.0);
            if own[axis] > match_variance[axis] * 0.1 {
                let factor = ratio * expected - match_variance[axis] - known[(axis, axis)];
                let factor = (factor / own[axis]).clamp(0.0, NOISE_BOUNDS[1]);
                self.noise[axis] = (self.noise[axis] + NOISE_GAIN * (factor - self.noise[axis]))
                    .clamp(NOISE_BOUNDS[0], NOISE_BOUNDS[1]);
            }
        }
        let Some(inverse) = (known + noise).try_inverse() else {
            return;
        };
        let gain = self.cov * by_bias.transpose() * inverse;
        self.bias += gain * error;
        self.cov -= gain * by_bias * self.cov;
        symmetrize(&mut self.cov);
    }
}

snapshot!(Past {
    stamp,
    submap_from_robot,
    odom_from_robot,
});
snapshot!(Motion {
    model,
    since_keyframe,
    keyframe_is_sure,
    odom_from_robot,
    pasts,
    speed,
});
snapshot!(OdometryModel {
    bias,
    cov,
    noise,
    slips,
});

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use crate::points::fixture::normal;

    /// Odometry of drives with these errors, each a way and a turn, and the motion that it was.
    fn drives(bias: [f64; 3], sigma: [f64; 2], seed: u64) -> Vec<(Odometry, Pose2)> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let drive = |_| {
            let (way, turn) = (0.25 + 0.1 * normal(&mut rng), 0.2 * normal(&mut rng));
            let motion = Pose2::new(way, 0.0, turn);
            let [of_way, for_way, of_turn] = bias;
            let shift = (sigma[0] * sigma[0] + 2.0 * MATCH_SHIFT * MATCH_SHIFT).sqrt();
            let angle = (sigma[1] * sigma[1] + 2.0 * MATCH_TURN * MATCH_TURN).sqrt();
            let matched = Pose2::new(
                way * (1.0 + of_way) + shift * normal(&mut rng),
                0.0,
                turn * (1.0 + of_turn) + for_way * way + angle * normal(&mut rng),
            );
            let odometry = Odometry {
                motion,
                cov: Matrix3::from_diagonal(&Vector3::new(4e-4, 4e-4, 1e-4)),
                ..Odometry::standing(Stamp(0))
            };
            (odometry, matched)
        };
        (0..400).map(drive).collect()
    }

    #[test]
    fn a_bias_is_found_to_within_what_is_said_of_it() {
        for (seed, bias) in [[-0.08, 0.06, 0.1], [0.05, -0.08, -0.05], [0.0; 3]]
            .into_iter()
            .enumerate()
        {
            let mut model = OdometryModel::default();
            for (odometry, matched) in drives(bias, [0.02, 0.01], seed as u64) {
                model.learn(&odometry, &matched, true);
            }
            for (axis, truth) in bias.into_iter().enumerate() {
                let sigma = model.cov[(axis, axis)].sqrt();
                let error = model.bias[axis] - truth;
                assert!(error.abs() < 3.5 * sigma, "{seed} {axis}: {error} {sigma}");
                assert!(sigma < 0.3 * FIRST_SIGMAS[axis], "{seed} {axis}: {sigma}");
            }
        }
    }

    #[test]
    fn noise_becomes_as_large_as_it_is() {
        for (sigma, factor) in [([0.02, 0.01], 1.0), ([0.06, 0.03], 9.0)] {
            let mut model = OdometryModel::default();
            for (odometry, matched) in drives([0.0; 3], sigma, 7) {
                model.learn(&odometry, &matched, true);
            }
            for noise in model.noise {
                // The newest thirty or so count.
                assert!(
                    noise > 0.4 * factor && noise < 2.2 * factor,
                    "{noise} {factor}"
                );
            }
        }
    }

    #[test]
    fn a_corridor_teaches_nothing_of_the_way() {
        let mut model = OdometryModel::default();
        for (odometry, matched) in drives([0.05, 0.05, 0.0], [0.02, 0.01], 1) {
            model.learn(&odometry, &matched, false);
        }
        assert!(model.bias.x.abs() < 1e-6, "{}", model.bias);
        assert!((model.bias.y - 0.05).abs() < 0.01, "{}", model.bias);
    }

    #[test]
    fn odometry_that_was_often_wrong_is_doubted_sooner() {
        let (mut good, mut bad) = (OdometryModel::default(), OdometryModel::default());
        for at in 0..200 {
            good.note(true);
            bad.note(at % 4 != 0);
        }
        assert!(good.mistrust() > 2.0 * bad.mistrust());
        assert!(bad.mistrust() > 0.0);
    }
}

//! The odometry errors of this robot, learned from reliable matches.
//!
//! In: odometry between keyframes, and the matched motions. Out: odometry with its bias removed,
//! and with a covariance as large as its errors really are.
//!
//! 1. Wheels have a bias: the distance errs by a fraction of itself, the rotation by a fraction of
//!    itself and by an amount per metre (unequal wheels). And a sensor whose mounting angle is
//!    slightly wrong makes the robot seem to move askew: odometry pulls each match sideways, and
//!    the heading with it, so keyframes a metre apart bend the trajectory by a fifth of a degree
//!    per metre for a sensor turned by one degree. These four are a slowly varying state, estimated
//!    by a Kalman filter.
//! 2. What the bias leaves is noise: the covariance given with the odometry is scaled until it
//!    explains the errors. Noise alone could explain a bias as well, but would not help in a
//!    corridor, where only the wheels tell how far the robot went.
//!
//! Source of the model: Borenstein & Feng (1996), "Measurement and correction of systematic
//! odometry errors in mobile robots"; Censi et al. (2013), "Simultaneous calibration of odometry
//! and sensor parameters for mobile robots".

use std::collections::VecDeque;

use nalgebra::{Matrix3, Matrix3x4, Matrix4, Rotation2, Vector3, Vector4};

use super::odometry_watch::{Believed, OdometryWatch};
use crate::geom::{Length, Pose2, symmetrize, wrap};
use crate::robot::{Odometry, Stamp};
use crate::snapshot::snapshot;

/// The biases: of the distance, 1; of the rotation per metre, rad/m; of the rotation, 1; and the
/// angle by which the robot moves askew, rad.
const WAY: usize = 0;
const BEND: usize = 1;
const TURN: usize = 2;
const ASKEW: usize = 3;
/// Prior standard deviations of the biases.
const FIRST_SIGMAS: [f64; 4] = [0.05, 0.05, 0.1, 0.02];
/// Random walk of each bias, per keyframe.
const WANDER: [f64; 4] = [0.001, 0.001, 0.002, 0.0002];
/// Uncertainty of a match at each end, m and rad.
const MATCH_SHIFT: f64 = 0.015;
const MATCH_TURN: f64 = 0.004;
/// Prior factor on the covariance given with odometry.
const FIRST_NOISE: f64 = 10.0;
/// The weight of a new error in the noise estimate.
const NOISE_GAIN: f64 = 0.03;
/// The smallest and the largest factor on the noise.
const NOISE_BOUNDS: [f64; 2] = [0.1, 30.0];
/// The uncertainty of the bias counts as if each motion were one of this many metres with the same
/// bias. That is much for a short motion: a prior that is assumed to be exact and is not harms
/// every match; one that is assumed to be loose harms no match that sees walls.
const BIAS_LENGTH: f64 = 20.0;
/// The variance along a direction that a match does not observe, m²: no information.
const UNSEEN: f64 = 1e6;
/// An error of more than this many standard deviations comes from a slip or from a wrong match.
const MOST_SIGMAS: f64 = 4.0;

/// The fraction of motions in which odometry is grossly wrong: prior, and least value.
const FIRST_SLIPS: f64 = 0.05;
const SELDOM: f64 = 0.003;
/// The weight of a new motion in this fraction.
const SLIP_GAIN: f64 = 0.02;
/// The penalty for each e-fold of it, as a fraction of a scan's points.
const MISTRUST: f64 = 0.06;

/// An earlier scan, with what late odometry needs of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Past {
    pub(super) stamp: Stamp,
    pub(super) submap_from_robot: Pose2,
    /// Odometry, accumulated since the beginning.
    pub(super) odom_from_robot: Pose2,
}

/// The number of earlier scans that late odometry may belong to.
const PASTS: usize = 8;

/// The robot's motion, by odometry and by matches.
#[derive(Clone, Debug, Default)]
pub(super) struct Motion {
    pub(super) model: OdometryModel,
    /// Raw odometry since the last keyframe.
    since_keyframe: Option<Odometry>,
    /// Whether the last keyframe surely lies where it was matched.
    keyframe_is_sure: bool,
    /// Odometry without its bias, accumulated since the beginning.
    pub(super) odom_from_robot: Pose2,
    /// The scans before this one, the newest last.
    pub(super) pasts: VecDeque<Past>,
    /// The motion between the last two scans, and the seconds it took.
    pub(super) speed: Option<(f64, Pose2)>,
    pub(super) watch: OdometryWatch,
}

impl Motion {
    /// Takes raw odometry and returns it without its bias.
    pub(super) fn moved(&mut self, odometry: Odometry) -> Odometry {
        self.since_keyframe = Some(match self.since_keyframe {
            Some(so_far) => so_far.then(&odometry),
            None => odometry,
        });
        let corrected = self.model.corrected(&odometry);
        self.odom_from_robot = self.odom_from_robot * corrected.motion;
        corrected
    }

    /// What to believe of bias-free odometry as the motion since the robot was matched at `here`.
    pub(super) fn believed(&mut self, moved: Odometry, here: &Pose2, stamp: Stamp) -> Believed {
        let believed = self.watch.moved(moved, here, &self.pasts, stamp);
        if !matches!(believed, Believed::Counted(counted) if counted.motion == moved.motion) {
            // Failed odometry teaches nothing.
            (self.since_keyframe, self.keyframe_is_sure) = (None, false);
        }
        believed
    }

    /// Moves the previous scans forward to where odometry has them: someone walking along held the
    /// robot back.
    pub(super) fn follow_odometry(&mut self) {
        let Some(first) = self.pasts.front().copied() else {
            return;
        };
        for past in &mut self.pasts {
            let way = first.odom_from_robot.delta_to(&past.odom_from_robot);
            past.submap_from_robot = first.submap_from_robot * way;
        }
    }

    /// Records where a scan was placed.
    pub(super) fn remember(&mut self, stamp: Stamp, submap_from_robot: Pose2) {
        if let Some(past) = self.pasts.back() {
            let motion = past.submap_from_robot.delta_to(&submap_from_robot);
            if (self.watch).matched(&past.submap_from_robot, &submap_from_robot) {
                self.model.note(false);
            }
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

    /// Another submap is the running one from here on.
    pub(super) fn rebase(&mut self, new_from_old: &Pose2) {
        for past in &mut self.pasts {
            past.submap_from_robot = *new_from_old * past.submap_from_robot;
        }
        self.watch.rebase(new_from_old);
    }

    /// A scan becomes a keyframe, at motion `matched` from the last one. The odometry model learns
    /// from it if both are reliable; `sees` says whether the match constrains the motion forwards
    /// and sideways.
    pub(super) fn keyframe(&mut self, matched: Option<Pose2>, is_sure: bool, sees: [bool; 2]) {
        let was_sure = std::mem::replace(&mut self.keyframe_is_sure, is_sure);
        let odometry = self.since_keyframe.take();
        if let (Some(odometry), Some(matched)) = (odometry, matched)
            && was_sure
            && is_sure
        {
            self.model.learn(&odometry, &matched, sees);
        }
    }
}

/// What is known of the odometry errors.
#[derive(Clone, Debug)]
pub(super) struct OdometryModel {
    bias: Vector4<f64>,
    cov: Matrix4<f64>,
    /// Factors on the variance of distance and rotation.
    noise: [f64; 2],
    /// How often odometry was grossly wrong.
    slips: f64,
}

impl Default for OdometryModel {
    fn default() -> Self {
        let variances = Vector4::from(FIRST_SIGMAS).map(|s| s * s);
        Self {
            bias: Vector4::zeros(),
            cov: Matrix4::from_diagonal(&variances),
            noise: [FIRST_NOISE; 2],
            slips: FIRST_SLIPS,
        }
    }
}

impl OdometryModel {
    /// The motion without its bias. The additional rotation is spread evenly over the motion, so
    /// the displacement is rotated by half of it.
    fn unbiased(&self, raw: &Pose2) -> Pose2 {
        let more = raw.heading() * self.bias[TURN] + raw.x() * self.bias[BEND];
        let askew = Rotation2::new(self.bias[ASKEW] + 0.5 * more);
        let shift = askew * raw.position().coords * (1.0 + self.bias[WAY]);
        Pose2::new(shift.x, shift.y, raw.heading() + more)
    }

    /// The odometry without its bias, with the covariance of its errors.
    fn corrected(&self, odometry: &Odometry) -> Odometry {
        let raw = &odometry.motion;
        let [shift, angle] = self.noise;
        let scale = Matrix3::from_diagonal(&Vector3::new(shift.sqrt(), shift.sqrt(), angle.sqrt()));
        let mut cov = scale * odometry.cov * scale;
        let squares = raw.position().coords.length() * BIAS_LENGTH;
        let turns = raw.heading() * raw.heading();
        let known = |bias: usize| self.cov[(bias, bias)];
        cov[(0, 0)] += known(WAY) * squares;
        cov[(1, 1)] += known(ASKEW) * squares;
        cov[(2, 2)] += known(BEND) * squares + known(TURN) * turns;
        symmetrize(&mut cov);
        Odometry {
            motion: self.unbiased(raw),
            cov,
            ..*odometry
        }
    }

    /// The penalty for a motion that odometry does not report, as a fraction of a scan's points:
    /// the larger, the more rarely odometry was grossly wrong.
    pub(super) fn mistrust(&self) -> f64 {
        -MISTRUST * libm::log(self.slips.max(SELDOM))
    }

    /// Records whether odometry was `right` about a motion that is certain by now.
    pub(super) fn note(&mut self, right: bool) {
        self.slips += SLIP_GAIN * (f64::from(!right) - self.slips);
    }

    /// Learns from odometry that should have been `matched`. `sees` says whether the match
    /// constrains the motion forwards and sideways.
    pub(super) fn learn(&mut self, odometry: &Odometry, matched: &Pose2, sees: [bool; 2]) {
        for (axis, wander) in WANDER.into_iter().enumerate() {
            self.cov[(axis, axis)] = (self.cov[(axis, axis)] + wander * wander)
                .min(FIRST_SIGMAS[axis] * FIRST_SIGMAS[axis]);
        }
        let raw = &odometry.motion;
        let expected = self.unbiased(raw);
        let error = Vector3::new(
            matched.x() - expected.x(),
            matched.y() - expected.y(),
            wrap(matched.heading() - expected.heading()),
        );
        let by_bias = by_bias(raw);
        let own = odometry.cov.diagonal();
        let match_variance =
            Vector3::new(MATCH_SHIFT, MATCH_SHIFT, MATCH_TURN).map(|sigma| 2.0 * sigma * sigma);
        let known = by_bias * self.cov * by_bias.transpose();
        let mut noise = Matrix3::zeros();
        // The sideways noise is assumed to be that of the distance, and is learned from it.
        for (axis, factor) in [(0, 0), (1, 0), (2, 1)] {
            if sees.get(axis) == Some(&false) {
                noise[(axis, axis)] = UNSEEN;
                continue;
            }
            noise[(axis, axis)] = self.noise[factor] * own[axis] + match_variance[axis];
            let expected = noise[(axis, axis)] + known[(axis, axis)];
            let square = error[axis] * error[axis];
            let ratio = (square / expected).min(MOST_SIGMAS * MOST_SIGMAS);
            // A slip says little about the bias.
            noise[(axis, axis)] *= ratio.max(1.0);
            if axis != 1 && own[axis] > match_variance[axis] * 0.1 {
                let noise = &mut self.noise[factor];
                let found = ratio * expected - match_variance[axis] - known[(axis, axis)];
                let found = (found / own[axis]).clamp(0.0, NOISE_BOUNDS[1]);
                *noise = (*noise + NOISE_GAIN * (found - *noise))
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

/// The derivative of the motion with respect to the biases, to first order in them.
fn by_bias(raw: &Pose2) -> Matrix3x4<f64> {
    let (x, y, turn) = (raw.x(), raw.y(), raw.heading());
    #[rustfmt::skip]
    let rows = Matrix3x4::new(
        //  WAY, BEND, TURN, ASKEW
        x, -0.5 * x * y, -0.5 * turn * y, -y,
        y,  0.5 * x * x,  0.5 * turn * x,  x,
        0.0, x, turn, 0.0,
    );
    rows
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
    watch,
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

    /// Odometry of drives with these biases and with errors of distance and rotation, each with its
    /// true motion.
    fn drives(bias: [f64; 4], sigma: [f64; 2], seed: u64) -> Vec<(Odometry, Pose2)> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let drive = |_| {
            let (way, turn) = (0.25 + 0.1 * normal(&mut rng), 0.2 * normal(&mut rng));
            let shift = (sigma[0] * sigma[0] + 2.0 * MATCH_SHIFT * MATCH_SHIFT).sqrt();
            let angle = (sigma[1] * sigma[1] + 2.0 * MATCH_TURN * MATCH_TURN).sqrt();
            let exact = driven(bias, way, turn);
            let matched = Pose2::new(
                exact.x() + shift * normal(&mut rng),
                exact.y() + shift * normal(&mut rng),
                exact.heading() + angle * normal(&mut rng),
            );
            let odometry = Odometry {
                motion: driven([0.0; 4], way, turn),
                cov: Matrix3::from_diagonal(&Vector3::new(4e-4, 4e-4, 1e-4)),
                ..Odometry::standing(Stamp(0))
            };
            (odometry, matched)
        };
        (0..400).map(drive).collect()
    }

    /// Where a drive at constant speed and turn rate ends, in a hundred small steps with a bias.
    fn driven(bias: [f64; 4], way: f64, turn: f64) -> Pose2 {
        const STEPS: usize = 100;
        let (way, turn) = (way / STEPS as f64, turn / STEPS as f64);
        let more = turn * bias[TURN] + way * bias[BEND];
        let half = Pose2::new(0.0, 0.0, 0.5 * (turn + more));
        let (sin, cos) = libm::sincos(bias[ASKEW]);
        let long = way * (1.0 + bias[WAY]);
        let step = half * Pose2::new(long * cos, long * sin, 0.0) * half;
        (0..STEPS).fold(Pose2::identity(), |so_far, _| so_far * step)
    }

    #[test]
    fn a_bias_is_found_to_within_what_is_said_of_it() {
        let wheels = [-0.08, 0.06, 0.1, 0.0];
        let turned = [0.05, -0.08, -0.05, -0.03];
        for (seed, bias) in [wheels, turned, [0.0; 4]].into_iter().enumerate() {
            let mut model = OdometryModel::default();
            for (odometry, matched) in drives(bias, [0.02, 0.01], seed as u64) {
                model.learn(&odometry, &matched, [true; 2]);
            }
            for (axis, truth) in bias.into_iter().enumerate() {
                let sigma = model.cov[(axis, axis)].sqrt();
                let error = model.bias[axis] - truth;
                assert!(error.abs() < 3.5 * sigma, "{seed} {axis}: {error} {sigma}");
                assert!(sigma < 0.5 * FIRST_SIGMAS[axis], "{seed} {axis}: {sigma}");
            }
        }
    }

    #[test]
    fn a_bent_way_is_not_taken_for_a_turned_sensor() {
        // A metre at a time, where the arc is deep.
        let bent = [0.0, -0.12, 0.0, 0.0];
        let mut model = OdometryModel::default();
        for _ in 0..200 {
            let odometry = Odometry {
                motion: Pose2::new(1.0, 0.0, 0.0),
                cov: Matrix3::from_diagonal(&Vector3::new(4e-4, 4e-4, 1e-4)),
                ..Odometry::standing(Stamp(0))
            };
            model.learn(&odometry, &driven(bent, 1.0, 0.0), [true; 2]);
        }
        assert!(model.bias[ASKEW].abs() < 1e-3, "{}", model.bias);
        assert!((model.bias[BEND] + 0.12).abs() < 2e-3, "{}", model.bias);
    }

    #[test]
    fn a_motion_without_its_bias_is_that_of_many_small_steps() {
        let bias = [0.03, -0.1, 0.06, 0.02];
        let model = OdometryModel {
            bias: Vector4::from(bias),
            ..OdometryModel::default()
        };
        for (way, turn) in [(0.3, 0.0), (0.3, 0.3), (-0.2, 0.2), (1.0, -0.1)] {
            let raw = driven([0.0; 4], way, turn);
            let off = model.unbiased(&raw).delta_to(&driven(bias, way, turn));
            // Second order in bias and rotation.
            assert!(
                off.position().coords.length() < 3e-3 * f64::abs(way),
                "{off:?}"
            );
            assert!(off.heading().abs() < 1e-3, "{off:?}");
        }
    }

    #[test]
    fn the_motion_changes_with_the_biases_as_differences_say() {
        let raw = Pose2::new(0.7, -0.2, 0.4);
        let by_bias = by_bias(&raw);
        for axis in 0..4 {
            let with = |bias: f64| {
                let mut model = OdometryModel::default();
                model.bias[axis] = bias;
                let motion = model.unbiased(&raw);
                Vector3::new(motion.x(), motion.y(), motion.heading())
            };
            let slope = (with(1e-6) - with(-1e-6)) / 2e-6;
            let off = (slope - by_bias.column(axis)).amax();
            assert!(off < 1e-6, "{axis}: {off}");
        }
    }

    #[test]
    fn a_turned_sensor_is_known_by_how_it_moves() {
        let robot_from_sensor = Pose2::new(0.0, 0.0, -0.02);
        let mut model = OdometryModel::default();
        for (odometry, _) in drives([0.0; 4], [0.02, 0.01], 3) {
            let of_sensor = robot_from_sensor.inverse() * odometry.motion * robot_from_sensor;
            model.learn(&odometry, &of_sensor, [true; 2]);
        }
        assert!((model.bias[ASKEW] - 0.02).abs() < 0.003, "{}", model.bias);
        assert!(model.bias[WAY].abs() < 0.01, "{}", model.bias);
    }

    #[test]
    fn noise_becomes_as_large_as_it_is() {
        for (sigma, factor) in [([0.02, 0.01], 1.0), ([0.06, 0.03], 9.0)] {
            let mut model = OdometryModel::default();
            for (odometry, matched) in drives([0.0; 4], sigma, 7) {
                model.learn(&odometry, &matched, [true; 2]);
            }
            for noise in model.noise {
                // About the newest thirty count.
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
        let bias = [0.05, 0.05, 0.0, 0.01];
        for (odometry, matched) in drives(bias, [0.02, 0.01], 1) {
            model.learn(&odometry, &matched, [false, true]);
        }
        // Almost nothing: how far sideways an arc ends says little about its length.
        assert!(model.cov[(WAY, WAY)].sqrt() > 0.8 * FIRST_SIGMAS[WAY]);
        assert!(model.bias[WAY].abs() < 0.02, "{}", model.bias);
        assert!((model.bias[BEND] - 0.05).abs() < 0.01, "{}", model.bias);
        assert!((model.bias[ASKEW] - 0.01).abs() < 0.006, "{}", model.bias);
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

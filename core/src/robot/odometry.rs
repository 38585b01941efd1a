//! From distances of the two tracks to a motion with its covariance.

use nalgebra::{Matrix2, Matrix3, SMatrix};

use super::{OdometryNoise, RobotModel, Stamp};
use crate::geom::{Pose2, PoseEstimate, sin_cos, symmetrize};

/// The robot's own estimate of its motion between two stamps, in the robot frame at the start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Odometry {
    /// Start of the motion.
    pub from: Stamp,
    /// End of the motion.
    pub to: Stamp,
    /// `robot_at_from_from_robot_at_to`.
    pub motion: Pose2,
    /// Covariance of (x, y, θ) of `motion` in the robot frame at `from`.
    pub cov: Matrix3<f64>,
}

/// Why an [`Odometry`] cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "odometry from {from:.3} s to {to:.3} s: {what}; expected finite numbers and variances of at least 0"
)]
pub struct OdometryError {
    /// Its beginning, s.
    pub from: f64,
    /// Its end, s.
    pub to: f64,
    /// What is wrong.
    pub what: &'static str,
}

impl Odometry {
    /// Checks that all numbers are finite and valid. A source calls it once where data enters;
    /// afterwards the motion is trusted.
    ///
    /// # Errors    [`OdometryError`], naming the instants and the part at fault.
    pub fn validate(&self) -> Result<(), OdometryError> {
        let what = if !self.motion.is_finite() {
            "the motion is not finite"
        } else if !self.cov.iter().all(|value| value.is_finite()) {
            "the covariance is not finite"
        } else if self.cov.diagonal().iter().any(|&variance| variance < 0.0) {
            "a variance is negative"
        } else {
            return Ok(());
        };
        let (from, to) = (self.from.seconds(), self.to.seconds());
        Err(OdometryError { from, to, what })
    }

    /// No motion, known exactly.
    #[must_use]
    pub fn standing(at: Stamp) -> Self {
        Self {
            from: at,
            to: at,
            motion: Pose2::identity(),
            cov: Matrix3::zeros(),
        }
    }

    /// This motion followed by `next`, covariances composed to first order.
    #[must_use]
    pub fn then(&self, next: &Self) -> Self {
        let before = PoseEstimate {
            pose: self.motion,
            cov: self.cov,
        };
        let PoseEstimate { pose: motion, cov } = next.after(&before);
        Self {
            from: self.from,
            to: next.to,
            motion,
            cov,
        }
    }

    /// The pose to which this motion leads from `before`, covariances composed to first order.
    #[must_use]
    pub fn after(&self, before: &PoseEstimate) -> PoseEstimate {
        let (cos, sin) = before.pose.cos_sin();
        let (dx, dy) = (self.motion.x(), self.motion.y());
        #[rustfmt::skip]
        let by_before = Matrix3::new(
            1.0, 0.0, -sin * dx - cos * dy,
            0.0, 1.0,  cos * dx - sin * dy,
            0.0, 0.0, 1.0,
        );
        let by_motion = before.pose.rotation();
        let mut cov = by_before * before.cov * by_before.transpose()
            + by_motion * self.cov * by_motion.transpose();
        symmetrize(&mut cov);
        PoseEstimate {
            pose: before.pose * self.motion,
            cov,
        }
    }
}

/// Distances that the two tracks (or wheels) travelled, m.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tracks {
    /// Left.
    pub left: f64,
    /// Right.
    pub right: f64,
}

impl Tracks {
    /// The motion of the midpoint rule: Δs cos(Δθ/2), Δs sin(Δθ/2), Δθ with Δθ = (Δs_R - Δs_L)/b.
    ///
    /// Source: TDK 2016 eq. (2.6), with the erratum of the specification: b is the whole track
    /// width.
    #[must_use]
    pub fn motion(&self, track_width: f64) -> Pose2 {
        let advance = 0.5 * (self.right + self.left);
        let turn = (self.right - self.left) / track_width;
        let (sin, cos) = sin_cos(0.5 * turn);
        Pose2::new(advance * cos, advance * sin, turn)
    }

    /// Covariance of [`Tracks::motion`]: k |Δs| for each track, and lateral slip in proportion to
    /// the turn and the distance.
    ///
    /// Source: TDK 2016 §3.1 (F_u Q F_uᵀ); the variance in proportion to the distance as in
    /// Siegwart & Nourbakhsh (2004), eq. (5.8).
    #[must_use]
    pub fn covariance(&self, track_width: f64, noise: &OdometryNoise) -> Matrix3<f64> {
        let of_track = |way: f64| noise.per_metre * way.abs();
        let mut cov = self.propagated(track_width, [of_track(self.left), of_track(self.right)]);
        let advance = 0.5 * (self.right + self.left);
        let turn = (self.right - self.left) / track_width;
        cov[(1, 1)] += noise.lateral_per_metre * advance.abs();
        cov[(2, 2)] += noise.heading_per_radian * turn.abs();
        symmetrize(&mut cov);
        cov
    }

    /// F_u Q F_uᵀ: covariance of [`Tracks::motion`], given the variances of the distances of the
    /// left and the right track, m².
    ///
    /// Source: TDK 2016 §3.1.
    #[must_use]
    pub fn propagated(&self, track_width: f64, variances: [f64; 2]) -> Matrix3<f64> {
        let advance = 0.5 * (self.right + self.left);
        let turn = (self.right - self.left) / track_width;
        let (sin, cos) = sin_cos(0.5 * turn);
        let (along, across) = (
            advance * sin / (2.0 * track_width),
            advance * cos / (2.0 * track_width),
        );
        #[rustfmt::skip]
        let by_tracks = SMatrix::<f64, 3, 2>::new(
            0.5 * cos + along,  0.5 * cos - along,
            0.5 * sin - across, 0.5 * sin + across,
            -1.0 / track_width, 1.0 / track_width,
        );
        let tracks = Matrix2::new(variances[0], 0.0, 0.0, variances[1]);
        let mut cov = by_tracks * tracks * by_tracks.transpose();
        symmetrize(&mut cov);
        cov
    }
}

/// What a filter assumes about the random errors of the odometry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TrackNoise {
    /// Variances grow with the distance and the turn.
    Proportional(OdometryNoise),
    /// The same variance for each track in each reading of the encoders, m², however far it ran: a
    /// standing robot becomes less and less certain, and a driving one is trusted too much. TDK
    /// 2016 §3.1, the paper's constant Q.
    Constant(f64),
}

impl TrackNoise {
    /// Covariance of [`Tracks::motion`].
    #[must_use]
    pub fn covariance(&self, tracks: &Tracks, track_width: f64) -> Matrix3<f64> {
        match self {
            Self::Proportional(noise) => tracks.covariance(track_width, noise),
            Self::Constant(variance) => tracks.propagated(track_width, [*variance; 2]),
        }
    }
}

/// Turns encoder counts of the two tracks into odometry; remembers the last counts.
#[derive(Clone, Debug)]
pub struct TrackOdometry {
    metres_per_tick: f64,
    track_width: f64,
    noise: OdometryNoise,
    last: Option<(Stamp, [i64; 2])>,
}

impl TrackOdometry {
    /// For the given robot, with the effective track width that slip gives.
    #[must_use]
    pub fn new(model: &RobotModel) -> Self {
        Self {
            metres_per_tick: model.metres_per_tick,
            track_width: model.track_width,
            noise: model.odometry_noise,
            last: None,
        }
    }

    /// The motion since the last call, from counts `[left, right]`; the first call gives no motion.
    pub fn update(&mut self, stamp: Stamp, ticks: [i64; 2]) -> Odometry {
        let Some((from, last)) = self.last.replace((stamp, ticks)) else {
            return Odometry::standing(stamp);
        };
        let metres = |now: i64, then: i64| now.wrapping_sub(then) as f64 * self.metres_per_tick;
        let tracks = Tracks {
            left: metres(ticks[0], last[0]),
            right: metres(ticks[1], last[1]),
        };
        Odometry {
            from,
            to: stamp,
            motion: tracks.motion(self.track_width),
            cov: tracks.covariance(self.track_width, &self.noise),
        }
    }
}

#[cfg(test)]
mod tests;

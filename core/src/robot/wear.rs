//! How the tracks of one robot differ from its model, and odometry corrected by that.
//!
//! In: odometry computed with the model's figures. Out: the same with the figures of this robot.

use super::{Odometry, TrackNoise, Tracks};
use crate::geom::{Pose2, sin_cos};

/// How the tracks of one robot differ from its model, as parts: 0.01 is one per cent.
///
/// Source: Borenstein & Feng (1996), "Measurement and correction of systematic odometry errors in
/// mobile robots": unequal wheels and an uncertain wheelbase are the two errors that matter.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TrackWear {
    /// How much farther the left track runs than its counts say.
    pub left: f64,
    /// The same for the right one.
    pub right: f64,
    /// How much wider the effective track is.
    pub track_width: f64,
}

impl TrackWear {
    /// The true distances of the tracks for the distances `counted`, m.
    #[must_use]
    pub fn ran(&self, counted: &Tracks) -> Tracks {
        Tracks {
            left: counted.left * (1.0 + self.left),
            right: counted.right * (1.0 + self.right),
        }
    }

    /// The effective track width of a robot whose model says `track_width`, m.
    #[must_use]
    pub fn width(&self, track_width: f64) -> f64 {
        track_width * (1.0 + self.track_width)
    }
}

/// What is known of a robot's odometry beyond its model: systematic errors and noise.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OdometryCalibration {
    /// How its tracks differ from its model.
    pub wear: TrackWear,
    /// Its random errors; `None`: as its model says.
    pub noise: Option<TrackNoise>,
}

impl OdometryCalibration {
    /// Odometry computed by a model with this track width, corrected to how this robot moved. If
    /// nothing moved (the robot stood, or nobody watched), the noise of a standing robot adds to
    /// what the odometry claims.
    #[must_use]
    pub fn corrected(&self, odometry: &Odometry, track_width: f64) -> Odometry {
        if *self == Self::default() {
            return *odometry;
        }
        let width = self.wear.width(track_width);
        if odometry.motion == Pose2::identity() {
            let mut stood = *odometry;
            if let Some(noise) = self.noise {
                stood.cov += noise.covariance(&Tracks::default(), width);
            }
            return stood;
        }
        let ran = self.wear.ran(&Tracks::of(odometry, track_width));
        let cov = self
            .noise
            .map_or(odometry.cov, |noise| noise.covariance(&ran, width));
        Odometry {
            motion: ran.motion(width),
            cov,
            ..*odometry
        }
    }
}

impl Tracks {
    /// The distances of the tracks that give this motion by the midpoint rule, the inverse of
    /// [`Tracks::motion`].
    #[must_use]
    pub fn of(odometry: &Odometry, track_width: f64) -> Self {
        let motion = &odometry.motion;
        let turn = motion.heading();
        let (sin, cos) = sin_cos(0.5 * turn);
        let advance = motion.x() * cos + motion.y() * sin;
        Self {
            left: advance - 0.5 * turn * track_width,
            right: advance + 0.5 * turn * track_width,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Length;
    use crate::robot::{RobotModel, Stamp};

    fn counted(tracks: Tracks, model: &RobotModel) -> Odometry {
        Odometry {
            from: Stamp(0),
            to: Stamp(10_000),
            motion: tracks.motion(model.track_width),
            cov: tracks.covariance(model.track_width, &model.odometry_noise),
        }
    }

    #[test]
    fn tracks_are_found_again_in_the_motion_they_made() {
        let model = RobotModel::rp6();
        for (left, right) in [(0.1, 0.12), (-0.1, -0.07), (0.05, -0.05), (0.0, 0.0)] {
            let found = Tracks::of(&counted(Tracks { left, right }, &model), model.track_width);
            assert!((found.left - left).abs() < 1e-15 && (found.right - right).abs() < 1e-15);
        }
    }

    #[test]
    fn a_worn_robot_counts_a_straight_drive_where_it_drove_a_curve() {
        let model = RobotModel::rp6();
        let wear = TrackWear {
            left: -0.01,
            right: 0.03,
            track_width: 0.05,
        };
        let straight = Tracks {
            left: 1.0,
            right: 1.0,
        };
        let calibration = OdometryCalibration { wear, noise: None };
        let moved = calibration.corrected(&counted(straight, &model), model.track_width);
        // Δθ = (1.03 - 0.99) / (1.05 b), Δs = 1.01.
        assert!((moved.motion.heading() - 0.04 / (1.05 * model.track_width)).abs() < 1e-12);
        assert!((moved.motion.position().coords.length() - 1.01).abs() < 1e-12);
    }

    #[test]
    fn odometry_without_calibration_is_as_counted_and_another_noise_is_applied() {
        let model = RobotModel::rp6();
        let odometry = counted(
            Tracks {
                left: 0.1,
                right: 0.13,
            },
            &model,
        );
        let mut calibration = OdometryCalibration::default();
        assert_eq!(
            calibration.corrected(&odometry, model.track_width),
            odometry
        );
        let twice = crate::robot::OdometryNoise {
            per_metre: 2.0 * model.odometry_noise.per_metre,
            lateral_per_metre: 2.0 * model.odometry_noise.lateral_per_metre,
            heading_per_radian: 2.0 * model.odometry_noise.heading_per_radian,
        };
        calibration.noise = Some(TrackNoise::Proportional(twice));
        let unsure = calibration.corrected(&odometry, model.track_width);
        assert!((unsure.cov - 2.0 * odometry.cov).length() < 1e-15);
        let unwatched = Odometry {
            motion: Pose2::identity(),
            cov: nalgebra::Matrix3::identity(),
            ..odometry
        };
        assert_eq!(
            calibration.corrected(&unwatched, model.track_width),
            unwatched
        );
    }
}

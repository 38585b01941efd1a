//! The figures of a robot: size, speeds, encoders, and how far its odometry can be trusted.

use super::DriveTrain;
use crate::geom::Footprint;

/// Everything about the chassis that the algorithms need to know.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RobotModel {
    /// Name of the preset.
    pub name: &'static str,
    /// Length of the body, m.
    pub length: f64,
    /// Width of the body, m.
    pub width: f64,
    /// The part of the body that touches walls.
    pub shape: BodyShape,
    /// Effective distance of the tracks when turning, m: because of slip it is larger than the
    /// distance measured with a ruler.
    pub track_width: f64,
    /// Distance of the tracks as measured with a ruler, m.
    pub ruled_width: f64,
    /// Distance of one encoder count, m.
    pub metres_per_tick: f64,
    /// Highest forward speed, m/s.
    pub max_speed: f64,
    /// Highest turn rate, rad/s.
    pub max_turn_rate: f64,
    /// Highest change of forward speed, m/s².
    pub max_acceleration: f64,
    /// Highest change of turn rate, rad/s².
    pub max_turn_acceleration: f64,
    /// The motors that drive the tracks.
    pub drive: DriveTrain,
    /// The random errors of the odometry, as a filter assumes them.
    pub odometry_noise: OdometryNoise,
    /// The systematic errors of the odometry of a single robot of this kind; no filter knows them.
    pub odometry_bias: OdometryBias,
}

/// The part of a robot's body that touches walls.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BodyShape {
    /// Its circumscribed circle, whatever its heading (TDK 2016 §5.1).
    #[default]
    Disc,
    /// The rectangle of its length and width about the centre.
    Rectangle,
}

impl BodyShape {
    /// All of them, with their names in settings and for people.
    pub const ALL: [(&'static str, Self, &'static str); 2] = [
        ("disc", Self::Disc, "disc"),
        ("rectangle", Self::Rectangle, "rectangle"),
    ];
}

/// Growth of the odometry's variance with the distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OdometryNoise {
    /// Variance of a track's distance for each metre it travelled, m²/m.
    pub per_metre: f64,
    /// Variance of the sideways slip for each metre travelled, m²/m.
    pub lateral_per_metre: f64,
    /// Variance of the heading for each radian turned, rad²/rad: tracks slip most when turning on
    /// the spot.
    pub heading_per_radian: f64,
}

/// Systematic errors of the odometry, which differ from robot to robot. The simulation draws those
/// of its robot from its seed, each with a random sign and between half and one and a half times
/// the size given here.
///
/// Source: Borenstein & Feng (1996), "Measurement and correction of systematic odometry errors in
/// mobile robots": unequal wheels and an uncertain wheelbase are the two that matter.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OdometryBias {
    /// How much longer one track runs than the other, as a part of the distance: it bends a
    /// straight drive.
    pub track_mismatch: f64,
    /// How much wider the effective track is than assumed, as a part: it makes each turn too short
    /// or too long.
    pub track_width: f64,
}

impl RobotModel {
    /// The tracked RP6: board 113 x 189 mm, 0.24 mm per count, tracks 103 mm apart that turn as if
    /// they were 197 mm apart.
    ///
    /// Source: the specification, "Motors and the drive controller" and "RP6 over UART".
    #[must_use]
    pub fn rp6() -> Self {
        Self {
            name: "rp6",
            length: 0.189,
            width: 0.113,
            shape: BodyShape::Disc,
            track_width: 0.197,
            ruled_width: 0.103,
            metres_per_tick: 0.000_24,
            max_speed: 0.30,
            max_turn_rate: 2.0,
            max_acceleration: 0.6,
            max_turn_acceleration: 6.0,
            drive: DriveTrain::rp6(),
            odometry_noise: OdometryNoise {
                per_metre: 2.5e-4,
                lateral_per_metre: 1e-4,
                heading_per_radian: 2e-3,
            },
            // Slip differs from floor to floor: the specification asks for a calibration on a known
            // turn.
            odometry_bias: OdometryBias {
                track_mismatch: 0.02,
                track_width: 0.03,
            },
        }
    }

    /// A Pioneer 2-DX: the wheeled robot under most of the recorded lidar logs.
    #[must_use]
    pub fn pioneer() -> Self {
        Self {
            name: "pioneer",
            length: 0.44,
            width: 0.38,
            shape: BodyShape::Disc,
            track_width: 0.33,
            ruled_width: 0.33,
            metres_per_tick: 0.000_1,
            max_speed: 0.7,
            max_turn_rate: 1.5,
            max_acceleration: 0.5,
            max_turn_acceleration: 2.0,
            drive: DriveTrain::pioneer(),
            odometry_noise: OdometryNoise {
                per_metre: 1e-3,
                lateral_per_metre: 5e-4,
                heading_per_radian: 5e-3,
            },
            odometry_bias: OdometryBias {
                track_mismatch: 0.005,
                track_width: 0.02,
            },
        }
    }

    /// Angle of a track's shaft for one encoder count, rad.
    #[must_use]
    pub fn radians_per_count(&self) -> f64 {
        self.metres_per_tick / self.drive.metres_per_radian
    }

    /// The body's outline, wider by `margin` m on every side; `None` if it is a disc, or if nothing
    /// of the outline remains.
    #[must_use]
    pub fn outline(&self, margin: f64) -> Option<Footprint> {
        match self.shape {
            BodyShape::Disc => None,
            BodyShape::Rectangle => {
                Footprint::rectangle(self.length + 2.0 * margin, self.width + 2.0 * margin)
            }
        }
    }

    /// Radius of the disc that contains the body, m.
    ///
    /// Source: TDK 2016 §5.1, the robot as a disc.
    #[must_use]
    pub fn radius(&self) -> f64 {
        0.5 * libm::hypot(self.length, self.width)
    }
}

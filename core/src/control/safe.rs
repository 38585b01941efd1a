//! Safe mode: no command, by hand or by pilot, drives into what the last scan saw.
//!
//! In: the speeds that are wished, the last scan's points, the motion since. Out: speeds that stop before contact.
//!
//! 1. The points are moved into the robot's present frame by odometry.
//! 2. The robot's disc is swept along the arc of the wished speeds, along the one it is on, and straight on: the turn
//!    rate takes time to change, and the robot is somewhere between them. The first point that it would touch gives the free
//!    distance. Points that the disc moves away from do not count, so that backing off a wall stays possible.
//! 3. Speed: v t + v²/(2 a) may not exceed the free distance, with reaction time t and braking a. Turning on the spot
//!    never moves the disc and is never limited.
//!
//! Source: Celej §5 (safe mode); braking distance plus reaction time as in the specification.

use nalgebra::Point2;

use crate::geom::Pose2;
use crate::points::Points;
use crate::robot::RobotModel;

/// How cautious safe mode is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SafeConfig {
    /// Distance kept between the robot's disc and obstacles, m. Default 0.018: below what planned paths keep.
    pub gap: f64,
    /// Time from what is seen to an effect, s. Default 0.3: a tick, a revolution of a lidar, and the motors. What stands still
    /// asks for half of that, since odometry moves its points along; a person who comes nearer meanwhile for all of it.
    pub reaction: f64,
    /// Part of the robot's acceleration that braking counts on. Default 0.7.
    pub braking: f64,
    /// How much wider than the disc the swept strip becomes, for each metre ahead. Default 0. Larger slows the robot before what
    /// it would only just pass: where that will be is not known to the centimetre.
    pub spread: f64,
    /// How fast people walk, m/s. Default 1.2. Growing: the robot slows down farther from them, and they have to be farther away for it
    /// to go on. 0 takes them for things.
    pub walking: f64,
    /// Oldest scan that is still trusted, s. Default 0.5.
    pub stale_after: f64,
}

impl Default for SafeConfig {
    fn default() -> Self {
        Self {
            gap: 0.018,
            reaction: 0.3,
            braking: 0.7,
            spread: 0.0,
            walking: 1.2,
            stale_after: 0.5,
        }
    }
}

impl SafeConfig {
    /// For driving by hand: nobody steers through gaps by the millimetre, and whoever leans on the key at a wall must not
    /// creep into it scan by scan. With the robot's radius, the gap is more than the 0.15 m within which a lidar is blind.
    #[must_use]
    pub fn by_hand(self) -> Self {
        Self {
            gap: self.gap.max(0.05),
            spread: self.spread.max(0.1),
            ..self
        }
    }
}

/// The speeds (m/s, rad/s) that are safe, for a robot that was told to run at `before`. `robot_at_scan_from_robot` is
/// the motion since the scan.
#[must_use]
pub fn limit_speed(
    (forward, turn): (f64, f64),
    before: (f64, f64),
    points: &Points,
    robot_at_scan_from_robot: &Pose2,
    model: &RobotModel,
    config: &SafeConfig,
) -> (f64, f64) {
    let (forward, turn) = within_model((forward, turn), model);
    if forward == 0.0 {
        return (0.0, turn);
    }
    let brake = config.braking * model.max_acceleration;
    let longest = forward.abs() * config.reaction + forward * forward / (2.0 * brake);
    // The turn rate takes time to change: what is swept lies between the old arc, the new one and the straight line.
    let free = [turn, before.1, 0.0].map(|turn| {
        let strip = Strip {
            radius: model.radius() + config.gap,
            spread: config.spread,
        };
        strip.free_distance((forward, turn), points, robot_at_scan_from_robot, longest)
    });
    let free = free.into_iter().fold(longest, f64::min);
    if free >= longest {
        return (forward, turn);
    }
    // v t + v²/(2 a) = d
    let at = brake * config.reaction;
    let safe = (at * at + 2.0 * brake * free).sqrt() - at;
    (safe.min(forward.abs()).copysign(forward), turn)
}

/// The speeds (m/s, rad/s) as far as the robot can run them; 0 for what is no number.
#[must_use]
pub fn within_model((forward, turn): (f64, f64), model: &RobotModel) -> (f64, f64) {
    let bounded = |wish: f64, most: f64| {
        if wish.is_finite() {
            wish.clamp(-most, most)
        } else {
            0.0
        }
    };
    (
        bounded(forward, model.max_speed),
        bounded(turn, model.max_turn_rate),
    )
}

/// How far a disc of `radius` moves along the arc of the given speeds before it touches a point of the scan, m; `most`
/// where it does not.
#[must_use]
pub fn free_distance(
    speeds: (f64, f64),
    points: &Points,
    robot_at_scan_from_robot: &Pose2,
    radius: f64,
    most: f64,
) -> f64 {
    let strip = Strip {
        radius,
        spread: 0.0,
    };
    strip.free_distance(speeds, points, robot_at_scan_from_robot, most)
}

/// What is swept: a disc that grows on its way.
#[derive(Clone, Copy)]
struct Strip {
    radius: f64,
    /// m/m.
    spread: f64,
}

impl Strip {
    fn free_distance(
        &self,
        (forward, turn): (f64, f64),
        points: &Points,
        robot_at_scan_from_robot: &Pose2,
        most: f64,
    ) -> f64 {
        let robot_from_scan = robot_at_scan_from_robot.inverse();
        let near = most + self.radius + self.spread * most;
        let obstacles: Vec<Point2<f64>> = points
            .hits()
            .map(|beam| robot_from_scan * beam.end_in_robot)
            .filter(|p| p.coords.norm_squared() < near * near)
            .collect();
        if obstacles.is_empty() || forward == 0.0 || most.is_nan() || most <= 0.0 {
            return most.max(0.0);
        }
        let steps = (most / STEP).ceil().clamp(1.0, 1e3) as usize;
        let motion_of = |distance: f64| {
            let time = distance / forward.abs();
            arc(forward * time, turn * time)
        };
        let mut before: Vec<f64> = obstacles.iter().map(|p| p.coords.norm()).collect();
        for step in 1..=steps {
            let distance = most * step as f64 / steps as f64;
            let at = motion_of(distance);
            let radius = self.radius + self.spread * distance;
            for (obstacle, before) in obstacles.iter().zip(&mut before) {
                let now = (obstacle - at).norm();
                if now < radius && now < *before - 1e-9 {
                    return most * (step - 1) as f64 / steps as f64;
                }
                *before = now;
            }
        }
        most
    }
}

/// Step along the arc, m.
const STEP: f64 = 0.01;

/// Where an arc of the given length and turn ends.
pub(super) fn arc(length: f64, turn: f64) -> Point2<f64> {
    let (sin, cos) = crate::geom::sin_cos(0.5 * turn);
    // Chord of the arc: length sin(turn/2)/(turn/2), in direction turn/2.
    let chord = if turn.abs() < 1e-9 {
        length
    } else {
        length * sin / (0.5 * turn)
    };
    Point2::new(chord * cos, chord * sin)
}

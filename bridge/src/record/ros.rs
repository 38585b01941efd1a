//! What is recorded, once more as ROS 2 messages, so that other tools can open a recording.
//!
//! Frames by REP-105: `odom`, in which the odometry is added up since the recording began, `base_link`, and `laser`. Stamps
//! are the time of day at which a message passed the bridge; the robot's own clock stands in channel `slamlab`.
//!
//! A `LaserScan` has equal angles between its beams and knows no others. Bearings are put in order, counter-clockwise; each
//! beam gets the nearest range within half a step of it, or NaN. Intensities are the qualities of the sensor, in its own unit,
//! where it tells any.

use std::time::Duration;

use slamlab_core::geom::Pose2;
use slamlab_core::wire::message::{FromBridge, Motion, OdometryBody, ScanBody, ToBridge};

use super::cdr::Cdr;

/// The topics.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Topic {
    Scan,
    Odometry,
    Velocity,
    Transforms,
}

impl Topic {
    pub(super) const ALL: [Self; 4] =
        [Self::Scan, Self::Odometry, Self::Velocity, Self::Transforms];

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Scan => "/scan",
            Self::Odometry => "/odom",
            Self::Velocity => "/cmd_vel",
            Self::Transforms => "/tf",
        }
    }

    pub(super) fn schema(self) -> &'static str {
        match self {
            Self::Scan => "sensor_msgs/msg/LaserScan",
            Self::Odometry => "nav_msgs/msg/Odometry",
            Self::Velocity => "geometry_msgs/msg/Twist",
            Self::Transforms => "tf2_msgs/msg/TFMessage",
        }
    }

    /// The definition with all that it stands on, as `ros2msg` wants it.
    pub(super) fn definition(self) -> &'static str {
        match self {
            Self::Scan => include_str!("ros/LaserScan.txt"),
            Self::Odometry => include_str!("ros/Odometry.txt"),
            Self::Velocity => include_str!("ros/Twist.txt"),
            Self::Transforms => include_str!("ros/TFMessage.txt"),
        }
    }
}

/// Messages for topics.
pub(super) type Messages = Vec<(Topic, Vec<u8>)>;

/// Adds up the odometry.
#[derive(Debug)]
pub(super) struct Odom {
    odom_from_robot: Pose2,
}

impl Default for Odom {
    fn default() -> Self {
        Self {
            odom_from_robot: Pose2::identity(),
        }
    }
}

impl Odom {
    pub(super) fn said(&mut self, message: &FromBridge, now: Duration) -> Messages {
        match message {
            FromBridge::Odometry(body) => self.moved(body, now),
            FromBridge::Scan(body) => scan(body, now),
            _ => Vec::new(),
        }
    }

    fn moved(&mut self, body: &OdometryBody, now: Duration) -> Messages {
        let [x, y, heading] = body.motion;
        self.odom_from_robot = self.odom_from_robot * Pose2::new(x, y, heading);
        let seconds = body.to.saturating_sub(body.from) as f64 * 1e-6;
        let per_second = |way: f64| if seconds > 0.0 { way / seconds } else { 0.0 };
        let twist = [per_second(x), per_second(y), per_second(heading)];
        vec![
            (Topic::Odometry, odometry(&self.odom_from_robot, twist, now)),
            (
                Topic::Transforms,
                transform(&self.odom_from_robot, ["odom", "base_link"], now),
            ),
        ]
    }
}

pub(super) fn ordered(message: &ToBridge) -> Messages {
    let ToBridge::Drive(body) = message else {
        return Vec::new();
    };
    let (forward, turn) = match body.motion {
        Motion::Velocity { forward, turn } => (forward, turn),
        Motion::Halt => (0.0, 0.0),
        // A leg or a turn has no speed that the bridge would know.
        _ => return Vec::new(),
    };
    let twist = [forward, 0.0, 0.0, 0.0, 0.0, turn];
    vec![(Topic::Velocity, Cdr::new().all(&twist).finish())]
}

fn odometry(pose: &Pose2, [x, y, turn]: [f64; 3], now: Duration) -> Vec<u8> {
    let mut cdr = Cdr::new();
    cdr.header(now, "odom").text("base_link");
    // The covariance of a pose that only adds up says nothing; 0 stands for unknown.
    cdr.all(&placed(pose)).all(&[0.0; 36]);
    cdr.all(&[x, y, 0.0, 0.0, 0.0, turn]).all(&[0.0; 36]);
    cdr.finish()
}

fn transform(pose: &Pose2, [parent, child]: [&str; 2], now: Duration) -> Vec<u8> {
    let mut cdr = Cdr::new();
    cdr.u32(1).header(now, parent).text(child);
    cdr.all(&placed(pose)).finish()
}

/// Position, and the quaternion of a turn about z.
fn placed(pose: &Pose2) -> [f64; 7] {
    let half = 0.5 * pose.heading();
    [pose.x(), pose.y(), 0.0, 0.0, 0.0, half.sin(), half.cos()]
}

fn scan(body: &ScanBody, now: Duration) -> Messages {
    let [x, y, heading] = body.mount;
    let mount = transform(&Pose2::new(x, y, heading), ["base_link", "laser"], now);
    let even = evenly(&body.bearings, &body.ranges);
    let (first, step, ranges) = (even.first, even.step, &even.ranges);
    let mut cdr = Cdr::new();
    cdr.header(now, "laser");
    cdr.f32(first)
        .f32(first + step * ranges.len().saturating_sub(1) as f32)
        .f32(step);
    let beams = ranges.len().max(2) as f32 - 1.0;
    cdr.f32(body.sweep as f32 / beams).f32(body.sweep as f32);
    cdr.f32(0.0).f32(body.max_range as f32);
    cdr.u32(ranges.len() as u32);
    for &range in ranges {
        cdr.f32(range);
    }
    let intensities = even.intensities(&body.qualities);
    cdr.u32(intensities.len() as u32);
    for intensity in intensities {
        cdr.f32(intensity);
    }
    vec![(Topic::Transforms, mount), (Topic::Scan, cdr.finish())]
}

/// Beams at equal angles.
struct Even {
    /// First bearing, rad.
    first: f32,
    /// From one beam to the next, rad.
    step: f32,
    ranges: Vec<f32>,
    /// Which beam of the scan each range is of; `None` where there was none so near.
    beams: Vec<Option<usize>>,
}

impl Even {
    /// Quality of each beam, 0 where there is none; empty where the sensor tells none.
    fn intensities(&self, qualities: &[u8]) -> Vec<f32> {
        if qualities.is_empty() {
            return Vec::new();
        }
        let of = |beam: &Option<usize>| beam.and_then(|beam| qualities.get(beam)).copied();
        let tell = |beam| f32::from(of(beam).unwrap_or_default());
        self.beams.iter().map(tell).collect()
    }
}

fn evenly(bearings: &[f64], ranges: &[f32]) -> Even {
    let least = bearings.iter().copied().fold(f64::INFINITY, f64::min);
    let most = bearings.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let gaps = bearings.len().saturating_sub(1);
    let step = (most - least) / gaps.max(1) as f64;
    let mut even = Even {
        first: least as f32,
        step: step as f32,
        ranges: vec![f32::NAN; bearings.len()],
        beams: vec![None; bearings.len()],
    };
    for (beam, (bearing, &range)) in bearings.iter().zip(ranges).enumerate() {
        // Equal bearings have no step; all fall on the first beam.
        let at = if step > 0.0 {
            ((bearing - least) / step).round() as usize
        } else {
            0
        };
        let (Some(nearest), Some(from)) = (even.ranges.get_mut(at), even.beams.get_mut(at)) else {
            continue;
        };
        // Of two in one place the nearer one counts, and a number before NaN.
        if from.is_none() || nearest.is_nan() || range < *nearest {
            (*nearest, *from) = (range, Some(beam));
        }
    }
    even
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bearings_come_into_counter_clockwise_order_at_equal_steps() {
        let even = evenly(&[0.2, 0.1, 0.0], &[3.0, 2.0, 1.0]);
        assert_eq!((even.first, &even.ranges), (0.0, &vec![1.0, 2.0, 3.0]));
        assert!((even.step - 0.1).abs() < 1e-6);
        assert_eq!(even.intensities(&[7, 8, 9]), [9.0, 8.0, 7.0]);
        assert!(even.intensities(&[]).is_empty());
        let uneven = evenly(&[0.0, 0.01, 0.3], &[1.0, 0.5, 2.0]);
        assert_eq!(uneven.intensities(&[7, 8, 9]), [8.0, 0.0, 9.0]);
        let uneven = uneven.ranges;
        assert_eq!((uneven[0], uneven[2]), (0.5, 2.0));
        assert!(uneven[1].is_nan());
        let same = evenly(&[1.0, 1.0], &[f32::INFINITY, f32::NAN]).ranges;
        assert!(same[0].is_infinite() && same[1].is_nan());
    }

    #[test]
    fn a_quarter_turn_is_the_quaternion_of_a_quarter_turn() {
        let placed = placed(&Pose2::new(1.0, 2.0, std::f64::consts::FRAC_PI_2));
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let expect = [1.0, 2.0, 0.0, 0.0, 0.0, half, half];
        let off = placed.iter().zip(expect).map(|(a, b)| (a - b).abs());
        assert!(off.fold(0.0, f64::max) < 1e-12, "{placed:?}");
    }
}

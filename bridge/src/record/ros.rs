//! What is recorded, once more as ROS 2 messages, so that other tools can open a recording.
//!
//! Frames by REP-105: `odom`, in which the odometry is added up since the recording began,
//! `base_link`, and `laser`. Stamps are the time of day at which a message passed the bridge; the
//! robot's own clock stands in channel `slamlab`.
//!
//! A `LaserScan` has equal angles between its beams and knows no others. Bearings are put in order,
//! counter-clockwise; each beam gets the nearest range within half a step of it, or NaN. The
//! `PointCloud2` beside it has every hit where it was.
//!
//! Covariances are those of the robot's own model, added up; where it has none they are 0, which
//! stands for unknown.
//!
//! Source: ROS 2 common_interfaces (sensor_msgs, nav_msgs, geometry_msgs) and geometry2 (tf2_msgs),
//! as of ROS 2 Humble.

mod messages;
mod odom;

use std::time::Duration;

use slamlab_core::geom::{Pose2, PoseEstimate};
use slamlab_core::map::Grid;
use slamlab_core::wire::message::{FromBridge, Motion, ToBridge};

use super::cdr::Cdr;
pub(crate) use messages::{in_space, intensities, placed};
pub(crate) use odom::{Moved, Odom};

/// The topics.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Topic {
    Scan,
    Points,
    Odometry,
    Velocity,
    Transforms,
    Pose,
    Map,
}

impl Topic {
    /// What a bridge hears and says.
    pub(crate) const HEARD: [Self; 5] = [
        Self::Scan,
        Self::Points,
        Self::Odometry,
        Self::Velocity,
        Self::Transforms,
    ];
    /// Beside these what is made of it.
    pub(crate) const ALL: [Self; 7] = [
        Self::Scan,
        Self::Points,
        Self::Odometry,
        Self::Velocity,
        Self::Transforms,
        Self::Pose,
        Self::Map,
    ];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Scan => "/scan",
            Self::Points => "/points",
            Self::Odometry => "/odom",
            Self::Velocity => "/cmd_vel",
            Self::Transforms => "/tf",
            Self::Pose => "/pose",
            Self::Map => "/map",
        }
    }

    pub(crate) fn schema(self) -> &'static str {
        match self {
            Self::Scan => "sensor_msgs/msg/LaserScan",
            Self::Points => "sensor_msgs/msg/PointCloud2",
            Self::Odometry => "nav_msgs/msg/Odometry",
            Self::Velocity => "geometry_msgs/msg/Twist",
            Self::Transforms => "tf2_msgs/msg/TFMessage",
            Self::Pose => "geometry_msgs/msg/PoseWithCovarianceStamped",
            Self::Map => "nav_msgs/msg/OccupancyGrid",
        }
    }

    /// The definition with all that it stands on, as `ros2msg` wants it.
    pub(crate) fn definition(self) -> &'static str {
        match self {
            Self::Scan => include_str!("ros/LaserScan.txt"),
            Self::Points => include_str!("ros/PointCloud2.txt"),
            Self::Odometry => include_str!("ros/Odometry.txt"),
            Self::Velocity => include_str!("ros/Twist.txt"),
            Self::Transforms => include_str!("ros/TFMessage.txt"),
            Self::Pose => include_str!("ros/PoseWithCovarianceStamped.txt"),
            Self::Map => include_str!("ros/OccupancyGrid.txt"),
        }
    }
}

/// Messages for topics.
pub(crate) type Messages = Vec<(Topic, Vec<u8>)>;

/// What a message holds for the topics.
pub(crate) fn messages_of(odom: &mut Odom, message: &FromBridge, now: Duration) -> Messages {
    match message {
        FromBridge::Odometry(body) => match body.odometry() {
            Ok(step) => moved(&odom.moved(&step), now),
            // The raw message stands in its own channel.
            Err(_) => vec![],
        },
        FromBridge::Scan(body) => {
            let [x, y, heading] = body.mount;
            let frames = ["base_link", "laser"];
            let mount = messages::transform(&Pose2::new(x, y, heading), frames, now);
            vec![
                (Topic::Transforms, mount),
                (Topic::Scan, messages::scan(body, now)),
                (Topic::Points, messages::points(body, now)),
            ]
        }
        _ => vec![],
    }
}

fn moved(moved: &Moved, now: Duration) -> Messages {
    let frames = ["odom", "base_link"];
    let transform = messages::transform(&moved.summed.motion, frames, now);
    vec![
        (Topic::Odometry, messages::odometry(moved, now)),
        (Topic::Transforms, transform),
    ]
}

/// Pose in the map, and where the map has the frame of the odometry.
pub(crate) fn localised(
    estimate: &PoseEstimate,
    odom_from_robot: &Pose2,
    now: Duration,
) -> Messages {
    let map_from_odom = estimate.pose * odom_from_robot.inverse();
    vec![
        (Topic::Pose, messages::pose(estimate, now)),
        (
            Topic::Transforms,
            messages::transform(&map_from_odom, ["map", "odom"], now),
        ),
    ]
}

/// The map; nothing of one without a known cell.
pub(crate) fn map(grid: &Grid, now: Duration) -> Messages {
    let bytes = messages::map(grid, now);
    bytes.map(|bytes| (Topic::Map, bytes)).into_iter().collect()
}

pub(crate) fn ordered(message: &ToBridge) -> Messages {
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

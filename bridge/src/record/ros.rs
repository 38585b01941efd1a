//! The recorded messages once more as ROS 2 messages, so that other tools can open a recording.
//!
//! Frames follow REP-105: `odom`, in which the odometry is summed up since the recording began,
//! `base_link`, and `laser`. Stamps are the time of day at which a message passed the bridge; the
//! robot's own clock is in channel `slamlab`.
//!
//! A `LaserScan` can only have equal angles between its beams. Bearings are sorted
//! counter-clockwise; each beam gets the nearest range within half a step of it, or NaN. The
//! `PointCloud2` sent with it has every hit at its exact place.
//!
//! Covariances are those of the robot's own model, summed up; without a model they are 0, which
//! stands for unknown.
//!
//! Source: ROS 2 common_interfaces (sensor_msgs, nav_msgs, geometry_msgs) and geometry2 (tf2_msgs),
//! as of ROS 2 Humble.

mod messages;
mod odom;

use std::time::Duration;

use slamlab_core::format::map_server::{MapMode, OccupancyMap};
use slamlab_core::geom::{Pose2, PoseEstimate};
use slamlab_core::map::Grid;
use slamlab_core::robot::Command;
use slamlab_core::wire::message::{FromBridge, MapBody, ToBridge};

use super::cdr::Cdr;
pub(crate) use messages::{in_space, intensities, placed};
pub(crate) use odom::{Moved, Odom};

/// The topics: one row for each, with the package that defines its message and the message's name.
macro_rules! topics {
    ($($Topic:ident, $name:literal, $package:literal, $message:literal;)+) => {
        /// The topics.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
        pub(crate) enum Topic {
            $($Topic,)+
        }

        impl Topic {
            /// First what a bridge receives and sends, then the results of mapping.
            pub(crate) const ALL: &[Self] = &[$(Self::$Topic),+];

            pub(crate) fn name(self) -> &'static str {
                match self {
                    $(Self::$Topic => $name,)+
                }
            }

            pub(crate) fn schema(self) -> &'static str {
                match self {
                    $(Self::$Topic => concat!($package, "/msg/", $message),)+
                }
            }

            /// The definition with all its dependencies, as `ros2msg` requires.
            pub(crate) fn definition(self) -> &'static str {
                match self {
                    $(Self::$Topic => include_str!(concat!("ros/", $message, ".txt")),)+
                }
            }
        }
    };
}

topics! {
    Scan, "/scan", "sensor_msgs", "LaserScan";
    Points, "/points", "sensor_msgs", "PointCloud2";
    Odometry, "/odom", "nav_msgs", "Odometry";
    Velocity, "/cmd_vel", "geometry_msgs", "Twist";
    Transforms, "/tf", "tf2_msgs", "TFMessage";
    Pose, "/pose", "geometry_msgs", "PoseWithCovarianceStamped";
    Map, "/map", "nav_msgs", "OccupancyGrid";
}

impl Topic {
    /// What a bridge receives and sends.
    pub(crate) const HEARD: &[Self] = Self::ALL.split_at(5).0;
}

/// Largest map that is sent to other tools, in cells: 100 m x 100 m in cells of 5 cm. As JSON it
/// has 12 MB.
pub(crate) const MOST_CELLS: usize = 4_000_000;

/// Messages for topics.
pub(crate) type Messages = Vec<(Topic, Vec<u8>)>;

/// The ROS messages that correspond to one of the bridge's messages.
pub(crate) fn messages_of(odom: &mut Odom, message: &FromBridge, now: Duration) -> Messages {
    match message {
        FromBridge::Odometry(body) => {
            // An unusable reading is recorded in channel `slamlab` only.
            let Ok(step) = body.odometry() else {
                return vec![];
            };
            let moved = odom.moved(&step);
            let frames = ["odom", "base_link"];
            let transform = messages::transform(&moved.summed.motion, frames, now);
            let mut all = vec![
                (Topic::Odometry, messages::odometry(&moved, now)),
                (Topic::Transforms, transform),
            ];
            all.extend(told(odom, now));
            all
        }
        FromBridge::Pose(body) => {
            odom.tell(body);
            told(odom, now)
        }
        FromBridge::Map(body) => drawn(body).map_or(vec![], |cells| {
            vec![(Topic::Map, messages::map(&cells, now))]
        }),
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

/// The last pose from the mapper, once the odometry has reached its time.
fn told(odom: &mut Odom, now: Duration) -> Messages {
    let localised = odom.localised();
    localised.map_or(vec![], |(estimate, odom_from_robot)| {
        self::localised(&estimate, &odom_from_robot, now)
    })
}

/// The cells of a map for other tools; none if no cell is known or the map is too large.
pub(crate) fn drawn(body: &MapBody) -> Option<OccupancyMap> {
    let cells = body.map().ok()?;
    (1..=MOST_CELLS)
        .contains(&cells.cells.len())
        .then_some(cells)
}

/// The pose in the map, and the transform `map_from_odom`.
pub(crate) fn localised(
    estimate: &PoseEstimate,
    odom_from_robot: &Pose2,
    now: Duration,
) -> Messages {
    let map_from_odom = estimate.pose * odom_from_robot.inverse();
    let transform = messages::transform(&map_from_odom, ["map", "odom"], now);
    vec![
        (Topic::Pose, messages::pose(estimate, now)),
        (Topic::Transforms, transform),
    ]
}

/// The map; nothing if no cell is known.
pub(crate) fn map(grid: &Grid, now: Duration) -> Messages {
    let cells = OccupancyMap::of_grid(grid, MapMode::Trinary).ok();
    cells.map_or(vec![], |cells| {
        vec![(Topic::Map, messages::map(&cells, now))]
    })
}

pub(crate) fn ordered(message: &ToBridge) -> Messages {
    let ToBridge::Drive(body) = message else {
        return Vec::new();
    };
    let (forward, turn) = match body.motion {
        Command::Velocity { forward, turn } => (forward, turn),
        Command::Stop => (0.0, 0.0),
        // The bridge does not know the speed of a leg or a turn.
        _ => return Vec::new(),
    };
    let twist = [forward, 0.0, 0.0, 0.0, 0.0, turn];
    vec![(Topic::Velocity, Cdr::new().all(&twist).finish())]
}

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

use slamlab_core::format::map_server::{MapMode, OccupancyMap};
use slamlab_core::geom::{Pose2, PoseEstimate};
use slamlab_core::map::Grid;
use slamlab_core::robot::Command;
use slamlab_core::wire::message::{FromBridge, MapBody, ToBridge};

use super::cdr::Cdr;
pub(crate) use messages::{in_space, intensities, placed};
pub(crate) use odom::{Moved, Odom};

/// The topics: a row for each, with the name of its message and of the package that defines it.
macro_rules! topics {
    ($($Topic:ident, $name:literal, $package:literal, $message:literal;)+) => {
        /// The topics.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
        pub(crate) enum Topic {
            $($Topic,)+
        }

        impl Topic {
            /// What a bridge hears and says, and behind it what is made of it.
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

            /// The definition with all that it stands on, as `ros2msg` wants it.
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
    /// What a bridge hears and says.
    pub(crate) const HEARD: &[Self] = Self::ALL.split_at(5).0;
}

/// Cells of a map beyond which other tools are sent none: 100 m x 100 m in cells of 5 cm. As JSON
/// it has 12 MB.
pub(crate) const MOST_CELLS: usize = 4_000_000;

/// Messages for topics.
pub(crate) type Messages = Vec<(Topic, Vec<u8>)>;

/// What a message holds for the topics.
pub(crate) fn messages_of(odom: &mut Odom, message: &FromBridge, now: Duration) -> Messages {
    match message {
        FromBridge::Odometry(body) => {
            // One that cannot be used stands in its own channel only.
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

/// A pose that was told, once the odometry has reached it.
fn told(odom: &mut Odom, now: Duration) -> Messages {
    let localised = odom.localised();
    localised.map_or(vec![], |(estimate, odom_from_robot)| {
        self::localised(&estimate, &odom_from_robot, now)
    })
}

/// The cells of a map that other tools are sent; none of one without a known cell, or too large.
pub(crate) fn drawn(body: &MapBody) -> Option<OccupancyMap> {
    let cells = body.map().ok()?;
    (1..=MOST_CELLS)
        .contains(&cells.cells.len())
        .then_some(cells)
}

/// Pose in the map, and where the map has the frame of the odometry.
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

/// The map; nothing of one without a known cell.
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
        // A leg or a turn has no speed that the bridge would know.
        _ => return Vec::new(),
    };
    let twist = [forward, 0.0, 0.0, 0.0, 0.0, turn];
    vec![(Topic::Velocity, Cdr::new().all(&twist).finish())]
}

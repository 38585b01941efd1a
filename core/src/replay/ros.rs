//! A ROS recording, converted into one of ours, so that a user can map a bag of their own robot.
//!
//! In: a [`RosLog`] and which of its topics to use. Out: a [`Recording`], as a bridge at that robot
//! would have written it, and notes on what had to be decided.
//!
//! 1. If there are several lidars, one is chosen by its topic. Odometry comes from an odometry
//!    topic, or from a moving transform ([`choice`]).
//! 2. All stamps are put on one clock ([`clock`]).
//! 3. The static transforms give the pose of the lidar on the robot, even upside down; each scan is
//!    converted to ours ([`scans`]).
//! 4. Between two poses of the odometry the robot moved along an arc; motions are split where a
//!    scan ends, whatever the rates of the two ([`motion`]).

mod choice;
mod clock;
mod motion;
mod scans;
#[cfg(test)]
mod tests;

use crate::format::ros::{FrameTree, RosError, RosLog};
use crate::robot::RobotModel;
use crate::wire::message::{FromBridge, MessageError, OdometryBody, ScanBody};
use crate::wire::recording::Recording;

pub use choice::{Offered, RosChoice, RosOffer};

use choice::Chosen;
use motion::Motions;

/// Index of the robot, and of its lidar, in the resulting recording.
const ROBOT: u8 = 0;
const LIDAR: u8 = 1;

/// The result of an import.
#[derive(Clone, Debug)]
pub struct Imported {
    /// As a bridge would have recorded it; stamps are those of the file, µs since 1970.
    pub recording: Recording,
    /// What people should know about it, a sentence each.
    pub notes: Vec<String>,
}

/// Why a ROS recording cannot be mapped.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ImportError {
    /// It is not a ROS recording.
    #[error(transparent)]
    File(#[from] RosError),
    /// It contains no scans.
    #[error(
        "the file holds no scan (sensor_msgs/LaserScan or MultiEchoLaserScan){}; points of a 3D lidar become scans by pointcloud_to_laserscan",
        topics(.0)
    )]
    NoScan(Vec<String>),
    /// The same for a damaged file: it may have contained some.
    #[error("{error}; {damage}", error = Self::NoScan(.topics.clone()))]
    NoScanLeft {
        /// The other topics.
        topics: Vec<String>,
        /// The first damage.
        damage: String,
    },
    /// There are several, and none was chosen.
    #[error("{what} stands in several topics: {}; choose one", .names.join(", "))]
    Several {
        /// What there are several of.
        what: &'static str,
        /// The topics, with what they hold.
        names: Vec<String>,
    },
    /// There is none with this name.
    #[error("there is no topic `{name}` with {what}; there are {}", .names.join(", "))]
    NoTopic {
        /// The requested name.
        name: String,
        /// What was requested.
        what: &'static str,
        /// The names that exist.
        names: Vec<String>,
    },
    /// The lidar does not scan in the plane in which the robot drives.
    #[error(
        "the lidar in frame `{frame}` is tilted by {degrees:.0}° against `{base}`: what it sees is no section of the building at one height, and cannot be mapped in two dimensions"
    )]
    Tilted {
        /// Frame of its scans.
        frame: String,
        /// Frame of the robot.
        base: String,
        /// Angle between the axes that should both be vertical, degrees.
        degrees: f64,
    },
    /// None of the scans can be used.
    #[error("none of the {0} scans can be used: {1}")]
    NothingLeft(usize, String),
    /// A scan has more beams than fit in a message.
    #[error(transparent)]
    Message(#[from] MessageError),
}

fn topics(names: &[String]) -> String {
    match names {
        [] => ", and no topic at all".to_owned(),
        names => format!("; its topics are {}", names.join(", ")),
    }
}

/// Makes a recording from the chosen topics, or from those that are the only possible choice.
///
/// # Errors    [`ImportError`]: what is missing, or what has to be chosen.
pub fn import_ros(log: &RosLog, choice: &RosChoice) -> Result<Imported, ImportError> {
    let tree = FrameTree::of(log);
    let chosen = Chosen::of(log, &tree, choice)?;
    let mut notes = log.damage();
    let times = clock::times(log, &chosen, &mut notes);
    let base = chosen.base(log, &tree, &mut notes);
    let scans = scans::scans(log, &tree, &times.scans, base, &mut notes)?;
    let motions = Motions::of(&times.poses);
    notes.insert(0, chosen.words(log, scans.len()));
    let robot = RobotModel::pioneer();
    let mut messages = vec![];
    let (mut untold, all) = (0, scans.len());
    match motions {
        None => {
            for scan in scans {
                let stamp = scan.stamp.0;
                messages.push((stamp, FromBridge::Scan(ScanBody::new(LIDAR, &scan))));
            }
        }
        Some(mut motions) => {
            for scan in scans {
                let stamp = scan.stamp;
                if !motions.tells(stamp) {
                    untold += 1;
                    continue;
                }
                for odometry in motions.up_to(stamp, &robot) {
                    let body = OdometryBody::new(ROBOT, &odometry);
                    messages.push((odometry.to.0, FromBridge::Odometry(body)));
                }
                messages.push((stamp.0, FromBridge::Scan(ScanBody::new(LIDAR, &scan))));
            }
            notes.extend(motions.jumps());
        }
    }
    if untold == all {
        let why = "the odometry covers other times than the scans";
        return Err(ImportError::NothingLeft(all, why.to_owned()));
    }
    if untold > 0 {
        notes.push(format!(
            "{untold} of {all} scans lie before or behind the odometry, or where it jumps, and were left out"
        ));
    }
    Ok(Imported {
        recording: Recording::of_messages(messages)?,
        notes,
    })
}

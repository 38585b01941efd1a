//! The robot as a node of ROS 2, without ROS: in the format of `rmw_zenoh`, over the bridge's
//! session at its router.
//!
//! | what | type | |
//! |---|---|---|
//! | `/scan`, `/points`, `/odom`, `/tf` | the same as in recordings ([`crate::record::ros`]) | each reading, the newest first |
//! | `/tf_static` | `tf2_msgs/TFMessage` | the mount of the lidar; kept for later readers |
//! | `/map`, `/pose` | `nav_msgs/OccupancyGrid`, `geometry_msgs/PoseWithCovarianceStamped` | if the bridge maps; the map is kept for later readers |
//! | `/cmd_vel` | `geometry_msgs/Twist` or `TwistStamped` | drives by the right named in the settings, after `/slamlab/arm` |
//! | `/slamlab/arm`, `/slamlab/release`, `/slamlab/reset_emergency_stop` | `std_srvs/srv/Trigger` | by that right; arming also takes the lease, which ends 2 s after the last velocity |
//! | `/slamlab/stop`, `/slamlab/emergency_stop` | the same | for everyone, if anyone may watch |
//!
//! 1. Tools find it by liveliness tokens (`names`), and messages carry number, time and origin
//!    (`attachment`).
//! 2. ROS signs nothing: anyone whom the router lets in drives by that right. So there is no such
//!    right by default, and it can be taken away like any other.
//! 3. A velocity carries its time by the sender's clock. Its age is how much longer it took than
//!    the fastest one from that sender (`twist`), and an old one is refused like any driving
//!    message.
//! 4. `odom` begins where the robot was when it connected to the router.

mod attachment;
mod driver;
mod names;
mod node;
mod twist;

use std::sync::Arc;

use ::zenoh::Session;

use super::RosConfig;
use crate::shared::Shared;
pub(super) use driver::Driver;
use names::Names;
pub(super) use node::Node;

/// Starts a node, and the driver that serves its requests.
pub(super) async fn start(
    session: &Session,
    config: &RosConfig,
    robot: &str,
    shared: &Arc<Shared>,
) -> ::zenoh::Result<(Node, Driver)> {
    let mut names = Names::new(config, session.zid().to_string(), robot);
    let node = Node::start(session, &mut names, shared.clock, shared.mapping.is_some())?;
    let driver = Driver::start(session, &mut names, config.right.clone(), shared).await?;
    Ok((node, driver))
}

//! The robot as a node of ROS 2, without ROS: in the format of `rmw_zenoh`, over the session that
//! the bridge has at its router.
//!
//! | what | type | |
//! |---|---|---|
//! | `/scan`, `/points`, `/odom`, `/tf` | as recordings have them ([`crate::record::ros`]) | each reading, the newest first |
//! | `/tf_static` | `tf2_msgs/TFMessage` | where the lidar sits; kept for who comes later |
//! | `/map`, `/pose` | `nav_msgs/OccupancyGrid`, `geometry_msgs/PoseWithCovarianceStamped` | of a bridge that maps; the map is kept |
//! | `/cmd_vel` | `geometry_msgs/Twist` or `TwistStamped` | drives by the right that the settings name, after `/slamlab/arm` |
//! | `/slamlab/arm`, `/slamlab/release`, `/slamlab/reset_emergency_stop` | `std_srvs/srv/Trigger` | by that right; arming takes the lease, too, and that ends 2 s after the last velocity |
//! | `/slamlab/stop`, `/slamlab/emergency_stop` | the same | for everyone, where anyone may watch |
//!
//! 1. Tools see it by liveliness tokens (`names`), and their messages carry number, time and origin
//!    (`attachment`).
//! 2. ROS signs nothing: whoever the router lets in drives by that right. So there is none unless
//!    it was given, and it can be taken away like any other.
//! 3. A velocity says when it was sent by its sender's clock; how much later it came than others is
//!    its age (`twist`), and an old one is refused like any driving message.
//! 4. `odom` begins where the robot was when it came to the router.

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

/// A node, and what drives by it.
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

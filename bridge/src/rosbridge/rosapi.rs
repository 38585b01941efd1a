//! `/rosapi`: what there is, for clients that ask before they subscribe.
//!
//! Source: rosapi of rosbridge_suite, service definitions in `rosapi_msgs/srv`; names of types as
//! ROS 2 has them.

use std::time::Duration;

use serde_json::{Value, json};
use slamlab_core::device::hub;
use slamlab_core::wire::message::CHALLENGE_BYTES;

use super::request::argument;
use crate::shared::Shared;

const NODE: &str = "/slamlab_bridge";

/// Topics with their types: what is taken, what is published, and what only a bridge that maps
/// publishes.
const TOPICS: [(&str, &str); 6] = [
    (super::VELOCITY, "geometry_msgs/msg/Twist"),
    ("/scan", "sensor_msgs/msg/LaserScan"),
    ("/odom", "nav_msgs/msg/Odometry"),
    ("/tf", "tf2_msgs/msg/TFMessage"),
    ("/map", "nav_msgs/msg/OccupancyGrid"),
    ("/pose", "geometry_msgs/msg/PoseWithCovarianceStamped"),
];
const WITHOUT_MAP: usize = 4;

/// The answer of the service of this name behind `/rosapi/`; an error in words where it has none.
pub(super) fn answer(
    service: &str,
    args: &Value,
    shared: &Shared,
    now: Duration,
) -> Result<Value, String> {
    let text = |name: &str| {
        let value = argument(args, name).and_then(Value::as_str);
        value.ok_or_else(|| format!("{name} is missing, or no text"))
    };
    let topics = match shared.mapping {
        Some(_) => &TOPICS[..],
        None => TOPICS.split_at(WITHOUT_MAP).0,
    };
    let published = topics.get(1..).unwrap_or_default();
    Ok(match service {
        "topics" => {
            let (topics, types): (Vec<_>, Vec<_>) = topics.iter().copied().unzip();
            json!({ "topics": topics, "types": types, "typedefs_full_text": [] })
        }
        "topics_for_type" => {
            let of = text("type")?;
            let is_of = |(_, kind): &&(&str, &str)| same_type(kind, of);
            json!({ "topics": names(topics.iter().filter(is_of)) })
        }
        "topic_type" => {
            let topic = text("topic")?;
            let mut found = topics.iter().filter(|(name, _)| *name == topic);
            json!({ "type": found.next().map_or("", |(_, kind)| kind) })
        }
        "publishers" => {
            let topic = text("topic")?;
            let is_there = names(published).contains(&topic);
            json!({ "publishers": if is_there { vec![NODE] } else { vec![] } })
        }
        "subscribers" => {
            let takes = text("topic")? == super::VELOCITY;
            json!({ "subscribers": if takes { vec![NODE] } else { vec![] } })
        }
        "services" => json!({ "services": services() }),
        "service_type" => {
            let known = services().contains(&text("service")?.to_owned());
            json!({ "type": if known { "std_srvs/srv/Trigger" } else { "" } })
        }
        "service_node" => {
            let known = services().contains(&text("service")?.to_owned());
            json!({ "node": if known { NODE } else { "" } })
        }
        "nodes" => json!({ "nodes": [NODE] }),
        "node_details" => {
            let _ = text("node")?;
            json!({
                "subscribing": [super::VELOCITY],
                "publishing": names(published),
                "services": services(),
            })
        }
        "get_param_names" => {
            let names: Vec<_> = params(shared).into_iter().map(|(name, _)| name).collect();
            json!({ "names": names })
        }
        "has_param" => json!({ "exists": param(text("name")?, shared).is_some() }),
        "get_param" => {
            let name = text("name")?;
            let value = param(name, shared).ok_or_else(|| format!("there is no {name}"))?;
            // As JSON in a text, as rosapi has it.
            json!({ "value": value.to_string() })
        }
        "get_time" => {
            let (seconds, nanos) = (now.as_secs(), now.subsec_nanos());
            // By the names of ROS 1 and of ROS 2.
            json!({ "time": { "secs": seconds, "nsecs": nanos, "sec": seconds, "nanosec": nanos } })
        }
        "get_ros_version" => json!({ "version": 2, "distro": "" }),
        _ => return Err(format!("there are {}", services().join(", "))),
    })
}

const SERVICES: [&str; 15] = [
    "topics",
    "topics_for_type",
    "topic_type",
    "publishers",
    "subscribers",
    "services",
    "service_type",
    "service_node",
    "nodes",
    "node_details",
    "get_param_names",
    "has_param",
    "get_param",
    "get_time",
    "get_ros_version",
];

/// All services of this bridge.
pub(super) fn services() -> Vec<String> {
    let of_api = SERVICES.into_iter().map(|name| format!("/rosapi/{name}"));
    let own = super::services::NAMES.into_iter();
    own.map(|name| format!("/slamlab/{name}"))
        .chain(of_api)
        .collect()
}

/// What is fixed for as long as the bridge runs.
fn params(shared: &Shared) -> Vec<(&'static str, Value)> {
    let hello = hub::hello(
        [0; CHALLENGE_BYTES],
        shared.about.watching,
        shared.robot.clone(),
    );
    let robot = shared.robot.as_ref();
    let limits = robot.map(|robot| robot.limits);
    let mut all = vec![
        ("/slamlab/version", json!(hello.version)),
        ("/slamlab/watchdog_ms", json!(hello.watchdog_millis)),
        ("/slamlab/lease_ms", json!(hello.lease_millis)),
    ];
    all.extend(robot.map(|robot| ("/slamlab/robot", json!(robot.preset))));
    if let Some([speed, turn_rate, ..]) = limits {
        all.push(("/slamlab/max_speed", json!(speed)));
        all.push(("/slamlab/max_turn_rate", json!(turn_rate)));
    }
    all
}

fn param(name: &str, shared: &Shared) -> Option<Value> {
    let all = params(shared).into_iter();
    // rclpy writes `/node:name`.
    all.filter(|(known, _)| *known == name.replace(':', "/"))
        .map(|(_, value)| value)
        .next()
}

fn names<'a>(
    topics: impl IntoIterator<Item = &'a (&'static str, &'static str)>,
) -> Vec<&'static str> {
    topics.into_iter().map(|(name, _)| *name).collect()
}

/// `sensor_msgs/LaserScan` is `sensor_msgs/msg/LaserScan`.
fn same_type(kind: &str, other: &str) -> bool {
    kind.replace("/msg/", "/") == other.replace("/msg/", "/")
}

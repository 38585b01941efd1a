//! `/rosapi`: lists topics, services and parameters, for clients that ask before they subscribe.
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

/// Topics with their types: first what is accepted, then what is published, then what only a
/// mapping bridge publishes.
const TOPICS: [(&str, &str); 6] = [
    (super::VELOCITY, "geometry_msgs/msg/Twist"),
    ("/scan", "sensor_msgs/msg/LaserScan"),
    ("/odom", "nav_msgs/msg/Odometry"),
    ("/tf", "tf2_msgs/msg/TFMessage"),
    ("/map", "nav_msgs/msg/OccupancyGrid"),
    ("/pose", "geometry_msgs/msg/PoseWithCovarianceStamped"),
];
const WITHOUT_MAP: usize = 4;

/// The answer of the service with this name after `/rosapi/`, or a sentence why there is none.
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
        "services" => json!({ "services": names_of_services() }),
        "service_type" => {
            json!({ "type": type_of_service(text("service")?).unwrap_or_default() })
        }
        "service_node" => {
            let known = type_of_service(text("service")?).is_some();
            json!({ "node": if known { NODE } else { "" } })
        }
        "nodes" => json!({ "nodes": [NODE] }),
        "node_details" => {
            let _ = text("node")?;
            json!({
                "subscribing": [super::VELOCITY],
                "publishing": names(published),
                "services": names_of_services(),
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
            // As JSON in a string, as in rosapi.
            json!({ "value": value.to_string() })
        }
        "get_time" => {
            let (seconds, nanos) = (now.as_secs(), now.subsec_nanos());
            // With the field names of both ROS 1 and ROS 2.
            json!({ "time": { "secs": seconds, "nsecs": nanos, "sec": seconds, "nanosec": nanos } })
        }
        "get_ros_version" => json!({ "version": 2, "distro": "" }),
        _ => return Err(format!("there are {}", names_of_services().join(", "))),
    })
}

/// The services under `/rosapi/`, with their types.
const SERVICES: [(&str, &str); 15] = [
    ("topics", "rosapi_msgs/srv/Topics"),
    ("topics_for_type", "rosapi_msgs/srv/TopicsForType"),
    ("topic_type", "rosapi_msgs/srv/TopicType"),
    ("publishers", "rosapi_msgs/srv/Publishers"),
    ("subscribers", "rosapi_msgs/srv/Subscribers"),
    ("services", "rosapi_msgs/srv/Services"),
    ("service_type", "rosapi_msgs/srv/ServiceType"),
    ("service_node", "rosapi_msgs/srv/ServiceNode"),
    ("nodes", "rosapi_msgs/srv/Nodes"),
    ("node_details", "rosapi_msgs/srv/NodeDetails"),
    ("get_param_names", "rosapi_msgs/srv/GetParamNames"),
    ("has_param", "rosapi_msgs/srv/HasParam"),
    ("get_param", "rosapi_msgs/srv/GetParam"),
    ("get_time", "rosapi_msgs/srv/GetTime"),
    ("get_ros_version", "rosapi_msgs/srv/GetROSVersion"),
];

/// All services of this bridge, with their types.
fn services() -> impl Iterator<Item = (String, &'static str)> {
    let of_api = SERVICES.map(|(name, kind)| (format!("/rosapi/{name}"), kind));
    let own = super::services::SERVICES.map(|(name, kind)| (format!("/slamlab/{name}"), kind));
    own.into_iter().chain(of_api)
}

/// The names of all services.
pub(super) fn names_of_services() -> Vec<String> {
    services().map(|(name, _)| name).collect()
}

/// The type of a service; empty if ROS has no type for it. None if there is no such service.
fn type_of_service(service: &str) -> Option<&'static str> {
    let mut all = services();
    all.find(|(name, _)| name == service).map(|(_, kind)| kind)
}

/// The parameters, which do not change while the bridge runs.
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Regression: all were listed as a Trigger, whose answer none of them gives.
    #[test]
    fn a_service_is_of_its_own_type_or_of_none_that_ros_knows() {
        let types = [
            ("/slamlab/stop", Some("std_srvs/srv/Empty")),
            ("/slamlab/enter", Some("")),
            ("/rosapi/topics", Some("rosapi_msgs/srv/Topics")),
            (
                "/rosapi/get_ros_version",
                Some("rosapi_msgs/srv/GetROSVersion"),
            ),
            ("/slamlab", None),
            ("stop", None),
        ];
        for (service, kind) in types {
            assert_eq!(type_of_service(service), kind, "{service}");
        }
        assert_eq!(names_of_services().len(), 25);
    }
}

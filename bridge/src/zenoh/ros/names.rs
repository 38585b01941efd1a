//! The names by which `rmw_zenoh` finds a node and its endpoints.
//!
//! | what | key |
//! |---|---|
//! | a topic or service | `DOMAIN/NAME/TYPE/HASH` |
//! | liveliness token of the node | `@ros2_lv/DOMAIN/SESSION/0/0/NN/%/NAMESPACE/NODE` |
//! | of a publisher (`MP`), subscription (`MS`), service (`SS`) | `@ros2_lv/DOMAIN/SESSION/0/ID/KIND/%/NAMESPACE/NODE/NAME/TYPE/HASH/QOS` |
//!
//! In tokens `/` is written as `%`. A type is `std_msgs::msg::dds_::String_`, its hash that of
//! REP-2016.
//!
//! # Source    github.com/ros2/rmw_zenoh, docs/design.md and liveliness_utils.cpp (Jazzy to
//! Rolling); ROS REP-2016 for the hashes. The crate `hiroz-protocol` 0.2 writes the same names, but
//! only compiles with all of Zenoh's transports.

use twox_hash::XxHash3_128;

use crate::record::ros::Topic;
use crate::zenoh::RosConfig;

/// Length of an endpoint's unique id.
pub(super) const GID_BYTES: usize = 16;
/// The unique id of an endpoint, in the graph and in its messages.
pub(super) type Gid = [u8; GID_BYTES];

/// A type of ROS, and its hash.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Type {
    pub(super) name: &'static str,
    hash: &'static str,
}

/// `std_srvs/srv/Trigger`.
pub(super) const TRIGGER: Type = Type {
    name: "std_srvs/srv/Trigger",
    hash: "eeff2cd6fa5ad9d27cdf4dec64818317839b62f212a91e6b5304b634b2062c5f",
};
/// `geometry_msgs/msg/Twist`.
pub(super) const TWIST: Type = Type {
    name: "geometry_msgs/msg/Twist",
    hash: "9c45bf16fe0983d80e3cfe750d6835843d265a9a6c46bd2e609fcddde6fb8d2a",
};
/// `geometry_msgs/msg/TwistStamped`.
pub(super) const TWIST_STAMPED: Type = Type {
    name: "geometry_msgs/msg/TwistStamped",
    hash: "5f0fcd4f81d5d06ad9b4c4c63e3ea51b82d6ae4d0558f1d475229b1121db6f64",
};

/// The type of a published topic.
pub(super) fn type_of(topic: Topic) -> Type {
    let hash = match topic {
        Topic::Scan => "64c191398013af96509d518dac71d5164f9382553fce5c1f8cca5be7924bd828",
        Topic::Points => "9198cabf7da3796ae6fe19c4cb3bdd3525492988c70522628af5daa124bae2b5",
        Topic::Odometry => "3cc97dc7fb7502f8714462c526d369e35b603cfc34d946e3f2eda2766dfec6e0",
        Topic::Velocity => TWIST.hash,
        Topic::Transforms => "e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087",
        Topic::Pose => "26432f9803e43727d3c8f668d1fdb3c630f548af631e2f4e31382371bfea3b6e",
        Topic::Map => "8d348150c12913a31ee0ec170fbf25089e4745d17035792a1ba94d6f0bc0cfc7",
    };
    let name = topic.schema();
    Type { name, hash }
}

impl Type {
    /// The type as written in keys.
    fn in_key(self) -> String {
        let (before, last) = self.name.rsplit_once('/').unwrap_or(("", self.name));
        let before = before.replace('/', "::");
        format!("{before}::dds_::{last}_/RIHS01_{}", self.hash)
    }
}

/// What an endpoint is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Publisher,
    Subscription,
    Service,
}

/// The quality of service of an endpoint: always reliable, because a reader that needs less accepts
/// that too.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Qos {
    pub(super) depth: u32,
    /// Transient local: a later reader gets the last message.
    pub(super) is_kept: bool,
}

impl Qos {
    /// Reliability, durability, history, deadline, lifespan, liveliness; empty is the default,
    /// which is reliable, volatile, the last 42.
    fn in_token(self) -> String {
        let durability = if self.is_kept { "1" } else { "" };
        format!(":{durability}:,{}:,:,:,,", self.depth)
    }
}

/// One node.
#[derive(Clone, Debug)]
pub(super) struct Names {
    domain: u8,
    session: String,
    /// Begins with `/`, does not end in `/`; empty for none.
    namespace: String,
    node: String,
    endpoints: u32,
}

/// An endpoint: its key, its liveliness token, its unique id.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Endpoint {
    pub(super) key: String,
    pub(super) token: String,
    pub(super) gid: Gid,
}

impl Names {
    /// The names of this robot's node. Characters that ROS does not allow become `_`.
    pub(super) fn new(config: &RosConfig, session: String, robot: &str) -> Self {
        let fit = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
        let robot: String = robot.chars().map(fit).collect();
        let namespace = config.namespace.as_deref();
        Self {
            domain: config.domain,
            session,
            namespace: namespace.map_or(String::new(), |name| format!("/{name}")),
            node: format!("slamlab_{robot}"),
            endpoints: 0,
        }
    }

    /// The node's own token.
    pub(super) fn token(&self) -> String {
        format!("{}/0/0/NN/{}", self.session_token(), self.node_token())
    }

    /// One more endpoint; `name` begins with `/`.
    pub(super) fn endpoint(&mut self, kind: Kind, name: &str, of: Type, qos: Qos) -> Endpoint {
        self.endpoints += 1;
        let name = format!("{}{name}", self.namespace);
        let kind = match kind {
            Kind::Publisher => "MP",
            Kind::Subscription => "MS",
            Kind::Service => "SS",
        };
        let token = format!(
            "{}/0/{}/{kind}/{}/{}/{}/{}",
            self.session_token(),
            self.endpoints,
            self.node_token(),
            mangled(&name),
            of.in_key(),
            qos.in_token()
        );
        let gid = XxHash3_128::oneshot(token.as_bytes()).to_le_bytes();
        let key = format!("{}{name}/{}", self.domain, of.in_key());
        Endpoint { key, token, gid }
    }

    fn session_token(&self) -> String {
        format!("@ros2_lv/{}/{}", self.domain, self.session)
    }

    fn node_token(&self) -> String {
        let namespace = match self.namespace.as_str() {
            "" => "/",
            name => name,
        };
        format!("%/{}/{}", mangled(namespace), self.node)
    }
}

fn mangled(name: &str) -> String {
    name.replace('/', "%")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(namespace: Option<&str>) -> Names {
        let config = RosConfig {
            domain: 2,
            namespace: namespace.map(str::to_owned),
            right: None,
        };
        Names::new(&config, "aac3178e146ba6f1fc6e6a4085e77f21".into(), "rp6.1")
    }

    /// The example of rmw_zenoh's design document, with our node and type.
    #[test]
    fn names_are_those_of_the_design_document() {
        let mut names = names(None);
        let (depth, is_kept) = (7, false);
        let qos = Qos { depth, is_kept };
        let found = names.endpoint(Kind::Publisher, "/scan", type_of(Topic::Scan), qos);
        let of = "sensor_msgs::msg::dds_::LaserScan_/RIHS01_64c191398013af96509d518dac71d5164f9382553fce5c1f8cca5be7924bd828";
        assert_eq!(found.key, format!("2/scan/{of}"));
        let node = "@ros2_lv/2/aac3178e146ba6f1fc6e6a4085e77f21/0";
        assert_eq!(
            found.token,
            format!("{node}/1/MP/%/%/slamlab_rp6_1/%scan/{of}/::,7:,:,:,,")
        );
        assert_eq!(names.token(), format!("{node}/0/NN/%/%/slamlab_rp6_1"));
    }

    #[test]
    fn a_namespace_stands_before_every_name() {
        let mut names = names(Some("floor/rp6"));
        let qos = Qos {
            depth: 1,
            is_kept: true,
        };
        let found = names.endpoint(Kind::Service, "/slamlab/arm", TRIGGER, qos);
        assert!(
            found
                .key
                .starts_with("2/floor/rp6/slamlab/arm/std_srvs::srv::dds_::Trigger_/")
        );
        assert!(
            found
                .token
                .contains("/SS/%/%floor%rp6/slamlab_rp6_1/%floor%rp6%slamlab%arm/")
        );
        assert!(found.token.ends_with("/:1:,1:,:,:,,"));
    }
}

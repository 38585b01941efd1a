//! Messages of Foxglove's protocol: JSON both ways, and binary data to the client.

use std::time::Duration;

use serde::{Deserialize, Serialize};

use crate::record::ros::Topic;

/// Kind byte of a message of a channel.
const MESSAGE_DATA: u8 = 1;

/// What a client sends.
#[derive(Debug, PartialEq, Deserialize)]
#[serde(tag = "op", rename_all = "camelCase")]
pub(super) enum Request {
    Subscribe {
        subscriptions: Vec<Subscription>,
    },
    #[serde(rename_all = "camelCase")]
    Unsubscribe {
        subscription_ids: Vec<u32>,
    },
    /// Any operation that is not for watching.
    #[serde(other)]
    Other,
}

/// The client's number for one of our channels.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Subscription {
    pub(super) id: u32,
    pub(super) channel_id: u32,
}

/// What is sent to a client.
#[derive(Debug, Serialize)]
#[serde(tag = "op", rename_all = "camelCase")]
pub(super) enum Reply<'a> {
    ServerInfo {
        name: &'static str,
        /// Empty: clients cannot publish, call or set anything here.
        capabilities: [&'static str; 0],
    },
    Advertise {
        channels: Vec<Channel>,
    },
    Status {
        /// 0 info, 1 warning, 2 error.
        level: u8,
        message: &'a str,
    },
}

#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Channel {
    id: u32,
    topic: &'static str,
    encoding: &'static str,
    schema_name: &'static str,
    schema_encoding: &'static str,
    schema: &'static str,
}

impl Reply<'_> {
    pub(super) fn server_info() -> Self {
        Self::ServerInfo {
            name: concat!("slamlab ", env!("CARGO_PKG_VERSION")),
            capabilities: [],
        }
    }

    /// A channel's number is its index in `topics`.
    pub(super) fn advertise(topics: &[Topic]) -> Self {
        let channel = |(id, topic): (usize, &Topic)| Channel {
            id: id as u32,
            topic: topic.name(),
            encoding: "cdr",
            schema_name: topic.schema(),
            schema_encoding: "ros2msg",
            schema: topic.definition(),
        };
        Self::Advertise {
            channels: topics.iter().enumerate().map(channel).collect(),
        }
    }
}

impl<'a> Reply<'a> {
    pub(super) fn error(message: &'a str) -> Self {
        Self::Status { level: 2, message }
    }
}

/// `01 | subscription u32 | ns since 1970 u64 | payload`, little-endian.
pub(super) fn data(subscription: u32, time: Duration, payload: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(13 + payload.len());
    bytes.push(MESSAGE_DATA);
    bytes.extend(subscription.to_le_bytes());
    bytes.extend((time.as_nanos() as u64).to_le_bytes());
    bytes.extend(payload);
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_are_those_of_the_specification() {
        let bytes = data(0x0102, Duration::from_nanos(0x0A0B), b"xy");
        let expect = b"\x01\x02\x01\0\0\x0B\x0A\0\0\0\0\0\0xy";
        assert_eq!(bytes, expect);
    }

    #[test]
    fn what_a_client_says_is_read_as_the_specification_writes_it() {
        let read = |text| serde_json::from_str::<Request>(text).unwrap();
        let subscribe = r#"{"op":"subscribe","subscriptions":[{"id":0,"channelId":3}]}"#;
        let subscriptions = vec![Subscription {
            id: 0,
            channel_id: 3,
        }];
        assert_eq!(read(subscribe), Request::Subscribe { subscriptions });
        let subscription_ids = vec![1, 2];
        let unsubscribe = r#"{"op":"unsubscribe","subscriptionIds":[1,2]}"#;
        assert_eq!(read(unsubscribe), Request::Unsubscribe { subscription_ids });
        let others = r#"{"op":"setParameters","parameters":[]}"#;
        assert_eq!(read(others), Request::Other);
    }

    #[test]
    fn an_advertisement_is_written_as_the_specification_reads_it() {
        let said = serde_json::to_value(Reply::advertise(&[Topic::Scan])).unwrap();
        assert_eq!(said["op"], "advertise");
        let channel = &said["channels"][0];
        assert_eq!(channel["schemaName"], "sensor_msgs/msg/LaserScan");
        assert_eq!(
            (&channel["id"], &channel["encoding"]),
            (&0.into(), &"cdr".into())
        );
        assert_eq!(channel["schemaEncoding"], "ros2msg");
    }
}

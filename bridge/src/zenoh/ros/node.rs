//! The publishers of a node of ROS 2.

use std::collections::BTreeMap;

use ::zenoh::bytes::Encoding;
use ::zenoh::liveliness::LivelinessToken;
use ::zenoh::qos::{CongestionControl, Priority};
use ::zenoh::{Session, Wait};
use slamlab_core::wire::message::FromBridge;
use zenoh_ext::{AdvancedPublisher, AdvancedPublisherBuilderExt, CacheConfig};

use super::attachment::Attachment;
use super::names::{Gid, Kind, Names, Qos, type_of};
use crate::clock::Clock;
use crate::record::ros::{self, Odom, Topic};
use crate::zenoh::lane::say_failed;

/// The sensor's mount does not change with each scan, so it is kept for later readers.
const STATIC: &str = "/tf_static";
/// How many transforms a reader may lag behind, as in `tf2`.
const TRANSFORMS: u32 = 100;

/// A node's publishers, which end with it.
pub(in crate::zenoh) struct Node {
    publishers: BTreeMap<&'static str, Publisher>,
    clock: Clock,
    odom: Odom,
    /// The last published mount of the sensor.
    mount: Option<[f64; 3]>,
    _tokens: Vec<LivelinessToken>,
}

struct Publisher {
    inner: AdvancedPublisher<'static>,
    gid: Gid,
    sequence: i64,
}

impl Node {
    pub(super) fn start(
        session: &Session,
        names: &mut Names,
        clock: Clock,
        maps: bool,
    ) -> ::zenoh::Result<Self> {
        let mut tokens = vec![session.liveliness().declare_token(names.token()).wait()?];
        let mut publishers = BTreeMap::new();
        let topics = Topic::ALL.iter().filter(|topic| match topic {
            // The node subscribes to this topic.
            Topic::Velocity => false,
            Topic::Pose | Topic::Map => maps,
            _ => true,
        });
        let named = topics.map(|topic| (topic.name(), *topic));
        for (name, topic) in named.chain([(STATIC, Topic::Transforms)]) {
            let is_kept = name == STATIC || topic == Topic::Map;
            let depth = match topic {
                Topic::Transforms if !is_kept => TRANSFORMS,
                _ => 1,
            };
            let qos = Qos { depth, is_kept };
            let endpoint = names.endpoint(Kind::Publisher, name, type_of(topic), qos);
            let publisher = session
                .declare_publisher(endpoint.key)
                .congestion_control(CongestionControl::Block)
                .priority(Priority::Data)
                .encoding(Encoding::APPLICATION_CDR)
                .advanced();
            let inner = match is_kept {
                true => publisher
                    .cache(CacheConfig::default().max_samples(depth as usize))
                    .publisher_detection()
                    .wait()?,
                false => publisher.wait()?,
            };
            let (gid, sequence) = (endpoint.gid, 0);
            publishers.insert(
                name,
                Publisher {
                    inner,
                    gid,
                    sequence,
                },
            );
            tokens.push(session.liveliness().declare_token(endpoint.token).wait()?);
        }
        Ok(Self {
            publishers,
            clock,
            odom: Odom::default(),
            mount: None,
            _tokens: tokens,
        })
    }

    /// Publishes what a message holds for ROS tools.
    pub(in crate::zenoh) fn publish(&mut self, message: &FromBridge) {
        let now = self.clock.time_of_day(self.clock.now());
        let mount = match message {
            FromBridge::Scan(body) => Some(body.mount),
            _ => None,
        };
        for (topic, payload) in ros::messages_of(&mut self.odom, message, now) {
            let name = match (topic, mount) {
                // The transform of a scan is its sensor's mount.
                (Topic::Transforms, Some(_)) if self.mount == mount => continue,
                (Topic::Transforms, Some(_)) => {
                    self.mount = mount;
                    STATIC
                }
                _ => topic.name(),
            };
            if let Some(publisher) = self.publishers.get_mut(name) {
                publisher.sequence += 1;
                let attachment = Attachment::new(publisher.sequence, now, publisher.gid);
                let put = publisher.inner.put(payload);
                say_failed(put.attachment(attachment.to_bytes()).wait());
            }
        }
    }
}

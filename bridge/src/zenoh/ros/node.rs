//! What a node of ROS 2 publishes.

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

/// Where a sensor sits does not change with each scan: that goes to who comes later, too.
const STATIC: &str = "/tf_static";
/// How many transforms a reader may lag behind, as `tf2` has it.
const TRANSFORMS: u32 = 100;

/// The publishers of a node; they go with it.
pub(in crate::zenoh) struct Node {
    publishers: BTreeMap<&'static str, Publisher>,
    clock: Clock,
    odom: Odom,
    /// Where the sensor was last said to sit.
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
            // That one it takes.
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

    /// Publishes what a message holds for tools of ROS.
    pub(in crate::zenoh) fn publish(&mut self, message: &FromBridge) {
        let now = self.clock.time_of_day(self.clock.now());
        let mount = match message {
            FromBridge::Scan(body) => Some(body.mount),
            _ => None,
        };
        for (topic, payload) in ros::messages_of(&mut self.odom, message, now) {
            let name = match (topic, mount) {
                // Of a scan, that is where its sensor sits.
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

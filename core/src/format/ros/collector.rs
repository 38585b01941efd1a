//! Puts messages cut from a file into a [`RosLog`]; shared by both kinds of files.

use std::collections::BTreeMap;

use super::fields::{Encoding, FieldsError};
use super::messages::{self, Stamped, TopicKind};
use super::{RosLog, RosPose, RosScan, Topic};

/// This many sentences on damage are kept; the rest is only counted.
const MOST_REPORTED: usize = 5;

/// Collects the content of either kind of file.
#[derive(Debug, Default)]
pub(super) struct Collector {
    pub(super) log: RosLog,
    /// Topic of each channel or connection, and the encoding of its messages.
    channels: BTreeMap<u32, (usize, Encoding)>,
}

impl Collector {
    /// A channel that carries messages. In a bag a topic has one channel per publisher.
    pub(super) fn channel(
        &mut self,
        id: u32,
        name: &str,
        type_name: &str,
        encoding: Option<Encoding>,
    ) {
        let topics = &mut self.log.topics;
        let known = topics
            .iter()
            .position(|topic| topic.name == name && topic.type_name == type_name);
        let topic = known.unwrap_or_else(|| {
            let kind = encoding.and_then(|_| TopicKind::of(type_name, name));
            topics.push(Topic {
                name: name.to_owned(),
                type_name: type_name.to_owned(),
                kind,
                messages: 0,
            });
            topics.len() - 1
        });
        let encoding = encoding.unwrap_or(Encoding::Cdr);
        self.channels.insert(id, (topic, encoding));
    }

    /// A message; `at` is its position in the file, or that of its chunk.
    pub(super) fn message(&mut self, id: u32, recorded: u64, bytes: &[u8], at: u64) {
        let Some(&(topic, encoding)) = self.channels.get(&id) else {
            return self.damaged(
                at,
                &format!("a message of channel {id}, which nobody announced"),
            );
        };
        let Some(entry) = self.log.topics.get_mut(topic) else {
            return;
        };
        entry.messages += 1;
        let Some(kind) = entry.kind else { return };
        if let Err(error) = self.take(kind, topic, encoding, recorded, bytes) {
            let name = self.log.topics.get(topic).map_or("", |topic| &topic.name);
            let what = format!("a message of {name} cannot be read: {error}");
            self.damaged(at, &what);
        }
    }

    fn take(
        &mut self,
        kind: TopicKind,
        topic: usize,
        encoding: Encoding,
        recorded: u64,
        bytes: &[u8],
    ) -> Result<(), FieldsError> {
        match kind {
            TopicKind::Scans | TopicKind::ManyEchoes => {
                let (head, scan) = messages::scan(bytes, encoding, kind)?;
                let frame = self.frame(&head.frame);
                self.log.scans.push(RosScan {
                    topic,
                    recorded,
                    stamp: head.stamp,
                    frame,
                    scan,
                });
            }
            TopicKind::Odometry => {
                let pose = messages::odometry(bytes, encoding)?;
                if let Some(pose) = self.pose(topic, recorded, &pose) {
                    keep(&mut self.log.odometry, pose);
                }
            }
            TopicKind::Transforms | TopicKind::StaticTransforms => {
                for pose in messages::transforms(bytes, encoding)? {
                    if let Some(pose) = self.pose(topic, recorded, &pose) {
                        keep(&mut self.log.transforms, pose);
                    }
                }
            }
        }
        Ok(())
    }

    /// `None` for a pose with invalid numbers.
    fn pose(&mut self, topic: usize, recorded: u64, stamped: &Stamped) -> Option<RosPose> {
        let parent_from_child = stamped.parent_from_child?;
        Some(RosPose {
            topic,
            recorded,
            stamp: stamped.head.stamp,
            parent: self.frame(&stamped.head.frame),
            child: self.frame(&stamped.child),
            parent_from_child,
        })
    }

    fn frame(&mut self, name: &str) -> usize {
        let frames = &mut self.log.frames;
        let known = frames.iter().position(|frame| frame == name);
        known.unwrap_or_else(|| {
            frames.push(name.to_owned());
            frames.len() - 1
        })
    }

    pub(super) fn damaged(&mut self, at: u64, what: &str) {
        if self.log.damage.len() < MOST_REPORTED {
            self.log.damage.push(format!("byte {at}: {what}"));
        } else {
            self.log.more_damage += 1;
        }
    }
}

/// How far back to look for the last poses of the same two frames: messages with many transforms
/// repeat them in turn.
const MOST_BACK: usize = 64;

/// Keeps a pose. If its value equals the last two of the same frames, it replaces the last one, so
/// only the end of the interval moves.
pub(super) fn keep(poses: &mut Vec<RosPose>, pose: RosPose) {
    let is_of = |other: &RosPose| {
        [other.topic, other.parent, other.child] == [pose.topic, pose.parent, pose.child]
    };
    let recent = poses.len().saturating_sub(2 * MOST_BACK);
    let mut same = (recent..poses.len())
        .rev()
        .filter(|&index| is_of(&poses[index]));
    let last_two = same.next().zip(same.next());
    let stands = last_two.filter(|&(last, before)| {
        let is_same = |at: usize| poses[at].parent_from_child == pose.parent_from_child;
        is_same(last) && is_same(before)
    });
    match stands {
        Some((last, _)) => poses[last] = pose,
        None => poses.push(pose),
    }
}

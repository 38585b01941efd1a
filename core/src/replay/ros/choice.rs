//! Which topics to use: those that were requested, or the only ones that exist.

use std::collections::BTreeMap;

use super::ImportError;
use crate::format::ros::{FrameTree, RosLog, RosPose, TopicKind};

/// Name of the choice of no odometry.
const NONE: &str = "none";

/// Which topics of a file to map.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RosChoice {
    /// Topic of the scans; by default the only one.
    pub scans: Option<String>,
    /// Name of an odometry in [`RosOffer`], or `none`; by default the only odometry topic; without
    /// topics, the only transform, if possible from an odometry frame.
    pub odometry: Option<String>,
}

/// The choices that a file offers.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RosOffer {
    /// Topics with scans.
    pub scans: Vec<Offered>,
    /// Topics with odometry, then moving transforms.
    pub odometry: Vec<Offered>,
    /// Whether a person has to choose.
    pub must_ask: bool,
}

/// One choice.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Offered {
    /// Its name: the topic, or `tf:PARENT:CHILD`.
    pub name: String,
    /// What it contains, for people.
    pub words: String,
}

impl RosOffer {
    /// The choices of a file.
    ///
    /// # Errors    [`ImportError::NoScan`], [`ImportError::NoScanLeft`].
    pub fn of(log: &RosLog) -> Result<Self, ImportError> {
        let tree = FrameTree::of(log);
        let scans = scan_topics(log)?;
        let odometry = odometries(log, &tree);
        let topics = odometry.iter().filter(|o| o.is_topic()).count();
        let must_ask = scans.len() > 1
            || topics > 1
            || (topics == 0 && usual(log, &odometry).is_none() && !odometry.is_empty());
        Ok(Self {
            scans: scans
                .iter()
                .map(|&topic| offered_scans(log, topic))
                .collect(),
            odometry: odometry.iter().map(|o| o.offered(log)).collect(),
            must_ask,
        })
    }
}

/// Where the motion of a robot is given.
#[derive(Clone, Debug, PartialEq, Eq)]
enum OdometrySource {
    /// In the messages of a topic.
    Topic(usize),
    /// In the transform from the second frame to the first.
    Frames(usize, usize),
}

impl OdometrySource {
    fn is_topic(&self) -> bool {
        matches!(self, Self::Topic(_))
    }

    fn poses<'a>(&self, log: &'a RosLog) -> Vec<&'a RosPose> {
        match *self {
            Self::Topic(topic) => {
                let poses = log.odometry().iter();
                poses.filter(|pose| pose.topic == topic).collect()
            }
            Self::Frames(parent, child) => {
                let poses = log.transforms().iter();
                poses
                    .filter(|pose| (pose.parent, pose.child) == (parent, child))
                    .collect()
            }
        }
    }

    fn offered(&self, log: &RosLog) -> Offered {
        let poses = self.poses(log);
        let count = poses.len();
        match *self {
            Self::Topic(topic) => {
                let frames = poses.first().map_or_else(String::new, |pose| {
                    format!(
                        " of `{}` in `{}`",
                        log.frame(pose.child),
                        log.frame(pose.parent)
                    )
                });
                Offered {
                    name: topic_name(log, topic),
                    words: format!("{count} poses{frames}"),
                }
            }
            Self::Frames(parent, child) => {
                let (parent, child) = (log.frame(parent), log.frame(child));
                Offered {
                    name: format!("tf:{parent}:{child}"),
                    words: format!("{count} transforms of `{child}` in `{parent}`"),
                }
            }
        }
    }
}

/// What was chosen.
#[derive(Debug)]
pub(super) struct Chosen<'a> {
    scans: usize,
    odometry: Option<OdometrySource>,
    pub(super) poses: Vec<&'a RosPose>,
}

impl<'a> Chosen<'a> {
    pub(super) fn of(
        log: &'a RosLog,
        tree: &FrameTree,
        choice: &RosChoice,
    ) -> Result<Self, ImportError> {
        let topics = scan_topics(log)?;
        let offered = topics.iter().map(|&topic| offered_scans(log, topic));
        let scans = match (&choice.scans, &topics[..]) {
            (Some(name), _) => pick(name, "scans", offered)?,
            (None, [_]) => 0,
            (None, _) => return Err(several("a lidar's scan", offered)),
        };
        let odometries = odometries(log, tree);
        let offered = odometries.iter().map(|odometry| odometry.offered(log));
        let odometry = match choice.odometry.as_deref() {
            Some(NONE) => None,
            Some(name) => Some(pick(name, "odometry", offered)?),
            None if odometries.is_empty() => None,
            None => match usual(log, &odometries) {
                Some(index) => Some(index),
                None => return Err(several("odometry", offered)),
            },
        };
        let odometry = odometry.and_then(|index| odometries.get(index).cloned());
        let poses = odometry.as_ref().map_or(vec![], |o| o.poses(log));
        Ok(Self {
            scans: topics.get(scans).copied().unwrap_or_default(),
            odometry,
            poses,
        })
    }

    /// Indices of its scans, in the order of the file.
    pub(super) fn scan_numbers(&self, log: &RosLog) -> Vec<usize> {
        let scans = log.scans().iter().enumerate();
        scans
            .filter(|(_, scan)| scan.topic == self.scans)
            .map(|(index, _)| index)
            .collect()
    }

    /// The frame whose motion is given, or the robot's by its usual names; `None` if the lidar
    /// itself has to serve as the robot.
    pub(super) fn base(
        &self,
        log: &RosLog,
        tree: &FrameTree,
        notes: &mut Vec<String>,
    ) -> Option<usize> {
        let told = self.poses.first().map(|pose| pose.child);
        let told = told.filter(|&frame| !log.frame(frame).is_empty());
        let usual = ["base_link", "base_footprint"];
        let base = told.or_else(|| usual.iter().find_map(|name| log.frame_number(name)))?;
        let first = self.scan_numbers(log).into_iter().next();
        let frame = first.and_then(|index| log.scans().get(index))?.frame;
        match tree.between(log, base, frame) {
            Ok(_) => Some(base),
            Err(error) => {
                notes.push(format!(
                    "{error}: the lidar is taken to sit in the middle of the robot and to look ahead"
                ));
                None
            }
        }
    }

    /// What is mapped, in words for people.
    pub(super) fn words(&self, log: &RosLog, scans: usize) -> String {
        let topic = topic_name(log, self.scans);
        let odometry = match &self.odometry {
            Some(source) => {
                let Offered { name, words } = source.offered(log);
                format!("odometry of {name} ({words})")
            }
            None => "without odometry".to_owned(),
        };
        format!("{scans} scans of {topic}, {odometry}")
    }
}

/// The odometry to use if none was chosen: the only topic; without topics, the only transform from
/// a frame named like odometry, or else the only transform.
fn usual(log: &RosLog, odometries: &[OdometrySource]) -> Option<usize> {
    let only = |is: &dyn Fn(&OdometrySource) -> bool| {
        let mut found = (0..odometries.len()).filter(|&index| is(&odometries[index]));
        found.next().filter(|_| found.next().is_none())
    };
    if odometries.iter().any(OdometrySource::is_topic) {
        return only(&OdometrySource::is_topic);
    }
    let is_odometry = |source: &OdometrySource| match source {
        OdometrySource::Frames(parent, _) => log.frame(*parent).contains("odom"),
        OdometrySource::Topic(_) => false,
    };
    only(&is_odometry).or_else(|| only(&|_| true))
}

/// Topics with odometry, then pairs of frames that move relative to each other, if the lower one is
/// fixed to a lidar.
fn odometries(log: &RosLog, tree: &FrameTree) -> Vec<OdometrySource> {
    let topics = of_kinds(log, &[TopicKind::Odometry]).map(OdometrySource::Topic);
    let mut frames: Vec<usize> = log.scans().iter().map(|scan| scan.frame).collect();
    frames.sort_unstable();
    frames.dedup();
    let carries = |child: usize| {
        frames
            .iter()
            .any(|&frame| tree.between(log, child, frame).is_ok())
    };
    let moving = tree.moving().iter();
    let moving = moving.filter(|(_, child)| carries(*child));
    let moving = moving.map(|&(parent, child)| OdometrySource::Frames(parent, child));
    let all = topics.chain(moving);
    all.filter(|source| source.poses(log).len() > 1).collect()
}

fn scan_topics(log: &RosLog) -> Result<Vec<usize>, ImportError> {
    let mut counts: BTreeMap<usize, usize> = BTreeMap::new();
    for scan in log.scans() {
        *counts.entry(scan.topic).or_default() += 1;
    }
    let kinds = [TopicKind::Scans, TopicKind::ManyEchoes];
    let topics: Vec<usize> = of_kinds(log, &kinds)
        .filter(|topic| counts.contains_key(topic))
        .collect();
    if topics.is_empty() {
        let topic =
            |topic: &crate::format::ros::Topic| format!("{} ({})", topic.name, topic.type_name);
        let topics = log.topics().iter().map(topic).collect();
        return Err(match log.damage().into_iter().next() {
            None => ImportError::NoScan(topics),
            Some(damage) => ImportError::NoScanLeft { topics, damage },
        });
    }
    Ok(topics)
}

fn of_kinds(log: &RosLog, kinds: &[TopicKind]) -> impl Iterator<Item = usize> {
    let topics = log.topics().iter().enumerate();
    topics
        .filter(|(_, topic)| topic.kind.is_some_and(|kind| kinds.contains(&kind)))
        .map(|(index, _)| index)
}

fn offered_scans(log: &RosLog, topic: usize) -> Offered {
    let mut scans = log.scans().iter().filter(|scan| scan.topic == topic);
    let first = scans.next();
    let beams = first.map_or(0, |scan| scan.scan.ranges.len());
    let frame = first.map_or("", |scan| log.frame(scan.frame));
    let count = scans.count() + 1;
    Offered {
        name: topic_name(log, topic),
        words: format!("{count} scans of {beams} beams in frame `{frame}`"),
    }
}

fn topic_name(log: &RosLog, topic: usize) -> String {
    log.topics()
        .get(topic)
        .map_or_else(String::new, |topic| topic.name.clone())
}

/// Index of the one with this name; a leading slash may be left out.
fn pick(
    name: &str,
    what: &'static str,
    offered: impl Iterator<Item = Offered>,
) -> Result<usize, ImportError> {
    let names: Vec<String> = offered.map(|offered| offered.name).collect();
    let is_meant = |other: &String| other.trim_start_matches('/') == name.trim_start_matches('/');
    let found = names.iter().position(is_meant);
    found.ok_or_else(|| ImportError::NoTopic {
        name: name.to_owned(),
        what,
        names,
    })
}

fn several(what: &'static str, offered: impl Iterator<Item = Offered>) -> ImportError {
    let names = offered.map(|Offered { name, words }| format!("{name} ({words})"));
    ImportError::Several {
        what,
        names: names.collect(),
    }
}

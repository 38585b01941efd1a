//! Recordings of other robots: bags of ROS 1 and MCAP files of ROS 2.
//!
//! In: the bytes of a file, in pieces of any size. Out: a [`RosLog`]: every scan, every pose by
//! odometry, every transform, and what part of the file is damaged. Which of several lidars is
//! meant, and where it sits according to the frames, is decided later ([`crate::replay`]).
//!
//! 1. A file is cut into records (`bag`, `mcap`), and chunks are decompressed (`unpack`). Only
//!    messages of the kinds in `messages` are read; images and other large messages are skipped.
//! 2. A record that cannot be read ends the file there; a chunk or a message that cannot be read is
//!    left out. Both are reported with their position in [`RosLog::damage`].
//! 3. Of a transform or a pose that is repeated unchanged only the first and the last are kept: an
//!    arm with many joints at rest costs nothing.

mod bag;
mod collector;
mod fields;
mod frames;
mod mcap;
mod messages;
#[cfg(test)]
mod tests;
mod unpack;

use nalgebra::Isometry3;

pub use bag::{ANY_BAG, BAG_MAGIC};
pub use frames::{FrameTree, NoTransform};
pub use messages::{LaserScan, TopicKind};

use collector::Collector;
use fields::Encoding;

/// Why a file is not a recording of ROS, or cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum RosError {
    /// The file does not begin like one.
    #[error("the file begins neither as a ROS 1 bag (`#ROSBAG V2.0`) nor as an MCAP file")]
    Magic,
    /// A bag from before 2010.
    #[error("this is a ROS bag of version {0}; expected 2.0: `rosbag fix` rewrites it")]
    Version(String),
}

/// The content of a file of ROS.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RosLog {
    topics: Vec<Topic>,
    frames: Vec<String>,
    scans: Vec<RosScan>,
    odometry: Vec<RosPose>,
    transforms: Vec<RosPose>,
    damage: Vec<String>,
    more_damage: usize,
}

/// A topic of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Topic {
    /// Its name: `/scan`.
    pub name: String,
    /// Type of its messages: `sensor_msgs/msg/LaserScan`.
    pub type_name: String,
    /// What is read of it; none if the type is not read.
    pub kind: Option<TopicKind>,
    /// Number of its messages, readable or not.
    pub messages: usize,
}

/// A scan with its place in the file.
#[derive(Clone, Debug, PartialEq)]
pub struct RosScan {
    /// Number of its topic.
    pub topic: usize,
    /// When it was recorded, ns.
    pub recorded: u64,
    /// When its first beam was taken according to the message, ns.
    pub stamp: u64,
    /// Number of its frame.
    pub frame: usize,
    /// What was seen.
    pub scan: LaserScan,
}

/// The pose of one frame in another, at a time.
#[derive(Clone, Debug, PartialEq)]
pub struct RosPose {
    /// Number of its topic.
    pub topic: usize,
    /// When it was recorded, ns.
    pub recorded: u64,
    /// The time it applies to according to the message, ns.
    pub stamp: u64,
    /// Number of the frame that it is expressed in.
    pub parent: usize,
    /// Number of the frame that it describes.
    pub child: usize,
    /// Transforms coordinates in the child's frame to coordinates in the parent's.
    pub parent_from_child: Isometry3<f64>,
}

impl RosLog {
    /// All topics, in the order in which they were announced.
    #[must_use]
    pub fn topics(&self) -> &[Topic] {
        &self.topics
    }

    /// All scans, in the order of the file.
    #[must_use]
    pub fn scans(&self) -> &[RosScan] {
        &self.scans
    }

    /// All poses of odometry topics, in the order of the file.
    #[must_use]
    pub fn odometry(&self) -> &[RosPose] {
        &self.odometry
    }

    /// All transforms, in the order of the file.
    #[must_use]
    pub fn transforms(&self) -> &[RosPose] {
        &self.transforms
    }

    #[cfg(test)]
    pub(crate) fn scans_mut(&mut self) -> &mut Vec<RosScan> {
        &mut self.scans
    }

    #[cfg(test)]
    pub(crate) fn odometry_mut(&mut self) -> &mut Vec<RosPose> {
        &mut self.odometry
    }

    #[cfg(test)]
    pub(crate) fn transforms_mut(&mut self) -> &mut Vec<RosPose> {
        &mut self.transforms
    }

    /// Name of a frame.
    #[must_use]
    pub fn frame(&self, number: usize) -> &str {
        self.frames.get(number).map_or("", String::as_str)
    }

    /// Number of a frame.
    #[must_use]
    pub fn frame_number(&self, name: &str) -> Option<usize> {
        self.frames.iter().position(|frame| frame == name)
    }

    /// What part of the file could not be read, with its position, one sentence each.
    #[must_use]
    pub fn damage(&self) -> Vec<String> {
        let more = (self.more_damage > 0)
            .then(|| format!("{} more places could not be read", self.more_damage));
        self.damage.iter().cloned().chain(more).collect()
    }
}

/// Reads a bag or an MCAP file, piece by piece.
#[derive(Debug, Default)]
pub struct RosReader {
    file: File,
}

#[derive(Debug)]
enum File {
    /// Too few bytes to recognise the format.
    Undecided(Vec<u8>),
    Bag(Box<bag::BagReader>),
    Mcap(Box<mcap::McapReader>),
}

impl Default for File {
    fn default() -> Self {
        Self::Undecided(vec![])
    }
}

impl RosReader {
    /// Takes the next bytes, any number of them.
    ///
    /// # Errors    [`RosError`]: the file is not a recording of ROS.
    pub fn push(&mut self, bytes: &[u8]) -> Result<(), RosError> {
        match &mut self.file {
            File::Undecided(begun) => {
                begun.extend_from_slice(bytes);
                if begun.len() < BAG_MAGIC.len() {
                    return Ok(());
                }
                let begun = std::mem::take(begun);
                self.file = if let Some(bag) = bag::BagReader::of(&begun)? {
                    File::Bag(Box::new(bag))
                } else if begun.starts_with(::mcap::MAGIC) {
                    File::Mcap(Box::default())
                } else {
                    return Err(RosError::Magic);
                };
                self.push(&begun)
            }
            File::Bag(reader) => {
                reader.push(bytes);
                Ok(())
            }
            File::Mcap(reader) => {
                reader.push(bytes);
                Ok(())
            }
        }
    }

    /// Ends the file.
    ///
    /// # Errors    [`RosError`]: the file is not a recording of ROS.
    pub fn finish(self) -> Result<RosLog, RosError> {
        match self.file {
            File::Undecided(_) => Err(RosError::Magic),
            File::Bag(reader) => Ok(reader.finish()),
            File::Mcap(reader) => Ok(reader.finish()),
        }
    }
}

/// Bytes that are not a complete record yet, and the position of the first of them in the file.
#[derive(Debug, Default)]
struct Waiting {
    bytes: Vec<u8>,
    at: u64,
}

impl Waiting {
    /// Passes complete records to `take`, which returns how many bytes it took, or `None` if it
    /// needs more.
    fn push(&mut self, bytes: &[u8], mut take: impl FnMut(&[u8], u64) -> Option<usize>) {
        self.bytes.extend_from_slice(bytes);
        let mut used = 0;
        while let Some(rest) = self.bytes.get(used..).filter(|rest| !rest.is_empty()) {
            match take(rest, self.at) {
                Some(count) => {
                    used += count;
                    self.at += count as u64;
                }
                None => break,
            }
        }
        self.bytes.drain(..used.min(self.bytes.len()));
    }
}

//! Recordings of other robots: bags of ROS 1 and MCAP files of ROS 2.
//!
//! In: the bytes of a file, in pieces of any size. Out: a [`RosLog`]: every scan, every pose by
//! odometry and every transform in it, and what of the file is damaged. Which of several lidars is
//! meant, and what the frames say of where it sits, is asked of it later ([`crate::replay`]).
//!
//! 1. A file is cut into records (`bag`, `mcap`), and chunks are unpacked (`unpack`). Only
//!    messages of the kinds in `messages` are read; cameras and whatever else is large pass by.
//! 2. A record that cannot be read ends the file there; a chunk or a message is left out. Either is
//!    told in [`RosLog::damage`], with its place.
//! 3. A transform or a pose that is said again and again is kept when it begins and when it ends:
//!    an arm of many joints at rest costs nothing.

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

/// Why a file is no recording of ROS, or of no use.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum RosError {
    /// It begins otherwise.
    #[error("the file begins neither as a ROS 1 bag (`#ROSBAG V2.0`) nor as an MCAP file")]
    Magic,
    /// A bag of before 2010.
    #[error("this is a ROS bag of version {0}; expected 2.0: `rosbag fix` rewrites it")]
    Version(String),
}

/// What a file of ROS holds.
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
    /// What is read of it; none where nothing is.
    pub kind: Option<TopicKind>,
    /// Messages of it, readable or not.
    pub messages: usize,
}

/// A scan with its place in the file.
#[derive(Clone, Debug, PartialEq)]
pub struct RosScan {
    /// Number of its topic.
    pub topic: usize,
    /// When it was recorded, ns.
    pub recorded: u64,
    /// When its first beam was taken, by its own word, ns.
    pub stamp: u64,
    /// Number of its frame.
    pub frame: usize,
    /// What was seen.
    pub scan: LaserScan,
}

/// Where one frame is in another, at a time.
#[derive(Clone, Debug, PartialEq)]
pub struct RosPose {
    /// Number of its topic.
    pub topic: usize,
    /// When it was recorded, ns.
    pub recorded: u64,
    /// When it was so, by its own word, ns.
    pub stamp: u64,
    /// Number of the frame that it is in.
    pub parent: usize,
    /// Number of the frame that it is of.
    pub child: usize,
    /// Coordinates in the child's frame to coordinates in the parent's.
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

    /// What of the file could not be read, with its place, a sentence each.
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
    /// Fewer bytes than show what it is.
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
    /// Takes the next bytes, as many as there are.
    ///
    /// # Errors    [`RosError`]: it is no such file.
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

    /// The file is all there.
    ///
    /// # Errors    [`RosError`]: it is no such file.
    pub fn finish(self) -> Result<RosLog, RosError> {
        match self.file {
            File::Undecided(_) => Err(RosError::Magic),
            File::Bag(reader) => Ok(reader.finish()),
            File::Mcap(reader) => Ok(reader.finish()),
        }
    }
}

/// Bytes that are not a whole record yet, and where the first of them stands in the file.
#[derive(Debug, Default)]
struct Waiting {
    bytes: Vec<u8>,
    at: u64,
}

impl Waiting {
    /// Hands whole records on: `take` says how many bytes it took, `None` where it needs more.
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

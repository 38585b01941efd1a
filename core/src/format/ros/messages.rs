//! The messages that say where a robot was and what it saw.
//!
//! In: the bytes of a message. Out: its fields unchanged, including NaN. Whether they are usable is
//! decided where they are used ([`crate::replay`]).
//!
//! Sources: `sensor_msgs/LaserScan`, `sensor_msgs/MultiEchoLaserScan`, `nav_msgs/Odometry`,
//! `tf2_msgs/TFMessage` of ROS 1 (Noetic) and ROS 2 (Jazzy).

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};

use super::fields::{Encoding, Fields, FieldsError};

/// What a topic carries.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum TopicKind {
    /// Scans of a lidar.
    Scans,
    /// Scans with several echoes for each beam; the first is used.
    ManyEchoes,
    /// Poses by odometry.
    Odometry,
    /// Transforms between frames.
    Transforms,
    /// Transforms between frames that never change.
    StaticTransforms,
}

impl TopicKind {
    /// From the name of the type, of ROS 1 or 2; `None` for types that are not read.
    pub(super) fn of(type_name: &str, topic: &str) -> Option<Self> {
        let (package, name) = type_name.split_once('/')?;
        let name = name.strip_prefix("msg/").unwrap_or(name);
        match (package, name) {
            ("sensor_msgs", "LaserScan") => Some(Self::Scans),
            ("sensor_msgs", "MultiEchoLaserScan") => Some(Self::ManyEchoes),
            ("nav_msgs", "Odometry") => Some(Self::Odometry),
            ("tf2_msgs" | "tf", "TFMessage" | "tfMessage") => {
                Some(match topic.ends_with("tf_static") {
                    true => Self::StaticTransforms,
                    false => Self::Transforms,
                })
            }
            _ => None,
        }
    }
}

/// When and where something was measured.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Head {
    /// ns; 0 if it was not filled in.
    pub(super) stamp: u64,
    /// Without the leading slash of ROS 1.
    pub(super) frame: String,
}

/// A scan as a driver sent it, in the frame of its lidar; units are m, rad and s.
#[derive(Clone, Debug, PartialEq)]
pub struct LaserScan {
    /// Direction of the first beam.
    pub angle_min: f32,
    /// Direction of the last beam.
    pub angle_max: f32,
    /// From one beam to the next.
    pub angle_increment: f32,
    /// From one beam to the next; 0 if all were taken at once.
    pub time_increment: f32,
    /// From one scan to the next.
    pub scan_time: f32,
    /// Nearer readings are invalid.
    pub range_min: f32,
    /// Farther readings are invalid.
    pub range_max: f32,
    /// One for each beam.
    pub ranges: Vec<f32>,
}

/// A transform between two frames.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Stamped {
    pub(super) head: Head,
    pub(super) child: String,
    /// `None` if the numbers are not a valid transform.
    pub(super) parent_from_child: Option<Isometry3<f64>>,
}

/// A scan; its stamp is that of its first beam.
pub(super) fn scan(
    bytes: &[u8],
    encoding: Encoding,
    kind: TopicKind,
) -> Result<(Head, LaserScan), FieldsError> {
    let mut fields = Fields::new(bytes, encoding)?;
    let head = head(&mut fields)?;
    let scan = LaserScan {
        angle_min: fields.f32("angle_min")?,
        angle_max: fields.f32("angle_max")?,
        angle_increment: fields.f32("angle_increment")?,
        time_increment: fields.f32("time_increment")?,
        scan_time: fields.f32("scan_time")?,
        range_min: fields.f32("range_min")?,
        range_max: fields.f32("range_max")?,
        ranges: match kind {
            TopicKind::ManyEchoes => first_echoes(&mut fields)?,
            _ => fields.f32s("ranges")?,
        },
    };
    Ok((head, scan))
}

/// The first echo of each beam; NaN where there is none.
fn first_echoes(fields: &mut Fields<'_>) -> Result<Vec<f32>, FieldsError> {
    let beams = fields.count("ranges", 4)?;
    let mut first = |_| Ok(fields.f32s("echoes")?.first().copied().unwrap_or(f32::NAN));
    (0..beams).map(&mut first).collect()
}

/// The pose of the child frame in the frame of the header.
pub(super) fn odometry(bytes: &[u8], encoding: Encoding) -> Result<Stamped, FieldsError> {
    let mut fields = Fields::new(bytes, encoding)?;
    Ok(Stamped {
        head: head(&mut fields)?,
        child: frame(&mut fields, "child_frame_id")?,
        parent_from_child: isometry(&mut fields, "pose")?,
    })
}

/// All transforms of one message.
pub(super) fn transforms(bytes: &[u8], encoding: Encoding) -> Result<Vec<Stamped>, FieldsError> {
    let mut fields = Fields::new(bytes, encoding)?;
    // Size of a stamp, two string lengths and seven numbers.
    let count = fields.count("transforms", 8 + 4 + 4 + 56)?;
    let transform = |_| {
        Ok(Stamped {
            head: head(&mut fields)?,
            child: frame(&mut fields, "child_frame_id")?,
            parent_from_child: isometry(&mut fields, "transform")?,
        })
    };
    (0..count).map(transform).collect()
}

fn head(fields: &mut Fields<'_>) -> Result<Head, FieldsError> {
    if fields.has_sequence() {
        fields.u32("seq")?;
    }
    let seconds = fields.u32("stamp")?;
    let nanos = fields.u32("stamp")?;
    Ok(Head {
        stamp: u64::from(seconds) * 1_000_000_000 + u64::from(nanos),
        frame: frame(fields, "frame_id")?,
    })
}

fn frame(fields: &mut Fields<'_>, field: &'static str) -> Result<String, FieldsError> {
    let name = fields.text(field)?;
    Ok(name.trim_start_matches('/').to_owned())
}

/// Three numbers of a translation and four of a rotation, x first and w last.
fn isometry(
    fields: &mut Fields<'_>,
    field: &'static str,
) -> Result<Option<Isometry3<f64>>, FieldsError> {
    let [x, y, z] = fields.f64s(field)?;
    let [i, j, k, w] = fields.f64s(field)?;
    let square = i * i + j * j + k * k + w * w;
    let is_one = [x, y, z].iter().all(|v| v.is_finite()) && (0.5..2.0).contains(&square);
    let rotation = UnitQuaternion::from_quaternion(Quaternion::new(w, i, j, k));
    Ok(is_one.then(|| Isometry3::from_parts(Translation3::new(x, y, z), rotation)))
}

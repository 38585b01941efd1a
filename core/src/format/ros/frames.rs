//! Frames that do not move against each other, and how to get from one to the other.
//!
//! In: the transforms of a file. Out: a tree of those that never change. Transforms on `/tf_static`
//! are constant by definition; others count if they have the same value in the whole file, because
//! many robots of ROS 1 send constant transforms again and again.

use std::collections::{BTreeMap, VecDeque};

use nalgebra::Isometry3;

use super::{RosLog, RosPose, TopicKind};

/// Two transforms that differ by less are the same, m and rad.
const SAME: f64 = 1e-6;

/// No chain of constant transforms connects two frames.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "no transform that stays leads from `{from}` to `{to}`{}",
    among(known)
)]
pub struct NoTransform {
    /// The frame in which the pose was asked for.
    pub from: String,
    /// The frame whose pose was asked for.
    pub to: String,
    /// Frames that can be reached from the first.
    pub known: Vec<String>,
}

fn among(known: &[String]) -> String {
    match known {
        [] => String::new(),
        known => format!(" (known from there: {})", known.join(", ")),
    }
}

/// Frames that do not move against each other.
#[derive(Clone, Debug, Default)]
pub struct FrameTree {
    /// Each edge is stored in both directions.
    edges: BTreeMap<usize, Vec<(usize, Isometry3<f64>)>>,
    /// Pairs of frames, parent first, that move against each other.
    moving: Vec<(usize, usize)>,
}

impl FrameTree {
    /// The frames of a file.
    #[must_use]
    pub fn of(log: &RosLog) -> Self {
        let mut pairs: BTreeMap<(usize, usize), Pair> = BTreeMap::new();
        for pose in &log.transforms {
            let topic = log.topics.get(pose.topic);
            let is_static = topic.is_some_and(|t| t.kind == Some(TopicKind::StaticTransforms));
            let key = (pose.parent, pose.child);
            let pair = pairs.entry(key).or_insert_with(|| Pair::new(pose));
            // Of static transforms the last one counts: a calibration may be sent again.
            if is_static {
                (pair.transform, pair.is_static) = (pose.parent_from_child, true);
            }
            pair.moves |= !is_same(&pair.first, &pose.parent_from_child);
        }
        let mut tree = Self::default();
        for ((parent, child), pair) in pairs {
            if pair.moves && !pair.is_static {
                tree.moving.push((parent, child));
                continue;
            }
            let there = pair.transform;
            tree.edges.entry(parent).or_default().push((child, there));
            let back = there.inverse();
            tree.edges.entry(child).or_default().push((parent, back));
        }
        tree
    }

    /// Pairs of frames, parent first, that move against each other.
    #[must_use]
    pub fn moving(&self) -> &[(usize, usize)] {
        &self.moving
    }

    /// The transform from coordinates in `to` to coordinates in `from`.
    ///
    /// # Errors    [`NoTransform`], with both names and the frames that can be reached.
    pub fn between(
        &self,
        log: &RosLog,
        from: usize,
        to: usize,
    ) -> Result<Isometry3<f64>, NoTransform> {
        let mut reached = BTreeMap::from([(from, Isometry3::identity())]);
        let mut waiting = VecDeque::from([from]);
        while let Some(frame) = waiting.pop_front() {
            let Some(&so_far) = reached.get(&frame) else {
                continue;
            };
            if frame == to {
                return Ok(so_far);
            }
            for (next, step) in self.edges.get(&frame).into_iter().flatten() {
                if !reached.contains_key(next) {
                    reached.insert(*next, so_far * step);
                    waiting.push_back(*next);
                }
            }
        }
        reached.remove(&from);
        let name = |frame: usize| log.frame(frame).to_owned();
        Err(NoTransform {
            from: name(from),
            to: name(to),
            known: reached.into_keys().map(name).collect(),
        })
    }
}

/// What a file says of two frames.
struct Pair {
    first: Isometry3<f64>,
    transform: Isometry3<f64>,
    is_static: bool,
    moves: bool,
}

impl Pair {
    fn new(pose: &RosPose) -> Self {
        Self {
            first: pose.parent_from_child,
            transform: pose.parent_from_child,
            is_static: false,
            moves: false,
        }
    }
}

fn is_same(a: &Isometry3<f64>, b: &Isometry3<f64>) -> bool {
    let place = (a.translation.vector - b.translation.vector).amax();
    // q and -q are the same rotation.
    let turn = 1.0 - a.rotation.coords.dot(&b.rotation.coords).abs();
    place < SAME && turn < SAME * SAME
}

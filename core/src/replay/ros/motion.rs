//! Motion between scans, from poses at other times.
//!
//! 1. Between two poses the robot moved along an arc ([`Pose2::fraction`]), so its pose is known at
//!    any time between the first and the last.
//! 2. A motion ends where a scan ends, and at poses in between that are far enough apart in time,
//!    because the motion within a sweep is needed to de-skew it.
//! 3. If a pose is farther from the one before than any robot drives, the odometry was reset: no
//!    motion is given for that time, and readers of the recording treat it as unobserved.

use nalgebra::Vector3;

use crate::format::ros::RosPose;
use crate::geom::{Length, Pose2};
use crate::robot::{Odometry, RobotModel, Stamp};

use super::super::feed::recorded_odometry;

/// Poses nearer in time than this add nothing, µs.
const LEAST_APART: u64 = 10_000;
/// No robot of these recordings is faster, m/s; and smaller jumps are ignored, m.
const FASTEST: f64 = 15.0;
const LEAST_JUMP: f64 = 0.5;

/// The trajectory of a robot by its odometry.
#[derive(Debug)]
pub(super) struct Motions {
    /// In rising order, no two at the same time.
    poses: Vec<(u64, Pose2)>,
    /// For each pose, whether the odometry was reset just before it.
    is_reset: Vec<bool>,
    /// The end of the last motion.
    last: Option<(u64, Pose2)>,
    next: usize,
}

impl Motions {
    /// `None` without poses.
    pub(super) fn of(times: &[(u64, &RosPose)]) -> Option<Self> {
        let poses = times
            .iter()
            .map(|(time, pose)| (time / 1000, in_plane(pose)));
        let mut poses: Vec<(u64, Pose2)> = poses.collect();
        // Of several at the same time, the last one is used.
        poses.reverse();
        poses.dedup_by_key(|(time, _)| *time);
        poses.reverse();
        let jumps = poses.windows(2).map(|pair| {
            let ((from, a), (to, b)) = (pair[0], pair[1]);
            let way = (b.position() - a.position()).length();
            let seconds = Stamp(to).since(Stamp(from));
            way > LEAST_JUMP + FASTEST * seconds
        });
        let is_reset = std::iter::once(false).chain(jumps).collect();
        (!poses.is_empty()).then_some(Self {
            poses,
            is_reset,
            last: None,
            next: 0,
        })
    }

    /// Whether the robot's pose is known at this time.
    pub(super) fn tells(&self, at: Stamp) -> bool {
        self.pose(at.0).is_some()
    }

    /// The motions from the end of the last ones up to this time.
    pub(super) fn up_to(&mut self, at: Stamp, robot: &RobotModel) -> Vec<Odometry> {
        let mut out = vec![];
        while let Some(&(time, pose)) = self.poses.get(self.next) {
            if time >= at.0 {
                break;
            }
            let is_reset = self.is_reset.get(self.next).copied().unwrap_or(false);
            self.next += 1;
            let is_near = self.last.is_some_and(|(last, _)| time < last + LEAST_APART);
            let next_resets = self.is_reset.get(self.next).copied().unwrap_or(false);
            if is_near && !is_reset && !next_resets {
                continue;
            }
            self.move_to(time, pose, is_reset, robot, &mut out);
        }
        if let Some(pose) = self.pose(at.0) {
            // A pose at exactly this time that follows a reset does not end a motion.
            let here = self.poses.get(self.next).filter(|(time, _)| *time == at.0);
            let is_reset = here.is_some() && self.is_reset.get(self.next) == Some(&true);
            self.move_to(at.0, pose, is_reset, robot, &mut out);
        }
        out
    }

    fn move_to(
        &mut self,
        time: u64,
        pose: Pose2,
        is_reset: bool,
        robot: &RobotModel,
        out: &mut Vec<Odometry>,
    ) {
        let last = self.last.replace((time, pose));
        let Some((from, from_pose)) = last.filter(|_| !is_reset) else {
            return;
        };
        if from < time {
            let motion = from_pose.delta_to(&pose);
            out.push(recorded_odometry(robot, Stamp(from), Stamp(time), motion));
        }
    }

    /// `None` before the first pose, after the last, and where the odometry was reset.
    fn pose(&self, at: u64) -> Option<Pose2> {
        let next = self.poses.partition_point(|(time, _)| *time < at);
        let &(to, after) = self.poses.get(next)?;
        if to == at {
            return Some(after);
        }
        let &(from, before) = self.poses.get(next.checked_sub(1)?)?;
        if self.is_reset.get(next) == Some(&true) {
            return None;
        }
        let part = (at - from) as f64 / (to - from) as f64;
        Some(before * before.delta_to(&after).fraction(part))
    }

    /// A sentence about resets.
    pub(super) fn jumps(&self) -> Option<String> {
        let count = self.is_reset.iter().filter(|is_reset| **is_reset).count();
        let at = self.is_reset.iter().position(|is_reset| *is_reset)?;
        let first = self.poses.first()?.0;
        let seconds = Stamp(self.poses.get(at)?.0).since(Stamp(first));
        Some(format!(
            "The odometry jumps {count} times, first {seconds:.1} s after its begin: how the robot moved there is not known"
        ))
    }
}

/// Projected onto the floor: height, roll and pitch are dropped.
fn in_plane(pose: &RosPose) -> Pose2 {
    let place = &pose.parent_from_child.translation.vector;
    let ahead = pose.parent_from_child.rotation * Vector3::x();
    Pose2::new(place.x, place.y, libm::atan2(ahead.y, ahead.x))
}

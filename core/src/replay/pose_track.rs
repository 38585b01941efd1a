//! Where a robot was at any time, by poses from another file.
//!
//! In: stamped poses of a [`PosesFile`], and times of scans on the same clock. Out: the pose at
//! such a time, or that the file does not tell.
//!
//! Between two poses the robot moved along an arc of constant speed and turn rate. Where two poses
//! are too far apart in time nobody knows what happened between them: nothing is said of that time.

use crate::format::poses::PosesFile;
use crate::geom::Pose2;

/// Poses that are farther apart tell nothing of the time between them, s. Those that come once a
/// second come not quite in time.
pub(super) const LONGEST_GAP: f64 = 1.5;
/// A pose holds for so long before and behind its time, s: stamps are written with few digits.
const SAME_TIME: f64 = 0.002;

/// Why poses and scans have nothing to do with each other.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PosesMisfit {
    /// Of no scan the pose is known.
    #[error(
        "none of the {scans} scans lies where the poses tell: the scans are from {first:.3} to {last:.3} s, the poses from {from:.3} to {to:.3} s, and none holds for longer than {LONGEST_GAP} s; both must be on one clock"
    )]
    NoScan {
        /// Scans of the log.
        scans: usize,
        /// Time of its first scan, s.
        first: f64,
        /// Time of its last scan, s.
        last: f64,
        /// Time of the first pose, s.
        from: f64,
        /// Time of the last pose, s.
        to: f64,
    },
    /// A log that has such poses already.
    #[error("this recording is mapped with the poses of another file already")]
    Twice,
}

/// Where a robot was, by a file of poses.
#[derive(Clone, Debug, PartialEq)]
pub struct PoseTrack {
    /// Times rise; at least one.
    poses: Vec<(f64, Pose2)>,
}

impl PoseTrack {
    /// Times and poses, rising; at least one.
    #[must_use]
    pub fn poses(&self) -> &[(f64, Pose2)] {
        &self.poses
    }

    /// The pose at a time, s; `None` before the first, behind the last, and where two are too far
    /// apart.
    #[must_use]
    pub fn at(&self, seconds: f64) -> Option<Pose2> {
        let next = self.poses.partition_point(|(time, _)| *time < seconds);
        let before = next.checked_sub(1).and_then(|at| self.poses.get(at));
        let after = self.poses.get(next);
        if let (Some((from, a)), Some((to, b))) = (before, after)
            && to - from <= LONGEST_GAP
        {
            let part = (seconds - from) / (to - from);
            return Some(*a * a.delta_to(b).fraction(part));
        }
        let near = [before, after].into_iter().flatten();
        let off = |time: f64| (time - seconds).abs();
        let (time, pose) = near.min_by(|a, b| off(a.0).total_cmp(&off(b.0)))?;
        (off(*time) <= SAME_TIME).then_some(*pose)
    }

    /// The poses between two times, both left out.
    pub(super) fn between(&self, from: f64, to: f64) -> &[(f64, Pose2)] {
        let begin = self.poses.partition_point(|(time, _)| *time <= from);
        let end = self.poses.partition_point(|(time, _)| *time < to);
        self.poses.get(begin..end).unwrap_or(&[])
    }

    /// How much of these scans it tells, by their times, s.
    ///
    /// # Errors    [`PosesMisfit::NoScan`]: nothing at all.
    pub(super) fn coverage(&self, scans: &[f64]) -> Result<Coverage, PosesMisfit> {
        let untold = scans.iter().filter(|seconds| self.at(**seconds).is_none());
        let coverage = Coverage {
            scans: scans.len(),
            untold: untold.clone().count(),
            first: untold.copied().next(),
        };
        if coverage.untold < coverage.scans {
            return Ok(coverage);
        }
        let end = |end: Option<&f64>| end.copied().unwrap_or(f64::NAN);
        let time = |end: Option<&(f64, Pose2)>| end.map_or(f64::NAN, |(time, _)| *time);
        Err(PosesMisfit::NoScan {
            scans: coverage.scans,
            first: end(scans.first()),
            last: end(scans.last()),
            from: time(self.poses.first()),
            to: time(self.poses.last()),
        })
    }
}

impl From<PosesFile> for PoseTrack {
    fn from(file: PosesFile) -> Self {
        Self { poses: file.poses }
    }
}

/// How many scans of a log poses tell of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Coverage {
    scans: usize,
    untold: usize,
    /// Time of the first of which they do not, s.
    first: Option<f64>,
}

impl Coverage {
    /// A sentence where some are not told of; `so` is what follows from it.
    pub(super) fn words(&self, so: &str) -> Option<String> {
        let Self {
            scans,
            untold,
            first,
        } = *self;
        let first = first?;
        Some(format!(
            "{untold} of {scans} scans lie before or behind the poses, or in a gap of more than {LONGEST_GAP} s between two of them, first at {first:.2} s: {so}"
        ))
    }
}

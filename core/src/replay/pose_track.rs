//! Where a robot was at any time, from poses in another file.
//!
//! In: stamped poses of a [`PosesFile`], and times of scans on the same clock. Out: the pose at
//! such a time, or that the file does not cover it.
//!
//! Between two poses the robot moved along an arc of constant speed and turn rate. If two poses are
//! too far apart in time, nobody knows what happened between them, and no pose is given.

use crate::format::poses::PosesFile;
use crate::geom::Pose2;

/// Poses farther apart than this say nothing about the time between them, s. A little more than one
/// second, because poses written once a second are not exactly regular.
pub(super) const LONGEST_GAP: f64 = 1.5;
/// A pose is valid for this long before and after its time, s: stamps are written with few digits.
const SAME_TIME: f64 = 0.002;

/// Why poses and scans do not belong together.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PosesMisfit {
    /// The pose of no scan is known.
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
    /// The log already has such poses.
    #[error("this recording is mapped with the poses of another file already")]
    Twice,
}

/// Where a robot was, from a file of poses.
#[derive(Clone, Debug, PartialEq)]
pub struct PoseTrack {
    /// In rising order of time; at least one.
    poses: Vec<(f64, Pose2)>,
}

impl PoseTrack {
    /// From times and poses, rising; at least one.
    #[must_use]
    pub fn poses(&self) -> &[(f64, Pose2)] {
        &self.poses
    }

    /// The pose at a time, s; `None` before the first, after the last, and where two are too far
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

    /// The poses between two times, excluding both.
    pub(super) fn between(&self, from: f64, to: f64) -> &[(f64, Pose2)] {
        let begin = self.poses.partition_point(|(time, _)| *time <= from);
        let end = self.poses.partition_point(|(time, _)| *time < to);
        self.poses.get(begin..end).unwrap_or(&[])
    }

    /// How many of these scans it covers, by their times, s.
    ///
    /// # Errors    [`PosesMisfit::NoScan`]: none at all.
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

/// How many scans of a log the poses cover.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Coverage {
    scans: usize,
    untold: usize,
    /// Time of the first scan that they do not cover, s.
    first: Option<f64>,
}

impl Coverage {
    /// A sentence if some are not covered; `so` says what follows from it.
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

//! Finds the pose of a trajectory for a stamp from another file.
//!
//! In: a trajectory stamped in seconds, and the stamps of a reference, which may be written with
//! fewer decimals than those of the log. Out: the pose at a stamp, if the trajectory has it.

use crate::geom::Pose2;

/// How far apart two stamps of the same scan may be, s, beside their rounding: seconds since 1970
/// are represented to a quarter of a microsecond.
const SAME_STAMP: f64 = 1e-6;
/// The most decimals with which stamps are written.
const MOST_DECIMALS: i32 = 6;

/// The poses of a trajectory, by the stamps of a reference.
#[derive(Clone, Copy, Debug)]
pub struct PosesByStamp<'a> {
    trajectory: &'a [(f64, Pose2)],
    same: f64,
}

impl<'a> PosesByStamp<'a> {
    /// For a trajectory sorted by stamp. `stamps` are all those of the reference, s: they show how
    /// far they are rounded.
    #[must_use]
    pub fn new(
        trajectory: &'a [(f64, Pose2)],
        stamps: &(impl Iterator<Item = f64> + Clone),
    ) -> Self {
        let same = rounding(stamps) + SAME_STAMP;
        Self { trajectory, same }
    }

    /// The pose at a stamp, s; `None` if the trajectory has none.
    #[must_use]
    pub fn at(&self, seconds: f64) -> Option<Pose2> {
        let after = self
            .trajectory
            .partition_point(|&(stamp, _)| stamp < seconds);
        let near = self.trajectory.iter().skip(after.saturating_sub(1)).take(2);
        let off = |stamp: f64| (stamp - seconds).abs();
        let (stamp, pose) = near.min_by(|a, b| off(a.0).total_cmp(&off(b.0)))?;
        (off(*stamp) <= self.same).then_some(*pose)
    }
}

/// One unit of the last decimal that any of the stamps has, s: they are rounded or truncated there.
fn rounding(stamps: &(impl Iterator<Item = f64> + Clone)) -> f64 {
    let has = |decimals: i32| {
        let unit = libm::pow(10.0, f64::from(-decimals));
        let mut rest = stamps
            .clone()
            .map(|s| (s / unit - (s / unit).round()).abs() * unit);
        rest.all(|rest| rest < SAME_STAMP)
    };
    let decimals = (0..MOST_DECIMALS)
        .find(|&d| has(d))
        .unwrap_or(MOST_DECIMALS);
    libm::pow(10.0, f64::from(-decimals))
}

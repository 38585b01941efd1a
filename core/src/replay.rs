//! A recorded log through the same SLAM that drives a robot.
//!
//! In: a [`CarmenLog`]. Out: scan by scan, the pose, the trajectory and the map.
//!
//! The odometry that stands in each laser message is turned into motions between scans, with the noise of a Pioneer.

use crate::estimation::{ScanMatcher, ScanMatcherConfig, ScanMatcherError};
use crate::format::carmen::CarmenLog;
use crate::geom::{Pose2, PoseEstimate};
use crate::hash::StateHash;
use crate::map::Grid;
use crate::robot::{Odometry, RobotModel, Stamp, Tracks};

/// How a log is replayed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReplayMethod {
    /// Odometry as recorded, nothing else: the yardstick.
    Odometry,
    /// Scan matching to submaps.
    ScanMatching,
}

/// A log that is being replayed.
#[derive(Clone, Debug)]
pub struct Replay {
    log: CarmenLog,
    method: ReplayMethod,
    robot: RobotModel,
    next: usize,
    matcher: ScanMatcher,
}

impl ReplayMethod {
    /// All methods with their names.
    pub const ALL: [(&'static str, Self); 2] = [
        ("odometry", Self::Odometry),
        ("scan-matching", Self::ScanMatching),
    ];

    /// The method of a name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL
            .into_iter()
            .find(|(n, _)| *n == name)
            .map(|(_, method)| method)
    }
}

impl Replay {
    /// Begins at the first scan.
    ///
    /// # Errors   [`ScanMatcherError`] for a configuration out of range.
    pub fn new(
        log: CarmenLog,
        method: ReplayMethod,
        config: ScanMatcherConfig,
    ) -> Result<Self, ScanMatcherError> {
        Ok(Self {
            log,
            method,
            robot: RobotModel::pioneer(),
            next: 0,
            matcher: ScanMatcher::new(config)?,
        })
    }

    /// Takes the next scan; `false` when there is none left, and then all work that was put off is done.
    pub fn step(&mut self) -> bool {
        let Some(scan) = self.log.scans.get(self.next) else {
            self.matcher.finish();
            return false;
        };
        let stamp = self.log.stamp(scan);
        if let Some(last) = self
            .next
            .checked_sub(1)
            .and_then(|last| self.log.scans.get(last))
        {
            let motion = last.odom_from_robot.delta_to(&scan.odom_from_robot);
            self.matcher.odometry(&recorded_odometry(
                &self.robot,
                self.log.stamp(last),
                stamp,
                motion,
            ));
        }
        if self.method == ReplayMethod::ScanMatching {
            self.matcher.scan(&self.log.scan(scan));
        }
        self.next += 1;
        true
    }

    /// The part that is done, 0 to 1.
    #[must_use]
    pub fn progress(&self) -> f64 {
        self.next as f64 / self.log.scans.len().max(1) as f64
    }

    /// Scans taken so far.
    #[must_use]
    pub fn scans_done(&self) -> usize {
        self.next
    }

    /// The log.
    #[must_use]
    pub fn log(&self) -> &CarmenLog {
        &self.log
    }

    /// What does the work.
    #[must_use]
    pub fn matcher(&self) -> &ScanMatcher {
        &self.matcher
    }

    /// The map. Raw odometry draws none.
    #[must_use]
    pub fn grid(&self) -> &Grid {
        self.matcher.grid()
    }

    /// The pose at the last scan; the map's frame begins at the first.
    #[must_use]
    pub fn estimate(&self) -> PoseEstimate {
        match self.method {
            ReplayMethod::ScanMatching => self.matcher.estimate(),
            ReplayMethod::Odometry => {
                let last = self
                    .next
                    .checked_sub(1)
                    .and_then(|last| self.log.scans.get(last));
                PoseEstimate::exact(last.map_or_else(Pose2::identity, |s| {
                    self.map_from_odom() * s.odom_from_robot
                }))
            }
        }
    }

    /// The pose of the robot's base at each scan taken so far, with the `ipc_timestamp`, as known now.
    #[must_use]
    pub fn trajectory(&self) -> Vec<(f64, Pose2)> {
        let scans = self.log.scans.iter().take(self.next);
        match self.method {
            ReplayMethod::Odometry => {
                let map_from_odom = self.map_from_odom();
                scans
                    .map(|s| (s.ipc_seconds, map_from_odom * s.odom_from_robot))
                    .collect()
            }
            ReplayMethod::ScanMatching => scans
                .zip(self.matcher.trajectory())
                .map(|(scan, (_, pose))| (scan.ipc_seconds, pose))
                .collect(),
        }
    }

    /// The hash of the whole trajectory: equal bits natively and in the browser.
    #[must_use]
    pub fn state_hash(&self) -> u64 {
        let mut hash = StateHash::new();
        for (seconds, pose) in self.trajectory() {
            hash.number(seconds).pose(&pose);
        }
        hash.finish()
    }

    fn map_from_odom(&self) -> Pose2 {
        self.log
            .scans
            .first()
            .map_or_else(Pose2::identity, |s| s.odom_from_robot.inverse())
    }
}

/// A recorded motion with the covariance that the robot's model gives to the tracks that made it.
fn recorded_odometry(robot: &RobotModel, from: Stamp, to: Stamp, motion: Pose2) -> Odometry {
    let turn = 0.5 * motion.heading() * robot.track_width;
    let tracks = Tracks {
        left: motion.x() - turn,
        right: motion.x() + turn,
    };
    Odometry {
        from,
        to,
        motion,
        cov: tracks.covariance(robot.track_width, &robot.odometry_noise),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimation::relation_errors;
    use crate::format::{recorded, relations};

    /// A robot that drives 2 m along a room of 8 m x 4 m, its laser 0.1 m ahead of its centre.
    fn small_log() -> CarmenLog {
        let mut text = String::new();
        for i in 0..40 {
            let x = 0.05 * f64::from(i);
            let laser = x + 0.1;
            text += "FLASER 180";
            for beam in 0..180 {
                let (sin, cos) = crate::geom::sin_cos((f64::from(beam) - 90.0).to_radians());
                let ahead = if cos > 1e-9 {
                    (5.0 - laser) / cos
                } else {
                    f64::INFINITY
                };
                let side = if sin.abs() > 1e-9 {
                    2.0 / sin.abs()
                } else {
                    f64::INFINITY
                };
                text += &format!(" {:.3}", ahead.min(side));
            }
            // Odometry claims a tenth too much.
            let (o, l) = (1.1 * x, 1.1 * x + 0.1);
            text += &format!(" {l} 0 0 {o} 0 0 {}.5 host 0\n", 100 + i);
        }
        CarmenLog::parse(text.as_bytes()).unwrap()
    }

    fn replay(log: CarmenLog, method: ReplayMethod) -> Replay {
        let mut replay = Replay::new(log, method, ScanMatcherConfig::default()).unwrap();
        while replay.step() {}
        replay
    }

    #[test]
    fn matching_finds_the_way_of_the_base_where_odometry_is_wrong() {
        let matched = replay(small_log(), ReplayMethod::ScanMatching);
        let trajectory = matched.trajectory();
        assert_eq!((trajectory.len(), matched.progress()), (40, 1.0));
        assert!((trajectory[39].0 - 139.5).abs() < 1e-9);
        assert!(
            (trajectory[39].1.x() - 1.95).abs() < 0.02,
            "{:?}",
            trajectory[39]
        );
        assert!(trajectory[39].1.y().abs() < 0.01);
        let raw = replay(small_log(), ReplayMethod::Odometry);
        assert!((raw.estimate().pose.x() - 1.1 * 1.95).abs() < 1e-6);
        assert_ne!(raw.state_hash(), matched.state_hash());
    }

    #[test]
    fn methods_are_found_by_name() {
        assert_eq!(
            ReplayMethod::from_name("odometry"),
            Some(ReplayMethod::Odometry)
        );
        assert_eq!(ReplayMethod::from_name("teleport"), None);
    }

    /// The buildings that others are measured on, with the same parameters for all.
    #[test]
    fn recorded_buildings_are_mapped_as_well_as_published() {
        for (name, all, long) in [("intel", 0.025, 0.035), ("fr079", 0.06, 0.09)] {
            let (Some(log), Some(truth)) = (
                recorded(&format!("{name}/{name}.clf")),
                recorded(&format!("{name}/{name}.relations")),
            ) else {
                continue;
            };
            let done = replay(CarmenLog::parse(&log).unwrap(), ReplayMethod::ScanMatching);
            let trajectory = done.trajectory();
            let truth = relations::parse(&truth).unwrap();
            let error = |least: f64| {
                let chosen = truth
                    .iter()
                    .filter(|r| (r.to_seconds - r.from_seconds).abs() >= least)
                    .map(|r| (r.from_seconds, r.to_seconds, r.motion));
                relation_errors(chosen, &trajectory)
            };
            assert_eq!(error(0.0).count, truth.len());
            assert!(error(0.0).trans_abs_mean < all, "{name}: {:?}", error(0.0));
            assert!(
                error(20.0).trans_abs_mean < long,
                "{name}: {:?}",
                error(20.0)
            );
        }
    }
}

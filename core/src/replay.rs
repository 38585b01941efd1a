//! A recorded log through the same SLAM that drives a robot.
//!
//! In: a [`CarmenLog`]. Out: scan by scan, the pose, the trajectory and the map.
//!
//! The odometry that stands in each laser message is turned into motions between scans, with the noise of a Pioneer.

use crate::estimation::ConsistencyWindow;
use crate::format::carmen::{CarmenLog, CarmenScan};
use crate::geom::Pose2;
use crate::hash::StateHash;
use crate::robot::{Odometry, RobotModel, Scan, Stamp, Tracks};
use crate::slam::{Method, Slam, SlamConfig, SlamError};

/// Motion between two scans that counts as none, m and rad: less than what logs are rounded to.
const STILL: f64 = 1e-4;

/// A log that is being replayed.
#[derive(Clone, Debug)]
pub struct Replay {
    log: CarmenLog,
    robot: RobotModel,
    next: usize,
    /// `ipc_timestamp` of each scan that was used, as many as the trajectory has poses.
    used: Vec<f64>,
    slam: Slam,
    consistency: ConsistencyWindow,
}

impl Replay {
    /// Begins at the first scan.
    ///
    /// # Errors   [`SlamError`] for a setting out of range.
    pub fn new(log: CarmenLog, method: Method, config: SlamConfig) -> Result<Self, SlamError> {
        Ok(Self {
            log,
            robot: RobotModel::pioneer(),
            next: 0,
            used: vec![],
            slam: Slam::new(method, config)?,
            consistency: ConsistencyWindow::default(),
        })
    }

    /// Takes the next scan; `false` when there is none left, and then all work that was put off is done.
    ///
    /// # Errors   [`SlamError`] for a scan that cannot be used; it is passed over by the next call.
    pub fn step(&mut self) -> Result<bool, SlamError> {
        let Some(scan) = self.log.scans.get(self.next) else {
            self.slam.finish();
            return Ok(false);
        };
        let stamp = self.log.stamp(scan);
        let last = self.last();
        let odometry = last.map_or(Odometry::standing(stamp), |last| {
            let motion = last.odom_from_robot.delta_to(&scan.odom_from_robot);
            recorded_odometry(&self.robot, self.log.stamp(last), stamp, motion)
        });
        let (seconds, scan) = (scan.ipc_seconds, self.log.scan(scan));
        self.next += 1;
        self.slam.odometry(&odometry)?;
        self.slam.scan(&scan)?;
        self.used.push(seconds);
        if let Some(report) = self.slam.explain() {
            self.consistency
                .push(None, report.nis, report.nis_degrees());
        }
        Ok(true)
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

    /// The scan taken last.
    #[must_use]
    pub fn last(&self) -> Option<&CarmenScan> {
        self.next
            .checked_sub(1)
            .and_then(|last| self.log.scans.get(last))
    }

    /// The log.
    #[must_use]
    pub fn log(&self) -> &CarmenLog {
        &self.log
    }

    /// Stretches of scans during which the odometry stood still, three scans or more.
    #[must_use]
    pub fn standing_stretches(&self) -> Vec<Vec<Scan>> {
        let scans = &self.log.scans;
        let stands = |a: &CarmenScan, b: &CarmenScan| {
            let motion = a.odom_from_robot.delta_to(&b.odom_from_robot);
            motion.position().coords.norm() < STILL && motion.heading().abs() < STILL
        };
        scans
            .chunk_by(stands)
            .filter(|stretch| stretch.len() >= 3)
            .map(|stretch| stretch.iter().map(|scan| self.log.scan(scan)).collect())
            .collect()
    }

    /// What does the work.
    #[must_use]
    pub fn slam(&self) -> &Slam {
        &self.slam
    }

    /// Whether the innovations of the last scans were as large as claimed; empty for methods without a line map.
    #[must_use]
    pub fn consistency(&self) -> &ConsistencyWindow {
        &self.consistency
    }

    /// The pose by odometry alone at the last scan; the map's frame begins at the first.
    #[must_use]
    pub fn odometry_pose(&self) -> Pose2 {
        self.last().map_or_else(Pose2::identity, |scan| {
            self.map_from_odom() * scan.odom_from_robot
        })
    }

    /// The motion that takes the log's odometry frame to the map's.
    #[must_use]
    pub fn map_from_odom(&self) -> Pose2 {
        let first = self.log.scans.first();
        first.map_or_else(Pose2::identity, |scan| scan.odom_from_robot.inverse())
    }

    /// The pose of the robot's base at each scan used so far, with the `ipc_timestamp`, as known now.
    #[must_use]
    pub fn trajectory(&self) -> Vec<(f64, Pose2)> {
        let used = self.used.iter();
        used.zip(self.slam.trajectory())
            .map(|(&seconds, (_, pose))| (seconds, pose))
            .collect()
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

    fn replay(log: CarmenLog, method: Method) -> Replay {
        let mut replay = Replay::new(log, method, SlamConfig::default()).unwrap();
        while replay.step().unwrap() {}
        replay
    }

    #[test]
    fn matching_finds_the_way_of_the_base_where_odometry_is_wrong() {
        let matched = replay(small_log(), Method::ScanMatching);
        let trajectory = matched.trajectory();
        assert_eq!((trajectory.len(), matched.progress()), (40, 1.0));
        assert!((trajectory[39].0 - 139.5).abs() < 1e-9);
        assert!(
            (trajectory[39].1.x() - 1.95).abs() < 0.02,
            "{:?}",
            trajectory[39]
        );
        assert!(trajectory[39].1.y().abs() < 0.01);
        let raw = replay(small_log(), Method::Odometry);
        assert!((raw.odometry_pose().x() - 1.1 * 1.95).abs() < 1e-6);
        assert!((raw.trajectory()[39].1.x() - 1.1 * 1.95).abs() < 1e-6);
        assert_ne!(raw.state_hash(), matched.state_hash());
    }

    #[test]
    fn stretches_are_where_the_odometry_stood() {
        let mut log = small_log();
        assert!(
            replay(log.clone(), Method::Odometry)
                .standing_stretches()
                .is_empty()
        );
        for scans in [10..14, 20..22, 30..37] {
            let stands = log.scans[scans.start].odom_from_robot;
            for scan in &mut log.scans[scans] {
                scan.odom_from_robot = stands;
            }
        }
        let stretches = replay(log, Method::Odometry).standing_stretches();
        let lengths: Vec<usize> = stretches.iter().map(Vec::len).collect();
        assert_eq!(lengths, [4, 7]);
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
            let done = replay(CarmenLog::parse(&log).unwrap(), Method::ScanMatching);
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

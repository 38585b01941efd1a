//! From a log to the input of SLAM: scan by scan, with the motions that led to it.

use std::collections::VecDeque;

use super::log::Log;
use super::posed_log::{Moved, PosedLog};
use crate::format::carmen::CarmenLog;
use crate::format::ranger_log::RangerLog;
use crate::format::revolution_log::RevolutionLog;
use crate::format::rover_log::RoverLog;
use crate::geom::Pose2;
use crate::robot::{Odometry, RobotModel, Scan, Stamp, TrackOdometry, Tracks};
use crate::settings::LogSettings;
use crate::wire::recording::{Recorded, Recording, Said};
use crate::wire::timeline::{Reading, Timeline, explain_gap};

/// A scan, and the motions that led to it.
#[derive(Debug)]
pub(super) struct Step {
    /// In order; each continues the one before.
    pub(super) odometry: Vec<Odometry>,
    pub(super) scan: Scan,
    /// Whether time was missed on the way to it.
    pub(super) is_after_gap: bool,
    /// Time of the scan as the log counts it, s.
    pub(super) seconds: f64,
    /// The pose by odometry alone.
    pub(super) odom_from_robot: Pose2,
}

/// How far a log has been read.
#[derive(Clone, Debug, Default)]
pub(super) struct Feed {
    /// Index of the next message of a recording, or of the next scan of other logs.
    next: usize,
    /// Figures that the log itself does not contain.
    figures: LogSettings,
    has_robot: bool,
    /// Whether the log's own robot gives the motion; otherwise poses of another file do.
    hears_robot: bool,
    /// For a log with such poses, the last scan taken.
    moved: Option<Moved>,
    timeline: Timeline,
    /// Encoder counts of a rover's log.
    tracks: Option<TrackOdometry>,
    readings: VecDeque<Reading>,
    odom_from_robot: Pose2,
    /// Messages for people; the caller empties the list.
    pub(super) notes: Vec<String>,
    unreadable: usize,
}

/// Unreadable messages that are reported one by one; of further ones, only the number.
const MOST_REPORTED: usize = 3;

impl Feed {
    pub(super) fn of(log: &Log, figures: &LogSettings) -> Self {
        let has_robot = figures.uses_odometry && log.has_odometry();
        Self {
            figures: *figures,
            has_robot,
            hears_robot: has_robot && !matches!(log, Log::Posed(_)),
            ..Self::default()
        }
    }

    /// Whether a robot reports its motion, and the reports are used.
    pub(super) fn has_robot(&self) -> bool {
        self.has_robot
    }

    /// The next scan; `None` after the last.
    pub(super) fn next(&mut self, log: &Log, robot: &RobotModel) -> Option<Step> {
        let mut step = match log {
            Log::Recording(recording) => return self.step(recording),
            Log::Posed(posed) => return self.posed_step(posed, robot),
            Log::Carmen(log) => carmen_step(log, self.next, robot)?,
            Log::Rover(log) => self.rover_step(log, robot)?,
            Log::Rangers(log) => ranger_step(log, self.next, robot, self.figures.ranger_reach)?,
            Log::Revolutions(log) => revolution_step(log, self.next, self.figures.revolution_rate)?,
        };
        if !self.hears_robot {
            step.odometry.clear();
        }
        self.next += 1;
        Some(step)
    }

    /// Scans or messages read so far.
    pub(super) fn position(&self) -> usize {
        self.next
    }

    pub(super) fn progress(&self, log: &Log) -> f64 {
        let all = match log {
            Log::Posed(posed) => return self.progress(posed.log()),
            Log::Recording(recording) => recording.len(),
            others => others.scans(),
        };
        self.next as f64 / all.max(1) as f64
    }
}

fn carmen_step(log: &CarmenLog, index: usize, robot: &RobotModel) -> Option<Step> {
    let scan = log.scans.get(index)?;
    let stamp = log.stamp(scan);
    let last = index.checked_sub(1).and_then(|last| log.scans.get(last));
    let odometry = last.map_or(Odometry::standing(stamp), |last| {
        let motion = last.odom_from_robot.delta_to(&scan.odom_from_robot);
        recorded_odometry(robot, log.stamp(last), stamp, motion)
    });
    Some(Step {
        odometry: vec![odometry],
        is_after_gap: false,
        seconds: scan.ipc_seconds,
        odom_from_robot: scan.odom_from_robot,
        scan: log.scan(scan),
    })
}

fn ranger_step(log: &RangerLog, index: usize, robot: &RobotModel, reach: f64) -> Option<Step> {
    let scan = log.scans.get(index)?;
    let stamp = log.stamp(scan);
    let last = index.checked_sub(1).and_then(|last| log.scans.get(last));
    let odometry = last.map_or(Odometry::standing(stamp), |last| {
        let motion = last.odom_from_robot.delta_to(&scan.odom_from_robot);
        recorded_odometry(robot, log.stamp(last), stamp, motion)
    });
    Some(Step {
        odometry: vec![odometry],
        is_after_gap: false,
        seconds: scan.seconds,
        odom_from_robot: scan.odom_from_robot,
        scan: log.scan(scan, reach),
    })
}

/// A lidar alone: nothing shows how it was carried.
fn revolution_step(log: &RevolutionLog, index: usize, rate: f64) -> Option<Step> {
    let scan = log.scan(index, rate)?;
    Some(Step {
        odometry: vec![],
        is_after_gap: false,
        seconds: scan.stamp.seconds(),
        odom_from_robot: Pose2::identity(),
        scan,
    })
}

/// A recorded motion with the covariance that the robot's model gives to the track distances that
/// made it.
pub(super) fn recorded_odometry(
    robot: &RobotModel,
    from: Stamp,
    to: Stamp,
    motion: Pose2,
) -> Odometry {
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

impl Feed {
    fn rover_step(&mut self, log: &RoverLog, robot: &RobotModel) -> Option<Step> {
        let line = log.scans.get(self.next)?;
        let tracks = self.tracks.get_or_insert_with(|| TrackOdometry::new(robot));
        let odometry = tracks.update(line.stamp(), line.counts);
        self.odom_from_robot = self.odom_from_robot * odometry.motion;
        Some(Step {
            odometry: vec![odometry],
            is_after_gap: false,
            seconds: line.seconds(),
            odom_from_robot: self.odom_from_robot,
            scan: log.scan(self.next)?,
        })
    }

    /// The next scan that the poses cover; if the poses are not to be used, the next scan.
    fn posed_step(&mut self, posed: &PosedLog, robot: &RobotModel) -> Option<Step> {
        loop {
            let step = self.next(posed.log(), robot)?;
            if !self.has_robot {
                return Some(step);
            }
            let moved = posed.moved(step, &mut self.moved, robot);
            if moved.is_some() {
                return moved;
            }
        }
    }

    fn step(&mut self, recording: &Recording) -> Option<Step> {
        let mut odometry = vec![];
        let mut is_after_gap = false;
        loop {
            match self.readings.pop_front() {
                Some(Reading::Odometry(motion)) => {
                    self.odom_from_robot = self.odom_from_robot * motion.motion;
                    odometry.push(motion);
                }
                Some(Reading::Gap { seconds }) => {
                    is_after_gap = true;
                    self.notes.push(explain_gap(seconds));
                }
                // Partial scans only saw people in the robot's way; the map does not need them.
                Some(Reading::PartialScan(_)) => {}
                Some(Reading::Scan(scan)) => {
                    return Some(Step {
                        odometry,
                        is_after_gap,
                        seconds: scan.stamp.seconds(),
                        odom_from_robot: self.odom_from_robot,
                        scan,
                    });
                }
                None => {
                    let Some(message) = recording.message(self.next) else {
                        self.sum_up();
                        return None;
                    };
                    self.next += 1;
                    match message {
                        Ok(recorded) => self.take(recorded),
                        Err(damage) => self.left_out(damage.to_string()),
                    }
                }
            }
        }
    }

    fn take(&mut self, Recorded { header, said, .. }: Recorded) {
        let Said::ByBridge(message) = said else {
            return;
        };
        let hears_robot = self.hears_robot;
        match self.timeline.message(header.micros, &message, hears_robot) {
            Some(Ok(readings)) => self.readings.extend(readings),
            Some(Err(error)) => self.left_out(format!("A reading was left out: {error}")),
            None => {}
        }
    }

    fn left_out(&mut self, why: String) {
        self.unreadable += 1;
        if self.unreadable <= MOST_REPORTED {
            self.notes.push(why);
        }
    }

    fn sum_up(&mut self) {
        let more = std::mem::take(&mut self.unreadable).saturating_sub(MOST_REPORTED);
        if more > 0 {
            self.notes
                .push(format!("{more} more messages could not be read"));
        }
    }
}

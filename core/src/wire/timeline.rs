//! One clock for the readings of several devices, and a report of every gap.
//!
//! In: odometry and scans as they arrive, with the bridge's time. Out: the same in an order that
//! SLAM can use: motions without gaps, and each scan once the motion up to its last beam is known.
//! Data of a live bridge and of a recording both pass through here.
//!
//! 1. The robot's clock is the reference. A bridge puts the devices at its ports on one clock. Any
//!    other source has its own: the difference of two clocks is that of their offsets from the
//!    bridge's ([`ClockMap`]). A small difference comes from delays, not from clocks
//!    (`SAME_CLOCK`).
//! 2. A robot whose clock restarts was reset, and during a gap in time nobody watched it. In both
//!    cases it may have been moved meanwhile, so the gap becomes a motion of zero with a large
//!    covariance (`GAP_SIGMA`).
//! 3. Without a robot, the motion between two scans is zero, and as uncertain as a hand or a foot
//!    may move a sensor.
//! 4. Partial scans come from the robot itself; they wait for motion as whole scans do.

use std::collections::BTreeMap;
use std::collections::VecDeque;

use nalgebra::{Matrix3, Vector3};

use super::ClockMap;
use super::message::FromBridge;
use crate::geom::Pose2;
use crate::robot::{Odometry, Scan, Stamp};

/// How far a robot may have moved in an unwatched gap, σ: m, m, rad.
const GAP_SIGMA: [f64; 3] = [0.2, 0.2, 0.3];
/// How fast a sensor without wheels may move, σ: m/s, m/s, rad/s.
const CARRIED_SIGMA: [f64; 3] = [0.5, 0.5, 0.8];
/// Two clocks that differ by less count as one, s: delays on two wires differ by some milliseconds.
const SAME_CLOCK: f64 = 0.2;
/// Scans that may wait for motion; older ones are dropped.
const MOST_WAITING: usize = 4;
/// A scan older than the motion by more than this dates from before a restart of its device, s.
const OLDEST: f64 = 2.0;

/// Readings that may be passed on now.
#[derive(Clone, Debug, PartialEq)]
pub enum Reading {
    /// Begins where the one before ended.
    Odometry(Odometry),
    /// No later than the end of the newest odometry.
    Scan(Scan),
    /// The same, of a robot on the move; not for the map.
    PartialScan(Scan),
    /// Motion is missing before this.
    Gap {
        /// Duration of the gap, s; 0 if the robot's clock restarted.
        seconds: f64,
    },
}

/// A gap in words for a person.
#[must_use]
pub fn explain_gap(seconds: f64) -> String {
    if seconds > 0.0 {
        format!("{seconds:.1} s of the robot's motion were missed: the pose is less sure now")
    } else {
        "The robot or its sensor was restarted: it may stand elsewhere now".to_owned()
    }
}

/// A source's clock relative to the bridge's, and its newest stamp.
#[derive(Clone, Debug, Default)]
struct SourceClock {
    map: ClockMap,
    said: Stamp,
}

/// See the module.
#[derive(Clone, Debug, Default)]
pub struct Timeline {
    /// Number of the source whose odometry is used.
    robot: Option<u8>,
    /// Each source's clock relative to the bridge's.
    clocks: BTreeMap<u8, SourceClock>,
    /// Added to the robot's stamps: the time that its clock lost by restarting, µs.
    shift: u64,
    newest: Option<Stamp>,
    waiting: VecDeque<Scan>,
    waiting_partial: VecDeque<Scan>,
}

impl Timeline {
    /// Takes a message of odometry or a scan that arrived at bridge time `arrived`, µs; `None` for
    /// any other message. `has_robot` as for [`Self::scan`].
    ///
    /// # Errors    A sentence about an invalid reading.
    pub fn message(
        &mut self,
        arrived: u64,
        message: &FromBridge,
        has_robot: bool,
    ) -> Option<Result<Vec<Reading>, String>> {
        let readings = match message {
            FromBridge::Odometry(body) => body
                .odometry()
                .map(|motion| self.odometry(body.source, arrived, motion))
                .map_err(|error| error.to_string()),
            FromBridge::Scan(body) => (body.clone().scan())
                .map(|scan| self.scan(body.source, arrived, scan, has_robot))
                .map_err(|error| error.to_string()),
            FromBridge::PartialScan(body) => (body.clone().scan())
                .map(|scan| self.partial_scan(body.source, scan))
                .map_err(|error| error.to_string()),
            _ => return None,
        };
        Some(readings)
    }

    /// Takes a motion of source `source` that arrived at bridge time `arrived`, µs.
    pub fn odometry(&mut self, source: u8, arrived: u64, odometry: Odometry) -> Vec<Reading> {
        if *self.robot.get_or_insert(source) != source {
            return vec![];
        }
        let mut out = vec![];
        let newest = self.newest.unwrap_or(odometry.from);
        let from = Stamp(odometry.from.0.saturating_add(self.shift));
        if from < newest {
            self.shift = newest.0.saturating_sub(odometry.from.0);
            self.clocks.clear();
            self.waiting.clear();
            self.waiting_partial.clear();
            out.push(Reading::Gap { seconds: 0.0 });
            out.push(Reading::Odometry(unsure(newest, newest, GAP_SIGMA)));
        } else if from > newest {
            let seconds = from.since(newest);
            out.push(Reading::Gap { seconds });
            out.push(Reading::Odometry(unsure(newest, from, GAP_SIGMA)));
        }
        self.note_clock(source, arrived, odometry.to);
        let to = Stamp(odometry.to.0.saturating_add(self.shift));
        let from = Stamp(odometry.from.0.saturating_add(self.shift));
        self.newest = Some(to);
        out.push(Reading::Odometry(Odometry {
            from,
            to,
            ..odometry
        }));
        self.let_through(&mut out);
        out
    }

    /// Takes a scan of source `source` that arrived at bridge time `arrived`, µs. `has_robot`:
    /// whether to expect odometry; once some was heard, it is expected anyway.
    pub fn scan(
        &mut self,
        source: u8,
        arrived: u64,
        mut scan: Scan,
        has_robot: bool,
    ) -> Vec<Reading> {
        let mut out = vec![];
        self.note_clock(source, arrived, scan.stamp);
        if !has_robot && self.robot.is_none() {
            let newest = self.newest.unwrap_or(scan.stamp);
            if scan.stamp < newest {
                // The sensor was reset; time continues from its new clock.
                self.newest = None;
                out.push(Reading::Gap { seconds: 0.0 });
                return out;
            }
            let sigma = CARRIED_SIGMA.map(|s| s * scan.stamp.since(newest));
            out.push(Reading::Odometry(unsure(newest, scan.stamp, sigma)));
            self.newest = Some(scan.stamp);
            out.push(Reading::Scan(scan));
            return out;
        }
        let Some(stamp) = self.on_robots_clock(source, scan.stamp) else {
            return out;
        };
        scan.stamp = stamp;
        put(&mut self.waiting, scan);
        self.let_through(&mut out);
        out
    }

    /// Takes a partial scan of source `source`; one before any motion of the robot is dropped.
    pub fn partial_scan(&mut self, source: u8, mut scan: Scan) -> Vec<Reading> {
        let mut out = vec![];
        if let Some(stamp) = self.on_robots_clock(source, scan.stamp) {
            scan.stamp = stamp;
            put(&mut self.waiting_partial, scan);
            self.let_through(&mut out);
        }
        out
    }

    fn note_clock(&mut self, source: u8, arrived: u64, said: Stamp) {
        let fresh = SourceClock::default;
        let clock = self.clocks.entry(source).or_insert_with(fresh);
        if said < clock.said {
            *clock = fresh();
        }
        clock.said = said;
        clock.map.observe(said, Stamp(arrived));
    }

    /// `None` until the robot was heard.
    fn on_robots_clock(&self, source: u8, stamp: Stamp) -> Option<Stamp> {
        let offset = |source: u8| self.clocks.get(&source)?.map.offset();
        let mut ahead = offset(source)? - offset(self.robot?)?;
        if ahead.abs() < SAME_CLOCK {
            ahead = 0.0;
        }
        let shifted = stamp.0.saturating_add(self.shift) as i64;
        let ahead = (ahead * 1e6).round() as i64;
        Some(Stamp(shifted.saturating_add(ahead).max(0) as u64))
    }

    fn let_through(&mut self, out: &mut Vec<Reading>) {
        let Some(newest) = self.newest else { return };
        let waiting = [
            (&mut self.waiting, Reading::Scan as fn(Scan) -> Reading),
            (&mut self.waiting_partial, Reading::PartialScan),
        ];
        for (scans, reading) in waiting {
            while let Some(scan) = scans.pop_front_if(|scan| scan.stamp <= newest) {
                if newest.since(scan.stamp) < OLDEST {
                    out.push(reading(scan));
                }
            }
        }
    }
}

fn put(waiting: &mut VecDeque<Scan>, scan: Scan) {
    waiting.push_back(scan);
    while waiting.len() > MOST_WAITING {
        waiting.pop_front();
    }
}

fn unsure(from: Stamp, to: Stamp, sigma: [f64; 3]) -> Odometry {
    Odometry {
        from,
        to,
        motion: Pose2::identity(),
        cov: Matrix3::from_diagonal(&Vector3::from(sigma.map(|s| s * s))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROBOT: u8 = 0;
    const LIDAR: u8 = 1;

    fn motion(from: u64, to: u64) -> Odometry {
        Odometry {
            from: Stamp(from),
            to: Stamp(to),
            motion: Pose2::new(0.01, 0.0, 0.0),
            cov: Matrix3::identity() * 1e-6,
        }
    }

    fn scan(stamp: u64) -> Scan {
        Scan {
            stamp: Stamp(stamp),
            robot_from_sensor: Pose2::identity(),
            bearings: vec![0.0],
            ranges: vec![1.0],
            sigmas: vec![0.01],
            bearing_sigma: 0.0,
            max_range: 6.0,
            sweep: 0.0,
            qualities: vec![],
        }
    }

    fn stamps(readings: &[Reading]) -> Vec<u64> {
        let stamp = |reading: &Reading| match reading {
            Reading::Odometry(odometry) => Some(odometry.to.0),
            Reading::Scan(scan) | Reading::PartialScan(scan) => Some(scan.stamp.0),
            Reading::Gap { .. } => None,
        };
        readings.iter().filter_map(stamp).collect()
    }

    #[test]
    fn a_scan_waits_for_the_motion_up_to_its_last_beam() {
        let mut timeline = Timeline::default();
        timeline.odometry(ROBOT, 1_000, motion(0, 1_000));
        assert!(timeline.scan(ROBOT, 1_500, scan(1_500), true).is_empty());
        let readings = timeline.odometry(ROBOT, 2_000, motion(1_000, 2_000));
        assert_eq!(stamps(&readings), [2_000, 1_500]);
    }

    #[test]
    fn a_partial_scan_waits_too_and_is_none_for_the_map() {
        let mut timeline = Timeline::default();
        assert_eq!(timeline.partial_scan(ROBOT, scan(500)), [], "no motion yet");
        timeline.odometry(ROBOT, 1_000, motion(0, 1_000));
        assert_eq!(timeline.partial_scan(ROBOT, scan(1_500)), []);
        let readings = timeline.odometry(ROBOT, 2_000, motion(1_000, 2_000));
        assert_eq!(readings[1], Reading::PartialScan(scan(1_500)));
    }

    #[test]
    fn a_lidar_of_its_own_is_put_on_the_robots_clock() {
        let mut timeline = Timeline::default();
        // The robot started at bridge time 10 s, the lidar at 4 s; delays of 1 to 3 ms on both.
        let jitter = [3_000_u64, 1_000, 2_000, 1_000];
        let mut found = vec![];
        for (i, late) in jitter.into_iter().enumerate() {
            let at = 20_000_000 + 100_000 * i as u64;
            let from = at - 10_000_000 - 100_000;
            timeline.odometry(ROBOT, at + late, motion(from, from + 100_000));
            let lidar_late = jitter[3 - i];
            let out = timeline.scan(LIDAR, at + lidar_late, scan(at - 4_000_000), true);
            found.extend(
                stamps(&out)
                    .into_iter()
                    .map(|stamp| stamp as i64 - (at - 10_000_000) as i64),
            );
        }
        let worst = found.iter().map(|off| off.abs()).max().unwrap_or(i64::MAX);
        assert!(found.len() >= 2 && worst <= 2_000, "off by {found:?} us");
    }

    #[test]
    fn a_clock_that_runs_fast_or_slow_does_not_drift_away_in_hours() {
        // 100 ppm are 0.72 s in two hours, with one scan a second.
        for second_of_lidar in [999_900, 1_000_100] {
            let mut timeline = Timeline::default();
            let mut worst = 0;
            for second in 1..7200_u64 {
                let robot = 1_000_000 * second;
                let at = robot + 50_000_000;
                timeline.odometry(ROBOT, at, motion(robot - 1_000_000, robot));
                let said = 10_000_000 + second_of_lidar * second;
                for stamp in stamps(&timeline.scan(LIDAR, at, scan(said), true)) {
                    worst = worst.max(stamp.abs_diff(robot));
                }
            }
            // Two windows of 10 s at 100 µs/s.
            assert!(worst <= 2_500, "{worst} us");
        }
    }

    #[test]
    fn delays_that_differ_do_not_move_stamps_of_one_clock() {
        let mut timeline = Timeline::default();
        timeline.odometry(ROBOT, 1_020_000, motion(0, 1_000_000));
        let scans = timeline.scan(LIDAR, 1_000_500, scan(999_000), true);
        assert_eq!(stamps(&scans), [999_000]);
    }

    #[test]
    fn time_that_nobody_watched_and_a_clock_that_begins_anew_are_gaps_of_unsure_motion() {
        let mut timeline = Timeline::default();
        timeline.odometry(ROBOT, 1_000, motion(0, 1_000));
        let readings = timeline.odometry(ROBOT, 5_000, motion(4_000, 5_000));
        assert_eq!(readings[0], Reading::Gap { seconds: 0.003 });
        assert_eq!(stamps(&readings), [4_000, 5_000]);
        let readings = timeline.odometry(ROBOT, 9_000, motion(0, 500));
        assert_eq!(readings[0], Reading::Gap { seconds: 0.0 });
        assert_eq!(stamps(&readings), [5_000, 5_500]);
        let Reading::Odometry(gap) = &readings[1] else {
            panic!("{readings:?}");
        };
        assert!(gap.cov[(0, 0)] > 0.01 && gap.motion == Pose2::identity());
    }

    #[test]
    fn a_sensor_alone_moves_as_a_hand_may_move_it() {
        let mut timeline = Timeline::default();
        timeline.scan(LIDAR, 0, scan(1_000_000), false);
        let readings = timeline.scan(LIDAR, 0, scan(1_200_000), false);
        assert_eq!(stamps(&readings), [1_200_000, 1_200_000]);
        let Reading::Odometry(carried) = &readings[0] else {
            panic!("{readings:?}");
        };
        assert!((carried.cov[(0, 0)].sqrt() - 0.1).abs() < 1e-9);
    }
}

//! From the scans of a ROS driver to ours.
//!
//! 1. The stamp of a driver is that of the first beam, ours that of the last; `time_increment` is
//!    the time between two beams. It is negative for a driver that measures in reverse order.
//! 2. A range is a hit between `range_min` and `range_max`; nothing came back if it is larger or
//!    positive infinity; everything else (NaN, negative infinity, too near) is no measurement (REP
//!    117).
//! 3. The transform from robot to lidar is in space. The bearings of a lidar mounted upside down
//!    are reversed. A slightly tilted lidar measures walls too far away, by the cosine of the tilt,
//!    so beams are projected onto the floor. One that is tilted more sees floor and ceiling, and is
//!    refused.

use std::collections::BTreeMap;

use nalgebra::{Isometry3, Vector3};

use super::ImportError;
use crate::format::ros::{FrameTree, LaserScan, RosLog};
use crate::geom::{Pose2, sin_cos, wrap};
use crate::robot::{Scan, Stamp};

/// A larger tilt is refused, rad.
const MOST_TILT: f64 = 0.35;
/// A smaller tilt counts as none: transforms are rounded.
const LEVEL: f64 = 0.002;
/// A smaller tilt is not mentioned, rad.
const TOLD_TILT: f64 = 0.03;
/// No lidar sees farther, m: a larger `range_max` is no real limit.
const FARTHEST: f32 = 1000.0;
/// σ of a range if it is not given: its constant part, m, and its growth with the range.
const SIGMA: [f32; 2] = [0.01, 0.003];
/// A sweep longer than the time between scans, times this, is a mistake of the driver.
const LONGEST_SWEEP: f64 = 1.2;

/// The mounting of a lidar.
#[derive(Clone, Debug)]
struct Mount {
    robot_from_sensor: Pose2,
    base_from_sensor: Isometry3<f64>,
    is_level: bool,
    /// -1 if upside down.
    sign: f64,
}

/// Problems with scans, counted.
#[derive(Debug, Default)]
struct Faults {
    without_beams: usize,
    without_angles: usize,
    unplaced: usize,
    invalid: Option<(usize, String)>,
}

/// All scans in order of time, in the robot frame.
pub(super) fn scans(
    log: &RosLog,
    tree: &FrameTree,
    times: &[(u64, usize)],
    base: Option<usize>,
    notes: &mut Vec<String>,
) -> Result<Vec<Scan>, ImportError> {
    let all = times.iter();
    let all: Vec<(u64, usize, &LaserScan)> = all
        .filter_map(|&(time, index)| log.scans().get(index).map(|s| (time, s.frame, &s.scan)))
        .collect();
    let period = median_period(times);
    let farthest = farthest(&all);
    let (mut mounts, mut faults, mut out) = (BTreeMap::new(), Faults::default(), vec![]);
    let mut distrusted = false;
    for &(time, frame, scan) in &all {
        if let std::collections::btree_map::Entry::Vacant(entry) = mounts.entry(frame) {
            entry.insert(mount(log, tree, base, frame, notes)?);
        }
        let Some(Some(mount)) = mounts.get(&frame) else {
            faults.unplaced += 1;
            continue;
        };
        let beams = scan.ranges.len();
        if beams == 0 {
            faults.without_beams += 1;
            continue;
        }
        let Some(step) = step(scan) else {
            faults.without_angles += 1;
            continue;
        };
        let mut between = f64::from(scan.time_increment);
        let sweep = between.abs() * (beams - 1) as f64;
        if !sweep.is_finite() || sweep > LONGEST_SWEEP * period {
            (between, distrusted) = (0.0, true);
        }
        let scan = turned(scan, step, mount, farthest, time, between);
        match scan.validate() {
            Ok(()) => out.push(scan),
            Err(error) => {
                let invalid = faults.invalid.get_or_insert((0, error.to_string()));
                invalid.0 += 1;
            }
        }
    }
    if distrusted {
        notes.push(format!(
            "time_increment makes sweeps last longer than the {period:.3} s from one scan to the next: it is not believed, and all beams of a scan count as taken at once"
        ));
    }
    faults.tell(out.len(), all.len(), notes)?;
    // If scans overlap in time, the order of their ends counts.
    out.sort_by_key(|scan| scan.stamp);
    Ok(out)
}

/// The scan in our format.
fn turned(
    scan: &LaserScan,
    step: f64,
    mount: &Mount,
    farthest: f32,
    time: u64,
    between: f64,
) -> Scan {
    let beams = scan.ranges.len();
    let sweep = between.abs() * (beams - 1) as f64;
    let max_range = match scan.range_max {
        max if max > 0.0 && max < FARTHEST => max,
        _ => farthest,
    };
    let (mut bearings, mut ranges) = (Vec::with_capacity(beams), Vec::with_capacity(beams));
    for (i, &range) in scan.ranges.iter().enumerate() {
        let (bearing, part) = mount.beam(f64::from(scan.angle_min) + i as f64 * step);
        bearings.push(bearing);
        ranges.push(match range {
            range if range.is_nan() || range < scan.range_min || range <= 0.0 => f32::NAN,
            range if range >= max_range => f32::INFINITY,
            range => range * part as f32,
        });
    }
    if between < 0.0 {
        bearings.reverse();
        ranges.reverse();
    }
    let [constant, growing] = SIGMA;
    let sigma = |range: &f32| match range.is_finite() {
        true => constant + growing * range,
        false => constant,
    };
    Scan {
        stamp: Stamp((time + (sweep * 1e9) as u64) / 1000),
        robot_from_sensor: mount.robot_from_sensor,
        sigmas: ranges.iter().map(sigma).collect(),
        bearings,
        ranges,
        qualities: vec![],
        bearing_sigma: 0.25 * step.abs(),
        max_range: f64::from(max_range),
        sweep,
    }
}

impl Mount {
    /// Bearing in the plane of the robot, and the part of a range that lies in that plane.
    fn beam(&self, angle: f64) -> (f64, f64) {
        let level = self.sign * angle;
        if self.is_level {
            return (level, 1.0);
        }
        let (sin, cos) = sin_cos(angle);
        let ray = self.base_from_sensor.rotation * Vector3::new(cos, sin, 0.0);
        let heading = libm::atan2(ray.y, ray.x) - self.robot_from_sensor.heading();
        (level + wrap(heading - level), libm::hypot(ray.x, ray.y))
    }
}

/// `None` if the frames are unknown, while others of the same topic are known.
fn mount(
    log: &RosLog,
    tree: &FrameTree,
    base: Option<usize>,
    frame: usize,
    notes: &mut Vec<String>,
) -> Result<Option<Mount>, ImportError> {
    let base_from_sensor = match base {
        None => Isometry3::identity(),
        Some(base) => match tree.between(log, base, frame) {
            Ok(transform) => transform,
            Err(error) => {
                notes.push(format!("{error}: scans in that frame are left out"));
                return Ok(None);
            }
        },
    };
    let up = base_from_sensor.rotation * Vector3::z();
    let tilt = libm::acos(up.z.abs().min(1.0));
    let base = base.map_or("", |base| log.frame(base));
    let name = log.frame(frame);
    if tilt > MOST_TILT {
        return Err(ImportError::Tilted {
            frame: name.to_owned(),
            base: base.to_owned(),
            degrees: tilt.to_degrees(),
        });
    }
    let ahead = base_from_sensor.rotation * Vector3::x();
    let heading = libm::atan2(ahead.y, ahead.x);
    let place = base_from_sensor.translation.vector;
    let sign = up.z.signum();
    let hangs = if sign < 0.0 {
        " and hangs upside down"
    } else {
        ""
    };
    let tilted = match tilt > TOLD_TILT {
        true => format!(
            ", tilted by {:.1}°: beams are projected onto the floor",
            tilt.to_degrees()
        ),
        false => String::new(),
    };
    if !base.is_empty() {
        notes.push(format!(
            "The lidar in frame `{name}` sits at x {:.3} m, y {:.3} m of `{base}`, turned by {:.1}°{hangs}{tilted}",
            place.x, place.y, heading.to_degrees()
        ));
    }
    Ok(Some(Mount {
        robot_from_sensor: Pose2::new(place.x, place.y, heading),
        base_from_sensor,
        is_level: tilt < LEVEL,
        sign,
    }))
}

/// Angle from beam to beam, rad; `None` if nothing determines it.
fn step(scan: &LaserScan) -> Option<f64> {
    let (first, last) = (f64::from(scan.angle_min), f64::from(scan.angle_max));
    let step = f64::from(scan.angle_increment);
    let gaps = scan.ranges.len().saturating_sub(1);
    if !first.is_finite() {
        return None;
    }
    if gaps == 0 || (step.is_finite() && step != 0.0) {
        return Some(step).filter(|step| step.is_finite());
    }
    let step = (last - first) / gaps as f64;
    (step.is_finite() && step != 0.0).then_some(step)
}

/// The farthest range of all: the assumed reach of a lidar that does not give one, m.
fn farthest(scans: &[(u64, usize, &LaserScan)]) -> f32 {
    let ranges = scans.iter().flat_map(|(_, _, scan)| &scan.ranges);
    let finite = ranges
        .copied()
        .filter(|range| *range > 0.0 && *range < FARTHEST);
    // A little more, so that this range is itself a hit.
    finite
        .max_by(f32::total_cmp)
        .map_or(FARTHEST, |range| range * 1.001)
}

/// Time from one scan to the next, s; infinite if there is no next one.
fn median_period(times: &[(u64, usize)]) -> f64 {
    let mut gaps: Vec<u64> = times.windows(2).map(|pair| pair[1].0 - pair[0].0).collect();
    gaps.retain(|gap| *gap > 0);
    gaps.sort_unstable();
    gaps.get(gaps.len() / 2)
        .map_or(f64::INFINITY, |gap| *gap as f64 * 1e-9)
}

impl Faults {
    fn tell(self, left: usize, all: usize, notes: &mut Vec<String>) -> Result<(), ImportError> {
        let counted = [
            (self.without_beams, "have no beams"),
            (self.without_angles, "do not tell the angles of their beams"),
            (
                self.unplaced,
                "are in a frame of which nobody knows where it is",
            ),
        ];
        let counted = counted.into_iter().filter(|(count, _)| *count > 0);
        let mut words: Vec<String> = counted
            .map(|(count, what)| format!("{count} scans {what}"))
            .collect();
        words.extend(
            self.invalid
                .map(|(count, first)| format!("{count} scans cannot be used; the first: {first}")),
        );
        if left == 0 {
            return Err(ImportError::NothingLeft(all, words.join("; ")));
        }
        notes.extend(
            words
                .into_iter()
                .map(|words| format!("{words}: they were left out")),
        );
        Ok(())
    }
}

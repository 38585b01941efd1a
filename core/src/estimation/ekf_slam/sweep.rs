//! Steps 1 and 2: a turning lidar sees each line at a different instant. At which instant and in
//! what order, what the line was at that instant, and how the state moves there by the pending
//! odometry.

use nalgebra::Matrix2x3;

use super::EkfSlam;
use super::point_model::{moved_with, rotation};
use super::robot_state::Step;
use crate::features::{LineFeature, PointFeature};
use crate::geom::symmetrize;
use crate::robot::{Odometry, Scan, Stamp};

/// The resolution of stamps is a microsecond, s.
const GRAIN: f64 = 1e-6;
/// An odometry reading is not split into parts smaller than this.
const LEAST_PART: f64 = 1e-3;

/// When the beams of a scan were taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SweepTiming {
    /// The instant in whose robot frame the lines are given.
    pub stamp: Stamp,
    /// Seconds from the last beam to `stamp`: scans arrive a little late.
    pub lag: f64,
    /// Seconds from the first beam to the last; 0 if all were taken at once or the robot stood
    /// still.
    pub seconds: f64,
    /// Number of beams.
    pub n_beams: usize,
}

impl SweepTiming {
    /// The timing of `scan`, whose lines are given in the robot frame at `stamp`, at the last beam
    /// or later.
    #[must_use]
    pub fn at(stamp: Stamp, scan: &Scan) -> Self {
        Self {
            stamp,
            lag: stamp.since(scan.stamp).max(0.0),
            seconds: scan.sweep,
            n_beams: scan.len(),
        }
    }

    /// All beams at once.
    #[must_use]
    pub fn at_once(stamp: Stamp) -> Self {
        Self {
            stamp,
            lag: 0.0,
            seconds: 0.0,
            n_beams: 0,
        }
    }

    /// Seconds from a beam to `stamp`.
    fn age(&self, beam: f64) -> f64 {
        let last = self.n_beams.saturating_sub(1);
        if last == 0 {
            return self.lag;
        }
        self.lag + self.seconds * (1.0 - beam / last as f64).clamp(0.0, 1.0)
    }

    /// Seconds from the middle of a run of beams to `stamp`.
    pub(super) fn age_of(&self, [first, last]: [usize; 2]) -> f64 {
        self.age(0.5 * (first + last) as f64)
    }
}

/// A line or a point of the scan, in the order of time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Turn {
    pub(super) which: Which,
    pub(super) beams: [usize; 2],
    age: f64,
    n_points: usize,
}

/// Which line or point of the scan.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Which {
    Line(usize),
    Point(usize),
}

/// Lines and points in the order in which they were seen; of those seen at once, the longest lines
/// first.
pub(super) fn order(
    lines: &[LineFeature],
    points: &[PointFeature],
    sweep: &SweepTiming,
    order: &mut Vec<Turn>,
) {
    let turn = |which, beams, n_points| Turn {
        which,
        beams,
        age: sweep.age_of(beams),
        n_points,
    };
    order.clear();
    let lines = lines.iter().enumerate().map(|(index, line)| {
        let beams = [line.first_beam, line.last_beam];
        turn(Which::Line(index), beams, line.n_points)
    });
    let points = points.iter().enumerate();
    let points = points.map(|(index, point)| turn(Which::Point(index), point.beams, 0));
    order.extend(lines.chain(points));
    // Ties by index: an unstable sort needs no memory.
    order.sort_unstable_by(|a, b| {
        let by_age = b.age.total_cmp(&a.age);
        by_age
            .then(b.n_points.cmp(&a.n_points))
            .then(a.which.cmp(&b.which))
    });
}

/// Moves a point from the end of the sweep back by `rest`, to the robot frame in which it was seen,
/// and adds the odometry uncertainty while the beams passed over it to its covariance.
pub(super) fn point_as_seen(
    point: &PointFeature,
    rest: &Odometry,
    sweep: &SweepTiming,
) -> PointFeature {
    let position = rest.motion * point.position;
    let turn = rotation(&rest.motion);
    let mut cov = turn * point.cov * turn.transpose();
    let [first, last] = point.beams;
    let (age, span) = (
        sweep.age_of(point.beams),
        sweep.age(first as f64) - sweep.age(last as f64),
    );
    if age > 0.0 && span > 0.0 {
        // As with a line: random walks from the middle beam to either end.
        let by_pose = moved_with(position.coords);
        cov += by_pose * rest.cov * by_pose.transpose() * (0.25 * span / age);
    }
    symmetrize(&mut cov);
    PointFeature {
        position,
        cov,
        ..*point
    }
}

/// Moves a line from the end of the sweep back by `rest`, to the robot frame in which it was seen,
/// and adds the odometry uncertainty while the beams passed over it to its covariance.
pub(super) fn as_seen(feature: &LineFeature, rest: &Odometry, sweep: &SweepTiming) -> LineFeature {
    let (line, by_line) = feature.line.transformed(&rest.motion);
    let age = sweep.age_of([feature.first_beam, feature.last_beam]);
    let span = sweep.age(feature.first_beam as f64) - sweep.age(feature.last_beam as f64);
    let mut cov = by_line * feature.cov * by_line.transpose();
    if age > 0.0 && span > 0.0 {
        // Random walks from the middle beam to either end, half of the span each; a shift moves the
        // line by less than a quarter of its accumulated variance.
        let part = span / age;
        let mut shift = rest.cov * (0.25 * part);
        shift.fill_row(2, 0.0);
        shift.fill_column(2, 0.0);
        let normal = line.normal();
        let by_pose = Matrix2x3::new(0.0, 0.0, -1.0, -normal.x, -normal.y, 0.0);
        cov += by_pose * shift * by_pose.transpose();
        for by_heading in feature.by_heading {
            let by_heading = by_line * by_heading;
            cov += by_heading * by_heading.transpose() * (0.5 * part * rest.cov[(2, 2)]);
        }
    }
    let mixed = 0.5 * (cov[(0, 1)] + cov[(1, 0)]);
    (cov[(0, 1)], cov[(1, 0)]) = (mixed, mixed);
    // The origin moves from one end of the sweep to the other; the sign of r shows whether it
    // changes sides.
    let same_way = line
        .normal()
        .dot(&rest.motion.rotate(feature.line.normal()))
        > 0.0;
    LineFeature {
        line,
        cov,
        ends: feature.ends.map(|end| rest.motion * end),
        seen_from_origin_side: feature.seen_from_origin_side == same_way,
        ..*feature
    }
}

impl EkfSlam {
    /// Step 1: moves the state by `odometry`.
    ///
    /// # Source   TDK 2016 eq. (3.1)-(3.4), (3.18)-(3.20).
    pub(super) fn advance(&mut self, odometry: &Odometry) {
        let step = Step::new(&self.pose, &self.errors, odometry, self.linearised_at());
        self.cov.advance(&step.by_robot, |own| step.covariance(own));
        self.pose = step.pose;
        self.predicted = step.pose.position();
    }

    /// Step 2: moves the state by the pending odometry up to `time` (seconds); a reading that
    /// extends beyond it is split.
    pub(super) fn advance_to(&mut self, time: f64) {
        let mut used = 0;
        while let Some(&next) = self.pending.get(used) {
            let part = part_until(&next, time);
            if part >= 1.0 {
                self.advance(&next);
                used += 1;
                continue;
            }
            if part > 0.0 {
                let (first, rest) = split(&next, part);
                self.advance(&first);
                self.pending[used] = rest;
            }
            break;
        }
        self.pending.drain(..used);
    }

    /// The motion from the time of the state to `time`, by the pending odometry: the motion by
    /// which a scan de-skewed to `time` has been moved.
    pub(super) fn motion_until(&self, time: f64) -> Odometry {
        let mut whole = Odometry::standing(Stamp(0));
        for next in &self.pending {
            let part = part_until(next, time);
            if part >= 1.0 {
                whole = whole.then(next);
                continue;
            }
            if part > 0.0 {
                whole = whole.then(&split(next, part).0);
            }
            break;
        }
        whole
    }
}

/// The part of a motion that lies before `time`, 0 to 1.
fn part_until(odometry: &Odometry, time: f64) -> f64 {
    let (from, to) = (odometry.from.seconds(), odometry.to.seconds());
    if to <= time + GRAIN {
        return 1.0;
    }
    let part = (time - from) / (to - from);
    let is_within = to > from && part > LEAST_PART;
    if is_within { part } else { 0.0 }
}

/// The first `part` of a motion, and the rest; the variance grows in proportion to the motion.
fn split(odometry: &Odometry, part: f64) -> (Odometry, Odometry) {
    let first = odometry.motion.fraction(part);
    let seconds = odometry.to.since(odometry.from);
    let middle = Stamp::from_seconds(odometry.from.seconds() + part * seconds);
    (
        Odometry {
            to: middle,
            motion: first,
            cov: odometry.cov * part,
            ..*odometry
        },
        Odometry {
            from: middle,
            motion: first.inverse() * odometry.motion,
            cov: odometry.cov * (1.0 - part),
            ..*odometry
        },
    )
}

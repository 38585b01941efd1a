//! A simulated twin beside a real or a recorded robot: it gets the same track counts, without
//! noise.
//!
//! In: the odometry as the robot counts it, and at each scan the pose that SLAM estimates, the
//! points and the grid. Out: where a robot with the given figures would be, and how far that is
//! from the estimate ([`TwinSample`]): position, heading and ranges, with their bounds of chance.
//!
//! 1. The twin begins where the robot is believed to be. Each motion moves it as
//!    [`OdometryCalibration`] says: by the model of the simulated robot ([`crate::sim`]) without
//!    its noise. The noise is accumulated in a covariance.
//! 2. At each scan the ranges that the twin would measure are the distances to the first occupied
//!    cell of the map in the direction of each beam. Cells have a size: even an exact twin differs
//!    by half a cell.
//! 3. A twin that stays within three standard deviations has the robot's figures. One that leaves
//!    them at once does not: fit the figures ([`crate::estimation::OdometryFit`]).

use nalgebra::{Matrix3, Point2};

use crate::geom::{Length, Pose2, PoseEstimate, unit_vector, wrap};
use crate::map::{CellState, Grid};
use crate::points::{Beam, Points};
use crate::robot::{Odometry, OdometryCalibration};

/// One in this many beams is compared; neighbours say the same.
const EVERY: usize = 5;
/// Fewest beams for a median.
const LEAST_BEAMS: usize = 5;

/// The twin and how far it is from the robot.
#[derive(Clone, Debug)]
pub struct Twin {
    calibration: OdometryCalibration,
    track_width: f64,
    /// Motion since the beginning, with covariance; its frame is the pose at the beginning.
    ran: Option<Odometry>,
    begin: Pose2,
    samples: Vec<TwinSample>,
}

/// Twin and robot at one scan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TwinSample {
    /// Time on the robot's clock, s.
    pub seconds: f64,
    /// Where the twin is, map frame.
    pub twin: Pose2,
    /// Distance from the twin to the robot's estimated position, m.
    pub position: f64,
    /// Three standard deviations of that distance along its most uncertain direction, from noise
    /// and from the estimate's own covariance.
    pub position_sigma3: f64,
    /// From the twin's heading to the robot's, rad.
    pub heading: f64,
    /// Three standard deviations of that difference.
    pub heading_sigma3: f64,
    /// Median difference between the measured ranges and those that the twin would measure in the
    /// map, m, not negative; `None` if too few beams meet the map.
    pub ranges: Option<f64>,
}

impl Twin {
    /// A twin with these figures, of a robot whose model says `track_width`, beginning at
    /// `map_from_robot`.
    #[must_use]
    pub fn new(calibration: OdometryCalibration, track_width: f64, map_from_robot: Pose2) -> Self {
        Self {
            calibration,
            track_width,
            ran: None,
            begin: map_from_robot,
            samples: vec![],
        }
    }

    /// Where the twin is, map frame.
    #[must_use]
    pub fn pose(&self) -> Pose2 {
        self.ran.map_or(self.begin, |ran| self.begin * ran.motion)
    }

    /// Takes the next motion as the robot counted it.
    pub fn odometry(&mut self, counted: &Odometry) {
        let motion = self.calibration.corrected(counted, self.track_width);
        self.ran = Some(self.ran.map_or(motion, |ran| ran.then(&motion)));
    }

    /// Compares with the robot after a scan at `seconds`.
    pub fn scan(&mut self, seconds: f64, robot: &PoseEstimate, points: &Points, grid: &Grid) {
        let twin = self.pose();
        let turned = self.begin.rotation();
        let chance = self.ran.map_or(Matrix3::zeros(), |ran| ran.cov);
        let cov = turned * chance * turned.transpose() + robot.cov;
        let of_position = cov.fixed_view::<2, 2>(0, 0).into_owned();
        let most = of_position.symmetric_eigenvalues().max().max(0.0);
        self.samples.push(TwinSample {
            seconds,
            twin,
            position: (robot.pose.position() - twin.position()).length(),
            position_sigma3: 3.0 * most.sqrt(),
            heading: wrap(robot.pose.heading() - twin.heading()),
            heading_sigma3: 3.0 * cov[(2, 2)].max(0.0).sqrt(),
            ranges: median_off(points, grid, &twin),
        });
    }

    /// One sample for each scan so far.
    #[must_use]
    pub fn samples(&self) -> &[TwinSample] {
        &self.samples
    }
}

/// Median over the beams of the difference between the measured range and the range at
/// `map_from_twin`.
fn median_off(points: &Points, grid: &Grid, map_from_twin: &Pose2) -> Option<f64> {
    let difference = |beam: &Beam| {
        let origin = *map_from_twin * beam.origin_in_robot;
        let towards = map_from_twin.rotate(beam.end_in_robot - beam.origin_in_robot);
        let bearing = libm::atan2(towards.y, towards.x);
        // The search ends a metre beyond what was measured; anything farther means that the twin
        // sees another room.
        let range = range_in(grid, origin, bearing, beam.range + 1.0)?;
        Some((range - beam.range).abs())
    };
    let beams = points.hits().step_by(EVERY);
    let mut off: Vec<f64> = beams.filter_map(difference).collect();
    off.sort_by(f64::total_cmp);
    (off.len() >= LEAST_BEAMS).then(|| off[off.len() / 2])
}

/// Distance to the first occupied cell, m, searched in steps of half a cell.
fn range_in(grid: &Grid, from: Point2<f64>, bearing: f64, farthest: f64) -> Option<f64> {
    let direction = unit_vector(bearing);
    let step = 0.5 * grid.resolution();
    let steps = (farthest / step) as u32;
    let is_occupied = |range: &f64| {
        let cell = grid.cell_at(from + direction * *range);
        grid.state(cell) == CellState::Occupied
    };
    (1..=steps).map(|i| f64::from(i) * step).find(is_occupied)
}

#[cfg(test)]
mod tests;

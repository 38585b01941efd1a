//! A scan, prepared once with everything that a method asks of it.

use std::borrow::Cow;

use super::SlamConfig;
use crate::estimation::BeamPose;
use crate::map::Evidence;
use crate::points::{Beam, MotionHistory, MovedSince, Points};
use crate::robot::Scan;

/// A scan, and everything needed to interpret it.
#[derive(Debug)]
pub(super) struct PreparedScan<'a> {
    pub(super) scan: Cow<'a, Scan>,
    /// The points, de-skewed by odometry.
    pub(super) points: Points,
    /// The motion by odometry since each beam was taken.
    pub(super) moved: Vec<MovedSince>,
    pub(super) history: &'a MotionHistory,
    pub(super) config: &'a SlamConfig,
}

impl<'a> PreparedScan<'a> {
    pub(super) fn new(
        scan: Cow<'a, Scan>,
        history: &'a MotionHistory,
        config: &'a SlamConfig,
    ) -> Self {
        let moved = history.since_beams(&scan);
        let now = history.now().unwrap_or(scan.stamp);
        Self {
            points: Points::from_moved_scan(&scan, now, &moved, &config.points),
            scan,
            moved,
            history,
            config,
        }
    }

    /// The scan without some of its beams, as if they had given no reading.
    pub(super) fn without(mut self, beams: &[usize]) -> Self {
        if beams.is_empty() {
            return self;
        }
        let scan = self.scan.to_mut();
        for &beam in beams {
            if let Some(range) = scan.ranges.get_mut(beam) {
                *range = f32::NAN;
            }
        }
        let is_left = |beam: &Beam| beams.binary_search(&beam.beam_idx).is_err();
        self.points.beams.retain(is_left);
        self
    }

    /// Variance of the heading that odometry accumulated since each beam of the scan was taken,
    /// rad².
    pub(super) fn heading_variances(&self) -> Vec<f64> {
        self.moved.iter().map(|m| m.heading_variance).collect()
    }

    /// Standard deviation of the direction of each usable beam in the robot's current frame, from
    /// the heading since it was taken and from the sensor, rad.
    pub(super) fn direction_sigmas(&self) -> Vec<f64> {
        sigmas(&self.points, |beam| {
            self.moved.get(beam).map_or(0.0, |m| m.heading_variance)
        })
    }

    /// The certain evidence of the scan by odometry alone.
    pub(super) fn evidence(&self) -> Evidence {
        self.certain(&self.points, &self.direction_sigmas())
    }

    /// The evidence of the scan by odometry alone, with the directions of beams taken as exact.
    pub(super) fn evidence_of_all(&self) -> Evidence {
        Evidence::of(&self.config.evidence.believed(&self.points))
    }

    /// The certain evidence of the scan with its beams taken from these poses, in their order.
    pub(super) fn evidence_from(&self, poses: &[BeamPose]) -> Evidence {
        let placed = |beam: usize| {
            poses
                .get(beam)
                .map_or_else(Default::default, |p| p.robot_from_then)
        };
        let (stamp, config) = (self.points.stamp, &self.config.points);
        let points = Points::from_placed_scan(&self.scan, stamp, config, placed);
        let turned = |beam: usize| poses.get(beam).map_or(0.0, |p| p.heading_variance);
        self.certain(&points, &sigmas(&points, turned))
    }

    fn certain(&self, points: &Points, sigmas: &[f64]) -> Evidence {
        let resolution = self.config.grid.resolution;
        Evidence::certain(points, sigmas, resolution, &self.config.evidence)
    }
}

/// Standard deviations of direction, from the sensor and the variance of the heading at each beam
/// of the scan.
fn sigmas(points: &Points, heading_variance: impl Fn(usize) -> f64) -> Vec<f64> {
    let bearing = points.bearing_sigma * points.bearing_sigma;
    let sigma = |beam: &Beam| (heading_variance(beam.beam_idx) + bearing).sqrt();
    points.beams.iter().map(sigma).collect()
}

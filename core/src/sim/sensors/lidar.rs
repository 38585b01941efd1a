//! A lidar that turns all the time, one beam after the other.
//!
//! 1. Beam k of a revolution is cast from where the robot is at its own instant: a moving robot's scan is skewed, as a
//!    real one's is, and has to be straightened by [`crate::points`].
//! 2. Range and bearing err by Gaussian noise; σ of the range is reported with it, from the range as measured.
//! 3. What is nearer than the least range, drops out, or is too dark to answer from where it stands is invalid (NaN, 0
//!    on the wire); what is farther than the greatest range is no return (infinite). A few readings are outliers,
//!    somewhere short of the surface, as from dust and edges.
//!
//! Bearings run from just above -π to π, counter-clockwise (+90° takes the x axis to the y axis); the seam between two
//! revolutions is behind the robot.
//!
//! Source: the specification, "Sensors"; RPLIDAR A1 data sheet (SLAMTEC) for rate and ranges; σ(ρ) rounded up from
//! the 1 % that it states.

use std::f64::consts::{PI, TAU};

use nalgebra::Vector2;
use rand::{Rng, RngExt};

use super::{SensorError, Span, View, check_figures};
use crate::geom::{Pose2, sin_cos};
use crate::robot::{Scan, Stamp};
use crate::sim::Material;
use crate::sim::noise::gaussian_pair;

/// Figures of a turning lidar.
#[derive(Clone, Debug, PartialEq)]
pub struct LidarModel {
    /// Beams of one revolution. Default 360.
    pub beams: usize,
    /// Seconds of one revolution. Default 0.18: 5.56 Hz, and every revolution ends on a step of the simulation.
    pub period: f64,
    /// Nearest range that is measured, m. Default 0.15.
    pub min_range: f64,
    /// Farthest range that is measured, m. Default 12.
    pub max_range: f64,
    /// σ of the range at no distance, m. Default 0.01.
    pub sigma: f64,
    /// Growth of that σ with the distance, m/m. Default 0.005.
    pub sigma_per_metre: f64,
    /// σ of the bearing, rad. Default 0.001.
    pub bearing_sigma: f64,
    /// Part of the readings that are lost. Default 0.005.
    pub dropouts: f64,
    /// Part of the readings that are wrong. Default 0.001.
    pub outliers: f64,
    /// Dark surfaces answer from nearer than this, m. Default 3.
    pub dark_range: f64,
    /// Glass answers beams within this angle of its normal, rad. Default 0.15.
    pub glass_angle: f64,
    /// Where it sits on the robot. Default: its middle.
    pub robot_from_sensor: Pose2,
}

impl Default for LidarModel {
    fn default() -> Self {
        Self {
            beams: 360,
            period: 0.18,
            min_range: 0.15,
            max_range: 12.0,
            sigma: 0.01,
            sigma_per_metre: 0.005,
            bearing_sigma: 0.001,
            dropouts: 0.005,
            outliers: 0.001,
            dark_range: 3.0,
            glass_angle: 0.15,
            robot_from_sensor: Pose2::identity(),
        }
    }
}

impl LidarModel {
    /// σ of a reading at `range`, m.
    #[must_use]
    pub fn sigma_at(&self, range: f64) -> f64 {
        self.sigma + self.sigma_per_metre * range
    }

    pub(super) fn validate(&self) -> Result<(), SensorError> {
        let beams = self.beams as f64;
        let part = |p: f64| (0.0..=1.0).contains(&p);
        let size = |v: f64| v >= 0.0 && v.is_finite();
        check_figures(
            "lidar",
            &[
                (
                    "beams",
                    beams,
                    (1.0..=100_000.0).contains(&beams),
                    "1 to 100000",
                ),
                (
                    "period",
                    self.period,
                    (0.001..=60.0).contains(&self.period),
                    "0.001 to 60 s",
                ),
                (
                    "min_range",
                    self.min_range,
                    size(self.min_range),
                    "at least 0 m",
                ),
                (
                    "max_range",
                    self.max_range,
                    self.max_range > self.min_range && self.max_range <= 1000.0,
                    "more than min_range and at most 1000 m",
                ),
                (
                    "sigma",
                    self.sigma,
                    self.sigma > 0.0 && self.sigma.is_finite(),
                    "more than 0 m",
                ),
                (
                    "sigma_per_metre",
                    self.sigma_per_metre,
                    size(self.sigma_per_metre),
                    "at least 0",
                ),
                (
                    "bearing_sigma",
                    self.bearing_sigma,
                    size(self.bearing_sigma),
                    "at least 0 rad",
                ),
                ("dropouts", self.dropouts, part(self.dropouts), "0 to 1"),
                ("outliers", self.outliers, part(self.outliers), "0 to 1"),
                (
                    "dark_range",
                    self.dark_range,
                    self.dark_range >= 0.0,
                    "at least 0 m",
                ),
                (
                    "glass_angle",
                    self.glass_angle,
                    size(self.glass_angle),
                    "at least 0 rad",
                ),
            ],
        )
    }
}

/// A lidar at work.
#[derive(Clone, Debug)]
pub(in crate::sim) struct Lidar {
    model: LidarModel,
    /// When the first revolution began, s.
    began: f64,
    /// Beams since then.
    taken: u64,
    bearings: Vec<f64>,
    ranges: Vec<f32>,
    sigmas: Vec<f32>,
}

impl Lidar {
    pub(super) fn new(model: &LidarModel) -> Self {
        let bearing = |k: usize| TAU * (k + 1) as f64 / model.beams as f64 - PI;
        Self {
            model: model.clone(),
            began: 0.0,
            taken: 0,
            bearings: (0..model.beams).map(bearing).collect(),
            ranges: Vec::with_capacity(model.beams),
            sigmas: Vec::with_capacity(model.beams),
        }
    }

    pub(super) fn begin(&mut self, seconds: f64) {
        self.began = seconds;
        self.taken = 0;
        self.ranges.clear();
        self.sigmas.clear();
    }

    pub(super) fn step(&mut self, span: &Span, view: &View, rng: &mut impl Rng) -> Option<Scan> {
        let between = self.model.period / self.model.beams as f64;
        let mut scan = None;
        loop {
            let seconds = self.began + (self.taken + 1) as f64 * between;
            // Beams on the border of two steps belong to the first, whatever the rounding.
            if seconds > span.to + 1e-9 {
                return scan;
            }
            let bearing = self
                .bearings
                .get(self.ranges.len())
                .copied()
                .unwrap_or_default();
            let (range, sigma) = self.read(seconds, bearing, span, view, rng);
            self.ranges.push(range);
            self.sigmas.push(sigma);
            self.taken += 1;
            if self.ranges.len() == self.model.beams {
                scan = Some(self.complete(seconds, between));
            }
        }
    }

    fn complete(&mut self, seconds: f64, between: f64) -> Scan {
        let beams = self.model.beams;
        Scan {
            stamp: Stamp::from_seconds(seconds),
            robot_from_sensor: self.model.robot_from_sensor,
            bearings: self.bearings.clone(),
            ranges: std::mem::replace(&mut self.ranges, Vec::with_capacity(beams)),
            sigmas: std::mem::replace(&mut self.sigmas, Vec::with_capacity(beams)),
            bearing_sigma: self.model.bearing_sigma,
            max_range: self.model.max_range,
            sweep: between * beams.saturating_sub(1) as f64,
        }
    }

    /// One reading and its σ.
    fn read(
        &self,
        seconds: f64,
        bearing: f64,
        span: &Span,
        view: &View,
        rng: &mut impl Rng,
    ) -> (f32, f32) {
        let model = &self.model;
        // Drawn for every beam, so that one wall more does not change the noise of all that follows.
        let luck: f64 = rng.random();
        let (of_range, of_bearing) = gaussian_pair(rng);
        let sigma = |range: f64| model.sigma_at(range) as f32;
        if luck < model.dropouts {
            return (f32::NAN, sigma(model.max_range));
        }
        let (origin, heading) = span.sensor_at(seconds, &model.robot_from_sensor);
        let (sin, cos) = sin_cos(heading + bearing + model.bearing_sigma * of_bearing);
        let echo = view.echo(
            origin,
            Vector2::new(cos, sin),
            model.max_range,
            model.glass_angle,
        );
        let Some(echo) = echo else {
            return (f32::INFINITY, sigma(model.max_range));
        };
        let too_dark = echo.material == Material::Dark && echo.distance > model.dark_range;
        if too_dark || echo.distance < model.min_range {
            return (f32::NAN, sigma(model.max_range));
        }
        if luck > 1.0 - model.outliers {
            // What is left of `luck` is uniform too.
            let part = (1.0 - luck) / model.outliers;
            let range = model.min_range + part * (echo.distance - model.min_range);
            return (range as f32, sigma(range));
        }
        let range = echo.distance + model.sigma_at(echo.distance) * of_range;
        if range > model.max_range {
            return (f32::INFINITY, sigma(model.max_range));
        }
        let range = range.max(model.min_range);
        (range as f32, sigma(range))
    }
}

//! Four infra-red rangers at 90° to one another on a servo that sweeps 90°: together they look all round.
//!
//! 1. The robot stands still; the servo goes from -45° to just below +45° in steps, and at each all four rangers are
//!    read, one cycle of the ranger after the other.
//! 2. σ grows with the square of the distance: volts fall like 1/d, so that one count of the ADC is worth d².
//! 3. Below the least range the characteristic folds back; such readings are invalid (NaN), or, with
//!    [`RangerModel::folds`], look like far ones, as they do on the real robot. Beyond the greatest range there is no
//!    return (infinite).
//!
//! The readings are handed on in the order of their bearings, with `sweep` 0: nothing moved meanwhile, and neighbours
//! in the scan are neighbours in the room.
//!
//! Source: TDK 2016 §1.3 (four rangers, servo, 38 ms); Sharp GP2Y0A02 and GP2Y0A21 data sheets for the ranges; the
//! specification for the noise: at 0.8 m about 1 cm for a count of the ADC, and 3 cm for 15 mV, for the short type.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

use nalgebra::Vector2;
use rand::{Rng, RngExt};

use super::{SensorError, Span, View, check_figures};
use crate::geom::{Pose2, sin_cos, wrap};
use crate::robot::{Scan, Stamp};
use crate::sim::Material;
use crate::sim::noise::gaussian_pair;

const RANGERS: u32 = 4;

/// Figures of four rangers on a servo.
#[derive(Clone, Debug, PartialEq)]
pub struct RangerModel {
    /// Positions of the servo in its 90°. Default 45: every 2°.
    pub positions: usize,
    /// Seconds for one reading. Default 0.038.
    pub period: f64,
    /// Nearest usable range, m. Default 0.2.
    pub min_range: f64,
    /// Farthest usable range, m. Default 1.5.
    pub max_range: f64,
    /// σ of the range at no distance, m. Default 0.005.
    pub sigma: f64,
    /// Growth of that σ with the square of the distance, m/m². Default 0.02.
    pub sigma_per_square_metre: f64,
    /// σ of the servo's angle, rad. Default 0.005.
    pub bearing_sigma: f64,
    /// Part of the readings that are lost. Default 0.002.
    pub dropouts: f64,
    /// Whether things nearer than the least range look far, as on the real robot. Default false: invalid.
    pub folds: bool,
    /// Where the servo sits on the robot. Default: its middle.
    pub robot_from_sensor: Pose2,
}

impl Default for RangerModel {
    fn default() -> Self {
        Self::long()
    }
}

impl RangerModel {
    /// Sharp GP2Y0A02: 0.2 to 1.5 m.
    #[must_use]
    pub fn long() -> Self {
        Self {
            positions: 45,
            period: 0.038,
            min_range: 0.2,
            max_range: 1.5,
            sigma: 0.005,
            sigma_per_square_metre: 0.02,
            bearing_sigma: 0.005,
            dropouts: 0.002,
            folds: false,
            robot_from_sensor: Pose2::identity(),
        }
    }

    /// Sharp GP2Y0A21: 0.1 to 0.8 m.
    #[must_use]
    pub fn short() -> Self {
        Self {
            min_range: 0.1,
            max_range: 0.8,
            sigma: 0.003,
            sigma_per_square_metre: 0.04,
            ..Self::long()
        }
    }

    /// σ of a reading at `range`, m.
    #[must_use]
    pub fn sigma_at(&self, range: f64) -> f64 {
        self.sigma + self.sigma_per_square_metre * range * range
    }

    pub(super) fn validate(&self) -> Result<(), SensorError> {
        let positions = self.positions as f64;
        let size = |v: f64| v >= 0.0 && v.is_finite();
        check_figures(
            "rangers",
            &[
                (
                    "positions",
                    positions,
                    (1.0..=10_000.0).contains(&positions),
                    "1 to 10000",
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
                    self.max_range > self.min_range && self.max_range <= 100.0,
                    "more than min_range and at most 100 m",
                ),
                (
                    "sigma",
                    self.sigma,
                    self.sigma > 0.0 && self.sigma.is_finite(),
                    "more than 0 m",
                ),
                (
                    "sigma_per_square_metre",
                    self.sigma_per_square_metre,
                    size(self.sigma_per_square_metre),
                    "at least 0",
                ),
                (
                    "bearing_sigma",
                    self.bearing_sigma,
                    size(self.bearing_sigma),
                    "at least 0 rad",
                ),
                (
                    "dropouts",
                    self.dropouts,
                    (0.0..=1.0).contains(&self.dropouts),
                    "0 to 1",
                ),
            ],
        )
    }
}

/// Rangers at work.
#[derive(Clone, Debug)]
pub(in crate::sim) struct Rangers {
    model: RangerModel,
    /// When the sweep under way began, s.
    began: Option<f64>,
    /// (bearing, range, σ) so far.
    readings: Vec<(f64, f32, f32)>,
}

impl Rangers {
    pub(super) fn new(model: &RangerModel) -> Self {
        Self {
            model: model.clone(),
            began: None,
            readings: Vec::new(),
        }
    }

    pub(super) fn begin(&mut self, seconds: f64) {
        self.began = Some(seconds);
        self.readings.clear();
    }

    pub(super) fn abort(&mut self) {
        self.began = None;
    }

    pub(super) fn step(&mut self, span: &Span, view: &View, rng: &mut impl Rng) -> Option<Scan> {
        let began = self.began?;
        loop {
            let position = self.readings.len() / RANGERS as usize;
            let seconds = began + (position + 1) as f64 * self.model.period;
            if seconds > span.to + 1e-9 {
                return None;
            }
            let servo = FRAC_PI_2 * position as f64 / self.model.positions as f64 - FRAC_PI_4;
            for ranger in 0..RANGERS {
                let bearing = wrap(servo + FRAC_PI_2 * f64::from(ranger));
                let (range, sigma) = self.read(seconds, bearing, span, view, rng);
                self.readings.push((bearing, range, sigma));
            }
            if position + 1 >= self.model.positions {
                return Some(self.complete(seconds));
            }
        }
    }

    fn complete(&mut self, seconds: f64) -> Scan {
        self.began = None;
        self.readings.sort_by(|a, b| a.0.total_cmp(&b.0));
        Scan {
            stamp: Stamp::from_seconds(seconds),
            robot_from_sensor: self.model.robot_from_sensor,
            bearings: self.readings.iter().map(|r| r.0).collect(),
            ranges: self.readings.iter().map(|r| r.1).collect(),
            sigmas: self.readings.iter().map(|r| r.2).collect(),
            bearing_sigma: self.model.bearing_sigma,
            max_range: self.model.max_range,
            sweep: 0.0,
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
        let luck: f64 = rng.random();
        let (of_range, of_bearing) = gaussian_pair(rng);
        let sigma = |range: f64| model.sigma_at(range) as f32;
        let invalid = (f32::NAN, sigma(model.max_range));
        if luck < model.dropouts {
            return invalid;
        }
        let (origin, heading) = span.sensor_at(seconds, &model.robot_from_sensor);
        let (sin, cos) = sin_cos(heading + bearing + model.bearing_sigma * of_bearing);
        // Infra-red rangers triangulate: a pane answers only head on, a dark surface by triangulation nearly as well.
        let Some(echo) = view.echo(origin, Vector2::new(cos, sin), model.max_range, 0.1) else {
            return (f32::INFINITY, sigma(model.max_range));
        };
        let mut distance = echo.distance;
        if distance < model.min_range {
            if !model.folds {
                return invalid;
            }
            // Volts rise from 0 at the lens to their peak at the least range: half-way looks like twice as far.
            distance =
                (model.min_range * model.min_range / distance.max(0.01)).min(model.max_range);
        }
        let rough = if echo.material == Material::Dark {
            1.5
        } else {
            1.0
        };
        let deviation = rough * model.sigma_at(distance);
        let range = distance + deviation * of_range;
        if range > model.max_range {
            return (f32::INFINITY, sigma(model.max_range));
        }
        let range = range.max(model.min_range);
        (range as f32, sigma(range) * rough as f32)
    }
}

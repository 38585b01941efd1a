//! A lidar that turns all the time, one beam after the other, over a full turn or a part of each
//! turn.
//!
//! 1. Beam k of a revolution is cast from where the robot is at that instant: a moving robot's scan
//!    is skewed, like a real one's, and has to be corrected by [`crate::points`].
//! 2. Range and bearing have Gaussian noise; σ of the range is reported with it, computed from the
//!    measured range.
//! 3. A reading nearer than the least range, lost, or too dark to be seen from its distance is
//!    invalid (NaN, 0 on the wire); beyond the greatest range there is no return (infinite). A few
//!    readings are outliers, somewhere in front of the surface, as from dust and edges.
//!
//! 4. A lidar like SICK's reports the greatest range if nothing came back, whether because of
//!    distance, glass or darkness: the three cannot be distinguished
//!    ([`LidarModel::says_maximum`]).
//! 5. The RPLIDAR reports the strength of each echo, 0 to 63 ([`LidarModel::reports_quality`]). The
//!    light scattered back by a matt surface falls with cos i / d² (Lambert; i the angle of
//!    incidence). Strength 1 is the weakest usable echo, met squarely at the greatest range for the
//!    material.
//!
//! Bearings of a whole turn run from just above -π to π, counter-clockwise (+90° takes the x axis
//! to the y axis); the seam between two revolutions is behind the robot. Bearings of a part of a
//! turn run from its right end to its left end.
//!
//! Source: the specification, "Sensors"; RPLIDAR A1 data sheet (SLAMTEC) for rate and ranges, σ(ρ)
//! rounded up from the 1 % that it states; SICK LMS 200 technical description for rate, ranges and
//! σ; Celej §1 for its 20 m.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use rand::{Rng, RngExt};

use super::check::check_sensor;
use super::view::Echo;
use super::{SensorError, Span, View};
use crate::bounds::{Bounds, PART, or_no_limit};
use crate::geom::{Pose2, unit_vector};
use crate::robot::{Scan, Stamp};
use crate::sim::Material;
use crate::sim::noise::gaussian_pair;

/// Quality of the weakest echo that counts as a reading, and the greatest that six bits hold.
const LEAST_QUALITY: u8 = 1;
const MOST_QUALITY: u8 = 63;

/// Figures of a turning lidar.
#[derive(Clone, Debug, PartialEq)]
pub struct LidarModel {
    /// Beams of one revolution. Default 360.
    pub beams: usize,
    /// Angle from the first beam to the last, rad; 2π, the default, means all round.
    pub field_of_view: f64,
    /// Beams that would fit into one period, were the field of view as wide as the period is long;
    /// those beyond [`Self::beams`] are not taken. Default 360: all are.
    pub slots: usize,
    /// Seconds of one revolution. Default 0.18: 5.56 Hz, and every revolution ends on a step of the
    /// simulation.
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
    /// Whether it says [`Self::max_range`] where nothing came back; otherwise that is infinite.
    /// Default false.
    pub says_maximum: bool,
    /// Whether each echo comes with its strength. Default true.
    pub reports_quality: bool,
    /// Where it sits on the robot. Default: its middle.
    pub robot_from_sensor: Pose2,
}

impl Default for LidarModel {
    fn default() -> Self {
        Self::rplidar()
    }
}

impl LidarModel {
    /// SLAMTEC RPLIDAR A1: all round, 360 beams, 5.5 Hz, 0.15 to 12 m.
    #[must_use]
    pub fn rplidar() -> Self {
        Self {
            beams: 360,
            field_of_view: TAU,
            slots: 360,
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
            says_maximum: false,
            reports_quality: true,
            robot_from_sensor: Pose2::identity(),
        }
    }

    /// SICK LMS 200: 180° by 0.5°, ten scans a second, each within half a turn of its mirror at 75
    /// Hz; up to 20 m.
    #[must_use]
    pub fn sick() -> Self {
        Self {
            beams: 361,
            field_of_view: PI,
            // 361 beams in 6.7 ms, and a scan every 100 ms.
            slots: 5415,
            period: 0.1,
            min_range: 0.05,
            max_range: 20.0,
            sigma: 0.01,
            sigma_per_metre: 0.001,
            bearing_sigma: 0.001,
            dropouts: 0.001,
            outliers: 0.0005,
            dark_range: 8.0,
            glass_angle: 0.15,
            says_maximum: true,
            reports_quality: false,
            robot_from_sensor: Pose2::identity(),
        }
    }

    /// σ of a reading at `range`, m.
    #[must_use]
    pub fn sigma_at(&self, range: f64) -> f64 {
        self.sigma + self.sigma_per_metre * range
    }

    /// Strength of an echo.
    fn quality(&self, echo: &Echo) -> u8 {
        let far = match echo.material {
            Material::Dark => self.dark_range,
            Material::Opaque | Material::Glass => self.max_range,
        };
        let nearness = far / echo.distance;
        let strength = echo.facing * nearness * nearness;
        (strength.round() as u8).clamp(LEAST_QUALITY, MOST_QUALITY)
    }

    /// What [`Self::beams`] may be.
    pub const BEAMS: Bounds = [1.0, 10_000.0];
    /// What [`Self::period`] may be, s.
    pub const PERIOD: Bounds = [0.02, 5.0];
    /// What [`Self::min_range`] may be, m.
    pub const MIN_RANGE: Bounds = [0.0, 5.0];
    /// What [`Self::max_range`] may be, m; more than [`Self::min_range`].
    pub const MAX_RANGE: Bounds = [0.5, 100.0];
    /// What [`Self::sigma`] may be, m.
    pub const SIGMA: Bounds = [1e-6, 0.5];
    /// What [`Self::sigma_per_metre`] may be, m/m.
    pub const SIGMA_PER_METRE: Bounds = [0.0, 0.2];
    /// What [`Self::bearing_sigma`] may be, rad.
    pub const BEARING_SIGMA: Bounds = [0.0, 0.1];
    /// What [`Self::dark_range`] may be, m.
    pub const DARK_RANGE: Bounds = [0.0, 100.0];
    /// What [`Self::glass_angle`] may be, rad.
    pub const GLASS_ANGLE: Bounds = [0.0, FRAC_PI_2];

    /// The same lidar with this many beams, taken in the same part of its period.
    #[must_use]
    pub fn with_beams(&self, beams: usize) -> Self {
        let slots = self.slots as f64 * beams as f64 / self.beams.max(1) as f64;
        let slots = (slots.round() as usize).max(beams);
        Self {
            beams,
            slots,
            ..self.clone()
        }
    }

    pub(super) fn validate(&self) -> Result<(), SensorError> {
        let beams = self.beams as f64;
        let nearest = f64::max(self.min_range, Self::MAX_RANGE[0]);
        let dark = or_no_limit(self.dark_range, Self::DARK_RANGE);
        let growth = self.sigma_per_metre;
        check_sensor(
            "lidar",
            &[
                ("beams", beams, Self::BEAMS),
                ("slots", self.slots as f64, [beams, 1e7]),
                ("field_of_view", self.field_of_view, [0.0, TAU]),
                ("period", self.period, Self::PERIOD),
                ("min_range", self.min_range, Self::MIN_RANGE),
                ("max_range", self.max_range, [nearest, Self::MAX_RANGE[1]]),
                ("sigma", self.sigma, Self::SIGMA),
                ("sigma_per_metre", growth, Self::SIGMA_PER_METRE),
                ("bearing_sigma", self.bearing_sigma, Self::BEARING_SIGMA),
                ("dropouts", self.dropouts, PART),
                ("outliers", self.outliers, PART),
                ("dark_range", dark, Self::DARK_RANGE),
                ("glass_angle", self.glass_angle, Self::GLASS_ANGLE),
            ],
        )
    }

    fn bearings(&self) -> Vec<f64> {
        let all_round = |k: usize| TAU * (k + 1) as f64 / self.beams as f64 - PI;
        let between = self.field_of_view / (self.beams.max(2) - 1) as f64;
        let part = |k: usize| between * k as f64 - 0.5 * self.field_of_view;
        match self.field_of_view >= TAU {
            true => (0..self.beams).map(all_round).collect(),
            false => (0..self.beams).map(part).collect(),
        }
    }

    /// What it reports if nothing came back.
    fn silence(&self) -> f32 {
        match self.says_maximum {
            true => self.max_range as f32,
            false => f32::INFINITY,
        }
    }
}

/// A lidar in operation.
#[derive(Clone, Debug)]
pub(in crate::sim) struct Lidar {
    model: LidarModel,
    /// When the first revolution began, s.
    began: f64,
    /// Slots since then.
    slots: u64,
    bearings: Vec<f64>,
    /// Of the revolution in progress.
    readings: Vec<Reading>,
}

/// The reading of one beam.
#[derive(Clone, Copy, Debug)]
struct Reading {
    /// m.
    range: f32,
    /// m.
    sigma: f32,
    /// 0 if nothing valid came back.
    quality: u8,
}

impl Lidar {
    pub(super) fn new(model: &LidarModel) -> Self {
        Self {
            model: model.clone(),
            began: 0.0,
            slots: 0,
            bearings: model.bearings(),
            readings: Vec::with_capacity(model.beams),
        }
    }

    pub(super) fn begin(&mut self, seconds: f64) {
        self.began = seconds;
        self.slots = 0;
        self.readings.clear();
    }

    pub(super) fn step(&mut self, span: &Span, view: &View, rng: &mut impl Rng) -> Option<Scan> {
        let slots = self.model.slots as u64;
        let between = self.model.period / slots as f64;
        let mut scan = None;
        loop {
            let seconds = self.began + (self.slots + 1) as f64 * between;
            // Beams on the border of two steps belong to the first, despite rounding.
            if seconds > span.to + 1e-9 {
                return scan;
            }
            let slot = (self.slots % slots) as usize;
            let Some(&bearing) = self.bearings.get(slot) else {
                // The lidar looks away; on to the next turn.
                self.slots += slots - slot as u64;
                continue;
            };
            let reading = self.read(seconds, bearing, span, view, rng);
            self.readings.push(reading);
            self.slots += 1;
            if self.readings.len() == self.model.beams {
                scan = Some(self.complete(seconds, between));
            }
        }
    }

    fn complete(&mut self, seconds: f64, between: f64) -> Scan {
        let qualities = self.readings.iter().map(|reading| reading.quality);
        let scan = Scan {
            stamp: Stamp::from_seconds(seconds),
            robot_from_sensor: self.model.robot_from_sensor,
            bearings: self.bearings.clone(),
            ranges: self.readings.iter().map(|reading| reading.range).collect(),
            sigmas: self.readings.iter().map(|reading| reading.sigma).collect(),
            bearing_sigma: self.model.bearing_sigma,
            max_range: self.model.max_range,
            sweep: between * self.model.beams.saturating_sub(1) as f64,
            qualities: qualities.filter(|_| self.model.reports_quality).collect(),
        };
        self.readings.clear();
        scan
    }

    /// One reading.
    fn read(
        &self,
        seconds: f64,
        bearing: f64,
        span: &Span,
        view: &View,
        rng: &mut impl Rng,
    ) -> Reading {
        let model = &self.model;
        // Drawn for every beam, so that one more wall does not change the noise of everything after
        // it.
        let luck: f64 = rng.random();
        let (of_range, of_bearing) = gaussian_pair(rng);
        let valid = |range: f64, quality| Reading {
            range: range as f32,
            sigma: model.sigma_at(range) as f32,
            quality,
        };
        let nothing = |range: f32| Reading {
            range,
            ..valid(model.max_range, 0)
        };
        if luck < model.dropouts {
            return nothing(f32::NAN);
        }
        let (origin, heading) = span.sensor_at(seconds, &model.robot_from_sensor);
        let direction = unit_vector(heading + bearing + model.bearing_sigma * of_bearing);
        let Some(echo) = view.echo(origin, direction, model.max_range, model.glass_angle) else {
            return nothing(model.silence());
        };
        let too_dark = echo.material == Material::Dark && echo.distance > model.dark_range;
        if too_dark && model.says_maximum {
            return nothing(model.silence());
        }
        if too_dark || echo.distance < model.min_range {
            return nothing(f32::NAN);
        }
        if luck > 1.0 - model.outliers {
            // The remainder of `luck` is uniform too.
            let part = (1.0 - luck) / model.outliers;
            let range = model.min_range + part * (echo.distance - model.min_range);
            // Dust and edges send little back.
            return valid(range, LEAST_QUALITY);
        }
        let range = echo.distance + model.sigma_at(echo.distance) * of_range;
        if range > model.max_range {
            return nothing(model.silence());
        }
        let range = range.max(model.min_range);
        valid(range, model.quality(&echo))
    }
}

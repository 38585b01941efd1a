//! Four infra-red rangers at 90° to one another on a servo that sweeps 90°: together they look all round.
//!
//! Forward, from the world to counts:
//! 1. The robot stands still; the servo goes from -45° to just below +45° in steps, and at each all four rangers are read.
//! 2. The servo stands at a new angle [`RangerModel::settle`] after it was told to. A ranger measures by itself, once in 38.3 ± 9.6 ms, and holds its output meanwhile: what is read may have been measured
//!    when the servo still stood elsewhere.
//! 3. The true range becomes volts ([`Sharp`]), which fold back below the peak; noise is in volts; the converter has 10 bits.
//!
//! Inverse, from counts to a range with its σ:
//!
//! 4. Counts become volts, and volts a range by a [`Characteristic`] fitted to the calibration pairs.
//! 5. σ is that of the volts (noise and steps) times the slope of the characteristic: a volt is worth d², so σ grows so too.
//!    The spread of the fit's residuals is added, being what the characteristic does not know.
//! 6. Beyond the greatest range there is no return (infinite), below the least the reading is invalid (NaN). What is nearer than the
//!    peak folds back and looks far, as on the real robot: the scan cannot tell, only what was seen before can
//!    ([`crate::points::BlindZone`]). Without [`RangerModel::folds`] such readings are taken to be recognised and invalid.
//!
//! The readings are handed on in the order of their bearings, with `sweep` 0: nothing moved meanwhile, and neighbours
//! in the scan are neighbours in the room.
//!
//! A robot that moves looks by single readings ([`look`]).
//!
//! Source: TDK 2016 §1.3 (four rangers, servo); Sharp GP2Y0A02 and GP2Y0A21 data sheets; the specification, "Sensors".

mod look;
#[cfg(test)]
mod tests;

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

use nalgebra::Vector2;
use rand::{Rng, RngExt};

use super::check::Check;
use super::{SensorError, Sharp, Span, View};
use crate::geom::{Pose2, sin_cos, wrap};
use crate::robot::{Adc, CalibrationPair, Characteristic, Fit, Scan, Stamp, Variable};
use crate::sim::Material;
use crate::sim::noise::gaussian_pair;

const RANGERS: usize = 4;
/// A pane answers within this angle of its normal, rad: the spot is seen by triangulation.
const GLASS_ANGLE: f64 = 0.1;
/// A dark surface sends so little back that the volts are so much noisier.
const DARK_NOISE: f64 = 1.5;
/// What is farther than this many greatest ranges sends nothing back.
const LIGHT_RANGE: f64 = 2.0;

/// Figures of four rangers on a servo.
#[derive(Clone, Debug, PartialEq)]
pub struct RangerModel {
    /// Type of the rangers. Default: long.
    pub sharp: Sharp,
    /// Positions of the servo in its 90°. Default 45: every 2°.
    pub positions: usize,
    /// Seconds at each position. Default 0.070, the firmware's: the servo has come to stand and the slowest cycle is over, so that
    /// what is read was measured there. Shorter reads what was measured at the position before.
    pub period: f64,
    /// Until the servo stands at a new angle, s. Default 0.022: its next pulse comes after 20 ms at the latest, and 2° take 2 ms.
    pub settle: f64,
    /// Mean cycle of a ranger, s. Default 0.0383.
    pub cycle: f64,
    /// How much the cycle of one ranger may differ from that, s. Default 0.0096.
    pub cycle_spread: f64,
    /// Nearest usable range, m. Default 0.2.
    pub min_range: f64,
    /// Farthest usable range, m. Default 1.5.
    pub max_range: f64,
    /// σ of the output, V. Default 0.015.
    pub volts_sigma: f64,
    /// What counts the volts. Default: 10 bits over 5 V.
    pub adc: Adc,
    /// What the characteristic is fitted to, by rising range. Default: the pairs of the data sheet.
    pub calibration: Vec<CalibrationPair>,
    /// What the characteristic is a polynomial of. Default: 1/volts.
    pub variable: Variable,
    /// σ of the servo's angle, rad. Default 0.005.
    pub bearing_sigma: f64,
    /// Part of the readings that are lost. Default 0.002.
    pub dropouts: f64,
    /// Part of the readings that are wrong: any volts at all. Default 0.001.
    pub outliers: f64,
    /// Whether things nearer than the peak look far, as on the real robot. Default true; false: they are recognised and invalid.
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
            sharp: Sharp::Long,
            positions: 45,
            period: 0.070,
            settle: 0.022,
            cycle: 0.0383,
            cycle_spread: 0.0096,
            min_range: 0.2,
            max_range: 1.5,
            volts_sigma: 0.015,
            adc: Adc::rp6(),
            calibration: Sharp::Long.data_sheet(),
            variable: Variable::PerVolt,
            bearing_sigma: 0.005,
            dropouts: 0.002,
            outliers: 0.001,
            folds: true,
            robot_from_sensor: Pose2::identity(),
        }
    }

    /// Sharp GP2Y0A21: 0.1 to 0.8 m.
    #[must_use]
    pub fn short() -> Self {
        Self {
            sharp: Sharp::Short,
            min_range: 0.1,
            max_range: 0.8,
            calibration: Sharp::Short.data_sheet(),
            ..Self::long()
        }
    }

    /// The characteristic that its readings go through.
    ///
    /// # Errors    [`SensorError::Calibration`] for pairs that settle none.
    pub fn fit(&self) -> Result<Fit, SensorError> {
        Ok(Characteristic::fit(&self.calibration, self.variable)?)
    }

    pub(super) fn validate(&self) -> Result<(), SensorError> {
        let check = Check("rangers");
        check.within("positions", self.positions as f64, [1.0, 10_000.0])?;
        check.within("period", self.period, [0.001, 60.0])?;
        check.within("settle", self.settle, [0.0, 60.0])?;
        check.within("cycle", self.cycle, [0.001, 60.0])?;
        check.within("cycle_spread", self.cycle_spread, [0.0, 0.9 * self.cycle])?;
        check.ranges(self.min_range, self.max_range, 100.0)?;
        check.size("volts_sigma", self.volts_sigma)?;
        check.within("bits", f64::from(self.adc.bits), [1.0, 31.0])?;
        check.positive("reference", self.adc.reference)?;
        check.size("bearing_sigma", self.bearing_sigma)?;
        check.part("dropouts", self.dropouts)?;
        check.part("outliers", self.outliers)?;
        self.fit().map(|_| ())
    }
}

/// Rangers at work.
#[derive(Clone, Debug)]
pub(in crate::sim) struct Rangers {
    model: RangerModel,
    inverse: Inverse,
    /// When the sweep under way began, s.
    began: Option<f64>,
    /// The cycles of the rangers: when the first ends after the sweep began, and how long they are, s.
    cycles: [(f64, f64); RANGERS],
    /// (bearing, range, σ) so far.
    readings: Vec<(f64, f32, f32)>,
    /// The look under way of a robot that moves.
    look: Option<look::Look>,
}

/// From counts to a range.
#[derive(Clone, Copy, Debug)]
struct Inverse {
    characteristic: Characteristic,
    /// Spread of the pairs about the characteristic, m.
    fit_sigma: f64,
    /// σ of the volts, V.
    volts_sigma: f64,
    min_range: f64,
    max_range: f64,
}

impl Rangers {
    /// # Errors    [`SensorError::Calibration`] for pairs that settle no characteristic.
    pub(super) fn new(model: &RangerModel) -> Result<Self, SensorError> {
        Ok(Self {
            inverse: Inverse::new(model)?,
            model: model.clone(),
            began: None,
            cycles: [(0.0, model.cycle); RANGERS],
            readings: Vec::new(),
            look: None,
        })
    }

    pub(super) fn begin(&mut self, seconds: f64) {
        self.began = Some(seconds);
        self.look = None;
        self.readings.clear();
    }

    pub(super) fn abort(&mut self) {
        self.began = None;
    }

    pub(super) fn step(&mut self, span: &Span, view: &View, rng: &mut impl Rng) -> Option<Scan> {
        let began = self.began?;
        loop {
            let position = self.readings.len() / RANGERS;
            let seconds = (position + 1) as f64 * self.model.period;
            if began + seconds > span.to + 1e-9 {
                return None;
            }
            if position == 0 {
                self.draw_cycles(rng);
            }
            for ranger in 0..RANGERS {
                let measured = self.held_position(ranger, seconds).min(position);
                let bearing = self.bearing(ranger, position);
                let volts = self.volts(
                    began + seconds,
                    self.bearing(ranger, measured),
                    span,
                    view,
                    rng,
                );
                let (range, sigma) = self.inverse.read(volts, &self.model);
                self.readings.push((bearing, range, sigma));
            }
            if position + 1 >= self.model.positions {
                return Some(self.complete(began + seconds));
            }
        }
    }

    /// Rangers run free of the servo and of one another.
    fn draw_cycles(&mut self, rng: &mut impl Rng) {
        for (first_end, cycle) in &mut self.cycles {
            let spread = self.model.cycle_spread * (2.0 * rng.random::<f64>() - 1.0);
            *cycle = self.model.cycle + spread;
            *first_end = *cycle * rng.random::<f64>();
        }
    }

    /// Where the servo stood at the end of the last cycle before `seconds` after the beginning.
    fn held_position(&self, ranger: usize, seconds: f64) -> usize {
        let Some((first_end, cycle)) = self.cycles.get(ranger) else {
            return 0;
        };
        let ends = ((seconds - first_end) / cycle).floor();
        let last_end = first_end + ends * cycle;
        // Before the sweep the servo stood at its first position; `as` takes what is negative to 0.
        ((last_end - self.model.settle) / self.model.period) as usize
    }

    fn bearing(&self, ranger: usize, position: usize) -> f64 {
        wrap(self.servo(position) + FRAC_PI_2 * ranger as f64)
    }

    fn servo(&self, position: usize) -> f64 {
        FRAC_PI_2 * position as f64 / self.model.positions as f64 - FRAC_PI_4
    }

    /// Where a sweep leaves the servo.
    fn servo_at_rest(&self) -> f64 {
        self.servo(self.model.positions.saturating_sub(1))
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
            qualities: vec![],
        }
    }

    /// What the converter is given; `None` for a reading that is lost or recognised as folded.
    fn volts(
        &self,
        seconds: f64,
        bearing: f64,
        span: &Span,
        view: &View,
        rng: &mut impl Rng,
    ) -> Option<f64> {
        let model = &self.model;
        let luck: f64 = rng.random();
        let (of_volts, of_bearing) = gaussian_pair(rng);
        if luck < model.dropouts {
            return None;
        }
        if luck > 1.0 - model.outliers {
            // What is left of `luck` is uniform too.
            return Some(model.adc.reference * (1.0 - luck) / model.outliers);
        }
        let (origin, heading) = span.sensor_at(seconds, &model.robot_from_sensor);
        let (sin, cos) = sin_cos(heading + bearing + model.bearing_sigma * of_bearing);
        let far = LIGHT_RANGE * model.max_range;
        let echo = view.echo(origin, Vector2::new(cos, sin), far, GLASS_ANGLE);
        let distance = echo.map_or(f64::INFINITY, |e| e.distance);
        if distance < model.min_range && !model.folds {
            return None;
        }
        let is_dark = echo.is_some_and(|e| e.material == Material::Dark);
        let noise = model.volts_sigma * if is_dark { DARK_NOISE } else { 1.0 };
        Some(model.sharp.volts_at(distance) + noise * of_volts)
    }
}

impl Inverse {
    fn new(model: &RangerModel) -> Result<Self, SensorError> {
        let fit = model.fit()?;
        Ok(Self {
            characteristic: fit.characteristic,
            fit_sigma: fit.sigma,
            volts_sigma: libm::hypot(model.volts_sigma, model.adc.sigma()),
            min_range: model.min_range,
            max_range: model.max_range,
        })
    }

    /// Range and σ of one reading.
    fn read(&self, volts: Option<f64>, model: &RangerModel) -> (f32, f32) {
        let Some(volts) = volts else {
            return (f32::NAN, self.max_range as f32);
        };
        let volts = model.adc.volts(model.adc.counts(volts));
        let range = self.characteristic.range_at(volts);
        let sigma = libm::hypot(
            self.volts_sigma * self.characteristic.slope_at(volts),
            self.fit_sigma,
        );
        let [lowest, _] = self.characteristic.domain();
        // Where the characteristic ends it says the same range for ever.
        if range >= self.max_range || volts <= lowest {
            return (f32::INFINITY, sigma as f32);
        }
        if range < self.min_range {
            return (f32::NAN, sigma as f32);
        }
        (range as f32, sigma as f32)
    }
}

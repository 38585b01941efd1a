//! Four infra-red rangers at 90° to one another on a servo that sweeps 90°: together they look all
//! round.
//!
//! Forward, from the world to counts:
//! 1. The robot stands still. The servo goes from -45° to just below +45° in steps, and all four
//!    rangers are read at each step.
//! 2. The servo reaches a new angle [`RangerModel::settle`] after the command. A ranger measures by
//!    itself, once in 38.3 ± 9.6 ms, and holds its output meanwhile: a reading may have been
//!    measured while the servo was still at the previous angle.
//! 3. The true range becomes volts ([`Sharp`]), which fold back closer than the peak; noise is
//!    added in volts; the converter has 10 bits.
//!
//! Inverse, from counts to a range with its σ: [`RangerInverse`]. Objects closer than the peak fold
//! back and look far away, as on the real robot. The scan cannot show this; only earlier
//! observations can ([`crate::points::BlindZone`]). Without [`RangerModel::folds`], such readings
//! are assumed to be recognised, and are invalid.
//!
//! The readings are returned in the order of their bearings, with `sweep` 0: the robot stood still,
//! and neighbours in the scan are neighbours in the room.
//!
//! A moving robot takes partial scans ([`partial_scan`]).
//!
//! Source: TDK 2016 §1.3 (four rangers, servo); Sharp GP2Y0A02 and GP2Y0A21 data sheets; the
//! specification, "Sensors".

mod partial_scan;
#[cfg(test)]
mod tests;

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

use rand::{Rng, RngExt};

use super::check::check_sensor;
use super::{SensorError, Span, View};
use crate::bounds::{Bounds, PART, POSITIVE};
use crate::geom::{unit_vector, wrap};
use crate::robot::{RangerInverse, RangerModel, Scan, Stamp};
use crate::sim::Material;
use crate::sim::noise::gaussian_pair;

const RANGERS: usize = 4;
/// A pane answers within this angle of its normal, rad: the spot is seen by triangulation.
const GLASS_ANGLE: f64 = 0.1;
/// Noise factor of a dark surface, because it sends so little back.
const DARK_NOISE: f64 = 1.5;
/// Beyond this many times the greatest range, nothing is sent back.
const LIGHT_RANGE: f64 = 2.0;

impl RangerModel {
    /// What [`Self::positions`] may be.
    pub const POSITIONS: Bounds = [5.0, 360.0];
    /// What [`Self::period`] may be, s.
    pub const PERIOD: Bounds = [0.005, 1.0];
    /// What [`Self::settle`] may be, s.
    pub const SETTLE: Bounds = [0.0, 1.0];
    /// What [`Self::min_range`] may be, m.
    pub const MIN_RANGE: Bounds = [0.02, 1.0];
    /// What [`Self::max_range`] may be, m; more than [`Self::min_range`].
    pub const MAX_RANGE: Bounds = [0.3, 5.0];
    /// What [`Self::volts_sigma`] may be, V.
    pub const VOLTS_SIGMA: Bounds = [0.0, 0.5];
    /// What [`Self::bearing_sigma`] may be, rad.
    pub const BEARING_SIGMA: Bounds = [0.0, 0.1];

    pub(super) fn validate(&self) -> Result<(), SensorError> {
        let nearest = f64::max(self.min_range, Self::MAX_RANGE[0]);
        check_sensor(
            "rangers",
            &[
                ("positions", self.positions as f64, Self::POSITIONS),
                ("period", self.period, Self::PERIOD),
                ("settle", self.settle, Self::SETTLE),
                ("cycle", self.cycle, [0.001, 60.0]),
                ("cycle_spread", self.cycle_spread, [0.0, 0.9 * self.cycle]),
                ("min_range", self.min_range, Self::MIN_RANGE),
                ("max_range", self.max_range, [nearest, Self::MAX_RANGE[1]]),
                ("volts_sigma", self.volts_sigma, Self::VOLTS_SIGMA),
                ("bits", f64::from(self.adc.bits), [1.0, 31.0]),
                ("reference", self.adc.reference, POSITIVE),
                ("bearing_sigma", self.bearing_sigma, Self::BEARING_SIGMA),
                ("dropouts", self.dropouts, PART),
                ("outliers", self.outliers, PART),
            ],
        )?;
        self.fit()?;
        Ok(())
    }
}

/// Rangers in operation.
#[derive(Clone, Debug)]
pub(in crate::sim) struct Rangers {
    model: RangerModel,
    inverse: RangerInverse,
    /// When the sweep in progress began, s.
    began: Option<f64>,
    /// The cycles of the rangers: when the first ends after the beginning of the sweep, and how
    /// long they are, s.
    cycles: [(f64, f64); RANGERS],
    /// (bearing, range, σ) so far.
    readings: Vec<(f64, f32, f32)>,
    /// The partial scan in progress of a moving robot.
    servo_move: Option<partial_scan::ServoMove>,
}

impl Rangers {
    /// # Errors    [`SensorError::Calibration`] for pairs that determine no characteristic.
    pub(super) fn new(model: &RangerModel) -> Result<Self, SensorError> {
        Ok(Self {
            inverse: model.inverse()?,
            model: model.clone(),
            began: None,
            cycles: [(0.0, model.cycle); RANGERS],
            readings: Vec::new(),
            servo_move: None,
        })
    }

    pub(super) fn begin(&mut self, seconds: f64) {
        self.began = Some(seconds);
        self.servo_move = None;
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
                let measured = self.bearing(ranger, measured);
                let volts = self.volts(began + seconds, measured, span, view, rng);
                let (range, sigma) = self.read(volts);
                let bearing = self.bearing(ranger, position);
                self.readings.push((bearing, range, sigma));
            }
            if position + 1 >= self.model.positions {
                return Some(self.complete(began + seconds));
            }
        }
    }

    /// Rangers run independently of the servo and of each other.
    fn draw_cycles(&mut self, rng: &mut impl Rng) {
        for (first_end, cycle) in &mut self.cycles {
            let spread = self.model.cycle_spread * (2.0 * rng.random::<f64>() - 1.0);
            *cycle = self.model.cycle + spread;
            *first_end = *cycle * rng.random::<f64>();
        }
    }

    /// The servo's position at the end of the last cycle before `seconds` after the beginning.
    fn held_position(&self, ranger: usize, seconds: f64) -> usize {
        let Some((first_end, cycle)) = self.cycles.get(ranger) else {
            return 0;
        };
        let ends = ((seconds - first_end) / cycle).floor();
        let last_end = first_end + ends * cycle;
        // Before the sweep the servo stood at its first position; `as` maps negative numbers to 0.
        ((last_end - self.model.settle) / self.model.period) as usize
    }

    fn bearing(&self, ranger: usize, position: usize) -> f64 {
        wrap(self.servo(position) + FRAC_PI_2 * ranger as f64)
    }

    fn servo(&self, position: usize) -> f64 {
        FRAC_PI_2 * position as f64 / self.model.positions as f64 - FRAC_PI_4
    }

    /// The servo's angle after a sweep.
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

    /// Range and σ of one reading, from its volts as converted.
    fn read(&self, volts: Option<f64>) -> (f32, f32) {
        let Some(volts) = volts else {
            return (f32::NAN, self.model.max_range as f32);
        };
        let adc = self.model.adc;
        self.inverse.read(adc.volts(adc.counts(volts)))
    }

    /// The input of the converter; `None` for a reading that is lost or recognised as folded.
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
            // The remainder of `luck` is uniform too.
            return Some(model.adc.reference * (1.0 - luck) / model.outliers);
        }
        let (origin, heading) = span.sensor_at(seconds, &model.robot_from_sensor);
        let direction = unit_vector(heading + bearing + model.bearing_sigma * of_bearing);
        let far = LIGHT_RANGE * model.max_range;
        let echo = view.echo(origin, direction, far, GLASS_ANGLE);
        let distance = echo.map_or(f64::INFINITY, |e| e.distance);
        if distance < model.min_range && !model.folds {
            return None;
        }
        let is_dark = echo.is_some_and(|e| e.material == Material::Dark);
        let noise = model.volts_sigma * if is_dark { DARK_NOISE } else { 1.0 };
        Some(model.sharp.volts_at(distance) + noise * of_volts)
    }
}

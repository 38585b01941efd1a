//! Infra-red rangers on a servo: their figures, and the conversion of volts to ranges.
//!
//! In: volts, as the converter reads them. Out: a range with its σ.
//!
//! 1. Volts become a range by a [`Characteristic`] fitted to the calibration pairs.
//! 2. σ is that of the volts (noise and quantisation) times the slope of the characteristic: the
//!    slope is proportional to d², so σ grows with it. The spread of the fit's residuals is added,
//!    as the error of the characteristic.
//! 3. From the greatest range on, and where the characteristic ends, the result is no return
//!    (infinite); below the least range the reading is invalid (NaN).
//!
//! The simulated rangers and those of a real RP6 use the same figures.
//!
//! Source: TDK 2016 §1.3 (four rangers, servo); Sharp GP2Y0A02 and GP2Y0A21 data sheets.

use std::f64::consts::FRAC_PI_6;

use super::{Adc, CalibrationPair, Characteristic, CharacteristicError, Fit, Sharp, Variable};
use crate::geom::Pose2;

/// Figures of four rangers on a servo.
#[derive(Clone, Debug, PartialEq)]
pub struct RangerModel {
    /// Type of the rangers. Default: long.
    pub sharp: Sharp,
    /// Positions of the servo in its 90°. Default 45: every 2°.
    pub positions: usize,
    /// Seconds at each position. Default 0.070, the firmware's: the servo has come to stand and the
    /// slowest cycle is over, so that what is read was measured there. Shorter reads what was
    /// measured at the position before.
    pub period: f64,
    /// Until the servo stands at a new angle, s. Default 0.022: its next pulse comes after 20 ms at
    /// the latest, and 2° take 2 ms.
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
    /// Whether things nearer than the peak look far, as on the real robot. Default true; false:
    /// they are recognised and invalid.
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
    /// Where the servo points in turn for partial scans while the robot moves, rad.
    pub const PARTIAL_SCAN: [f64; 4] = [0.0, FRAC_PI_6, 0.0, -FRAC_PI_6];

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

    /// Rangers of this type.
    #[must_use]
    pub fn of(sharp: Sharp) -> Self {
        match sharp {
            Sharp::Long => Self::long(),
            Sharp::Short => Self::short(),
        }
    }

    /// The characteristic that its readings go through.
    ///
    /// # Errors    [`CharacteristicError`] for pairs that determine none.
    pub fn fit(&self) -> Result<Fit, CharacteristicError> {
        Characteristic::fit(&self.calibration, self.variable)
    }

    /// The conversion of its volts to ranges.
    ///
    /// # Errors    [`CharacteristicError`] for pairs that determine no characteristic.
    pub fn inverse(&self) -> Result<RangerInverse, CharacteristicError> {
        let fit = self.fit()?;
        Ok(RangerInverse {
            characteristic: fit.characteristic,
            fit_sigma: fit.sigma,
            volts_sigma: libm::hypot(self.volts_sigma, self.adc.sigma()),
            min_range: self.min_range,
            max_range: self.max_range,
        })
    }
}

/// From volts to a range.
#[derive(Clone, Copy, Debug)]
pub struct RangerInverse {
    characteristic: Characteristic,
    /// Spread of the pairs about the characteristic, m.
    fit_sigma: f64,
    /// σ of the volts, V.
    volts_sigma: f64,
    min_range: f64,
    max_range: f64,
}

impl RangerInverse {
    /// Range and σ (m) of one reading.
    #[must_use]
    pub fn read(&self, volts: f64) -> (f32, f32) {
        let range = self.characteristic.range_at(volts);
        let of_volts = self.volts_sigma * self.characteristic.slope_at(volts);
        let sigma = libm::hypot(of_volts, self.fit_sigma) as f32;
        let [lowest, _] = self.characteristic.domain();
        // Where the characteristic ends, it gives the same range for all further volts.
        if range >= self.max_range || volts <= lowest {
            return (f32::INFINITY, sigma);
        }
        if range < self.min_range {
            return (f32::NAN, sigma);
        }
        (range as f32, sigma)
    }
}

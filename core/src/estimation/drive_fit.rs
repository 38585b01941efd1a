//! Everything that a recorded drive shows about its robot and its sensor: [`OdometryFit`], and σ(ρ)
//! from readings taken standing.

use super::{FittedParameter, OdometryFit, OdometryFitError};
use crate::points::{Growth, SigmaError, SigmaFit};

/// What a drive showed.
#[derive(Clone, Debug)]
pub struct DriveFit {
    /// The odometry errors.
    pub odometry: Result<OdometryFit, OdometryFitError>,
    /// The noise of the ranges, from readings taken standing; none if these were not examined.
    pub ranges: Option<Result<SigmaFit, SigmaError>>,
    /// Whether the sensor turns all the time, so that its σ(ρ) describes a simulated lidar too.
    pub is_lidar: bool,
}

impl DriveFit {
    /// All parameters with their standard errors; what could not be fitted contributes none.
    #[must_use]
    pub fn parameters(&self) -> Vec<FittedParameter> {
        let odometry = self.odometry.iter().flat_map(OdometryFit::parameters);
        odometry.chain(self.of_ranges()).collect()
    }

    fn of_ranges(&self) -> Vec<FittedParameter> {
        let Some(Ok(fit)) = &self.ranges else {
            return vec![];
        };
        let grows = match fit.growth {
            Growth::Linear => ["Growth of σ with the range", "m/m"],
            Growth::Square => ["Growth of σ with the squared range", "m/m²"],
        };
        // The simulated lidar's σ grows linearly, from a value above zero.
        let is_like_a_lidar = self.is_lidar
            && fit.growth == Growth::Linear
            && fit.coefficients[0] >= 1e-4
            && fit.coefficients[1] >= 0.0;
        let keys: [&'static [&'static str]; 2] = match is_like_a_lidar {
            true => [
                &["points.sigma_constant", "lidar.sigma"],
                &["points.sigma_slope", "lidar.sigma_per_metre"],
            ],
            false => [&["points.sigma_constant"], &["points.sigma_slope"]],
        };
        let row = |i: usize, name| {
            let figures = [fit.coefficients[i], fit.cov[(i, i)].sqrt(), f64::NAN];
            FittedParameter::new(keys[i], name, figures, "")
        };
        vec![row(0, ["σ of a range at 0 m", "m"]), row(1, grows)]
    }

    /// Keys and values of the settings for which the drive gave a value.
    #[must_use]
    pub fn settings(&self) -> Vec<(&'static str, f64)> {
        let odometry = self.odometry.iter().flat_map(OdometryFit::settings);
        let mut values: Vec<_> = odometry.collect();
        if let Some(Ok(fit)) = &self.ranges {
            let growth = match fit.growth {
                Growth::Linear => 1.0,
                Growth::Square => 2.0,
            };
            let least = fit.to_use().least;
            values.extend([("points.sigma", growth), ("points.sigma_least", least)]);
        }
        values.extend(self.of_ranges().iter().flat_map(FittedParameter::settings));
        values
    }

    /// Why something could not be fitted, in words.
    #[must_use]
    pub fn reasons(&self) -> Vec<String> {
        let odometry = self.odometry.as_ref().err();
        let odometry = odometry.map(|e| format!("Odometry: {e}"));
        let ranges = self.ranges.iter().find_map(|ranges| ranges.as_ref().err());
        let ranges = ranges.map(|e| format!("Ranges, from scans taken standing: {e}"));
        odometry.into_iter().chain(ranges).collect()
    }
}

#[cfg(test)]
mod tests;

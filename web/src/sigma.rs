//! σ(ρ) of a sensor from scans taken while standing, for the page.

use serde::{Deserialize, Serialize};
use slamlab_core::points::{SigmaBin as Bin, SigmaError, estimate_sigma};
use slamlab_core::robot::Scan;
use slamlab_core::sim::SensorModel;
use tsify::{Ts, Tsify};
use wasm_bindgen::prelude::wasm_bindgen;

use crate::border::{Float64Array, GrowthName, Typed, typed};
use crate::run::{RunError, Source, WebRun};

/// Number of scans of a standing twin from which σ(ρ) is estimated.
const STANDING_SCANS: usize = 120;
/// Number of points of the curve that the page draws.
const CURVE: u32 = 60;

/// σ(ρ) of a sensor with its uncertainty, estimated from scans taken while standing; m.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
#[serde(rename_all = "camelCase")]
pub struct SigmaCurve {
    /// How it grows.
    pub growth: GrowthName,
    /// Number of scans that were compared.
    pub scans: u32,
    /// Number of intervals in which the robot stood.
    pub stretches: u32,
    /// a (m) of σ = a + b ρ or a + b ρ².
    pub constant: f64,
    /// b (m/m or m/m²).
    pub slope: f64,
    /// The smallest σ to use, m.
    pub least: f64,
    /// Standard deviation of a.
    pub constant_error: f64,
    /// Standard deviation of b.
    pub slope_error: f64,
    /// χ² of the bins about the curve.
    pub chi_squared: f64,
    /// Its degrees of freedom.
    pub freedom: f64,
    /// Readings grouped by range.
    pub bins: Vec<SigmaBin>,
    /// Ranges of the curve, m.
    pub curve_ranges: Float64Array,
    /// σ there, m.
    pub curve_sigmas: Float64Array,
    /// The true σ there, with which a simulation drew its noise, m; empty if unknown.
    pub truth: Float64Array,
}

/// Readings of similar range.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Tsify)]
pub struct SigmaBin {
    /// Mean range, m.
    pub range: f64,
    /// σ, m.
    pub sigma: f64,
    /// Standard deviation of that σ, m.
    pub error: f64,
    /// Number of readings used.
    pub used: u32,
}

#[wasm_bindgen]
impl WebRun {
    /// σ(ρ) of the sensor: for a simulation from scans of a twin that stands where the robot is,
    /// for a recording from the intervals in which the robot stood.
    ///
    /// # Errors    A sentence on why it cannot be estimated.
    pub fn estimate_sigma(&self, growth: &Ts<GrowthName>) -> Typed<SigmaCurve> {
        let growth = growth.to_rust()?;
        typed(&match &self.source {
            Source::Simulation(sim) => {
                let scans = sim.experiment.standing_scans(STANDING_SCANS);
                let truth = match sim.experiment.sim().sensor() {
                    SensorModel::Lidar(model) => Some((model.sigma, model.sigma_per_metre)),
                    SensorModel::Sonar(model) => Some((model.sigma, model.sigma_per_metre)),
                    SensorModel::Rangers(_) => None,
                };
                SigmaCurve::of(&[&scans], growth, truth)?
            }
            Source::Recording(replay) => {
                let stretches = replay.standing_stretches();
                let stretches: Vec<&[Scan]> = stretches.iter().map(Vec::as_slice).collect();
                SigmaCurve::of(&stretches, growth, None)?
            }
            Source::Live(_) => return Err(RunError::NotRecorded.into()),
        })
    }
}

impl From<&Bin> for SigmaBin {
    fn from(bin: &Bin) -> Self {
        Self {
            range: bin.range,
            sigma: bin.sigma,
            error: bin.sigma * (0.75 / bin.used as f64).sqrt(),
            used: bin.used as u32,
        }
    }
}

impl SigmaCurve {
    /// `truth`: σ at distance zero and its growth, if a simulation knows them.
    pub(crate) fn of(
        stretches: &[&[Scan]],
        growth: GrowthName,
        truth: Option<(f64, f64)>,
    ) -> Result<Self, SigmaError> {
        let fit = estimate_sigma(stretches, growth.into())?;
        let used = fit.to_use();
        let farthest = fit.bins.iter().map(|bin| bin.range).fold(0.0, f64::max);
        let at = |i: u32| 1.05 * farthest * f64::from(i) / f64::from(CURVE);
        let ranges: Vec<f64> = (0..=CURVE).map(at).collect();
        let true_sigmas = |(a, b)| ranges.iter().map(|range| a + b * range).collect();
        Ok(Self {
            growth,
            scans: stretches.iter().map(|stretch| stretch.len() as u32).sum(),
            stretches: stretches.len() as u32,
            constant: used.constant,
            slope: used.slope,
            least: used.least,
            constant_error: fit.cov[(0, 0)].sqrt(),
            slope_error: fit.cov[(1, 1)].sqrt(),
            chi_squared: fit.chi_squared,
            freedom: fit.bins.len() as f64 - 2.0,
            bins: fit.bins.iter().map(Into::into).collect(),
            curve_sigmas: ranges.iter().map(|&range| used.at(range)).collect(),
            truth: truth.map(true_sigmas).unwrap_or_default(),
            curve_ranges: ranges.into(),
        })
    }
}

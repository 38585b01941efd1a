//! σ(ρ) of a sensor from scans taken standing, for the page.

use slamlab_core::points::{Growth, SigmaConfig, estimate_sigma_of_stretches};
use slamlab_core::robot::Scan;
use wasm_bindgen::prelude::{JsError, wasm_bindgen};

/// Points of the curve that the page draws.
const CURVE: u32 = 60;

/// There is no growth of that name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no growth `{0}`; expected linear or square")]
pub struct GrowthError(String);

/// σ(ρ) with its doubts.
#[wasm_bindgen(getter_with_clone)]
#[derive(Clone, Debug, PartialEq)]
pub struct SigmaCurve {
    /// Scans that were compared.
    pub scans: u32,
    /// Stretches in which the robot stood.
    pub stretches: u32,
    /// a (m) and b (m/m or m/m²) of σ = a + b ρ or a + b ρ², and the least σ to believe (m).
    pub coefficients: Vec<f64>,
    /// Standard deviations of a and b.
    pub errors: Vec<f64>,
    /// Misfit of the bins over their variance, and its degrees of freedom.
    pub chi_squared: Vec<f64>,
    /// For each bin: mean range (m), σ (m), standard deviation of that σ (m), readings used, readings left out.
    pub bins: Vec<f64>,
    /// Ranges of the curve, m.
    pub curve_ranges: Vec<f64>,
    /// σ there, m.
    pub curve_sigmas: Vec<f64>,
    /// σ there with which a simulation drew its noise, m; empty where nobody knows.
    pub truth: Vec<f64>,
}

impl SigmaCurve {
    /// `truth`: σ at no distance and its growth, where a simulation knows them.
    pub(crate) fn of(
        stretches: &[&[Scan]],
        growth: &str,
        truth: Option<(f64, f64)>,
    ) -> Result<Self, JsError> {
        let growth = match growth {
            "linear" => Growth::Linear,
            "square" => Growth::Square,
            other => return Err(GrowthError(other.to_owned()).into()),
        };
        let config = SigmaConfig {
            growth,
            ..SigmaConfig::default()
        };
        let fit = estimate_sigma_of_stretches(stretches, &config)?;
        let used = fit.to_use();
        let farthest = fit.bins.iter().map(|bin| bin.range).fold(0.0, f64::max);
        let at = |i: u32| 1.05 * farthest * f64::from(i) / f64::from(CURVE);
        let curve_ranges: Vec<f64> = (0..=CURVE).map(at).collect();
        let bins = fit.bins.iter().flat_map(|bin| {
            let (n, clipped) = (bin.used as f64, bin.clipped as f64);
            [
                bin.range,
                bin.sigma,
                bin.sigma * (0.75 / n).sqrt(),
                n,
                clipped,
            ]
        });
        Ok(Self {
            scans: stretches.iter().map(|stretch| stretch.len() as u32).sum(),
            stretches: stretches.len() as u32,
            coefficients: vec![used.constant, used.slope, used.least],
            errors: vec![fit.cov[(0, 0)].sqrt(), fit.cov[(1, 1)].sqrt()],
            chi_squared: vec![fit.chi_squared, fit.bins.len() as f64 - 2.0],
            bins: bins.collect(),
            curve_sigmas: curve_ranges.iter().map(|&range| used.at(range)).collect(),
            truth: truth
                .map(|(a, b)| curve_ranges.iter().map(|range| a + b * range).collect())
                .unwrap_or_default(),
            curve_ranges,
        })
    }
}

//! Calibration of infra-red rangers, for the page: pairs in, curve and residuals out.

use slamlab_core::format::calibration;
use slamlab_core::robot::Sharp;
use slamlab_core::robot::Variable;
use wasm_bindgen::prelude::{JsError, wasm_bindgen};

/// Points of the curve that the page draws.
const CURVE: u32 = 200;

/// Why a calibration cannot be asked for.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum CalibrationError {
    /// No variable of that name.
    #[error("there is no variable `{0}`; expected volts or per-volt")]
    Variable(String),
}

/// A characteristic and how well it fits.
#[wasm_bindgen(getter_with_clone)]
#[derive(Clone, Debug, PartialEq)]
pub struct Calibration {
    /// True ranges of the pairs, m.
    pub ranges: Vec<f64>,
    /// Volts of the pairs.
    pub volts: Vec<f64>,
    /// Fitted less true range of each pair, m.
    pub residuals: Vec<f64>,
    /// Spread of the pairs about the curve, m.
    pub sigma: f64,
    /// Volts at which the curve turns round; NaN where it falls all along.
    pub reverses_at: f64,
    /// Lowest and highest volts: beyond, volts are clamped.
    pub domain: Vec<f64>,
    /// Volts of the curve, somewhat beyond the domain.
    pub curve_volts: Vec<f64>,
    /// Its ranges, m.
    pub curve_ranges: Vec<f64>,
}

/// Fits a characteristic of the fifth degree in `volts` or `per-volt` (1/V) to pairs in the format of
/// `slamlab_core::format::calibration`.
///
/// # Errors    A sentence with line and field of what is wrong.
#[wasm_bindgen]
pub fn calibrate(text: &str, variable: &str) -> Result<Calibration, JsError> {
    let (pairs, fit) = calibration::fit(text.as_bytes(), variable_of(variable)?)?;
    let [low, high] = fit.characteristic.domain();
    let beyond = 0.06 * (high - low);
    let span = high - low + 2.0 * beyond;
    let at = |i: u32| (low - beyond).max(0.0) + span * f64::from(i) / f64::from(CURVE);
    let curve_volts: Vec<f64> = (0..=CURVE).map(at).collect();
    Ok(Calibration {
        ranges: pairs.iter().map(|pair| pair.range).collect(),
        volts: pairs.iter().map(|pair| pair.volts).collect(),
        residuals: fit.residuals,
        sigma: fit.sigma,
        reverses_at: fit.reverses_at.unwrap_or(f64::NAN),
        domain: vec![low, high],
        curve_ranges: curve_volts
            .iter()
            .map(|&v| fit.characteristic.range_at(v))
            .collect(),
        curve_volts,
    })
}

/// The pairs of the data sheet of the rangers that are simulated, as text.
#[wasm_bindgen]
#[must_use]
pub fn data_sheet() -> String {
    let pairs = Sharp::default().data_sheet();
    let rows = pairs
        .iter()
        .map(|p| format!("{:.0};{:.2}\n", 100.0 * p.range, p.volts));
    format!("range_cm;volts\n{}", rows.collect::<String>())
}

/// # Errors    [`CalibrationError::Variable`].
pub(crate) fn variable_of(name: &str) -> Result<Variable, CalibrationError> {
    match name {
        "volts" => Ok(Variable::Volts),
        "per-volt" => Ok(Variable::PerVolt),
        other => Err(CalibrationError::Variable(other.to_owned())),
    }
}

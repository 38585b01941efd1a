//! Calibration of infra-red rangers, for the page: pairs in, curve and residuals out.

use serde::{Deserialize, Serialize};
use slamlab_core::format::calibration;
use tsify::{Ts, Tsify};
use wasm_bindgen::prelude::wasm_bindgen;

use crate::border::{Float64Array, Typed, VariableName, typed};

/// Points of the curve that the page draws.
const CURVE: u32 = 200;

/// Calibration pairs of a ranger as text, and what the characteristic is a polynomial of.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
pub struct Pairs {
    /// In the format of `slamlab_core::format::calibration`.
    pub text: String,
    /// V or 1/V.
    pub variable: VariableName,
}

/// A characteristic of the fifth degree and how well it fits; m and V.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
#[serde(rename_all = "camelCase")]
pub struct Calibration {
    /// True ranges of the pairs.
    pub ranges: Float64Array,
    /// Volts of the pairs.
    pub volts: Float64Array,
    /// Fitted minus true range of each pair.
    pub residuals: Float64Array,
    /// Spread of the pairs about the curve, m.
    pub sigma: f64,
    /// Voltage at which the curve changes direction; NaN if it falls everywhere.
    pub reverses_at: f64,
    /// Lowest and highest voltage; beyond them, voltages are clamped.
    pub domain: [f64; 2],
    /// Voltages of the curve, somewhat beyond the domain.
    pub curve_volts: Float64Array,
    /// Its ranges.
    pub curve_ranges: Float64Array,
}

/// Fits a characteristic to pairs.
///
/// # Errors    A sentence on what is wrong, with line and field.
#[wasm_bindgen]
pub fn calibrate(pairs: &Ts<Pairs>) -> Typed<Calibration> {
    let Pairs { text, variable } = pairs.to_rust()?;
    let (pairs, fit) = calibration::fit(text.as_bytes(), variable.into())?;
    let [low, high] = fit.characteristic.domain();
    let beyond = 0.06 * (high - low);
    let span = high - low + 2.0 * beyond;
    let at = |i: u32| (low - beyond).max(0.0) + span * f64::from(i) / f64::from(CURVE);
    let volts: Vec<f64> = (0..=CURVE).map(at).collect();
    let curve = volts.iter().map(|&v| fit.characteristic.range_at(v));
    typed(&Calibration {
        ranges: pairs.iter().map(|pair| pair.range).collect(),
        volts: pairs.iter().map(|pair| pair.volts).collect(),
        residuals: fit.residuals.into(),
        sigma: fit.sigma,
        reverses_at: fit.reverses_at.unwrap_or(f64::NAN),
        domain: [low, high],
        curve_ranges: curve.collect(),
        curve_volts: volts.into(),
    })
}

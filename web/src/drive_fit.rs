//! What a drive tells of its robot, and the twin beside it, for the page.

use slamlab_core::estimation::{DriveFit, FittedParameter};
use slamlab_core::format::preset::{self, FittedLine, PresetFile};
use slamlab_core::robot::{OdometryCalibration, RobotModel};
use slamlab_core::settings::Settings;
use slamlab_core::twin::{Twin, TwinSample};
use wasm_bindgen::prelude::{JsError, wasm_bindgen};

use crate::settings::apply_present;

/// What a drive told, one entry of each list a parameter.
#[wasm_bindgen(getter_with_clone)]
#[derive(Clone, Debug, PartialEq)]
pub struct FitTable {
    /// Name and unit of each parameter, and why it is not known (empty where it is), one after the other.
    pub words: Vec<String>,
    /// Value, standard error (NaN for none) and what the model says (NaN for nothing) of each.
    pub numbers: Vec<f64>,
    /// What could not be fitted at all, in words.
    pub reasons: Vec<String>,
    /// Settings that take what is known.
    pub keys: Vec<String>,
    /// Their numbers.
    pub values: Vec<f64>,
    /// Legs that were used, and legs that the model could not explain.
    pub legs: Vec<u32>,
}

impl FitTable {
    pub(crate) fn of(fit: &DriveFit) -> Self {
        let parameters = fit.parameters();
        let words = |p: &FittedParameter| [p.name, p.unit, p.verdict.reason()].map(str::to_owned);
        let settings = fit.settings();
        let legs = fit
            .odometry
            .as_ref()
            .map_or([0; 2], |o| [o.legs, o.left_out]);
        Self {
            words: parameters.iter().flat_map(words).collect(),
            numbers: parameters
                .iter()
                .flat_map(|p| [p.value, p.sigma, p.model])
                .collect(),
            reasons: fit.reasons(),
            keys: settings.iter().map(|(key, _)| (*key).to_owned()).collect(),
            values: settings.iter().map(|(_, value)| *value).collect(),
            legs: legs.map(|count| count as u32).to_vec(),
        }
    }
}

/// A preset as its file holds it.
#[wasm_bindgen(getter_with_clone)]
#[derive(Clone, Debug, PartialEq)]
pub struct PresetText {
    /// For people.
    pub name: String,
    /// Keys of settings.
    pub keys: Vec<String>,
    /// Their numbers.
    pub values: Vec<f64>,
}

/// Reads a preset file.
///
/// # Errors    A sentence on what is wrong, with its place.
#[wasm_bindgen]
pub fn read_preset(bytes: &[u8]) -> Result<PresetText, JsError> {
    let file = preset::read(bytes)?;
    let (keys, values) = file.settings.into_iter().unzip();
    Ok(PresetText {
        name: file.name,
        keys,
        values,
    })
}

/// A fit as a preset file.
#[wasm_bindgen]
#[must_use]
pub fn write_preset(name: &str, fit: &FitTable) -> String {
    let settings = fit.keys.iter().cloned().zip(fit.values.iter().copied());
    let lines = fit.words.chunks_exact(3).zip(fit.numbers.chunks_exact(3));
    let lines = lines.map(|(words, numbers)| FittedLine {
        name: words[0].clone(),
        unit: words[1].clone(),
        value: numbers[0],
        sigma: Some(numbers[1]).filter(|sigma| sigma.is_finite()),
        unknown: words[2].clone(),
    });
    let file = PresetFile {
        name: name.to_owned(),
        settings: settings.collect(),
    };
    preset::write(&file, &lines.collect::<Vec<_>>())
}

/// What the settings tell of the odometry of a robot of this model.
///
/// # Errors    A sentence on a setting that does not exist.
pub(crate) fn told(
    robot: &RobotModel,
    keys: &[String],
    values: &[f64],
) -> Result<OdometryCalibration, JsError> {
    let mut settings = Settings::of_robot(robot, false);
    apply_present(&mut settings, keys, values)?;
    Ok(settings.odometry.calibration(robot))
}

/// Samples of the twin from number `from` on, see `TWIN` of www/src/protocol/figures.ts.
pub(crate) fn samples_since(twin: Option<&Twin>, from: u32) -> Vec<f64> {
    let samples = twin.map_or(&[][..], Twin::samples);
    let flat = |s: &TwinSample| {
        [
            s.seconds,
            s.twin.x(),
            s.twin.y(),
            s.twin.heading(),
            s.position,
            s.position_sigma3,
            s.heading,
            s.heading_sigma3,
            s.ranges.unwrap_or(f64::NAN),
        ]
    };
    samples.iter().skip(from as usize).flat_map(flat).collect()
}

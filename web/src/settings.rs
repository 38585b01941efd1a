//! The table of settings, for the page.

use slamlab_core::settings::{Acts, Kind, PRESETS, SettingError, Settings, table};
use slamlab_core::sim::{RobotKind, SensorKind};
use wasm_bindgen::prelude::{JsError, wasm_bindgen};

/// One setting; see `Setting` of the core.
#[wasm_bindgen(getter_with_clone)]
#[derive(Clone, Debug, PartialEq)]
#[expect(missing_docs, reason = "names and units as in `Setting` of the core")]
pub struct SettingInfo {
    pub key: String,
    pub group: String,
    pub name: String,
    pub unit: String,
    pub low: f64,
    pub high: f64,
    /// `real`, `whole`, `switch` or `choice`.
    pub kind: String,
    pub choices: Vec<String>,
    pub at_once: bool,
    pub meaning: String,
    /// NaN where it comes with a choice that is not made.
    pub default: f64,
}

/// A preset; see `Preset` of the core.
#[wasm_bindgen(getter_with_clone)]
#[derive(Clone, Debug, PartialEq)]
#[expect(missing_docs, reason = "names as in `Preset` of the core")]
pub struct PresetInfo {
    pub group: String,
    pub name: String,
    pub meaning: String,
    pub keys: Vec<String>,
    pub values: Vec<f64>,
}

/// The settings of a run with this sensor, changed as given; their defaults without the changes.
///
/// # Errors    A sentence on a sensor or a setting that does not exist.
#[wasm_bindgen]
#[allow(
    clippy::needless_pass_by_value,
    reason = "lists of text cross the border by value only"
)]
pub fn setting_list(
    sensor: &str,
    keys: Vec<String>,
    values: Vec<f64>,
) -> Result<Vec<SettingInfo>, JsError> {
    let kind: SensorKind = sensor.parse()?;
    let defaults = Settings::of(kind.model(), &RobotKind::default().model());
    let mut settings = defaults.clone();
    apply(&mut settings, &keys, &values)?;
    let present = table().filter(|setting| settings.get(setting).is_some());
    Ok(present
        .map(|setting| SettingInfo {
            key: setting.key.to_owned(),
            group: setting.group.to_owned(),
            name: setting.name.to_owned(),
            unit: setting.unit.to_owned(),
            low: setting.range[0],
            high: setting.range[1],
            kind: match setting.kind {
                Kind::Real => "real",
                Kind::Whole => "whole",
                Kind::Switch => "switch",
                Kind::Choice(_) => "choice",
            }
            .to_owned(),
            choices: match setting.kind {
                Kind::Choice(names) => names.iter().map(|&name| name.to_owned()).collect(),
                _ => vec![],
            },
            at_once: setting.acts == Acts::AtOnce,
            meaning: setting.meaning.to_owned(),
            default: defaults
                .get(setting)
                .or(settings.get(setting))
                .unwrap_or(f64::NAN),
        })
        .collect())
}

/// All presets.
#[wasm_bindgen]
#[must_use]
pub fn preset_list() -> Vec<PresetInfo> {
    let info = |preset: &slamlab_core::settings::Preset| PresetInfo {
        group: preset.group.to_owned(),
        name: preset.name.to_owned(),
        meaning: preset.meaning.to_owned(),
        keys: preset
            .values
            .iter()
            .map(|(key, _)| (*key).to_owned())
            .collect(),
        values: preset.values.iter().map(|(_, value)| *value).collect(),
    };
    PRESETS.iter().map(info).collect()
}

/// Sets all of them, choices before the settings that come with them: in the order of the table.
///
/// # Errors    [`SettingError`] for the first that cannot be.
pub(crate) fn apply(
    settings: &mut Settings,
    keys: &[String],
    values: &[f64],
) -> Result<(), SettingError> {
    settings.set_all(keys.iter().map(String::as_str).zip(values.iter().copied()))
}

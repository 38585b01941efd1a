//! The table of settings, for the page.

use slamlab_core::settings::{Acts, Kind, Needs, PRESETS, Scope, Setting, Settings, Source, table};
use slamlab_core::sim::{RobotKind, SensorKind};
use wasm_bindgen::prelude::{JsError, wasm_bindgen};

/// One setting; see `Setting` of the core. Numbers are as stored: what a person reads is `scale` times as much, in `unit`.
#[wasm_bindgen(getter_with_clone)]
#[derive(Clone, Debug, PartialEq)]
#[expect(missing_docs, reason = "names and units as in `Setting` of the core")]
pub struct SettingInfo {
    pub key: String,
    pub group: String,
    pub name: String,
    pub unit: String,
    pub scale: f64,
    pub low: f64,
    pub high: f64,
    /// `real`, `whole`, `switch` or `choice`.
    pub kind: String,
    pub choices: Vec<String>,
    pub at_once: bool,
    pub is_basic: bool,
    pub meaning: String,
    pub default: f64,
    /// Key of the setting that it depends on; empty for none.
    pub needs: String,
    /// Numbers of that one with which it has an effect; empty: all above 0.
    pub needed: Vec<f64>,
    /// Why it has no effect on this run; empty where it has.
    pub idle: String,
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

/// No source of that name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no source `{0}`")]
pub(crate) struct UnknownSource(String);

/// All settings for a run fed by this source (`sim`, `replay` or `bridge`), with this method and sensor, changed as given.
///
/// # Errors    A sentence on a source, a method, a sensor or a setting that does not exist.
#[wasm_bindgen]
#[allow(
    clippy::needless_pass_by_value,
    reason = "lists of text cross the border by value only"
)]
pub fn setting_list(
    source: &str,
    method: &str,
    sensor: &str,
    keys: Vec<String>,
    values: Vec<f64>,
) -> Result<Vec<SettingInfo>, JsError> {
    let row = Source::ALL.iter().find(|(name, ..)| *name == source);
    let (_, source, _) = *row.ok_or_else(|| UnknownSource(source.to_owned()))?;
    let scope = Scope {
        source,
        method: method.parse()?,
    };
    let kind: SensorKind = sensor.parse()?;
    let defaults = Settings::of(kind.model(), &RobotKind::default().model());
    let mut settings = defaults.clone();
    let changes = keys.iter().map(String::as_str);
    settings.take(&scope, changes.zip(values.iter().copied()))?;
    let info = |setting: &Setting| info(setting, &defaults, &settings, &scope);
    Ok(table().map(info).collect())
}

fn info(setting: &Setting, defaults: &Settings, settings: &Settings, scope: &Scope) -> SettingInfo {
    let (needs, needed) = needs_of(setting);
    let titles = match setting.kind {
        Kind::Choice(_) => setting.names(),
        _ => vec![],
    };
    let default = defaults.get(setting).or(settings.get(setting));
    let idle = settings.idle(setting, scope);
    SettingInfo {
        key: setting.key.to_owned(),
        group: setting.group.to_owned(),
        name: setting.name.to_owned(),
        unit: setting.unit.shown.to_owned(),
        scale: setting.unit.scale,
        low: setting.range[0],
        high: setting.range[1],
        kind: match setting.kind {
            Kind::Real => "real",
            Kind::Whole => "whole",
            Kind::Switch => "switch",
            Kind::Choice(_) => "choice",
        }
        .to_owned(),
        choices: titles.iter().map(|named| named.title.to_owned()).collect(),
        at_once: setting.acts == Acts::AtOnce,
        is_basic: setting.is_basic,
        meaning: setting.meaning.to_owned(),
        // A setting that has no number here has no effect either.
        default: default.unwrap_or(f64::NAN),
        needs: needs.to_owned(),
        needed,
        idle: idle.map_or_else(String::new, |idle| idle.to_string()),
    }
}

/// The setting that this one depends on, and the numbers of that.
fn needs_of(setting: &Setting) -> (&'static str, Vec<f64>) {
    match setting.needs {
        Needs::Nothing | Needs::Sensor(_) => ("", vec![]),
        Needs::MoreThanZero(key) => (key, vec![]),
        Needs::Choice { key, is } => {
            let other = table().find(|other| other.key == key);
            let names = other.map(Setting::names).unwrap_or_default();
            let numbers = names.iter().zip(0_u8..);
            let needed = numbers.filter(|(named, _)| is.contains(&named.name));
            (key, needed.map(|(_, at)| f64::from(at)).collect())
        }
    }
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

//! The table of settings, for the page.

use serde::{Deserialize, Serialize};
use slamlab_core::settings::{
    Acts, Kind, Needs, Preset, Scope, Setting, Settings, Source as SettingSource, table,
};
use tsify::{Ts, Tsify};
use wasm_bindgen::prelude::wasm_bindgen;

use crate::border::{SettingKind, SettingValues, WebError, typed};
use crate::run::{Source, WebRun};

/// One setting of a run; see `Setting` of the core. Numbers are as stored: a person reads `scale`
/// times as much, in `unit`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
#[serde(rename_all = "camelCase")]
#[expect(missing_docs, reason = "names and units as in `Setting` of the core")]
pub struct SettingInfo {
    pub key: String,
    pub group: String,
    pub name: String,
    pub unit: String,
    pub scale: f64,
    pub low: f64,
    pub high: f64,
    pub kind: SettingKind,
    pub choices: Vec<String>,
    pub at_once: bool,
    pub is_basic: bool,
    pub meaning: String,
    pub default: f64,
    /// Key of the setting that it depends on; empty if there is none.
    pub needs: String,
    /// Values of that setting with which it has an effect; empty: all above 0.
    pub needed: Vec<f64>,
    /// Why it has no effect on this run; empty if it has one.
    pub idle: String,
}

/// A preset; see `Preset` of the core.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
#[tsify(hashmap_as_object)]
#[expect(missing_docs, reason = "names as in `Preset` of the core")]
pub struct PresetInfo {
    pub group: String,
    pub name: String,
    pub meaning: String,
    pub values: SettingValues,
}

impl From<&Preset> for PresetInfo {
    fn from(preset: &Preset) -> Self {
        Self {
            group: preset.group.to_owned(),
            name: preset.name.to_owned(),
            meaning: preset.meaning.to_owned(),
            values: preset.values.iter().copied().collect(),
        }
    }
}

#[wasm_bindgen]
impl WebRun {
    /// All settings of this run, changed as given. Their defaults are those of its robot and
    /// sensor.
    ///
    /// # Errors    A sentence on an unknown setting or an invalid value.
    pub fn settings(&self, changes: &Ts<SettingValues>) -> Result<Vec<Ts<SettingInfo>>, WebError> {
        let (source, defaults) = match &self.source {
            Source::Simulation(sim) => (SettingSource::Simulation, sim.defaults.clone()),
            Source::Recording(replay) => (SettingSource::Recording, replay.log().settings()),
            Source::Live(live) => (SettingSource::Live, live.defaults()),
        };
        let scope = Scope {
            source,
            method: self.session().slam().method(),
        };
        let mut settings = defaults.clone();
        settings.take(&scope, changes.to_rust()?.pairs())?;
        table()
            .map(|setting| typed(&info(setting, &defaults, &settings, &scope)))
            .collect()
    }
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
        kind: (&setting.kind).into(),
        choices: titles.iter().map(|named| named.title.to_owned()).collect(),
        at_once: setting.acts == Acts::AtOnce,
        is_basic: setting.is_basic,
        meaning: setting.meaning.to_owned(),
        // A setting without a number here has no effect either.
        default: default.unwrap_or(f64::NAN),
        needs: needs.to_owned(),
        needed,
        idle: idle.map_or_else(String::new, |idle| idle.to_string()),
    }
}

/// The setting that this one depends on, and the required values.
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

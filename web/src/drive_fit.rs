//! What a drive reveals about its robot, and the twin beside it, for the page.

use serde::{Deserialize, Serialize};
use slamlab_core::estimation::{self, FittedParameter as CoreParameter};
use slamlab_core::format::preset::{self, FittedLine, PresetFile as CoreFile};
use slamlab_core::robot::RobotModel;
use slamlab_core::settings::{self, Settings};
use slamlab_core::sim::SensorModel;
use slamlab_core::slam::Method;
use slamlab_core::twin::{Twin, TwinSample};
use tsify::{Ts, Tsify};
use wasm_bindgen::prelude::wasm_bindgen;

use crate::border::{SettingValues, TwinRow, Typed, WebError, flat, typed};
use crate::run::{Source, WebRun};

/// What was estimated of a robot from a drive.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
#[serde(rename_all = "camelCase")]
#[tsify(hashmap_as_object)]
pub struct DriveFit {
    /// The parameters that were estimated.
    pub parameters: Vec<FittedParameter>,
    /// What could not be fitted at all, in words.
    pub reasons: Vec<String>,
    /// Settings that apply the parameters that are known.
    pub settings: SettingValues,
    /// Legs that were used.
    pub legs: u32,
    /// Legs that did not fit the model.
    pub left_out: u32,
}

/// A parameter as fitted to a drive.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
pub struct FittedParameter {
    /// For people.
    pub name: String,
    /// Unit of the value.
    pub unit: String,
    /// Fitted value.
    pub value: f64,
    /// Standard error; NaN if there is none.
    pub sigma: f64,
    /// Value in the robot's model; NaN if it has none.
    pub model: f64,
    /// Why the drive does not determine it; empty if it does.
    pub unknown: String,
}

#[wasm_bindgen]
impl WebRun {
    /// Turns on or off a twin beside the robot, with what is known of the odometry.
    pub fn set_twin(&mut self, on: bool) {
        let calibration = on.then(|| *self.session().calibration());
        match &mut self.source {
            Source::Simulation(sim) => sim.experiment.set_twin(calibration),
            Source::Recording(replay) => replay.set_twin(calibration),
            Source::Live(live) => live.set_twin(calibration),
        }
    }

    /// What the drive so far reveals about the robot; nothing for a simulated one, whose figures
    /// are settings.
    ///
    /// # Errors    None that a page can cause.
    pub fn fit(&self) -> Result<Option<Ts<DriveFit>>, WebError> {
        let fit = match &self.source {
            Source::Simulation(_) => None,
            Source::Recording(replay) => Some(replay.fit()),
            Source::Live(live) => Some(live.session().fit()),
        };
        fit.map(|fit| typed(&fit.into())).transpose()
    }

    /// Samples of the twin from number `from` on, see `TWIN`.
    #[must_use]
    pub fn twin_since(&self, from: u32) -> Vec<f64> {
        let samples = self.session().twin().map_or(&[][..], Twin::samples);
        let row = |s: &TwinSample| TwinRow {
            time: s.seconds,
            x: s.twin.x(),
            y: s.twin.y(),
            heading: s.twin.heading(),
            position_off: s.position,
            position_sigma3: s.position_sigma3,
            heading_off: s.heading,
            heading_sigma3: s.heading_sigma3,
            ranges: s.ranges.unwrap_or(f64::NAN),
        };
        flat(samples.iter().skip(from as usize).map(row))
    }
}

impl From<&CoreParameter> for FittedParameter {
    fn from(parameter: &CoreParameter) -> Self {
        Self {
            name: parameter.name.to_owned(),
            unit: parameter.unit.to_owned(),
            value: parameter.value,
            sigma: parameter.sigma,
            model: parameter.model,
            unknown: parameter.unknown.to_owned(),
        }
    }
}

impl From<estimation::DriveFit> for DriveFit {
    fn from(fit: estimation::DriveFit) -> Self {
        let [legs, left_out] = fit
            .odometry
            .as_ref()
            .map_or([0; 2], |o| [o.legs, o.left_out]);
        Self {
            parameters: fit.parameters().iter().map(Into::into).collect(),
            reasons: fit.reasons(),
            settings: fit.settings().into_iter().collect(),
            legs: legs as u32,
            left_out: left_out as u32,
        }
    }
}

/// The content of a preset file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
#[tsify(hashmap_as_object)]
pub struct PresetFile {
    /// For people.
    pub name: String,
    /// What it sets.
    pub settings: SettingValues,
}

/// Reads a preset file, and checks its keys and ranges.
///
/// # Errors    A sentence on what is wrong, and where.
#[wasm_bindgen]
pub fn read_preset(bytes: &[u8]) -> Typed<PresetFile> {
    let CoreFile { name, settings } = preset::read(bytes)?;
    let settings: SettingValues = settings.into_iter().collect();
    // Keys and ranges are checked whatever run will use the preset.
    let mut checked = Settings::of(SensorModel::lidar(), &RobotModel::rp6());
    settings.apply_to(&mut checked, settings::Source::Simulation, Method::LineEkf)?;
    typed(&PresetFile { name, settings })
}

/// A fit as the text of a preset file.
///
/// # Errors    The fit is invalid.
#[wasm_bindgen]
pub fn write_preset(name: &str, fit: &Ts<DriveFit>) -> Result<String, WebError> {
    let fit = fit.to_rust()?;
    let line = |p: FittedParameter| FittedLine {
        name: p.name,
        unit: p.unit,
        value: p.value,
        sigma: Some(p.sigma).filter(|sigma| sigma.is_finite()),
        unknown: p.unknown,
    };
    let file = CoreFile {
        name: name.to_owned(),
        settings: fit.settings.0.into_iter().collect(),
    };
    let lines: Vec<_> = fit.parameters.into_iter().map(line).collect();
    Ok(preset::write(&file, &lines))
}

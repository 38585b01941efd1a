//! What a simulated run starts from, as the page says it.

use slamlab_core::experiment::ExperimentConfig;
use slamlab_core::format::{calibration, world};
use slamlab_core::pilot::Mode;
use slamlab_core::settings::Settings;
use slamlab_core::sim::{SensorKind, SensorModel, World, worlds};
use wasm_bindgen::prelude::{JsError, wasm_bindgen};

use crate::building::Known;
use crate::calibration::variable_of;
use crate::settings::apply;

/// Why a setup names something that does not exist.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SetupError {
    /// No built-in world of that name.
    #[error("there is no world `{0}`; expected one of {expected}", expected = worlds::NAMES.join(", "))]
    World(String),
    /// Calibration pairs for a sensor without.
    #[error("calibration pairs belong to IR rangers; this run has another sensor")]
    Calibration,
    /// No mode of that name to start with.
    #[error("there is no mode `{0}` to start with; expected manual or explore")]
    Mode(String),
}

/// What a simulated run starts from.
#[wasm_bindgen(getter_with_clone)]
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WebSetup {
    /// Name of a built-in world, or the text of a world file.
    pub world: String,
    /// Whether it is the text.
    pub is_file: bool,
    /// Name of the sensor.
    pub sensor: String,
    /// Of all noise.
    pub seed: u32,
    /// Name of the method.
    pub method: String,
    /// `manual` or `explore`.
    pub mode: String,
    /// Whether it drives by the cycle.
    pub cycle: bool,
    /// Settings that differ from their defaults.
    pub keys: Vec<String>,
    /// Their numbers.
    pub values: Vec<f64>,
    /// Calibration pairs of the rangers as text; empty for those of the data sheet.
    pub calibration: String,
    /// What their characteristic is a polynomial of: `volts` or `per-volt`.
    pub variable: String,
    /// The map that the method `known-map` finds the robot in; by default the walls of the world.
    pub known: Option<Known>,
}

#[wasm_bindgen]
impl WebSetup {
    /// An empty setup.
    #[wasm_bindgen(constructor)]
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }
}

impl WebSetup {
    /// The run that it describes, and its settings.
    ///
    /// # Errors    A sentence on the first thing that cannot be.
    pub(crate) fn read(&self) -> Result<(ExperimentConfig, Settings), JsError> {
        let world = load_world(&self.world, self.is_file)?;
        let sensor: SensorKind = self.sensor.parse()?;
        let mode = match self.mode.as_str() {
            "manual" => Mode::Manual,
            "explore" => Mode::Explore,
            other => return Err(SetupError::Mode(other.to_owned()).into()),
        };
        let robot = world.robot.model();
        let mut settings = Settings::of(sensor.model(), &robot);
        apply(&mut settings, &self.keys, &self.values)?;
        if !self.calibration.is_empty() {
            let SensorModel::Rangers(rangers) = &mut settings.sensor else {
                return Err(SetupError::Calibration.into());
            };
            rangers.variable = variable_of(&self.variable)?;
            rangers.calibration =
                calibration::fit(self.calibration.as_bytes(), rangers.variable)?.0;
        }
        let mut config = ExperimentConfig::of(&settings, world, robot, u64::from(self.seed));
        config.method = self.method.parse()?;
        config.mode = mode;
        config.cycle = self.cycle;
        if let Some(known) = &self.known {
            config.slam.prior_map = known.into();
        }
        Ok((config, settings))
    }
}

fn load_world(world: &str, is_file: bool) -> Result<World, JsError> {
    if is_file {
        return Ok(world::read(world.as_bytes())?);
    }
    worlds::builtin(world).ok_or_else(|| SetupError::World(world.to_owned()).into())
}

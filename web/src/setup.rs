//! What a simulated run starts from, in the page's form.

use serde::{Deserialize, Serialize};
use slamlab_core::experiment::ExperimentConfig;
use slamlab_core::format::{calibration, world};
use slamlab_core::lesson::Lesson;
use slamlab_core::pilot;
use slamlab_core::settings::{Settings, Source};
use slamlab_core::sim::{SensorKind, SensorModel, World, worlds};
use tsify::Tsify;

use crate::border::{MethodName, Mode, SettingValues, WebError};
use crate::building::PriorMapSetup;
use crate::calibration::Pairs;

/// Why a setup names something that does not exist.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SetupError {
    /// No built-in world has this name.
    #[error("there is no world `{0}`; expected one of {expected}", expected = worlds::NAMES.join(", "))]
    World(String),
    /// Calibration pairs for a sensor that has no calibration.
    #[error("calibration pairs belong to IR rangers; this run has another sensor")]
    Calibration,
    /// The seed is larger than the page can show.
    #[error("the seed is {0}, at most {max}", max = u32::MAX)]
    Seed(u64),
    /// No lesson has this name.
    #[error("there is no lesson `{0}`")]
    Lesson(String),
    /// A setup cannot begin with a goal.
    #[error("a run begins by hand or exploring: a goal is chosen on its map")]
    Goal,
}

crate::border::kinds! { Setup: SetupError; }

/// What a simulated run starts from; the same setup gives the same bits.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
#[serde(rename_all = "camelCase")]
#[tsify(missing_as_null)]
pub struct Setup {
    /// Name of a built-in world, or of the dropped file where `worldJson` is given.
    pub world: String,
    /// Text of a world file; null for a built-in world.
    pub world_json: Option<String>,
    /// Name of the sensor.
    pub sensor: String,
    /// Seed of all noise.
    pub seed: u32,
    /// The SLAM method.
    pub method: MethodName,
    /// `manual` or `explore`.
    pub mode: Mode,
    /// Whether to scan standing, plan, make one turn and one leg, and again, whatever the sensor.
    pub cycle: bool,
    /// Settings that differ from their defaults.
    pub settings: SettingValues,
    /// Calibration of the rangers; null for the one of the data sheet.
    pub calibration: Option<Pairs>,
    /// The map for the method `prior-map`; null for the walls of the world.
    pub prior_map: Option<PriorMapSetup>,
    /// Name of the lesson that it is a try at; null for none.
    pub lesson: Option<String>,
}

impl Setup {
    /// The run that it describes, and the settings before its changes.
    ///
    /// # Errors    A sentence on the first thing that is invalid.
    pub(crate) fn read(&self) -> Result<(ExperimentConfig, Settings), WebError> {
        let world = self.load_world()?;
        let sensor: SensorKind = self.sensor.parse()?;
        let robot = world.robot.model();
        let mut settings = Settings::of(sensor.model(), &robot);
        let method = self.method.0;
        if let Some(pairs) = &self.calibration {
            let SensorModel::Rangers(rangers) = &mut settings.sensor else {
                return Err(SetupError::Calibration.into());
            };
            rangers.variable = pairs.variable.into();
            rangers.calibration = calibration::fit(pairs.text.as_bytes(), rangers.variable)?.0;
        }
        let defaults = settings.clone();
        self.settings
            .apply_to(&mut settings, Source::Simulation, method)?;
        let mut config = ExperimentConfig::of(&settings, world, robot, u64::from(self.seed));
        config.method = method;
        config.mode = match self.mode {
            Mode::Manual => pilot::Mode::Manual,
            Mode::Explore => pilot::Mode::Explore,
            Mode::GoTo => return Err(SetupError::Goal.into()),
        };
        config.cycle = self.cycle;
        if let Some(map) = &self.prior_map {
            config.slam.prior_map = map.into();
        }
        Ok((config, defaults))
    }

    /// The lesson that it is a try at.
    ///
    /// # Errors    [`SetupError::Lesson`].
    pub(crate) fn lesson(&self) -> Result<Option<&'static Lesson>, SetupError> {
        let named =
            |name: &String| Lesson::named(name).ok_or_else(|| SetupError::Lesson(name.clone()));
        self.lesson.as_ref().map(named).transpose()
    }

    fn load_world(&self) -> Result<World, WebError> {
        if let Some(text) = &self.world_json {
            return Ok(world::read(text.as_bytes())?);
        }
        let world = worlds::builtin(&self.world);
        Ok(world.ok_or_else(|| SetupError::World(self.world.clone()))?)
    }
}

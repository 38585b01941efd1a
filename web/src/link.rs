//! An experiment as a link: making and following it.

use serde::{Deserialize, Serialize};
use slamlab_core::experiment::{CONTROL_PERIOD, Experiment, Link, Place, Untold};
use slamlab_core::{pilot, sim};
use tsify::{Ts, Tsify};
use wasm_bindgen::prelude::wasm_bindgen;

use crate::border::{Mode, Typed, WebError, typed};
use crate::run::{Simulated, Source, WebRun};
use crate::setup::{Setup, SetupError};

/// Why a run cannot become a link.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum NoLink {
    /// It uses a file of calibration pairs or a prior map.
    #[error("the run uses {0}, which does not fit into a link")]
    File(&'static str),
    /// A person did something that a link cannot express.
    #[error(transparent)]
    Untold(#[from] Untold),
}

crate::border::kinds! { Save: NoLink; }

/// The beginning of a link's run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
#[tsify(missing_as_null)]
pub struct LinkStart {
    /// The setup.
    pub setup: Setup,
    /// Number of a person's actions.
    pub actions: u32,
    /// Simulated seconds at which the link was made; 0 if it does not say.
    pub seconds: f64,
}

/// Reads a link, or an address with a link after its `#`.
///
/// # Errors    A sentence on what is wrong with it.
#[wasm_bindgen]
pub fn read_link(text: &str) -> Typed<LinkStart> {
    let link = Link::read(text)?;
    let (actions, result) = (link.actions.len() as u32, link.result);
    typed(&LinkStart {
        setup: setup_of(link)?,
        actions,
        seconds: result.map_or(0.0, |(until, _)| until as f64 * CONTROL_PERIOD),
    })
}

/// The beginning of a link's run.
///
/// # Errors    [`SetupError::Seed`], and errors of a world that comes with the link.
pub(crate) fn setup_of(link: Link) -> Result<Setup, WebError> {
    let name = link.world.load()?.name;
    let (world, world_json) = match link.world {
        Place::Builtin(world) => (world, None),
        Place::Drawn(text) => (name, Some(text)),
    };
    Ok(Setup {
        world,
        world_json,
        sensor: link.sensor.name().to_owned(),
        seed: u32::try_from(link.seed).map_err(|_| SetupError::Seed(link.seed))?,
        method: link.method.into(),
        mode: match link.mode {
            pilot::Mode::Manual => Mode::Manual,
            pilot::Mode::GoTo(_) | pilot::Mode::Explore => Mode::Explore,
        },
        cycle: link.cycle,
        settings: link.settings.into_iter().collect(),
        calibration: None,
        prior_map: None,
        lesson: None,
    })
}

/// The link of a run that begins with `setup`.
///
/// # Errors    A sentence on what a link cannot hold.
pub(crate) fn link_of(setup: Setup) -> Result<Link, WebError> {
    let file = [
        (setup.calibration.is_some(), "calibration pairs"),
        (setup.prior_map.is_some(), "a map to be found in"),
    ];
    if let Some((_, what)) = file.iter().find(|(is_used, _)| *is_used) {
        return Err(NoLink::File(what).into());
    }
    Ok(Link {
        world: match setup.world_json {
            Some(text) => Place::Drawn(text),
            None => Place::Builtin(setup.world),
        },
        sensor: setup.sensor.parse::<sim::SensorKind>()?,
        method: setup.method.0,
        seed: setup.seed.into(),
        mode: match setup.mode {
            Mode::Manual => pilot::Mode::Manual,
            Mode::Explore | Mode::GoTo => pilot::Mode::Explore,
        },
        cycle: setup.cycle,
        settings: setup.settings.0.into_iter().collect(),
        actions: vec![],
        result: None,
    })
}

#[wasm_bindgen]
impl WebRun {
    /// The simulated run of a link; its actions are repeated, each at its time.
    ///
    /// # Errors    A sentence on what is wrong with it.
    pub fn follow_link(text: &str) -> Result<Self, WebError> {
        let link = Link::read(text)?;
        let (config, defaults) = link.config()?;
        let mut experiment = Experiment::new(config)?;
        experiment.follow(link.actions);
        let source = Source::Simulation(Box::new(Simulated {
            expected: link.result,
            ..Simulated::new(experiment, defaults)
        }));
        Ok(Self::of(source))
    }

    /// The link of this run, which began with `setup`: the part of an address after the `#`.
    ///
    /// # Errors    A sentence on what a link cannot hold.
    pub fn link(&self, setup: &Ts<Setup>) -> Result<String, WebError> {
        let experiment = &self.simulated()?.experiment;
        let link = Link {
            actions: experiment.actions().map_err(NoLink::from)?.to_vec(),
            result: Some((experiment.periods(), experiment.state_hash())),
            ..link_of(setup.to_rust()?)?
        };
        Ok(link.write()?)
    }

    /// Whether actions of a link are still to be repeated; until then the run is not over.
    #[must_use]
    pub fn has_due(&self) -> bool {
        let due = self.simulated().map(|sim| sim.experiment.has_due());
        due.unwrap_or_default()
    }

    /// At the moment at which the followed link was made: whether the state is the same, to the
    /// bit. Nothing at any other time.
    #[must_use]
    pub fn link_holds(&self) -> Option<bool> {
        let sim = self.simulated().ok()?;
        let (until, hash) = sim.expected?;
        // A run that was forked meanwhile ends in another state.
        let went_on = !sim.experiment.has_due() && !sim.experiment.has_forked();
        let is_there = sim.experiment.periods() == until && went_on;
        is_there.then(|| sim.experiment.state_hash() == hash)
    }
}

//! Driving, for the page: by hand, to a goal, exploring, and by the cycle; and the pilot's plans.

use nalgebra::Point2;
use serde::{Deserialize, Serialize};
use slamlab_core::geom::Pose2;
use slamlab_core::pilot::{self, Stage as CoreStage, StageRecord};
use tsify::Tsify;
use wasm_bindgen::prelude::wasm_bindgen;

use crate::border::{Stage, Typed, WebError, typed};
use crate::run::{RunError, Source, WebRun};
use crate::view;

/// The cycle of TDK 2016 §6.3: scan standing, plan, one turn, one leg, again.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
#[tsify(missing_as_null)]
pub struct Cycle {
    /// Scans asked for so far.
    pub round: u32,
    /// Reports shown so far.
    pub count: f64,
    /// The stage of the newest report; null before the first.
    pub now: Option<Stage>,
    /// The stages, in order.
    pub stages: Vec<StageWords>,
}

/// A stage and its result.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
pub struct StageWords {
    /// Which one.
    pub stage: Stage,
    /// Its last result, in words; empty before.
    pub text: String,
}

#[wasm_bindgen]
impl WebRun {
    /// Explore from here on.
    pub fn explore(&mut self) {
        self.set_mode(pilot::Mode::Explore);
    }

    /// Switch to manual driving.
    pub fn manual(&mut self) {
        self.set_mode(pilot::Mode::Manual);
    }

    /// Go to a point of the map, m.
    pub fn go_to(&mut self, x: f64, y: f64) {
        self.set_mode(pilot::Mode::GoTo(Point2::new(x, y)));
    }

    /// Drives by hand; fractions of the robot's highest speeds in [-1, 1], forward and to the left.
    pub fn drive(&mut self, forward: f64, turn: f64) {
        match &mut self.source {
            Source::Simulation(sim) => {
                let robot = *sim.experiment.sim().robot();
                sim.experiment
                    .drive(forward * robot.max_speed, turn * robot.max_turn_rate);
            }
            Source::Recording(_) => {}
            Source::Live(live) => live.drive(forward, turn),
        }
    }

    /// Stops at once, at a time of the page's clock, µs. A real robot is disarmed too, whoever
    /// drives it.
    pub fn stop(&mut self, now: f64) {
        match &mut self.source {
            Source::Simulation(sim) => sim.experiment.stop(),
            Source::Recording(_) => {}
            Source::Live(live) => live.stop(now as u64),
        }
    }

    /// x y of the corners of the path.
    #[must_use]
    pub fn path(&self) -> Vec<f32> {
        view::corners(self.pilot().route().map(|route| &route.path))
    }

    /// x y of the corners of the path before it was shortened.
    #[must_use]
    pub fn raw_path(&self) -> Vec<f32> {
        view::corners(self.pilot().route().map(|route| &route.raw))
    }

    /// x1 y1 x2 y2 of the edges of the planner's trees.
    #[must_use]
    pub fn tree(&self) -> Vec<f32> {
        view::segments(self.pilot().tree().iter(), &Pose2::identity())
    }

    /// x y of the cells where open floor meets the unknown.
    #[must_use]
    pub fn frontiers(&self) -> Vec<f32> {
        let grid = self.slam().grid();
        let frontiers = self.pilot().frontiers().iter();
        let cells = frontiers.flat_map(|frontier| frontier.edge(grid));
        let centres: Vec<_> = cells.map(|cell| grid.centre_of(cell)).collect();
        view::polyline(&centres)
    }

    /// Whether the robot drives by the cycle of TDK 2016 §6.3.
    #[must_use]
    pub fn in_cycle(&self) -> bool {
        self.session().scans_on_command()
    }

    /// Makes a robot that is driven from here follow the cycle, or drive as continuously as its
    /// sensor allows.
    ///
    /// # Errors    The run is a recording.
    pub fn set_cycle(&mut self, cycle: bool) -> Result<(), WebError> {
        match &mut self.source {
            Source::Simulation(sim) => sim.experiment.set_cycle(cycle),
            Source::Recording(_) => return Err(RunError::Recorded.into()),
            Source::Live(live) => live.set_cycle(cycle),
        }
        Ok(())
    }

    /// The stages of the cycle with their results.
    ///
    /// # Errors    None that a page can cause.
    pub fn cycle(&self) -> Typed<Cycle> {
        typed(&Cycle::of(self.session().stages()))
    }

    /// Number of reports of the cycle shown so far.
    #[must_use]
    pub fn cycle_count(&self) -> f64 {
        self.session().stages().count() as f64
    }
}

impl WebRun {
    fn set_mode(&mut self, mode: pilot::Mode) {
        match &mut self.source {
            Source::Simulation(sim) => sim.experiment.set_mode(mode),
            Source::Recording(_) => {}
            Source::Live(live) => live.set_mode(mode),
        }
    }
}

impl Cycle {
    fn of(record: &StageRecord) -> Self {
        let words = |(_, stage): &(_, CoreStage)| StageWords {
            stage: stage.into(),
            text: record
                .report(*stage)
                .map(ToString::to_string)
                .unwrap_or_default(),
        };
        Self {
            round: record.round(),
            count: record.count() as f64,
            now: record.now().as_ref().map(Into::into),
            stages: CoreStage::ALL.iter().map(words).collect(),
        }
    }
}

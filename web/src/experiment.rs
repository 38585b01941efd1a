//! A simulated run, for the page.

use std::cell::OnceCell;

use nalgebra::Point2;
use slamlab_core::experiment::Experiment;
use slamlab_core::format::carmen::CarmenLog;
use slamlab_core::geom::{Pose2, Segment};
use slamlab_core::pilot::{Mode, Pilot, Stage, Status};
use slamlab_core::session::Session;
use slamlab_core::settings::Settings;
use slamlab_core::sim::{Material, ReachableArea, SensorModel, Wall, reachable_area};
use wasm_bindgen::prelude::{JsError, wasm_bindgen};

use crate::bench::{BenchResponse, BenchTrial};
use crate::export::trajectory_of;
use crate::settings::apply;
use crate::setup::WebSetup;
use crate::shows_slam::shows_slam;
use crate::sigma::SigmaCurve;
use crate::status::RunStatus;
use crate::view;

/// What the page calls it.
pub(crate) fn mode_name(mode: Mode) -> &'static str {
    match mode {
        Mode::Manual => "manual",
        Mode::GoTo(_) => "goto",
        Mode::Explore => "explore",
    }
}

/// What a pilot is doing, or how its errand ended, in words; on its way back from an exploration `homeward`.
pub(crate) fn activity_of(pilot: &Pilot) -> String {
    match pilot.status() {
        Status::Driving if pilot.is_homeward() => "homeward".to_owned(),
        status => status.to_string(),
    }
}

/// A simulated robot that maps, finds itself, plans and drives.
#[wasm_bindgen]
#[derive(Debug)]
pub struct WebExperiment {
    experiment: Experiment,
    settings: Settings,
    /// What can be explored at all; found out when it is first asked for.
    area: OnceCell<ReachableArea>,
}

#[wasm_bindgen]
impl WebExperiment {
    /// A run from this setup.
    ///
    /// # Errors    A sentence on the first thing that cannot be.
    #[wasm_bindgen(constructor)]
    #[allow(
        clippy::needless_pass_by_value,
        reason = "handed over: the page need not free it"
    )]
    pub fn new(setup: WebSetup) -> Result<Self, JsError> {
        let (config, settings) = setup.read()?;
        Ok(Self {
            experiment: Experiment::new(config)?,
            settings,
            area: OnceCell::new(),
        })
    }

    /// Changes settings that act at once.
    ///
    /// # Errors    A sentence on a setting that cannot be; then all stay as they were.
    #[allow(
        clippy::needless_pass_by_value,
        reason = "lists of text cross the border by value only"
    )]
    pub fn configure(&mut self, keys: Vec<String>, values: Vec<f64>) -> Result<(), JsError> {
        let mut settings = self.settings.clone();
        apply(&mut settings, &keys, &values)?;
        self.experiment.reconfigure(&settings)?;
        self.settings = settings;
        Ok(())
    }

    /// Drive by the cycle of TDK 2016 §6.3, or continuously.
    pub fn set_cycle(&mut self, cycle: bool) {
        self.experiment.set_cycle(cycle);
    }

    /// Whether it drives by the cycle.
    #[must_use]
    pub fn in_cycle(&self) -> bool {
        self.experiment.session().scans_on_command()
    }

    /// Goes on to the next stage of the cycle; its name, or empty where there is none.
    ///
    /// # Errors    A scan that cannot be used.
    pub fn next_stage(&mut self) -> Result<String, JsError> {
        let stage = self.experiment.next_stage()?;
        Ok(stage.map(name_of).unwrap_or_default())
    }

    /// Names of the stages, each followed by what it gave last (empty before).
    #[must_use]
    pub fn stages(&self) -> Vec<String> {
        let stages = self.experiment.session().stages();
        let told = |stage| {
            stages
                .report(stage)
                .map(ToString::to_string)
                .unwrap_or_default()
        };
        Stage::ALL
            .iter()
            .flat_map(|&(name, stage)| [name.to_owned(), told(stage)])
            .collect()
    }

    /// The stage of the newest report; empty before the first.
    #[must_use]
    pub fn stage(&self) -> String {
        self.experiment
            .session()
            .stages()
            .now()
            .map(name_of)
            .unwrap_or_default()
    }

    /// Which round of the cycle this is, and the number of reports so far.
    #[must_use]
    pub fn cycle_count(&self) -> Vec<f64> {
        let stages = self.experiment.session().stages();
        vec![f64::from(stages.round()), stages.count() as f64]
    }

    /// σ(ρ) of the sensor, from `scans` of a twin that stands where the robot is.
    ///
    /// # Errors    A sentence on why it cannot be told.
    pub fn estimate_sigma(&self, scans: u32, growth: &str) -> Result<SigmaCurve, JsError> {
        let scans = self.experiment.standing_scans(scans as usize);
        let truth = match self.experiment.sim().sensor() {
            SensorModel::Lidar(model) => Some((model.sigma, model.sigma_per_metre)),
            SensorModel::Sonar(model) => Some((model.sigma, model.sigma_per_metre)),
            SensorModel::Rangers(_) => None,
        };
        SigmaCurve::of(&[&scans], growth, truth)
    }

    /// Material of each true wall: 0 opaque, 1 glass, 2 dark.
    #[must_use]
    pub fn materials(&self) -> Vec<u8> {
        let walls = self.walls();
        let code = |material| match material {
            Material::Opaque => 0,
            Material::Glass => 1,
            Material::Dark => 2,
        };
        walls.iter().map(|wall| code(wall.material)).collect()
    }

    /// Half the opening of a beam, rad: that of a sonar's cone, 0 for a ray of light.
    #[must_use]
    pub fn beam_half_angle(&self) -> f64 {
        match self.experiment.sim().sensor() {
            SensorModel::Sonar(model) => model.half_angle,
            _ => 0.0,
        }
    }

    /// First half of a control period: the pilot decides.
    pub fn decide(&mut self) {
        self.experiment.decide();
    }

    /// Second half of a control period: the robot moves, senses and maps.
    ///
    /// # Errors    A scan that cannot be used.
    pub fn advance(&mut self) -> Result<(), JsError> {
        self.experiment.advance()?;
        Ok(())
    }

    /// The numbers of the moment.
    #[must_use]
    pub fn status(&self) -> RunStatus {
        let (experiment, sim) = (&self.experiment, self.experiment.sim());
        let truth = experiment.truth();
        let goal = experiment.session().pilot().goal();
        let samples = experiment.record().samples();
        RunStatus {
            time: sim.stamp().seconds(),
            scans: samples.len() as u32,
            truth_x: truth.x(),
            truth_y: truth.y(),
            truth_heading: truth.heading(),
            distance: experiment.record().distance(),
            contacts: f64::from(sim.contacts()),
            goal_x: goal.map_or(f64::NAN, |goal| goal.x),
            goal_y: goal.map_or(f64::NAN, |goal| goal.y),
            finished: experiment.session().status().is_over(),
            ..RunStatus::of(experiment.session())
        }
    }

    /// `manual`, `goto` or `explore`.
    #[must_use]
    pub fn mode(&self) -> String {
        mode_name(self.experiment.session().pilot().mode()).to_owned()
    }

    /// What the pilot is doing, or how its errand ended, in words.
    #[must_use]
    pub fn activity(&self) -> String {
        activity_of(self.experiment.session().pilot())
    }

    /// Which planner found the path; empty without a path.
    #[must_use]
    pub fn planner(&self) -> String {
        self.experiment
            .session()
            .pilot()
            .planner()
            .map(|planner| format!("{planner:?}"))
            .unwrap_or_default()
    }

    /// Part of the reachable area that is known, 0 to 1. Costs more than a step, and at first as much as the world's
    /// floor is large.
    #[must_use]
    pub fn explored(&self) -> f64 {
        let area = self.area.get_or_init(|| {
            let sim = self.experiment.sim();
            let resolution = self.experiment.session().slam().grid().resolution();
            reachable_area(sim.world(), sim.robot().radius(), resolution)
        });
        self.experiment.explored_fraction(area)
    }

    /// Area of the rectangle around the world, m².
    #[must_use]
    pub fn extent(&self) -> f64 {
        let (low, high) = self.experiment.sim().world().bounds();
        (high.x - low.x) * (high.y - low.y)
    }

    /// Explore from here on.
    pub fn explore(&mut self) {
        self.experiment.set_mode(Mode::Explore);
    }

    /// Wait for the hand.
    pub fn manual(&mut self) {
        self.experiment.set_mode(Mode::Manual);
    }

    /// Go to a point of the map, m.
    pub fn go_to(&mut self, x: f64, y: f64) {
        self.experiment.set_mode(Mode::GoTo(Point2::new(x, y)));
    }

    /// Drive by hand; fractions of the robot's highest speeds in [-1, 1], forward and to the left.
    pub fn drive(&mut self, forward: f64, turn: f64) {
        let robot = *self.experiment.sim().robot();
        self.experiment
            .drive(forward * robot.max_speed, turn * robot.max_turn_rate);
    }

    /// The robot's drive controller on a bench: a step to `forward` (a part of its highest speed), the right motor's magnet
    /// stronger than believed by the part `mismatch`, from `pull_at` (s) on a pull back on the left track (N).
    ///
    /// # Errors    No controller for the robot's figures, or motors that cannot be.
    pub fn bench(
        &self,
        forward: f64,
        mismatch: f64,
        pull: f64,
        pull_at: f64,
        seconds: f64,
    ) -> Result<BenchResponse, JsError> {
        let trial = BenchTrial {
            forward,
            mismatch,
            pull,
            pull_at,
            seconds,
        };
        BenchResponse::of(self.experiment.sim().robot(), trial)
    }

    /// Stop at once.
    pub fn stop(&mut self) {
        self.experiment.stop();
    }

    /// x1 y1 x2 y2 of the true walls, without doors.
    #[must_use]
    pub fn truth(&self) -> Vec<f32> {
        let walls = self.walls();
        view::segments(
            walls.iter().map(|wall| &wall.segment),
            &self.experiment.map_from_world(),
        )
    }

    /// x1 y1 x2 y2 of each door, whether it is open, and whether it is to be: one that is to shut waits while somebody stands in it.
    #[must_use]
    pub fn doors(&self) -> Vec<f32> {
        let sim = self.experiment.sim();
        let leaves = sim.world().doors.iter().map(|door| &door.leaf);
        let ends = view::segments(leaves, &self.experiment.map_from_world());
        let states = sim.doors_open().zip(sim.doors_ordered());
        let flag = |yes| f32::from(u8::from(yes));
        ends.chunks(4)
            .zip(states)
            .flat_map(|(ends, (open, ordered))| [ends, &[flag(open), flag(ordered)]].concat())
            .collect()
    }

    /// Opens or shuts a door; it moves with the next step.
    ///
    /// # Errors    There is no such door.
    pub fn set_door(&mut self, index: u32, open: bool) -> Result<(), JsError> {
        Ok(self.experiment.set_door(index as usize, open)?)
    }

    /// x y radius of what walks about.
    #[must_use]
    pub fn movers(&self) -> Vec<f32> {
        let map_from_world = self.experiment.map_from_world();
        let discs = self.experiment.sim().movers().iter();
        discs
            .flat_map(|disc| {
                let centre = map_from_world * disc.centre;
                [centre.x as f32, centre.y as f32, disc.radius as f32]
            })
            .collect()
    }

    /// x y of the corners of the path.
    #[must_use]
    pub fn path(&self) -> Vec<f32> {
        self.experiment
            .session()
            .pilot()
            .path()
            .map(|path| view::polyline(&path.points))
            .unwrap_or_default()
    }

    /// The same before it was shortened.
    #[must_use]
    pub fn raw_path(&self) -> Vec<f32> {
        self.experiment
            .session()
            .pilot()
            .raw_path()
            .map(|path| view::polyline(&path.points))
            .unwrap_or_default()
    }

    /// x1 y1 x2 y2 of the edges of the planner's trees.
    #[must_use]
    pub fn tree(&self) -> Vec<f32> {
        view::segments(
            self.experiment.session().pilot().tree().iter(),
            &Pose2::identity(),
        )
    }

    /// x y of the cells between known and unknown.
    #[must_use]
    pub fn frontiers(&self) -> Vec<f32> {
        let grid = self.experiment.session().slam().grid();
        let cells = self
            .experiment
            .session()
            .pilot()
            .frontiers()
            .iter()
            .flat_map(|frontier| &frontier.cells);
        let centres: Vec<_> = cells.map(|&cell| grid.centre_of(cell)).collect();
        view::polyline(&centres)
    }

    /// Whether the filter is honest, and the likeliest cause if not: a name of `Diagnosis`.
    #[must_use]
    pub fn diagnosis(&self) -> String {
        let consistency = self.experiment.session().consistency();
        consistency.diagnosis().name().to_owned()
    }

    /// Fingerprint of the whole state, 16 hexadecimal digits.
    #[must_use]
    pub fn state_hash(&self) -> String {
        format!("{:016x}", self.experiment.state_hash())
    }
}

impl WebExperiment {
    /// The walls that stand for good. Doors that are shut come after them.
    fn walls(&self) -> &[Wall] {
        let sim = self.experiment.sim();
        let walls = sim.caster().walls();
        let shut = sim.doors_open().filter(|open| !open).count();
        walls.get(..walls.len() - shut).unwrap_or(walls)
    }
}

fn name_of(stage: Stage) -> String {
    let entry = Stage::ALL.iter().find(|(_, known)| *known == stage);
    entry
        .map(|(name, _)| (*name).to_owned())
        .unwrap_or_default()
}

shows_slam!(WebExperiment);

impl WebExperiment {
    fn session(&self) -> &Session {
        self.experiment.session()
    }

    /// The true walls, doors as they are now, and the motion into the map's frame.
    fn true_walls(&self) -> Option<(Vec<Segment>, Pose2)> {
        let walls = self.experiment.sim().caster().walls().iter();
        let segments = walls.map(|wall| wall.segment).collect();
        Some((segments, self.experiment.map_from_world()))
    }

    fn trajectory(&self) -> Vec<(f64, Pose2)> {
        trajectory_of(self.session().slam())
    }

    fn scan_log(&self) -> Result<&CarmenLog, JsError> {
        Ok(self.experiment.log())
    }
}

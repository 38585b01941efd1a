//! A simulated run, for the page.

use nalgebra::Point2;
use slamlab_core::experiment::{Experiment, ExperimentConfig};
use slamlab_core::format::{map_server, world};
use slamlab_core::geom::Pose2;
use slamlab_core::pilot::Mode;
use slamlab_core::sim::{ReachableArea, SensorKind, World, reachable_area, worlds};
use slamlab_core::slam::Method;
use wasm_bindgen::prelude::{JsError, wasm_bindgen};

use crate::view::{self, GridBlocks};

/// Why a setup names something that does not exist.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SetupError {
    /// No built-in world of that name.
    #[error("there is no world `{0}`; expected one of {expected}", expected = worlds::NAMES.join(", "))]
    World(String),
    /// No mode of that name to start with.
    #[error("there is no mode `{0}` to start with; expected manual or explore")]
    Mode(String),
}

/// The numbers of the moment; poses in the map frame, m and rad.
#[wasm_bindgen]
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(
    missing_docs,
    reason = "names and units as in `Status` of www/src/protocol.ts"
)]
pub struct ExperimentStatus {
    pub time: f64,
    pub scans: u32,
    pub x: f64,
    pub y: f64,
    pub heading: f64,
    pub cov_xx: f64,
    pub cov_xy: f64,
    pub cov_yy: f64,
    pub cov_heading: f64,
    pub truth_x: f64,
    pub truth_y: f64,
    pub truth_heading: f64,
    pub odometry_x: f64,
    pub odometry_y: f64,
    pub odometry_heading: f64,
    pub distance: f64,
    pub contacts: u32,
    pub goal_x: f64,
    pub goal_y: f64,
    pub finished: bool,
}

/// A simulated robot that maps, finds itself, plans and drives.
#[wasm_bindgen]
#[derive(Debug)]
pub struct WebExperiment {
    experiment: Experiment,
    /// What can be explored at all.
    area: ReachableArea,
}

#[wasm_bindgen]
impl WebExperiment {
    /// `world`: name of a built-in world, or the text of a world file. `mode`: `manual` or `explore`.
    ///
    /// # Errors    A sentence on the first thing that cannot be.
    #[wasm_bindgen(constructor)]
    pub fn new(
        world: &str,
        is_file: bool,
        sensor: &str,
        seed: u32,
        method: &str,
        mode: &str,
    ) -> Result<Self, JsError> {
        let world = load_world(world, is_file)?;
        let sensor: SensorKind = sensor.parse()?;
        let mode = match mode {
            "manual" => Mode::Manual,
            "explore" => Mode::Explore,
            other => return Err(SetupError::Mode(other.to_owned()).into()),
        };
        let method: Method = method.parse()?;
        let robot = world.robot.model();
        let config = ExperimentConfig {
            method,
            mode,
            ..ExperimentConfig::new(world, robot, sensor.model(), u64::from(seed))
        };
        let resolution = config.slam.grid.resolution;
        let experiment = Experiment::new(config)?;
        let area = reachable_area(experiment.sim().world(), robot.radius(), resolution);
        Ok(Self { experiment, area })
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
    pub fn status(&self) -> ExperimentStatus {
        let (experiment, sim) = (&self.experiment, self.experiment.sim());
        let (estimate, truth, odometry) = (
            experiment.estimate(),
            experiment.truth(),
            experiment.odometry_pose(),
        );
        let goal = experiment
            .pilot()
            .goal()
            .unwrap_or(Point2::new(f64::NAN, f64::NAN));
        ExperimentStatus {
            time: sim.stamp().seconds(),
            scans: experiment.record().samples().len() as u32,
            x: estimate.pose.x(),
            y: estimate.pose.y(),
            heading: estimate.pose.heading(),
            cov_xx: estimate.cov[(0, 0)],
            cov_xy: estimate.cov[(0, 1)],
            cov_yy: estimate.cov[(1, 1)],
            cov_heading: estimate.cov[(2, 2)],
            truth_x: truth.x(),
            truth_y: truth.y(),
            truth_heading: truth.heading(),
            odometry_x: odometry.x(),
            odometry_y: odometry.y(),
            odometry_heading: odometry.heading(),
            distance: experiment.record().distance(),
            contacts: sim.contacts(),
            goal_x: goal.x,
            goal_y: goal.y,
            finished: experiment.status().is_over(),
        }
    }

    /// `manual`, `goto` or `explore`.
    #[must_use]
    pub fn mode(&self) -> String {
        let name = match self.experiment.pilot().mode() {
            Mode::Manual => "manual",
            Mode::GoTo(_) => "goto",
            Mode::Explore => "explore",
        };
        name.to_owned()
    }

    /// What the pilot is doing, or how its errand ended, in words.
    #[must_use]
    pub fn activity(&self) -> String {
        self.experiment.status().to_string()
    }

    /// Which planner found the path; empty without a path.
    #[must_use]
    pub fn planner(&self) -> String {
        self.experiment
            .pilot()
            .planner()
            .map(|planner| format!("{planner:?}"))
            .unwrap_or_default()
    }

    /// Part of the reachable area that is known, 0 to 1. Costs more than a step.
    #[must_use]
    pub fn explored(&self) -> f64 {
        self.experiment.explored_fraction(&self.area)
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

    /// Stop at once.
    pub fn stop(&mut self) {
        self.experiment.stop();
    }

    /// Half length and half width of the robot, m.
    #[must_use]
    pub fn half_size(&self) -> Vec<f64> {
        let robot = self.experiment.sim().robot();
        vec![0.5 * robot.length, 0.5 * robot.width]
    }

    /// x1 y1 x2 y2 of the true walls.
    #[must_use]
    pub fn truth(&self) -> Vec<f32> {
        let walls = self.experiment.sim().caster().walls();
        view::segments(
            walls.iter().map(|wall| &wall.segment),
            &self.experiment.map_from_world(),
        )
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
            .pilot()
            .path()
            .map(|path| view::polyline(&path.points))
            .unwrap_or_default()
    }

    /// The same before it was shortened.
    #[must_use]
    pub fn raw_path(&self) -> Vec<f32> {
        self.experiment
            .pilot()
            .raw_path()
            .map(|path| view::polyline(&path.points))
            .unwrap_or_default()
    }

    /// x1 y1 x2 y2 of the edges of the planner's trees.
    #[must_use]
    pub fn tree(&self) -> Vec<f32> {
        view::segments(self.experiment.pilot().tree().iter(), &Pose2::identity())
    }

    /// x y of the cells between known and unknown.
    #[must_use]
    pub fn frontiers(&self) -> Vec<f32> {
        let grid = self.experiment.slam().grid();
        let cells = self
            .experiment
            .pilot()
            .frontiers()
            .iter()
            .flat_map(|frontier| &frontier.cells);
        let centres: Vec<_> = cells.map(|&cell| grid.centre_of(cell)).collect();
        view::polyline(&centres)
    }

    /// x y of what the last scan hit.
    #[must_use]
    pub fn scan(&self) -> Vec<f32> {
        let slam = self.experiment.slam();
        let map_from_robot_at_scan = slam.estimate().pose * slam.motion_since_scan().inverse();
        view::hits(slam.points(), &map_from_robot_at_scan)
    }

    /// The walls of the line map, see `LINE_STRIDE` of www/src/protocol.ts.
    #[must_use]
    pub fn lines(&self) -> Vec<f64> {
        view::lines(self.experiment.slam())
    }

    /// Blocks of the grid that changed after a revision.
    #[must_use]
    pub fn grid_since(&self, revision: f64) -> GridBlocks {
        GridBlocks::since(self.experiment.slam().grid(), revision)
    }

    /// Changes when the grid was drawn anew and old blocks are worth nothing.
    #[must_use]
    pub fn grid_generation(&self) -> u32 {
        self.experiment.slam().grid_version() as u32
    }

    /// Side of a cell, m.
    #[must_use]
    pub fn grid_resolution(&self) -> f64 {
        self.experiment.slam().grid().resolution()
    }

    /// Area known to be free, m². Costs more than a step.
    #[must_use]
    pub fn known_area(&self) -> f64 {
        view::free_area(self.experiment.slam().grid())
    }

    /// Fingerprint of the whole state, 16 hexadecimal digits.
    #[must_use]
    pub fn state_hash(&self) -> String {
        format!("{:016x}", self.experiment.state_hash())
    }

    /// The grid as a PGM of map_server.
    ///
    /// # Errors    An empty map.
    pub fn map_pgm(&self) -> Result<Vec<u8>, JsError> {
        Ok(map_server::write(self.experiment.slam().grid(), "")?.pgm)
    }

    /// The YAML of map_server that goes with the PGM of the given name.
    ///
    /// # Errors    An empty map.
    pub fn map_yaml(&self, image: &str) -> Result<String, JsError> {
        Ok(map_server::write(self.experiment.slam().grid(), image)?.yaml)
    }
}

fn load_world(world: &str, is_file: bool) -> Result<World, JsError> {
    if is_file {
        return Ok(world::read(world.as_bytes())?);
    }
    worlds::builtin(world).ok_or_else(|| SetupError::World(world.to_owned()).into())
}

//! One run, for the page: SLAM and pilot with what feeds them, a simulation, a recording or a live robot.

use std::cell::OnceCell;
use std::collections::VecDeque;

use nalgebra::Point2;
use serde::{Deserialize, Serialize};
use slamlab_core::experiment::Experiment;
use slamlab_core::format::map_server::{MapImage, MapMode};
use slamlab_core::geom::{Pose2, Segment};
use slamlab_core::hash::StateHash;
use slamlab_core::live::Live;
use slamlab_core::pilot::{self, Pilot, Stage as CoreStage, StageRecord};
use slamlab_core::replay::Replay;
use slamlab_core::robot::{RobotModel, Scan};
use slamlab_core::session::Session;
use slamlab_core::settings::Settings;
use slamlab_core::sim::{ReachableArea, SensorModel};
use slamlab_core::slam::Slam;
use tsify::{Ts, Tsify};
use wasm_bindgen::prelude::wasm_bindgen;

use crate::border::{
    FieldName, GrowthName, Level, SavedKind, SettingValues, Stage, Typed, WebError, names, typed,
};
use crate::building::KnownFile;
use crate::contest::{ContestAsk, Field, WebContest};
use crate::drive_fit::{DriveFit, samples_since};
use crate::export::{self, SavedFile, trajectory_of};
use crate::field::FieldChange;
use crate::inspection::Inspection;
use crate::rooms::Rooms;
use crate::sigma::SigmaCurve;
use crate::status::RunStatus;
use crate::view::{self, SlamView};

/// Scans of a standing twin from which σ(ρ) is estimated.
const STANDING_SCANS: usize = 120;

names! {
    /// What feeds a run.
    SourceKind { Sim = "sim", Replay = "replay", Bridge = "bridge" }
}

/// Why a run cannot do what it was asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum RunError {
    /// Only a simulation has it.
    #[error("only a simulation can do that")]
    NoSimulation,
    /// Only a robot behind a bridge has it.
    #[error("only a robot behind a bridge can do that")]
    NotLive,
    /// σ(ρ) of a live robot.
    #[error(
        "σ(ρ) is estimated from a recording: record the standing robot, and open the recording here"
    )]
    NotRecorded,
}

/// What feeds a run.
#[derive(Debug)]
pub(crate) enum Source {
    Simulation(Box<Simulated>),
    Recording(Box<Replay>),
    Live(Box<Behind>),
}

/// A simulated robot.
#[derive(Debug)]
pub(crate) struct Simulated {
    pub(crate) experiment: Experiment,
    pub(crate) settings: Settings,
    /// What can be explored at all; found out when it is first asked for.
    pub(crate) area: OnceCell<ReachableArea>,
}

/// A robot behind a bridge.
#[derive(Debug)]
pub(crate) struct Behind {
    pub(crate) live: Live,
    /// Messages to be sent.
    pub(crate) waiting: VecDeque<Vec<u8>>,
}

/// The cycle of TDK 2016 §6.3: scan standing, plan, one turn, one leg, again.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
#[tsify(missing_as_null)]
pub struct Cycle {
    /// Scans asked for so far.
    pub round: u32,
    /// Reports shown so far.
    pub count: f64,
    /// The stage of the newest; null before the first.
    pub now: Option<Stage>,
    /// In the order in which they are done.
    pub stages: Vec<StageWords>,
}

/// A stage and what it gave.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
pub struct StageWords {
    /// Which one.
    pub stage: Stage,
    /// What it gave last, in words; empty before.
    pub text: String,
}

/// What a person should read.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
pub struct Notice {
    /// How grave it is.
    pub level: Level,
    /// The sentence.
    pub text: String,
}

/// A robot that is mapped, finds itself, plans and drives; or a log of one that is mapped.
#[wasm_bindgen]
#[derive(Debug)]
pub struct WebRun {
    pub(crate) source: Source,
}

#[wasm_bindgen]
impl WebRun {
    /// First half of a simulated control period: the pilot decides. Others decide by themselves.
    pub fn decide(&mut self) {
        if let Source::Simulation(sim) = &mut self.source {
            sim.experiment.decide();
        }
    }

    /// The smallest step: a control period's second half of a simulation, the next scan of a recording; false when there is none
    /// left. A live robot goes at its own pace.
    ///
    /// # Errors    A scan that cannot be used.
    pub fn advance(&mut self) -> Result<bool, WebError> {
        match &mut self.source {
            Source::Simulation(sim) => {
                sim.experiment.advance()?;
                Ok(true)
            }
            Source::Recording(replay) => Ok(replay.step()?),
            Source::Live(_) => Ok(true),
        }
    }

    /// The present numbers.
    ///
    /// # Errors    None that a page can cause.
    pub fn status(&self) -> Typed<RunStatus> {
        typed(&match &self.source {
            Source::Simulation(sim) => sim.status(),
            Source::Recording(replay) => RunStatus {
                time: replay.time(),
                progress: replay.progress(),
                ..RunStatus::of(replay.session(), false)
            },
            Source::Live(behind) => RunStatus::of(behind.live.session(), true),
        })
    }

    /// The map since `revision` of `generation`, and the last scan.
    ///
    /// # Errors    None that a page can cause.
    pub fn view(&self, generation: u32, revision: f64) -> Typed<SlamView> {
        typed(&SlamView::since(self.session(), generation, revision))
    }

    /// Why the last scan's lines were matched, and, with `matrix`, how errors hang together; nothing for methods without a line
    /// map.
    ///
    /// # Errors    None that a page can cause.
    pub fn inspect(&self, matrix: bool) -> Result<Option<Ts<Inspection>>, WebError> {
        let inside = Inspection::of(self.session(), matrix);
        inside.as_ref().map(typed).transpose()
    }

    /// Walls that the last scan showed to be parts of others: the one that stays and the one that goes, pair by pair.
    #[must_use]
    pub fn merged(&self) -> Vec<u32> {
        view::merged(self.slam())
    }

    /// x1 y1 x2 y2 of the walls of the prior map, m; empty for other methods.
    #[must_use]
    pub fn known_walls(&self) -> Vec<f32> {
        view::known_walls(self.slam())
    }

    /// A map to be found in, made of the grid as it is. A real robot is not put back to where the map began: it begins where it is.
    ///
    /// # Errors    A sentence on what is missing in it.
    pub fn as_known(&self, name: &str) -> Typed<KnownFile> {
        let mut file = KnownFile::of_grid(name, self.slam())?;
        if let Source::Live(_) = self.source {
            let pose = self.slam().estimate().pose;
            file.known.start = [pose.x(), pose.y(), pose.heading()];
        }
        typed(&file)
    }

    /// Area known to be free, m². Costs more than a step.
    #[must_use]
    pub fn known_area(&self) -> f64 {
        view::free_area(self.slam())
    }

    /// A field of the grid that the pose's sensor draws, in the blocks in which it may have changed since `revision` of
    /// `generation`.
    ///
    /// # Errors    None that a page can cause.
    pub fn field(
        &self,
        name: &Ts<FieldName>,
        generation: u32,
        revision: f64,
    ) -> Typed<FieldChange> {
        let (radius, name) = (self.robot().radius(), name.to_rust()?);
        let field = FieldChange::since(self.slam(), radius, name, generation, revision);
        typed(&field)
    }

    /// Rooms, corridors and doors of the map, if the grid that the pose's sensor draws has changed since `revision` of
    /// `generation`. Costs more than a step.
    ///
    /// # Errors    None that a page can cause.
    pub fn rooms(&self, generation: u32, revision: f64) -> Result<Option<Ts<Rooms>>, WebError> {
        let (grid, now) = (self.slam().grid(), self.slam().grid_version() as u32);
        let is_known = now == generation && grid.revision() == revision as u64;
        let rooms = (!is_known).then(|| Rooms::of(grid, now));
        rooms.as_ref().map(typed).transpose()
    }

    /// All planners on one query.
    ///
    /// # Errors    A sentence on start, goal or ground that cannot be.
    pub fn contest(&self, ask: &Ts<ContestAsk>) -> Result<WebContest, WebError> {
        let on = Field {
            slam: self.slam(),
            walls: self.true_walls(),
            robot: self.robot(),
        };
        WebContest::on(on, ask.to_rust()?)
    }

    /// Files to save, named after `stem`.
    ///
    /// # Errors    A sentence on why there is no such file.
    pub fn export(&self, what: &Ts<SavedKind>, stem: &str) -> Result<Vec<Ts<SavedFile>>, WebError> {
        let slam = self.slam();
        let files = match what.to_rust()? {
            SavedKind::Map => {
                let name = format!("{stem}.pgm");
                export::map(slam, MapMode::Trinary, MapImage::Pgm, &name)
            }
            SavedKind::MapScale => {
                let name = format!("{stem}-map.png");
                export::map(slam, MapMode::Scale, MapImage::Png, &name)
            }
            SavedKind::MapRaw => {
                let name = format!("{stem}-raw.pgm");
                export::map(slam, MapMode::Raw, MapImage::Pgm, &name)
            }
            SavedKind::OgMap => export::og_map(slam),
            SavedKind::Plan => export::plan(slam, stem),
            SavedKind::Rooms => export::rooms(slam, stem),
            SavedKind::Tum => export::trajectory(&self.trajectory(), stem),
            SavedKind::Carmen => match &self.source {
                Source::Simulation(sim) => export::carmen(sim.experiment.log(), stem),
                Source::Recording(replay) => export::carmen(&replay.carmen_log(), stem),
                Source::Live(_) => Err(export::ExportError::Recorded.into()),
            },
        };
        files?.iter().map(typed).collect()
    }

    /// Changes settings that act at once.
    ///
    /// # Errors    A sentence on a setting that cannot be; then all stay as they were.
    pub fn configure(&mut self, values: &Ts<SettingValues>) -> Result<(), WebError> {
        let values = values.to_rust()?;
        match &mut self.source {
            Source::Simulation(sim) => sim.configure(&values),
            Source::Recording(replay) => {
                let mut settings = replay.log().settings();
                values.apply_to(&mut settings)?;
                Ok(replay.reconfigure(&settings)?)
            }
            Source::Live(behind) => Ok(behind.live.reconfigure(values.0.into_iter().collect())?),
        }
    }

    /// A twin with what is known of the odometry runs beside the robot from here on, or no longer.
    pub fn set_twin(&mut self, on: bool) {
        let calibration = on.then(|| *self.session().calibration());
        match &mut self.source {
            Source::Simulation(sim) => sim.experiment.set_twin(calibration),
            Source::Recording(replay) => replay.set_twin(calibration),
            Source::Live(behind) => behind.live.set_twin(calibration),
        }
    }

    /// σ(ρ) of the sensor: of a simulated one from scans of a twin that stands where the robot is, of a recording from the
    /// stretches in which the robot stood.
    ///
    /// # Errors    A sentence on why it cannot be estimated.
    pub fn estimate_sigma(&self, growth: &Ts<GrowthName>) -> Typed<SigmaCurve> {
        let growth = growth.to_rust()?;
        typed(&match &self.source {
            Source::Simulation(sim) => {
                let scans = sim.experiment.standing_scans(STANDING_SCANS);
                let truth = match sim.experiment.sim().sensor() {
                    SensorModel::Lidar(model) => Some((model.sigma, model.sigma_per_metre)),
                    SensorModel::Sonar(model) => Some((model.sigma, model.sigma_per_metre)),
                    SensorModel::Rangers(_) => None,
                };
                SigmaCurve::of(&[&scans], growth, truth)?
            }
            Source::Recording(replay) => {
                let stretches = replay.standing_stretches();
                let stretches: Vec<&[Scan]> = stretches.iter().map(Vec::as_slice).collect();
                SigmaCurve::of(&stretches, growth, None)?
            }
            Source::Live(_) => return Err(RunError::NotRecorded.into()),
        })
    }

    /// What the drive so far tells of the robot; nothing of a simulated one, whose figures are settings.
    ///
    /// # Errors    None that a page can cause.
    pub fn fit(&self) -> Result<Option<Ts<DriveFit>>, WebError> {
        let fit = match &self.source {
            Source::Simulation(_) => None,
            Source::Recording(replay) => Some(replay.fit()),
            Source::Live(behind) => Some(behind.live.session().fit()),
        };
        fit.map(|fit| typed(&fit.into())).transpose()
    }

    /// Samples of the twin from number `from` on, see `TWIN`.
    #[must_use]
    pub fn twin_since(&self, from: u32) -> Vec<f64> {
        samples_since(self.session().twin(), from)
    }

    /// What a person should read since the last call.
    ///
    /// # Errors    None that a page can cause.
    pub fn notices(&mut self) -> Result<Vec<Ts<Notice>>, WebError> {
        let notices: Vec<Notice> = match &mut self.source {
            Source::Simulation(_) => vec![],
            Source::Recording(replay) => {
                let level = Level::Warn;
                let notes = replay.take_notes().into_iter();
                notes.map(|text| Notice { level, text }).collect()
            }
            Source::Live(behind) => behind.notices(),
        };
        notices.iter().map(typed).collect()
    }

    /// For each scan of a recording so far: NaN NaN (no truth), odometry x y, estimate x y. Of others the page follows the poses.
    #[must_use]
    pub fn trail(&self) -> Vec<f32> {
        match &self.source {
            Source::Recording(replay) => crate::recording::trail(replay),
            _ => vec![],
        }
    }

    /// x y of the corners of the path.
    #[must_use]
    pub fn path(&self) -> Vec<f32> {
        let path = self.pilot().path();
        path.map(|path| view::polyline(&path.points))
            .unwrap_or_default()
    }

    /// The same before it was shortened.
    #[must_use]
    pub fn raw_path(&self) -> Vec<f32> {
        let path = self.pilot().raw_path();
        path.map(|path| view::polyline(&path.points))
            .unwrap_or_default()
    }

    /// x1 y1 x2 y2 of the edges of the planner's trees.
    #[must_use]
    pub fn tree(&self) -> Vec<f32> {
        view::segments(self.pilot().tree().iter(), &Pose2::identity())
    }

    /// x y of the cells between known and unknown.
    #[must_use]
    pub fn frontiers(&self) -> Vec<f32> {
        let grid = self.slam().grid();
        let frontiers = self.pilot().frontiers().iter();
        let cells = frontiers.flat_map(|frontier| &frontier.cells);
        let centres: Vec<_> = cells.map(|&cell| grid.centre_of(cell)).collect();
        view::polyline(&centres)
    }

    /// Whether the robot drives by the cycle of TDK 2016 §6.3.
    #[must_use]
    pub fn in_cycle(&self) -> bool {
        self.session().scans_on_command()
    }

    /// The stages of the cycle with what they gave.
    ///
    /// # Errors    None that a page can cause.
    pub fn cycle(&self) -> Typed<Cycle> {
        typed(&Cycle::of(self.session().stages()))
    }

    /// Reports of the cycle that were shown so far.
    #[must_use]
    pub fn cycle_count(&self) -> f64 {
        self.session().stages().count() as f64
    }

    /// Explore from here on.
    pub fn explore(&mut self) {
        self.set_mode(pilot::Mode::Explore);
    }

    /// Wait for the hand.
    pub fn manual(&mut self) {
        self.set_mode(pilot::Mode::Manual);
    }

    /// Go to a point of the map, m.
    pub fn go_to(&mut self, x: f64, y: f64) {
        self.set_mode(pilot::Mode::GoTo(Point2::new(x, y)));
    }

    /// Drive by hand; fractions of the robot's highest speeds in [-1, 1], forward and to the left.
    pub fn drive(&mut self, forward: f64, turn: f64) {
        match &mut self.source {
            Source::Simulation(sim) => {
                let robot = *sim.experiment.sim().robot();
                sim.experiment
                    .drive(forward * robot.max_speed, turn * robot.max_turn_rate);
            }
            Source::Recording(_) => {}
            Source::Live(behind) => behind.live.drive(forward, turn),
        }
    }

    /// Stop at once, at a time of the page's clock, µs. A real robot is disarmed too, whoever drives it.
    pub fn stop(&mut self, now: f64) {
        match &mut self.source {
            Source::Simulation(sim) => sim.experiment.stop(),
            Source::Recording(_) => {}
            Source::Live(behind) => behind.live.stop(now as u64),
        }
    }

    /// Fingerprint of the whole state of a simulation, the trajectory of a recording, pose and map of a live robot: 16
    /// hexadecimal digits.
    #[must_use]
    pub fn state_hash(&self) -> String {
        let hash = match &self.source {
            Source::Simulation(sim) => sim.experiment.state_hash(),
            Source::Recording(replay) => replay.state_hash(),
            Source::Live(behind) => {
                let mut hash = StateHash::new();
                behind.live.session().slam().add_to(&mut hash);
                hash.finish()
            }
        };
        format!("{hash:016x}")
    }
}

impl WebRun {
    fn session(&self) -> &Session {
        match &self.source {
            Source::Simulation(sim) => sim.experiment.session(),
            Source::Recording(replay) => replay.session(),
            Source::Live(behind) => behind.live.session(),
        }
    }

    fn slam(&self) -> &Slam {
        self.session().slam()
    }

    /// Of a recording whose log does not tell: a Pioneer, for most were recorded with one.
    fn robot(&self) -> &RobotModel {
        self.session().robot()
    }

    fn pilot(&self) -> &Pilot {
        self.session().pilot()
    }

    fn set_mode(&mut self, mode: pilot::Mode) {
        match &mut self.source {
            Source::Simulation(sim) => sim.experiment.set_mode(mode),
            Source::Recording(_) => {}
            Source::Live(behind) => behind.live.set_mode(mode),
        }
    }

    fn trajectory(&self) -> Vec<(f64, Pose2)> {
        match &self.source {
            Source::Recording(replay) => replay.trajectory(),
            _ => trajectory_of(self.slam()),
        }
    }

    /// The true walls, doors as they are now, and the motion into the map's frame.
    fn true_walls(&self) -> Option<(Vec<Segment>, Pose2)> {
        let Source::Simulation(sim) = &self.source else {
            return None;
        };
        let walls = sim.experiment.sim().caster().walls().iter();
        let segments = walls.map(|wall| wall.segment).collect();
        Some((segments, sim.experiment.map_from_world()))
    }

    /// # Errors    [`RunError::NoSimulation`].
    pub(crate) fn simulated(&self) -> Result<&Simulated, RunError> {
        match &self.source {
            Source::Simulation(sim) => Ok(sim),
            _ => Err(RunError::NoSimulation),
        }
    }

    /// # Errors    [`RunError::NoSimulation`].
    pub(crate) fn simulated_mut(&mut self) -> Result<&mut Simulated, RunError> {
        match &mut self.source {
            Source::Simulation(sim) => Ok(sim),
            _ => Err(RunError::NoSimulation),
        }
    }

    /// # Errors    [`RunError::NotLive`].
    pub(crate) fn behind(&self) -> Result<&Behind, RunError> {
        match &self.source {
            Source::Live(behind) => Ok(behind),
            _ => Err(RunError::NotLive),
        }
    }

    /// # Errors    [`RunError::NotLive`].
    pub(crate) fn behind_mut(&mut self) -> Result<&mut Behind, RunError> {
        match &mut self.source {
            Source::Live(behind) => Ok(behind),
            _ => Err(RunError::NotLive),
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

//! What only a simulated run has: the truth, doors, people, the cycle by stages, the bench.

use std::cell::OnceCell;

use slamlab_core::association::RefindingCurve;
use slamlab_core::experiment::Experiment;
use slamlab_core::lesson::Grade;
use slamlab_core::settings;
use slamlab_core::sim::{ReachableArea, SensorModel, Wall, reachable_area};
use tsify::Ts;
use wasm_bindgen::prelude::wasm_bindgen;

use crate::bench::{BenchResponse, BenchTrial};
use crate::border::{DoorRow, RefindingRow, SettingValues, Stage, Typed, WebError, flat, typed};
use crate::link::link_of;
use crate::run::{Simulated, Source, WebRun};
use crate::setup::Setup;
use crate::status::RunStatus;
use crate::view;

#[wasm_bindgen]
impl WebRun {
    /// A simulated run from this setup.
    ///
    /// # Errors    A sentence on the first thing that is invalid.
    pub fn simulate(setup: &Ts<Setup>) -> Result<Self, WebError> {
        let setup = setup.to_rust()?;
        let lesson = setup.lesson()?;
        let (config, defaults) = setup.read()?;
        let mut experiment = Experiment::new(config)?;
        if let Some(lesson) = lesson {
            lesson.check(&link_of(setup)?)?;
            experiment.follow(lesson.begin()?.actions);
        }
        let source = Source::Simulation(Box::new(Simulated {
            lesson,
            ..Simulated::new(experiment, defaults)
        }));
        Ok(Self::of(source))
    }

    /// The settings that differ from their defaults, if repeated actions of a link or an earlier
    /// run have changed them since the last call; nothing otherwise.
    ///
    /// # Errors    Never because of input, only at the border to the page.
    pub fn take_followed_settings(&mut self) -> Result<Option<Ts<SettingValues>>, WebError> {
        let Source::Simulation(sim) = &mut self.source else {
            return Ok(None);
        };
        let followed = sim.experiment.take_followed_settings();
        let changes = followed.map(|settings| settings.changes_from(&sim.defaults));
        changes
            .map(|changes| typed(&changes.into_iter().collect::<SettingValues>()))
            .transpose()
    }

    /// Goes on to the next stage of the cycle; nothing if there is none.
    ///
    /// # Errors    The source is not a simulation.
    pub fn next_stage(&mut self) -> Result<Option<Ts<Stage>>, WebError> {
        let stage = self.simulated_mut()?.experiment.next_stage()?;
        stage.map(|stage| typed(&Stage::from(&stage))).transpose()
    }

    /// Part of the reachable area that is known, 0 to 1; NaN if the truth is unknown. Costs more
    /// than a step; the first call takes time proportional to the world's floor.
    #[must_use]
    pub fn explored(&self) -> f64 {
        self.simulated().map_or(f64::NAN, Simulated::explored)
    }

    /// Area of the bounding rectangle of the world, m²; infinite if it is unknown.
    #[must_use]
    pub fn extent(&self) -> f64 {
        self.simulated().map_or(f64::INFINITY, |sim| {
            let (low, high) = sim.experiment.sim().world().bounds();
            (high.x - low.x) * (high.y - low.y)
        })
    }

    /// How well landmarks were found again so far, gate by gate, see `REFINDING`; nothing if the
    /// truth is unknown, or for methods without landmarks.
    #[must_use]
    pub fn refinding(&self) -> Vec<f32> {
        let curve = self.simulated().map(|sim| sim.experiment.refinding());
        let counted = curve.into_iter().flat_map(RefindingCurve::points);
        let rows = counted.map(|(gate, counts)| RefindingRow {
            gate: *gate as f32,
            tpr: counts.tpr() as f32,
            fpr: counts.fpr() as f32,
            ppv: counts.ppv() as f32,
            acc: counts.acc() as f32,
            sightings: (counts.with_partner + counts.without) as f32,
        });
        flat(rows.filter(|row| row.sightings > 0.0))
    }

    /// x1 y1 x2 y2 of the true walls, without doors.
    #[must_use]
    pub fn truth(&self) -> Vec<f32> {
        self.simulated().map_or(vec![], |sim| {
            let walls = sim.walls().iter().map(|wall| &wall.segment);
            view::segments(walls, &sim.experiment.map_from_world())
        })
    }

    /// Material of each true wall: 0 opaque, 1 glass, 2 dark.
    #[must_use]
    pub fn materials(&self) -> Vec<u8> {
        let walls = self.simulated().map_or(&[][..], Simulated::walls);
        walls.iter().map(|wall| wall.material as u8).collect()
    }

    /// Doors, see `DOOR`.
    #[must_use]
    pub fn doors(&self) -> Vec<f32> {
        self.simulated().map_or(vec![], Simulated::doors)
    }

    /// Opens or shuts a door; it moves with the next step.
    ///
    /// # Errors    There is no such door.
    pub fn set_door(&mut self, index: u32, open: bool) -> Result<(), WebError> {
        let experiment = &mut self.simulated_mut()?.experiment;
        Ok(experiment.set_door(index as usize, open)?)
    }

    /// Carries the robot to a random free place; the robot does not notice.
    ///
    /// # Errors    The source is not a simulation, or people stand everywhere.
    pub fn kidnap(&mut self) -> Result<(), WebError> {
        Ok(self.simulated_mut()?.experiment.kidnap(None)?)
    }

    /// x y radius of each moving object.
    #[must_use]
    pub fn movers(&self) -> Vec<f32> {
        self.simulated().map_or(vec![], |sim| {
            let map_from_world = sim.experiment.map_from_world();
            let discs = sim.experiment.sim().movers().iter();
            discs
                .flat_map(|disc| {
                    let centre = map_from_world * disc.centre;
                    [centre.x as f32, centre.y as f32, disc.radius as f32]
                })
                .collect()
        })
    }

    /// Tests the robot's drive controller on a bench: a step and a load.
    ///
    /// # Errors    No controller can be designed for the robot, or its motors are invalid.
    pub fn bench(&self, trial: &Ts<BenchTrial>) -> Typed<BenchResponse> {
        let robot = self.simulated()?.experiment.sim().robot();
        typed(&BenchResponse::of(robot, trial.to_rust()?)?)
    }
}

impl Simulated {
    pub(crate) fn status(&self) -> RunStatus {
        let (truth, sim) = (self.experiment.truth(), self.experiment.sim());
        RunStatus {
            time: sim.stamp().seconds(),
            truth_x: truth.x(),
            truth_y: truth.y(),
            truth_heading: truth.heading(),
            contacts: f64::from(sim.contacts().total()),
            by_hand: self.experiment.by_hand(),
            beam_half_angle: match sim.sensor() {
                SensorModel::Sonar(model) => model.half_angle,
                _ => 0.0,
            },
            ..RunStatus::of(self.experiment.session(), true)
        }
    }

    fn explored(&self) -> f64 {
        self.experiment.explored_fraction(self.area())
    }

    fn area(&self) -> &ReachableArea {
        self.area.get_or_init(|| {
            let sim = self.experiment.sim();
            let resolution = self.experiment.session().slam().grid().resolution();
            reachable_area(sim.world(), sim.robot().radius(), resolution)
        })
    }

    /// The grade of this try at a lesson: now, or when it was over.
    pub(crate) fn grade(&self) -> Option<Grade> {
        let now = || Some(self.lesson?.grade(&self.experiment, self.area()));
        self.graded.get().cloned().or_else(now)
    }

    /// Keeps the grade as soon as the try is over: what happens later does not count.
    pub(crate) fn note_grade(&mut self) {
        let is_over = self.lesson.is_some_and(|l| l.is_over(&self.experiment));
        if is_over && self.graded.get().is_none() {
            self.graded = self.grade().map(OnceCell::from).unwrap_or_default();
        }
    }

    pub(crate) fn configure(&mut self, values: &SettingValues) -> Result<(), WebError> {
        let mut settings = self.defaults.clone();
        let method = self.experiment.session().slam().method();
        values.apply_to(&mut settings, settings::Source::Simulation, method)?;
        Ok(self.experiment.reconfigure(&settings)?)
    }

    fn doors(&self) -> Vec<f32> {
        let sim = self.experiment.sim();
        let leaves = sim.world().doors.iter().map(|door| &door.leaf);
        let ends = view::segments(leaves, &self.experiment.map_from_world());
        let (ends, _) = ends.as_chunks::<4>();
        let states = sim.doors_open().zip(sim.doors_ordered());
        let flag = |yes| f32::from(u8::from(yes));
        let doors = ends.iter().zip(states);
        flat(doors.map(|(&[x1, y1, x2, y2], (open, ordered))| DoorRow {
            x1,
            y1,
            x2,
            y2,
            open: flag(open),
            ordered: flag(ordered),
        }))
    }

    /// The fixed walls. Doors that are shut come after them.
    fn walls(&self) -> &[Wall] {
        let sim = self.experiment.sim();
        let walls = sim.caster().walls();
        let shut = sim.doors_open().filter(|open| !open).count();
        walls.get(..walls.len() - shut).unwrap_or(walls)
    }
}

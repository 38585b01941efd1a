//! All planners on one query, for the page.

use nalgebra::Point2;
use serde::{Deserialize, Serialize};
use slamlab_core::geom::{Pose2, Segment};
use slamlab_core::plan::{
    Contest, ContestBody, ContestConfig, NoPath, Planner, Query, RouteConfig, Standing, Unknown,
};
use tsify::{Ts, Tsify};
use wasm_bindgen::prelude::wasm_bindgen;

use crate::border::{
    Float32Array, Float64Array, Ground, NoPathKind, PlannerName, Typed, WebError, typed,
};
use crate::run::{Source, WebRun};
use crate::view;

/// Why a contest cannot be held.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum AskError {
    /// There are no true walls to plan among.
    #[error("only a simulation knows the true walls: choose the map")]
    NoTruth,
}

crate::border::kinds! { Question: AskError; }

/// What all planners are asked.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Tsify)]
pub struct ContestAsk {
    /// Where they search.
    pub ground: Ground,
    /// x y of the start, then of the goal, map frame, m.
    pub ends: [f64; 4],
    /// Time of each planner, s.
    pub seconds: f64,
}

/// The state of all planners; map frame, m and s.
#[derive(Clone, Debug, PartialEq, Serialize, Tsify)]
#[serde(rename_all = "camelCase")]
#[tsify(missing_as_null)]
pub struct ContestState {
    /// What they were asked.
    pub ask: ContestAsk,
    /// Diameter of the disc around the robot, which all planners but `outline` use.
    pub disc: f64,
    /// The state of each planner; `outline` only for a robot that is not a disc.
    pub entrants: Vec<Entrant>,
    /// Length that the others are compared with; NaN while there is no path.
    pub shortest: f64,
    /// It is proved that there is no shorter path.
    pub is_optimum: bool,
    /// Whose tree this is: an index into `entrants`.
    pub watched: u32,
    /// x1 y1 x2 y2 of each leg or step that it tried.
    pub tree: Float32Array,
}

/// The state of one planner.
#[derive(Clone, Debug, PartialEq, Serialize, Tsify)]
#[serde(rename_all = "camelCase")]
#[tsify(missing_as_null)]
pub struct Entrant {
    /// The planner's name.
    pub planner: PlannerName,
    /// As people call it.
    pub title: String,
    /// It has finished.
    pub is_over: bool,
    /// The straight line was free.
    pub is_straight: bool,
    /// Length of its path; NaN without one.
    pub length: f64,
    /// Its length over the shortest.
    pub ratio: f64,
    /// Time taken.
    pub seconds: f64,
    /// Points drawn, cells expanded or legs checked.
    pub iterations: f64,
    /// Legs of trees, steps over cells or legs of the graph.
    pub tried: f64,
    /// Why it has no path.
    pub reason: Option<NoPathReason>,
    /// Why the planner over rooms gave up searching by rooms, whether it has a path or not.
    pub left_rooms: Option<String>,
    /// x y of the corners of its best path.
    pub path: Float32Array,
    /// Time taken and length, at each improvement.
    pub curve: Float64Array,
}

/// Why there is no path.
#[derive(Clone, Debug, PartialEq, Serialize, Tsify)]
pub struct NoPathReason {
    /// The kind of reason.
    pub kind: NoPathKind,
    /// In words.
    pub text: String,
}

impl From<NoPath> for NoPathReason {
    fn from(reason: NoPath) -> Self {
        Self {
            kind: (&reason).into(),
            text: reason.to_string(),
        }
    }
}

/// Planners that search for the same path; map frame, m and s.
#[wasm_bindgen]
#[derive(Debug)]
pub struct WebContest {
    contest: Contest,
    ask: ContestAsk,
    /// Diameter of the disc around the robot, m.
    disc: f64,
}

#[wasm_bindgen]
impl WebContest {
    /// One turn of one planner; returns whether there was anything to do.
    pub fn step(&mut self) -> bool {
        self.contest.step()
    }

    /// Reports how long the last turn took, s.
    pub fn took(&mut self, seconds: f64) {
        self.contest.took(seconds);
    }

    /// Whether all planners have finished.
    #[must_use]
    pub fn is_over(&self) -> bool {
        self.contest.is_over()
    }

    /// The state of all planners, with the tree of the one at index `watched`.
    ///
    /// # Errors    None that a page can cause.
    pub fn state(&self, watched: u32) -> Typed<ContestState> {
        let shortest = self.contest.shortest();
        let tree = self.contest.planners().nth(watched as usize);
        let tree = tree.map(|planner| self.contest.tree(planner));
        let standings = self.contest.standings();
        let entrants = self.contest.planners().zip(&standings);
        typed(&ContestState {
            ask: self.ask,
            disc: self.disc,
            entrants: entrants.map(|(p, s)| self.entrant(p, s)).collect(),
            shortest: shortest.as_ref().map_or(f64::NAN, |s| s.length),
            is_optimum: shortest.is_some_and(|s| s.is_optimum),
            watched,
            tree: view::segments(tree.iter().flatten(), &Pose2::identity()).into(),
        })
    }
}

impl WebContest {
    fn entrant(&self, planner: Planner, standing: &Standing) -> Entrant {
        let path = self.contest.path(planner);
        let curve = self.contest.curve(planner);
        Entrant {
            planner: planner.into(),
            title: planner.title().to_owned(),
            is_over: standing.is_over,
            is_straight: standing.is_straight,
            length: standing.length.unwrap_or(f64::NAN),
            ratio: standing.ratio.unwrap_or(f64::NAN),
            seconds: standing.seconds,
            iterations: standing.iterations as f64,
            tried: standing.tried as f64,
            reason: standing.reason.map(Into::into),
            left_rooms: standing.fallback.map(|why| why.to_string()),
            path: view::corners(path.as_ref()).into(),
            curve: curve
                .iter()
                .flat_map(|&(seconds, length)| [seconds, length])
                .collect(),
        }
    }
}

#[wasm_bindgen]
impl WebRun {
    /// All planners on one query.
    ///
    /// # Errors    A sentence on an invalid start, goal or ground.
    pub fn contest(&self, ask: &Ts<ContestAsk>) -> Result<WebContest, WebError> {
        let ask = ask.to_rust()?;
        let [x0, y0, x1, y1] = ask.ends;
        let query = Query {
            start: Point2::new(x0, y0),
            goal: Point2::new(x1, y1),
        };
        let config = ContestConfig {
            seconds: ask.seconds,
            ..ContestConfig::default()
        };
        let margin = RouteConfig::default().narrowest();
        let body = ContestBody {
            keep: self.robot().radius() + margin,
            outline: self.robot().outline(margin),
        };
        let grid = self.slam().grid();
        let contest = match ask.ground {
            Ground::Truth => Contest::among_walls(self.true_walls()?, body, query, config)?,
            Ground::Map => Contest::on_grid(grid, body, Unknown::Free, query, config)?,
            Ground::Known => Contest::on_grid(grid, body, Unknown::Blocked, query, config)?,
        };
        let disc = 2.0 * self.robot().radius();
        Ok(WebContest { contest, ask, disc })
    }
}

impl WebRun {
    /// The true walls, with doors as they are now, in the map frame.
    fn true_walls(&self) -> Result<Vec<Segment>, AskError> {
        let Source::Simulation(sim) = &self.source else {
            return Err(AskError::NoTruth);
        };
        let map_from_world = sim.experiment.map_from_world();
        let walls = sim.experiment.sim().caster().walls().iter();
        Ok(walls.map(|wall| map_from_world * wall.segment).collect())
    }
}

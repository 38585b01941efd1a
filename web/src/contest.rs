//! All planners on one query, for the page.

use nalgebra::Point2;
use slamlab_core::geom::{Pose2, Segment};
use slamlab_core::plan::{
    Contest, ContestBody, ContestConfig, NoPath, Planner, Query, RouteConfig, Unknown,
};
use slamlab_core::robot::RobotModel;
use slamlab_core::slam::Slam;
use wasm_bindgen::prelude::{JsError, wasm_bindgen};

use crate::view;

/// Why a contest cannot be asked for.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum AskError {
    /// No ground of that name.
    #[error("there is no ground `{0}` here; expected map, known, or, in a simulation, truth")]
    Ground(String),
    /// Not four numbers.
    #[error("{0} numbers, expected x and y of the start and of the goal")]
    Ends(usize),
}

/// Planners that look for the same path; map frame, m and s.
#[wasm_bindgen]
#[derive(Debug)]
pub struct WebContest {
    contest: Contest,
    /// Width of the disc around the robot, m.
    disc: f64,
}

#[wasm_bindgen]
impl WebContest {
    /// Names of those who take part, in the order of all that is told of them; `Outline` only for a robot that is no disc.
    #[must_use]
    pub fn planners(&self) -> Vec<String> {
        let planners = self.contest.planners();
        planners.map(|planner| format!("{planner:?}")).collect()
    }

    /// Width of the disc that the others plan for, m.
    #[must_use]
    pub fn disc(&self) -> f64 {
        self.disc
    }

    /// One turn of one planner; whether there was anything to do.
    pub fn step(&mut self) -> bool {
        self.contest.step()
    }

    /// How long that took, s.
    pub fn took(&mut self, seconds: f64) {
        self.contest.took(seconds);
    }

    /// Whether nobody has anything left to do.
    #[must_use]
    pub fn is_over(&self) -> bool {
        self.contest.is_over()
    }

    /// Numbers of each planner, see `STANDING` of www/src/protocol/contest.ts.
    #[must_use]
    pub fn standings(&self) -> Vec<f64> {
        let flag = |yes| f64::from(u8::from(yes));
        let numbers = |s: &slamlab_core::plan::Standing| {
            [
                flag(s.is_over),
                flag(s.is_straight),
                s.length.unwrap_or(f64::NAN),
                s.ratio.unwrap_or(f64::NAN),
                s.seconds,
                s.iterations as f64,
                s.tried as f64,
            ]
        };
        self.contest.standings().iter().flat_map(numbers).collect()
    }

    /// Why each planner has no path, in words, after a word for the kind; `rooms` where it left the rooms on the way, whether it has a
    /// path or not; empty where there is nothing to say.
    #[must_use]
    pub fn reasons(&self) -> Vec<String> {
        let words = |reason: NoPath| format!("{} {reason}", kind_of(reason));
        self.contest
            .standings()
            .iter()
            .map(|s| {
                let left = s.fallback.map(|why| format!("rooms {why}"));
                s.reason.map(words).or(left).unwrap_or_default()
            })
            .collect()
    }

    /// What the lengths are held against, m, and 1 if there is no shorter path; empty while nobody has one.
    #[must_use]
    pub fn shortest(&self) -> Vec<f64> {
        let numbers =
            |s: slamlab_core::plan::Shortest| vec![s.length, f64::from(u8::from(s.is_optimum))];
        self.contest.shortest().map(numbers).unwrap_or_default()
    }

    /// x y of the corners of a planner's best path.
    #[must_use]
    pub fn path(&self, place: usize) -> Vec<f32> {
        let path = self
            .planner_at(place)
            .and_then(|planner| self.contest.path(planner));
        path.map(|path| view::polyline(&path.points))
            .unwrap_or_default()
    }

    /// x1 y1 x2 y2 of what a planner tried.
    #[must_use]
    pub fn tree(&self, place: usize) -> Vec<f32> {
        let tree = self
            .planner_at(place)
            .map(|planner| self.contest.tree(planner));
        view::segments(tree.iter().flatten(), &Pose2::identity())
    }

    /// Time taken and length of a planner's path, whenever that became shorter.
    #[must_use]
    pub fn curve(&self, place: usize) -> Vec<f64> {
        let curve = self
            .planner_at(place)
            .map(|planner| self.contest.curve(planner));
        curve
            .unwrap_or_default()
            .iter()
            .flat_map(|&(seconds, length)| [seconds, length])
            .collect()
    }
}

/// Where the planners look: the true walls with the motion into the map's frame, where there are any, or the map.
pub(crate) struct Ground<'a> {
    pub(crate) slam: &'a Slam,
    pub(crate) walls: Option<(Vec<Segment>, Pose2)>,
    pub(crate) robot: &'a RobotModel,
}

impl WebContest {
    /// On a ground by its name; `ends` are x and y of start and goal.
    pub(crate) fn on(
        ground: Ground,
        name: &str,
        ends: &[f64],
        seconds: f64,
    ) -> Result<Self, JsError> {
        let &[x0, y0, x1, y1] = ends else {
            return Err(AskError::Ends(ends.len()).into());
        };
        let query = Query {
            start: Point2::new(x0, y0),
            goal: Point2::new(x1, y1),
        };
        let config = ContestConfig {
            seconds,
            ..ContestConfig::default()
        };
        let margin = RouteConfig::default().narrowest();
        let body = ContestBody {
            keep: ground.robot.radius() + margin,
            outline: ground.robot.outline(margin),
        };
        let grid = ground.slam.grid();
        let contest = match (name, ground.walls) {
            ("truth", Some((walls, map_from_world))) => {
                let into_map =
                    |w: &Segment| Segment::new(map_from_world * w.a, map_from_world * w.b);
                let walls = walls.iter().map(into_map).collect();
                Contest::among_walls(walls, body, query, config)?
            }
            ("map", _) => Contest::on_grid(grid, body, Unknown::Free, query, config)?,
            ("known", _) => Contest::on_grid(grid, body, Unknown::Blocked, query, config)?,
            (other, _) => return Err(AskError::Ground(other.to_owned()).into()),
        };
        let disc = 2.0 * ground.robot.radius();
        Ok(Self { contest, disc })
    }

    fn planner_at(&self, place: usize) -> Option<Planner> {
        self.contest.planners().nth(place)
    }
}

fn kind_of(reason: NoPath) -> &'static str {
    match reason {
        NoPath::StartBlocked { .. } | NoPath::GoalBlocked { .. } => "blocked",
        NoPath::Unreachable { .. } => "proved",
        NoPath::NotOffered { .. } => "not-offered",
        _ => "open",
    }
}

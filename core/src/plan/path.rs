//! The result of planners: a path of straight legs, or the reason why there is none.

use std::iter::successors;

use nalgebra::Point2;

use crate::geom::Segment;

/// Corners of a path, from the robot to the goal.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Path {
    /// The corners, map frame, m.
    pub points: Vec<Point2<f64>>,
}

impl Path {
    /// Length, m.
    #[must_use]
    pub fn length(&self) -> f64 {
        self.legs().map(|leg| leg.length()).sum()
    }

    /// The straight legs in order.
    pub fn legs(&self) -> impl Iterator<Item = Segment> + '_ {
        self.points
            .iter()
            .zip(self.points.iter().skip(1))
            .map(|(&a, &b)| Segment::new(a, b))
    }
}

/// The chain that leads to `last`, itself included, from its beginning: `before` gives the
/// predecessor of each element.
pub(super) fn way_to<T>(last: T, before: impl Fn(&T) -> Option<T>) -> Vec<T> {
    let mut way: Vec<T> = successors(Some(last), before).collect();
    way.reverse();
    way
}

/// Which planner searches for the path, or found it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Planner {
    /// The straight line was free.
    Straight,
    /// One tree with goal bias (TDK 2016 §5.2).
    Rrt,
    /// Two trees that grow towards each other (Kuffner & LaValle 2000).
    RrtConnect,
    /// One tree that is rewired where that shortens it (Karaman & Frazzoli 2011).
    RrtStar,
    /// The same, drawing only where the path can still be shortened (Gammell et al. 2014).
    InformedRrtStar,
    /// The shortest way over cells in eight directions (Hart et al. 1968).
    AStar,
    /// Cells with legs in any direction (Nash et al. 2007).
    ThetaStar,
    /// Rooms and doors first, then Theta* within the rooms crossed (Thrun 1998).
    Rooms,
    /// Tangents of the walls' ends: the shortest possible path.
    Visibility,
    /// Places and headings, for an outline that is not a disc (Latombe 1991).
    Outline,
    /// The cells of the grid, used when the trees had spent their budget but the grid proved that
    /// there is a way.
    Wavefront,
}

impl Planner {
    /// All planners, with their names in settings and pages, and their names for people; those that
    /// can be chosen come first.
    pub const ALL: [(&'static str, Self, &'static str); 11] = [
        ("rrt-connect", Self::RrtConnect, "RRT-Connect"),
        ("rrt", Self::Rrt, "RRT"),
        ("rrt-star", Self::RrtStar, "RRT*"),
        ("informed-rrt-star", Self::InformedRrtStar, "Informed RRT*"),
        ("a-star", Self::AStar, "A*"),
        ("theta-star", Self::ThetaStar, "Theta*"),
        ("rooms", Self::Rooms, "rooms, then Theta*"),
        ("straight", Self::Straight, "straight line"),
        ("visibility", Self::Visibility, "visibility graph"),
        ("outline", Self::Outline, "outline, turns and steps"),
        ("wavefront", Self::Wavefront, "wavefront"),
    ];
    /// Their names.
    pub const NAMES: &[&str] = &{
        let mut names = [""; Self::ALL.len()];
        let mut place = 0;
        while place < names.len() {
            names[place] = Self::ALL[place].0;
            place += 1;
        }
        names
    };
    /// How many of them can be chosen; the others find a path in special cases.
    pub const CHOOSABLE: usize = 7;

    /// The name.
    #[must_use]
    pub fn name(self) -> &'static str {
        self.words().0
    }

    /// The name for people.
    #[must_use]
    pub fn title(self) -> &'static str {
        self.words().1
    }

    fn words(self) -> (&'static str, &'static str) {
        let row = Self::ALL.iter().find(|(_, planner, _)| *planner == self);
        row.map_or(("", ""), |(name, _, title)| (name, title))
    }
}

/// Why there is no path.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum NoPath {
    /// The robot is enclosed where it stands.
    #[error(
        "the start at ({:.2}, {:.2}) m is inside an obstacle or enclosed: no free place within reach",
        .0.x, .0.y
    )]
    StartBlocked(Point2<f64>),
    /// The goal, and everything near it, is inside an obstacle or off the map.
    #[error(
        "the goal at ({:.2}, {:.2}) m is inside an obstacle, too near to one, or off the map",
        .0.x, .0.y
    )]
    GoalBlocked(Point2<f64>),
    /// It is proved that no chain of cells, not even of partly free ones, leads to this goal.
    #[error("no way leads to ({:.2}, {:.2}) m: the map proves it is closed off", .0.x, .0.y)]
    Unreachable(Point2<f64>),
    /// The planner has tried everything it can, which is no proof: its cells may be too large for
    /// the gap that leads there.
    #[error("no path among the {iterations} places that the planner could try")]
    Exhausted {
        /// Iterations used.
        iterations: usize,
    },
    /// The planner cannot work in such a space.
    #[error("{} cannot plan in this space", .planner.title())]
    NotOffered {
        /// The planner.
        planner: Planner,
    },
    /// Nothing was found, and nothing was proved.
    #[error("no path found within {iterations} iterations")]
    BudgetSpent {
        /// Iterations used.
        iterations: usize,
    },
}

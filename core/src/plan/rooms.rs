//! Rooms first: a way through doors, then Theta* within the rooms that it crosses.
//!
//! In: a [`Lattice`] over a configuration space and a query, cell by cell. Out: a path, or the
//! result that there is none over the cells; and whether the rooms helped.
//!
//! 1. The topology of the open cells ([`Topology`]): where the robot's centre can be, divided at
//!    places that are narrow for it.
//! 2. The shortest way through doors from the room of the start to that of the goal (Dijkstra),
//!    with straight lines from door to door: a lower bound, because within a room the way may have
//!    to go round something.
//! 3. Theta* over the cells of the crossed rooms only: on a long way that is a small part of a
//!    building.
//! 4. If the graph has no way, or the cells of those rooms have none, Theta* takes all cells, and
//!    [`NoRooms`] says why.
//!
//! Source: Thrun (1998), "Learning metric-topological maps for indoor mobile robot navigation",
//! section 4: plan on the topological map, refine on the metric one.

use nalgebra::Point2;
use rand::Rng;

use super::cspace::ConfigSpace;
use super::lattice::Lattice;
use super::path::{Path, way_to};
use super::query::Query;
use super::search::Planning;
use super::theta_star::ThetaStar;
use crate::geom::{Length, Segment};
use crate::map::{CellRect, CellState, Topology, TopologyConfig};

/// Why a search over rooms had to take all cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum NoRooms {
    /// The start is in no room.
    #[error("the start lies in no room")]
    Start,
    /// The goal is in no room.
    #[error("the goal lies in no room")]
    Goal,
    /// No doors lead from one room to the other.
    #[error("no doors lead from the room of the start to that of the goal")]
    Apart,
    /// There is no way over the cells of the crossed rooms.
    #[error("the rooms crossed hold no way for the robot")]
    Blocked,
}

/// A search over rooms, then over their cells.
#[derive(Debug)]
pub(super) struct RoomSearch {
    query: Query,
    search: ThetaStar,
    /// All cells; `None` while they are being searched.
    whole: Option<Lattice>,
    fallback: Option<NoRooms>,
}

impl RoomSearch {
    /// Finds the rooms, and begins in those that the way through doors crosses.
    pub(super) fn new(lattice: Lattice, query: Query) -> Self {
        let (part, whole, fallback) = match rooms_crossed(&lattice, &query) {
            Ok(is_crossed) => {
                let mut part = lattice.clone();
                part.close_but(|cell| is_crossed.get(cell) == Some(&true));
                (part, Some(lattice), None)
            }
            Err(why) => (lattice, None, Some(why)),
        };
        Self {
            query,
            search: ThetaStar::new(part, &query),
            whole,
            fallback,
        }
    }
}

impl Planning for RoomSearch {
    fn iterate(&mut self, space: &dyn ConfigSpace, rng: &mut dyn Rng) -> bool {
        if self.search.iterate(space, rng) {
            return true;
        }
        if self.search.is_found() {
            return false;
        }
        let Some(whole) = self.whole.take() else {
            return false;
        };
        self.search = ThetaStar::new(whole, &self.query);
        self.fallback = Some(NoRooms::Blocked);
        true
    }

    fn is_found(&self) -> bool {
        self.search.is_found()
    }

    fn path(&self) -> Option<Path> {
        self.search.path()
    }

    fn edges(&self) -> Vec<Segment> {
        self.search.edges()
    }

    fn edge_count(&self) -> usize {
        self.search.edge_count()
    }

    fn fallback(&self) -> Option<NoRooms> {
        self.fallback
    }
}

/// Steps 1 and 2: for each cell of the lattice, whether it lies in a crossed room.
fn rooms_crossed(lattice: &Lattice, query: &Query) -> Result<Vec<bool>, NoRooms> {
    let (width, height) = lattice.size();
    let state = |cell| match lattice.is_open(cell) {
        true => CellState::Free,
        false => CellState::Occupied,
    };
    let states: Vec<CellState> = (0..lattice.len()).map(state).collect();
    let rect = CellRect::of_size(width, height);
    // Every open cell counts as wide enough, however narrow the floor.
    let config = TopologyConfig {
        narrowest_door: 0.0,
        ..TopologyConfig::default()
    };
    let topology = Topology::of_cells(rect, lattice.side(), &states, &config);
    let regions: Vec<Option<usize>> = topology.cells().collect();
    let region_at = |point| {
        let cell = lattice.cell_at(point)?;
        regions.get(cell).copied().flatten()
    };
    let start = region_at(query.start).ok_or(NoRooms::Start)?;
    let goal = region_at(query.goal).ok_or(NoRooms::Goal)?;
    let ends = [
        lattice.in_lattice(query.start),
        lattice.in_lattice(query.goal),
    ];
    let crossed = way_over_doors(&topology, [start, goal], ends).ok_or(NoRooms::Apart)?;
    let is_crossed = |region: &Option<usize>| region.is_some_and(|r| crossed.contains(&r));
    Ok(regions.iter().map(is_crossed).collect())
}

/// The regions that the shortest way from door to door crosses; `None` if no doors lead to the
/// goal.
///
/// # Units    `ends`: start and goal in the frame of the topology, m, `regions`: their regions.
fn way_over_doors(
    topology: &Topology,
    [start, goal]: [usize; 2],
    ends: [Point2<f64>; 2],
) -> Option<Vec<usize>> {
    if start == goal {
        return Some(vec![start]);
    }
    let doors = topology.doors();
    let mut ways: Vec<Step> = doors
        .iter()
        .map(|door| Step {
            length: match door.other(start) {
                Some(_) => (door.centre - ends[0]).length(),
                None => f64::INFINITY,
            },
            into: door.other(start).unwrap_or(start),
            from: None,
            is_done: false,
        })
        .collect();
    let mut best: Option<(f64, usize)> = None;
    while let Some(at) = nearest(&ways) {
        let here = ways[at];
        if best.is_some_and(|(length, _)| length <= here.length) {
            break;
        }
        ways[at].is_done = true;
        if here.into == goal {
            let length = here.length + (doors[at].centre - ends[1]).length();
            if best.is_none_or(|(least, _)| length < least) {
                best = Some((length, at));
            }
            continue;
        }
        for &next in &topology.regions()[here.into].doors {
            let length = here.length + (doors[next].centre - doors[at].centre).length();
            if let Some(into) = doors[next].other(here.into)
                && length < ways[next].length
            {
                ways[next] = Step {
                    length,
                    into,
                    from: Some(at),
                    is_done: false,
                };
            }
        }
    }
    let doors = way_to(best?.1, |&door| ways[door].from);
    let crossed = doors.into_iter().map(|door| ways[door].into);
    Some(crossed.chain([start]).collect())
}

/// How a door is reached.
#[derive(Clone, Copy)]
struct Step {
    /// Length of the way to it, m.
    length: f64,
    /// The region behind it.
    into: usize,
    /// The door before it.
    from: Option<usize>,
    is_done: bool,
}

fn nearest(ways: &[Step]) -> Option<usize> {
    let open = ways.iter().enumerate();
    let open = open.filter(|(_, way)| !way.is_done && way.length.is_finite());
    let nearest = open.min_by(|a, b| a.1.length.total_cmp(&b.1.length));
    nearest.map(|(at, _)| at)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::{Planner, RrtConfig, Sampler, Search, SegmentSpace};

    /// Four rooms in a ring: doors between neighbours, except in the wall between the first and the
    /// last.
    fn rooms(open: [bool; 4]) -> Vec<Segment> {
        let wall = |x0: f64, y0: f64, x1: f64, y1: f64| {
            Segment::new(Point2::new(x0, y0), Point2::new(x1, y1))
        };
        let mut walls = vec![
            wall(0.0, 0.0, 8.0, 0.0),
            wall(8.0, 0.0, 8.0, 8.0),
            wall(8.0, 8.0, 0.0, 8.0),
            wall(0.0, 8.0, 0.0, 0.0),
        ];
        // From the centre to the east, north, west, south.
        let ways = [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)];
        for ((x, y), open) in ways.into_iter().zip(open) {
            let at = |along: f64| (4.0 + x * along, 4.0 + y * along);
            let mut part = |from: f64, to: f64| {
                let ((x0, y0), (x1, y1)) = (at(from), at(to));
                walls.push(wall(x0, y0, x1, y1));
            };
            if open {
                part(0.0, 1.5);
                part(2.5, 4.0);
            } else {
                part(0.0, 4.0);
            }
        }
        walls
    }

    fn solved(planner: Planner, walls: &[Segment], goal: (f64, f64)) -> Search {
        let bounds = (Point2::new(0.0, 0.0), Point2::new(8.0, 8.0));
        let space = SegmentSpace::new(walls.to_vec(), 0.15, bounds).unwrap();
        let query = Query {
            start: Point2::new(6.0, 2.0),
            goal: Point2::new(goal.0, goal.1),
        };
        let sampler = || Sampler::anywhere(&space);
        let mut search =
            Search::new(planner, &space, query, RrtConfig::default(), sampler).unwrap();
        let mut rng = <rand_chacha::ChaCha8Rng as rand::SeedableRng>::seed_from_u64(1);
        search.step(&space, &mut rng, usize::MAX);
        for leg in search
            .path()
            .iter()
            .flat_map(|path| path.legs().collect::<Vec<_>>())
        {
            assert!(space.leg_is_free(&leg));
        }
        search
    }

    #[test]
    fn the_way_through_the_doors_is_nearly_the_shortest() {
        let walls = rooms([true, true, true, false]);
        let found = solved(Planner::Rooms, &walls, (2.0, 2.0));
        let shortest = solved(Planner::Visibility, &walls, (2.0, 2.0));
        let (length, least) = (
            found.path().unwrap().length(),
            shortest.path().unwrap().length(),
        );
        assert!(
            length >= least - 1e-9 && length < 1.02 * least,
            "{length} {least}"
        );
        assert_eq!(found.fallback(), None);
    }

    #[test]
    fn where_no_door_leads_all_cells_are_taken_and_the_reason_is_told() {
        let found = solved(Planner::Rooms, &rooms([false; 4]), (2.0, 2.0));
        assert!(found.path().is_none());
        assert_eq!(found.fallback(), Some(NoRooms::Apart));
    }

    #[test]
    fn rooms_where_the_way_over_doors_leads_are_the_only_ones_crossed() {
        let walls = rooms([true, true, true, false]);
        let bounds = (Point2::new(0.0, 0.0), Point2::new(8.0, 8.0));
        let space = SegmentSpace::new(walls, 0.15, bounds).unwrap();
        let query = Query {
            start: Point2::new(6.0, 2.0),
            goal: Point2::new(6.0, 6.0),
        };
        let lattice = Lattice::over(&space, &query);
        let is_crossed = rooms_crossed(&lattice, &query).unwrap();
        let is_in = |x: f64, y: f64| is_crossed[lattice.cell_at(Point2::new(x, y)).unwrap()];
        assert!(is_in(6.0, 2.0) && is_in(6.0, 6.0));
        assert!(!is_in(2.0, 2.0) && !is_in(2.0, 6.0));
    }
}

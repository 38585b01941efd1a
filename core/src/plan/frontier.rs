//! Frontiers: borders between known free cells and unknown cells.
//!
//! In: a snapshot of the grid, and what can be reached in it. Out: scored clusters of frontier
//! cells, each with a goal from which it can be seen.
//!
//! 1. A frontier cell is free and has an unknown neighbour (Yamauchi 1997, "A frontier-based
//!    approach for autonomous exploration"); clusters are connected over eight neighbours, and cut
//!    into pieces no longer than `longest`: a border that runs round the whole known area has only
//!    one middle, and all of it would be given up when a scan there shows nothing.
//! 2. The gain of a cluster is the unknown area behind it: measured by a flood through unknown
//!    cells, as deep as [`GAIN_REACH`]. Walls stop the flood, so the slivers along walls and
//!    between beams gain next to nothing and are dropped; so are clusters narrower than the robot,
//!    not counting cells right beside a wall.
//! 3. The goal is the reachable cell from which the frontier is nearest over free floor, the
//!    cheapest one of the first few. Floor nearer to a wall than [`MIN_CLEARANCE`] is not followed:
//!    errors of the pose make holes of a cell or two in walls, and free floor behind them that no
//!    scan will ever make known. This alone does not make an exploration end: walls must be drawn
//!    so that they last (`map::Evidence`), and scans that show nothing must count
//!    (`pilot::explorer`).
//! 4. Score: the gain, bounded, times e^(-λ cost), as in González-Baños & Latombe (2002),
//!    "Navigation strategies for exploring indoor environments", eq. (1). Gain over cost and gain
//!    over cost squared were tried: in `office` they drive 131 and 108 m in the mean of three
//!    seeds, the exponential 97 m.
//! 5. Room by room: what lies in the room in which the way begins comes before everything else
//!    ([`crate::map::Topology`]). Corridors do not count as rooms: a robot that finished a corridor
//!    before its rooms would drive through it twice.

use std::collections::BTreeSet;

use nalgebra::Point2;

use super::cspace::GridSpace;
use super::view::view_gain;
use super::wavefront::Wavefront;
use crate::bounds::config;
use crate::map::{
    CellIndex, CellState, Grid, RegionKind, Rings, Topology, TopologyConfig, cells_around, spread,
};

/// Cells nearer to a wall than this do not count in the length of a cluster, and do not lead to it,
/// m: noise makes holes in walls, and strips of free cells behind them, through which nothing can
/// pass.
const MIN_CLEARANCE: f64 = 0.1;
/// Depth to which unknown area is counted, m.
const GAIN_REACH: f64 = 1.0;
/// Distance from which a frontier may be viewed, m over free floor; no farther than the sensor
/// sees.
const VIEW_REACH: f64 = 1.0;

/// A cell at the straight edge of open floor has five free neighbours, one in a jagged edge one
/// fewer, one on a lone beam two.
const OPEN_NEIGHBOURS: usize = 4;

/// Which frontier is the best.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FrontierChoice {
    /// The gain behind it, weighed against the way there: step 4.
    GainOverCost,
    /// The first one on the shortest tour through all of them ([`super::order_by_tour`]).
    #[default]
    ShortestTour,
    /// The nearest one, whatever it promises (Yamauchi 1997): the baseline.
    Nearest,
    /// The area visible all round from its goal, weighed against the way there (González-Baños &
    /// Latombe 2002).
    NextBestView,
    /// As [`FrontierChoice::GainOverCost`], but the current room first, before going through a
    /// door: step 5.
    RoomByRoom,
}

impl FrontierChoice {
    /// All strategies, with their names in settings and commands, and their names for people.
    pub const ALL: [(&'static str, Self, &'static str); 5] = [
        ("gain-over-cost", Self::GainOverCost, "Gain over cost"),
        ("nearest", Self::Nearest, "Nearest frontier"),
        ("next-best-view", Self::NextBestView, "Next best view"),
        ("room-by-room", Self::RoomByRoom, "Room by room"),
        ("shortest-tour", Self::ShortestTour, "Shortest tour"),
    ];
}

config! {
    /// Which frontiers count, and which counts most.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct FrontierConfig {
        /// Which is the best. Default [`FrontierChoice::ShortestTour`].
        pub choice: FrontierChoice = FrontierChoice::default(),
        /// How far the sensor sees, for [`FrontierChoice::NextBestView`], m. Default 4: as far as a
        /// view is worth a way.
        pub sight: f64 = 4.0,
        /// Clusters shorter than this are dropped, m. Default 0.2: about the robot's width.
        pub min_width: f64 = 0.2,
        /// Clusters longer than this are cut, m along the cluster. Default 3: of 2, 3, 4, 6 m and
        /// no cut, with the lidar the shortest way in `doors` and `office`.
        pub longest: f64 = 3.0,
        /// Clusters that would tell less than this are dropped, m². Default 0.06.
        pub min_gain: f64 = 0.06,
        /// Gains beyond this count no more, m². Default 1.5: a hall is no better than a room round
        /// the corner.
        pub most_gain: f64 = 1.5,
        /// How fast a gain loses worth with the cost of the way, 1/m. Default 0.25; larger sweeps
        /// nearer first.
        pub cost_decay: f64 = 0.25,
    }
}

/// One cluster of frontier cells.
#[derive(Clone, Debug, PartialEq)]
pub struct Frontier {
    /// Its cells.
    pub cells: Vec<CellIndex>,
    /// The cell nearest to their mean, map frame, m.
    pub centre: Point2<f64>,
    /// Unknown area behind it, m², to the counted depth.
    pub gain: f64,
    /// Where to view it from; `None` if no reachable place is near.
    pub goal: Option<Point2<f64>>,
    /// Cost of the way there, m of open floor; infinite without a goal.
    pub cost: f64,
    /// Its gain weighed against the way; 0 without a goal.
    pub score: f64,
}

impl Frontier {
    /// Those of its cells at the edge of open floor, for people who look at it. Far beams are a
    /// cell wide with unknown cells between them: all their cells border on unknown cells, but do
    /// not show where the unknown area begins.
    pub fn edge<'a>(&'a self, grid: &'a Grid) -> impl Iterator<Item = CellIndex> + 'a {
        let is_free = |col, row| grid.state(CellIndex::new(col, row)) == CellState::Free;
        let is_edge = move |cell: &CellIndex| {
            let rows = cell.row - 1..=cell.row + 1;
            let around = rows.flat_map(|row| (cell.col - 1..=cell.col + 1).map(move |c| (c, row)));
            // The cell itself is free.
            around.filter(|&(col, row)| is_free(col, row)).count() > OPEN_NEIGHBOURS
        };
        self.cells.iter().copied().filter(is_edge)
    }
}

/// All frontiers that count, best first; unreachable ones come last, without a goal.
#[must_use]
pub fn find_frontiers(
    space: &GridSpace,
    wave: &Wavefront,
    config: &FrontierConfig,
) -> Vec<Frontier> {
    let survey = Survey::new(space);
    let mut flood = Flood::new(space);
    let longest = (config.longest / space.resolution()).max(1.0) as usize;
    let mut frontiers: Vec<Frontier> = clusters(&survey)
        .into_iter()
        .flat_map(|cells| cut(&survey, cells, longest))
        .filter_map(|cells| judge(space, wave, config, &survey, &mut flood, &cells))
        .collect();
    if config.choice == FrontierChoice::RoomByRoom {
        stay_in_room(space, wave, config, &mut frontiers);
    }
    frontiers.sort_by(|a, b| b.score.total_cmp(&a.score));
    frontiers
}

/// Step 5: no gain is worth more than `most_gain`, so adding that much puts the frontiers of the
/// room first.
fn stay_in_room(
    space: &GridSpace,
    wave: &Wavefront,
    config: &FrontierConfig,
    frontiers: &mut [Frontier],
) {
    let states = space.states();
    let rooms = TopologyConfig::default();
    let topology = Topology::of_cells(space.rect(), space.resolution(), states, &rooms);
    let here = wave
        .start()
        .and_then(|start| topology.region_of(space.cell_of(start)));
    let is_room = |&number: &usize| topology.regions()[number].kind == RegionKind::Room;
    let Some(here) = here.filter(is_room) else {
        return;
    };
    for frontier in frontiers.iter_mut().filter(|f| f.goal.is_some()) {
        let inside = |&&cell: &&CellIndex| topology.region_of(cell) == Some(here);
        if 2 * frontier.cells.iter().filter(inside).count() > frontier.cells.len() {
            frontier.score += config.most_gain;
        }
    }
}

fn judge(
    space: &GridSpace,
    wave: &Wavefront,
    config: &FrontierConfig,
    survey: &Survey,
    flood: &mut Flood,
    cells: &[usize],
) -> Option<Frontier> {
    let resolution = space.resolution();
    let is_open = |cell: usize| space.clearance_of(cell) >= MIN_CLEARANCE;
    let open: Vec<usize> = cells.iter().copied().filter(|&c| is_open(c)).collect();
    let width = open.len() as f64 * resolution;
    if width < config.min_width {
        return None;
    }
    let depth = (GAIN_REACH / resolution).max(1.0) as usize;
    let mut unknown = 0_usize;
    let through = |cell: usize| survey.states[cell] == CellState::Unknown;
    flood.from(survey, cells, through, depth, |_, _| {
        unknown += 1;
        true
    });
    let gain = unknown as f64 * resolution * resolution;
    if gain < config.min_gain {
        return None;
    }
    // The first reachable cells, and those up to two rings farther; the cheapest of them is taken.
    let depth = (VIEW_REACH / resolution) as usize;
    let (mut first_ring, mut best) = (None, None::<(f64, usize)>);
    let through = |cell: usize| survey.states[cell] == CellState::Free && is_open(cell);
    flood.from(survey, &open, through, depth, |cell, ring| {
        if first_ring.is_some_and(|first| ring > first + 2) {
            return false;
        }
        if let Some(cost) = wave.cost(cell) {
            first_ring.get_or_insert(ring);
            if best.is_none_or(|(least, _)| cost < least) {
                best = Some((cost, cell));
            }
        }
        true
    });
    let (goal, cost) = best.map_or((None, f64::INFINITY), |(cost, cell)| {
        (Some(space.centre_of(cell)), cost)
    });
    let worth = |gain: f64, most: f64| gain.min(most) * libm::exp(-config.cost_decay * cost);
    let score = best.map_or(0.0, |(_, cell)| match config.choice {
        FrontierChoice::GainOverCost | FrontierChoice::RoomByRoom => worth(gain, config.most_gain),
        // Tours are planned among all frontiers.
        FrontierChoice::Nearest | FrontierChoice::ShortestTour => 1.0 / (1.0 + cost),
        // The view all round has its own bound: what is visible all round.
        FrontierChoice::NextBestView => worth(view_gain(space, cell, config.sight), f64::INFINITY),
    });
    Some(Frontier {
        centre: middle(space, cells)?,
        cells: cells.iter().map(|&i| space.cell_of(i)).collect(),
        gain,
        goal,
        cost,
        score,
    })
}

/// The cell centre nearest to the mean of all.
fn middle(space: &GridSpace, cells: &[usize]) -> Option<Point2<f64>> {
    let centres = || cells.iter().map(|&i| space.centre_of(i));
    let sum = centres().fold(nalgebra::Vector2::zeros(), |sum, c| sum + c.coords);
    let mean = Point2::from(sum / cells.len() as f64);
    centres().min_by(|a, b| {
        (a - mean)
            .norm_squared()
            .total_cmp(&(b - mean).norm_squared())
    })
}

/// Connected frontier cells.
fn clusters(survey: &Survey) -> Vec<Vec<usize>> {
    let is_frontier = |i: usize| {
        survey.states[i] == CellState::Free
            && survey
                .neighbours(i)
                .any(|n| survey.states[n] == CellState::Unknown)
    };
    let frontier: BTreeSet<usize> = (0..survey.states.len())
        .filter(|&i| is_frontier(i))
        .collect();
    components(survey, frontier)
}

/// Cuts a cluster into pieces that span `longest` cells along it: cells in the same band of steps
/// from one of its ends, and connected there. In a ring, the piece around that end reaches as far
/// to both sides.
fn cut(survey: &Survey, cells: Vec<usize>, longest: usize) -> Vec<Vec<usize>> {
    if cells.len() <= longest {
        return vec![cells];
    }
    let spread_from = |seed: usize| {
        let mut rest: BTreeSet<usize> = cells.iter().copied().collect();
        spread_over(survey, seed, &mut rest)
    };
    let end = spread_from(cells[0]).cells().last().unwrap_or(cells[0]);
    let bands = spread_from(end);
    let bands = bands.bands(longest);
    bands
        .flat_map(|band| components(survey, band.into_iter().collect()))
        .collect()
}

/// Parts of a set of cells that are connected over eight neighbours.
fn components(survey: &Survey, mut cells: BTreeSet<usize>) -> Vec<Vec<usize>> {
    let mut components = vec![];
    while let Some(seed) = cells.first().copied() {
        let component = spread_over(survey, seed, &mut cells);
        components.push(component.cells().collect());
    }
    components
}

/// Removes from `rest` what is connected with `seed`.
fn spread_over(survey: &Survey, seed: usize, rest: &mut BTreeSet<usize>) -> Rings {
    rest.remove(&seed);
    spread(
        seed,
        |cell| survey.neighbours_8(cell),
        |to| rest.remove(&to),
    )
}

/// The states with their neighbourhoods.
struct Survey<'a> {
    states: &'a [CellState],
    width: usize,
}

impl<'a> Survey<'a> {
    fn new(space: &'a GridSpace) -> Self {
        Self {
            states: space.states(),
            width: space.rect().width(),
        }
    }

    fn neighbours(&self, at: usize) -> impl Iterator<Item = usize> + '_ {
        let col = at % self.width;
        let east = (col + 1 < self.width).then_some(at + 1);
        let west = (col > 0).then(|| at - 1);
        let north = Some(at + self.width).filter(|&n| n < self.states.len());
        let south = at.checked_sub(self.width);
        [east, west, north, south].into_iter().flatten()
    }

    fn neighbours_8(&self, at: usize) -> impl Iterator<Item = usize> + '_ {
        let height = self.states.len() / self.width;
        cells_around(at, 1, self.width, height).filter(move |&n| n != at)
    }
}

/// A breadth-first flood whose marks are reused.
struct Flood {
    marks: Vec<u32>,
    mark: u32,
    queue: Vec<usize>,
}

impl Flood {
    fn new(space: &GridSpace) -> Self {
        Self {
            marks: vec![0; space.states().len()],
            mark: 0,
            queue: vec![],
        }
    }

    /// Floods from `seeds` through the cells that satisfy `through`, showing each with its ring;
    /// seeds that satisfy it are ring 0. Ends beyond `depth` rings or when `visit` returns `false`.
    fn from(
        &mut self,
        survey: &Survey,
        seeds: &[usize],
        through: impl Fn(usize) -> bool,
        depth: usize,
        mut visit: impl FnMut(usize, usize) -> bool,
    ) {
        self.mark += 1;
        self.queue.clear();
        self.queue.extend(seeds);
        for &seed in seeds {
            self.marks[seed] = self.mark;
            if through(seed) && !visit(seed, 0) {
                return;
            }
        }
        let mut begin = 0;
        for ring in 1..=depth {
            let end = self.queue.len();
            for at in begin..end {
                for to in survey.neighbours(self.queue[at]) {
                    if self.marks[to] == self.mark || !through(to) {
                        continue;
                    }
                    self.marks[to] = self.mark;
                    if !visit(to, ring) {
                        return;
                    }
                    self.queue.push(to);
                }
            }
            begin = end;
        }
    }
}

//! Planning on random floors, compared with brute force.

use nalgebra::Point2;
use proptest::prelude::*;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::reach::may_reach;
use super::*;
use crate::geom::{Length, Pose2, Segment};
use crate::map::{CellIndex, CellRect, CellState, Grid, GridConfig};
use crate::points::Beam;
use crate::points::fixture::{beam, scan_of};

const SIDE: i32 = 60;
const RESOLUTION: f64 = 0.05;
const RADIUS: f64 = 0.11;

/// A floor 3 m square with the given boxes (column, row, width, height) in it, walled all round,
/// drawn by beams: the last beams of a cell decide its state.
fn floor(boxes: &[(i32, i32, i32, i32)]) -> Grid {
    let mut grid = Grid::new(GridConfig {
        hit: 0.98,
        miss: 0.02,
        ..GridConfig::default()
    })
    .unwrap();
    let centre = |col: i32, row: i32| {
        let at = |cell: i32| (f64::from(cell) + 0.5) * RESOLUTION;
        Point2::new(at(col), at(row))
    };
    let is_wall = |col: i32, row: i32| {
        let border = col == 0 || row == 0 || col == SIDE - 1 || row == SIDE - 1;
        border
            || boxes
                .iter()
                .any(|&(c, r, w, h)| col >= c && col < c + w && row >= r && row < r + h)
    };
    let mut beams: Vec<Beam> = (0..SIDE)
        .map(|row| beam(0, centre(0, row), centre(SIDE - 1, row), false))
        .collect();
    for row in 0..SIDE {
        for col in (0..SIDE).filter(|&col| is_wall(col, row)) {
            beams.push(beam(0, centre(col, row), centre(col, row), true));
        }
    }
    grid.insert(&scan_of(beams), &Pose2::identity());
    grid
}

fn walls_of(grid: &Grid) -> Vec<Point2<f64>> {
    let cells = (0..SIDE).flat_map(|row| (0..SIDE).map(move |col| CellIndex { col, row }));
    cells
        .filter(|&cell| grid.state(cell) == CellState::Occupied)
        .map(|cell| grid.centre_of(cell))
        .collect()
}

/// Distance from the nearest wall cell of densely sampled points of the path, computed without
/// distance transforms.
fn nearest_wall(path: &Path, walls: &[Point2<f64>]) -> f64 {
    let mut nearest = f64::INFINITY;
    for leg in path.legs() {
        let pieces = (leg.length() / 0.005).ceil() as usize + 1;
        for i in 0..=pieces {
            let at = leg.a + leg.vector() * (i as f64 / pieces as f64);
            nearest = walls
                .iter()
                .map(|w| (w - at).length())
                .fold(nearest, f64::min);
        }
    }
    nearest
}

/// Brute-force flood from cell to cell with the exact distance to every wall.
fn floods(walls: &[Point2<f64>], start: Point2<f64>, goal: Point2<f64>, keep: f64) -> bool {
    let cell = |p: Point2<f64>| {
        (
            (p.x / RESOLUTION).floor() as i32,
            (p.y / RESOLUTION).floor() as i32,
        )
    };
    let free = |(c, r): (i32, i32)| {
        let at = Point2::new(
            (f64::from(c) + 0.5) * RESOLUTION,
            (f64::from(r) + 0.5) * RESOLUTION,
        );
        (0..SIDE).contains(&c)
            && (0..SIDE).contains(&r)
            && walls.iter().all(|w| (w - at).length() >= keep)
    };
    let mut seen = std::collections::BTreeSet::from([cell(start)]);
    let mut todo = vec![cell(start)];
    while let Some((c, r)) = todo.pop() {
        if (c, r) == cell(goal) {
            return true;
        }
        for next in [(c + 1, r), (c - 1, r), (c, r + 1), (c, r - 1)] {
            if free(next) && seen.insert(next) {
                todo.push(next);
            }
        }
    }
    false
}

/// Flood from start to goal over centres ten times as dense as the cells, where the room is at
/// least `least`.
fn floods_finely(space: &GridSpace, least: f64) -> bool {
    const SIDES: usize = 10 * SIDE as usize;
    let fine = RESOLUTION / 10.0;
    let number = |p: Point2<f64>| (p.y / fine) as usize * SIDES + (p.x / fine) as usize;
    let room = |i: usize| {
        let at = |i: usize| (i as f64 + 0.5) * fine;
        space.room(Point2::new(at(i % SIDES), at(i / SIDES)))
    };
    let mut seen = vec![false; SIDES * SIDES];
    let mut todo = vec![number(START)];
    while let Some(at) = todo.pop() {
        if at == number(GOAL) {
            return true;
        }
        // The floor is walled all round: nothing is reached at its border.
        for next in [at + 1, at - 1, at + SIDES, at - SIDES] {
            if !std::mem::replace(&mut seen[next], true) && room(next) >= least {
                todo.push(next);
            }
        }
    }
    false
}

fn boxes() -> impl Strategy<Value = Vec<(i32, i32, i32, i32)>> {
    proptest::collection::vec((8..SIDE - 8, 1..SIDE - 1, 1..14_i32, 1..40_i32), 0..6)
}

fn whole() -> CellRect {
    CellRect {
        min: CellIndex { col: 0, row: 0 },
        max: CellIndex::new(SIDE, SIDE),
    }
}

const START: Point2<f64> = Point2::new(0.225, 0.225);
const GOAL: Point2<f64> = Point2::new(2.775, 2.775);

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn routes_never_collide_and_exist_where_a_flood_says_so(boxes in boxes(), seed in 0_u64..1000, which in 0_usize..6, is_tight: bool) {
        let planner = [
            Planner::Rrt, Planner::RrtConnect, Planner::RrtStar, Planner::InformedRrtStar, Planner::AStar, Planner::ThetaStar,
        ][which];
        let shortening = if is_tight { Shortening::Tight } else { Shortening::Chords };
        let grid = floor(&boxes);
        let walls = walls_of(&grid);
        let margin = 0.03;
        let config = RouteConfig { margins: vec![margin], planner, shortening, goal_reach: 0.0, ..RouteConfig::default() };
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        // Half a cell, because walls may be anywhere in their cells.
        let keep = RADIUS + margin + 0.5 * RESOLUTION;
        let goal_is_free = walls.iter().all(|w| (w - GOAL).length() >= keep);
        let start_is_free = walls.iter().all(|w| (w - START).length() >= keep);
        prop_assume!(start_is_free && goal_is_free);
        match plan_route(&grid, START, GOAL, RADIUS, &config, &mut rng) {
            Ok(route) => {
                prop_assert_eq!(route.path.points.first(), Some(&START));
                prop_assert_eq!(route.path.points.last(), Some(&GOAL));
                // Bilinear distances err by up to 4 mm here (see the distance transform).
                let nearest = nearest_wall(&route.path, &walls);
                prop_assert!(nearest > keep - 0.005, "{} to a wall, by {:?}", nearest, route.by);
                prop_assert!(route.path.length() <= route.raw.length() + 1e-9);
            }
            Err(failure) => {
                prop_assert!(!floods(&walls, START, GOAL, keep + 1e-4), "{}", failure.reason);
                if matches!(failure.reason, NoPath::Unreachable { .. }) {
                    // Bilinear distances err by up to 4 mm here.
                    prop_assert!(!floods(&walls, START, GOAL, keep + 0.005), "a false proof");
                }
            }
        }
    }

    #[test]
    fn the_proof_of_no_path_is_that_of_a_flood_ten_times_as_fine(boxes in boxes(), keep in 0.05..0.35_f64) {
        let space = GridSpace::new(&floor(&boxes), whole(), keep, Unknown::Free);
        prop_assume!(space.is_free(START) && space.is_free(GOAL));
        let fine = RESOLUTION / 10.0;
        // The room changes by at most √2 per metre: by this much from a place to the nearest of the
        // fine centres.
        let found = may_reach(&space, START, GOAL);
        prop_assert!(found || !floods_finely(&space, 0.5 * fine * std::f64::consts::SQRT_2), "a false proof");
        prop_assert!(!found || floods_finely(&space, -fine), "a proof was missed");
    }

    #[test]
    fn source_rrt_finds_collision_free_paths_by_itself(boxes in boxes(), seed in 0_u64..1000) {
        let grid = floor(&boxes);
        let space = GridSpace::new(&grid, whole(), RADIUS, Unknown::Free);
        prop_assume!(space.is_free(START) && space.is_free(GOAL));
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let query = Query { start: START, goal: GOAL };
        let config = RrtConfig { max_iterations: 800, ..RrtConfig::default() };
        let mut search = Search::new(Planner::Rrt, &space, query, config, || Sampler::anywhere(&space)).unwrap();
        search.step(&space, &mut rng, 800);
        // The march may step over half a step, on which the room shrinks by √2 per metre.
        let slack = space.step() * std::f64::consts::FRAC_1_SQRT_2;
        let reachable = may_reach(&space.with_keep(RADIUS - slack), START, GOAL);
        prop_assert!(search.path().is_none() || reachable, "the proof of no path is wrong");
        if let Some(path) = search.path() {
            prop_assert!(nearest_wall(&path, &walls_of(&grid)) > RADIUS + 0.5 * RESOLUTION - 0.005);
            prop_assert!(search.iterations() <= 800);
        }
    }

    #[test]
    fn wavefront_ways_are_free_no_longer_than_their_cost_and_found_where_a_flood_says_so(boxes in boxes()) {
        let grid = floor(&boxes);
        let space = GridSpace::new(&grid, whole(), RADIUS, Unknown::Free);
        prop_assume!(space.is_free(START));
        let wave = Wavefront::new(&space, START);
        for cell in wave.reached() {
            // Every way is free, and its length is at most its cost: walls increase the cost, never
            // the length.
            let path = wave.path_to(&space, cell).unwrap();
            prop_assert!(path.legs().all(|leg| space.leg_is_free(&leg)));
            prop_assert!(path.length() <= wave.cost(cell).unwrap() * 1.02 + 1e-9);
        }
        let by_flood = floods(&walls_of(&grid), START, GOAL, RADIUS + 0.5 * RESOLUTION + 1e-4);
        let goal = space.index_at(GOAL).unwrap();
        prop_assert!(!by_flood || wave.cost(goal).is_some());
    }
}

#[test]
fn a_gap_that_opens_between_the_centres_of_cells_is_no_proof() {
    // Two blocks, corner to corner, five cells apart across and up: halfway between the corners
    // lies a saddle and no cell centre.
    let grid = floor(&[(1, 30, 20, 29), (25, 1, 34, 25)]);
    let space = |keep| GridSpace::new(&grid, whole(), keep, Unknown::Free);
    // Centres around the saddle are √13 and √8 cells from the corners, the saddle lies in the
    // middle of both.
    let saddle = (0.5 * (13.0_f64.sqrt() + 8.0_f64.sqrt()) - 0.5) * RESOLUTION;
    let goal = |space: &GridSpace| space.index_at(GOAL).unwrap();
    for (keep, expected) in [(saddle - 1e-4, true), (saddle + 1e-4, false)] {
        let space = space(keep);
        assert!(Wavefront::new(&space, START).cost(goal(&space)).is_none());
        assert_eq!(may_reach(&space, START, GOAL), expected, "{keep}");
    }
}

#[test]
fn shortest_chords_round_a_box_touch_its_corner_only() {
    // A wall from (1, 0) to (1, 1): the shortest way from (0, 0.5) to (2, 0.5) bends round its end.
    let wall = Segment::new(Point2::new(1.0, 0.0), Point2::new(1.0, 1.0));
    let bounds = (Point2::new(-1.0, 0.0), Point2::new(3.0, 3.0));
    let space = SegmentSpace::new(vec![wall], 0.1, bounds).unwrap();
    let points = [
        (0.0, 0.5),
        (0.0, 2.0),
        (1.0, 2.0),
        (1.0, 1.2),
        (2.0, 2.0),
        (2.0, 0.5),
    ];
    let path = Path {
        points: points.map(|(x, y)| Point2::new(x, y)).to_vec(),
    };
    let short = shorten(&path, &space);
    let corners: Vec<_> = short.points.iter().map(|p| (p.x, p.y)).collect();
    assert_eq!(corners, [(0.0, 0.5), (1.0, 1.2), (2.0, 0.5)]);
}

#[test]
fn a_leg_past_a_segment_is_judged_by_the_exact_capsule() {
    let wall = Segment::new(Point2::new(0.0, 0.0), Point2::new(1.0, 0.0));
    let bounds = (Point2::new(-2.0, -2.0), Point2::new(3.0, 2.0));
    for (keep, free) in [(0.2 - 1e-9, true), (0.2 + 1e-9, false)] {
        let space = SegmentSpace::new(vec![wall], keep, bounds).unwrap();
        let leg = Segment::new(Point2::new(-1.0, 0.2), Point2::new(2.0, 0.2));
        assert_eq!(space.leg_is_free(&leg), free);
        let marched = space.free_length(&leg);
        assert!(
            free == (marched >= leg.length()) && marched > 0.5,
            "{marched}"
        );
    }
}

#[test]
fn a_robot_in_a_pocket_that_walls_have_closed_gets_out() {
    // A passage of seven cells, shut at one end and five cells wide at the other: too narrow by
    // half a cell.
    let grid = floor(&[
        (24, 1, 11, 25),
        (24, 33, 11, 26),
        (24, 31, 2, 2),
        (33, 26, 2, 7),
    ]);
    let config = RouteConfig::default();
    let keep = RADIUS + config.narrowest();
    let space = GridSpace::new(&grid, whole(), keep, Unknown::Blocked);
    let here = Point2::new(1.425, 1.475);
    let goal = Point2::new(0.5, 1.5);
    assert!(space.is_free(here));
    let aim = space.index_at(goal).unwrap();
    assert!(Wavefront::new(&space, here).cost(aim).is_none());
    let out = space.escape(here, keep + ESCAPE_REACH).unwrap();
    assert!(Wavefront::new(&space, out).cost(aim).is_some());
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let route = plan_route(&grid, here, goal, RADIUS, &config, &mut rng).unwrap();
    assert!(nearest_wall(&route.path, &walls_of(&grid)) > RADIUS);
    // If nothing leads out, the pocket is all there is.
    let shut = floor(&[
        (24, 1, 11, 25),
        (24, 33, 11, 26),
        (24, 26, 2, 7),
        (33, 26, 2, 7),
    ]);
    let space = GridSpace::new(&shut, whole(), keep, Unknown::Blocked);
    let nearest = space.nearest_free(here, keep);
    assert!(nearest.is_some());
    assert_eq!(space.escape(here, keep + ESCAPE_REACH), nearest);
}

#[test]
fn a_robot_too_near_to_a_wall_gets_out_and_an_enclosed_one_says_so() {
    let grid = floor(&[(30, 1, 4, 58)]);
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let config = RouteConfig::default();
    let plan = |start: Point2<f64>, goal: Point2<f64>, rng: &mut ChaCha8Rng| {
        plan_route(&grid, start, goal, RADIUS, &config, rng)
    };
    let out = plan(Point2::new(0.12, 1.5), Point2::new(1.0, 1.5), &mut rng).unwrap();
    assert_eq!(out.path.points[0], Point2::new(0.12, 1.5));
    let other_side = plan(Point2::new(0.5, 1.5), Point2::new(2.5, 1.5), &mut rng).unwrap_err();
    assert!(matches!(other_side.reason, NoPath::Unreachable { .. }));
    let outside = plan(Point2::new(0.5, 1.5), Point2::new(1.6, 9.0), &mut rng).unwrap_err();
    assert!(matches!(outside.reason, NoPath::Unreachable { .. }));
    for nonsense in [f64::NAN, f64::INFINITY, 1e9] {
        let failure =
            plan(Point2::new(0.5, 1.5), Point2::new(nonsense, 0.0), &mut rng).unwrap_err();
        assert!(matches!(failure.reason, NoPath::GoalBlocked { .. }));
    }
    let cell = floor(&[(1, 1, 58, 58)]);
    let enclosed = plan_route(
        &cell,
        Point2::new(1.5, 1.5),
        GOAL,
        RADIUS,
        &config,
        &mut rng,
    );
    let said = enclosed.unwrap_err().reason.to_string();
    assert!(
        said.contains("(1.50, 1.50)") && said.contains("enclosed"),
        "{said}"
    );
}

/// A frontier with its goal at `x`, at this cost of the way.
fn frontier(x: f64, cost: f64) -> Frontier {
    let goal = Point2::new(x, 1.5);
    Frontier {
        cells: vec![],
        centre: goal,
        gain: 1.0,
        goal: Some(goal),
        cost,
        score: 0.0,
    }
}

#[test]
fn what_is_left_over_near_by_comes_before_the_long_way() {
    let grid = floor(&[]);
    let space = GridSpace::new(&grid, whole(), RADIUS, Unknown::Blocked);
    let wave = Wavefront::new(&space, Point2::new(1.2, 1.5));
    let order = |goals: &[f64], heading_for: Option<f64>| {
        let found = goals.iter().map(|x| frontier(*x, (x - 1.2).abs()));
        let mut found: Vec<Frontier> = found.collect();
        let heading_for = heading_for.map(|x| Point2::new(x, 1.5));
        order_by_tour(&mut found, &space, &wave, heading_for, |_| true);
        let places = found.iter().filter_map(|f| Some(f.goal?.x));
        places.collect::<Vec<f64>>()
    };
    // 0.6 m to the left, and 0.4, 0.8 and 1.2 m to the right: visiting the left end first saves 0.6
    // m of the whole tour.
    assert_eq!(order(&[1.6, 2.4, 0.6, 2.0], None), [0.6, 1.6, 2.0, 2.4]);
    // With nothing far off to the right it is the other way round.
    assert_eq!(order(&[0.6, 1.6], None), [1.6, 0.6]);
    // Two decimetres are not worth turning round.
    assert_eq!(order(&[0.6, 1.6], Some(0.6)), [0.6, 1.6]);
}

#[test]
fn what_was_given_up_or_is_out_of_reach_is_not_toured() {
    let grid = floor(&[]);
    let space = GridSpace::new(&grid, whole(), RADIUS, Unknown::Blocked);
    let wave = Wavefront::new(&space, Point2::new(1.0, 1.5));
    let out_of_reach = Frontier {
        goal: None,
        cost: f64::INFINITY,
        ..frontier(1.2, 0.2)
    };
    let mut found = vec![out_of_reach.clone(), frontier(1.4, 0.4), frontier(2.4, 1.4)];
    order_by_tour(&mut found, &space, &wave, None, |f| f.cost > 1.0);
    assert_eq!(
        found,
        [frontier(2.4, 1.4), frontier(1.4, 0.4), out_of_reach]
    );
    // And many more than are toured.
    let mut many: Vec<Frontier> = (0..25)
        .map(|i| frontier(1.0 + 0.06 * f64::from(i), 0.06 * f64::from(i)))
        .collect();
    let sorted = many.clone();
    many.reverse();
    order_by_tour(&mut many, &space, &wave, None, |_| true);
    assert_eq!(many[10..], sorted[10..]);
    assert!(sorted.iter().all(|f| many.contains(f)));
}

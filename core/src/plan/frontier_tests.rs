//! Which frontier comes first, in a room with more to see at its far end and a door close by.

use std::f64::consts::TAU;

use nalgebra::{Point2, Vector2};

use super::*;
use crate::geom::Pose2;
use crate::map::{CellIndex, CellState, Grid, GridConfig};
use crate::points::fixture::{beam, beam_along, scan_of};

const CELL: f64 = 0.05;

/// A room of 4 m x 3 m whose western end was not seen, and through the door in its eastern wall a
/// part of the next one.
fn two_rooms() -> Grid {
    let sure = GridConfig {
        hit: 0.98,
        miss: 0.02,
        ..GridConfig::default()
    };
    let mut grid = Grid::new(sure).unwrap();
    let mut beams = vec![];
    let mut draw = |x0: f64, x1: f64, y: f64, is_hit: bool| {
        beams.push(beam(0, Point2::new(x0, y), Point2::new(x1, y), is_hit));
    };
    for row in -1..=60 {
        let y = (f64::from(row) + 0.5) * CELL;
        let is_door = (1.0..1.9).contains(&y);
        if row == -1 || row == 60 {
            for col in 0..120 {
                let x = (f64::from(col) + 0.5) * CELL;
                draw(x, x, y, true);
            }
            continue;
        }
        draw(0.01, 3.99, y, false);
        if is_door {
            draw(4.01, 4.2, y, false);
        } else {
            draw(4.025, 4.025, y, true);
        }
        if (0.3..2.6).contains(&y) {
            draw(4.06, 5.6, y, false);
        }
    }
    grid.insert(&scan_of(beams), &Pose2::identity());
    grid
}

fn first_goal(choice: FrontierChoice) -> Point2<f64> {
    let grid = two_rooms();
    let robot = Point2::new(3.5, 1.45);
    let rect = rect_around(&grid, &[robot], 2, i32::MAX).unwrap();
    let space = GridSpace::new(&grid, rect, 0.13, Unknown::Blocked);
    assert!(space.states().contains(&CellState::Occupied));
    let wave = Wavefront::new(&space, robot);
    let config = FrontierConfig {
        choice,
        ..FrontierConfig::default()
    };
    let found = find_frontiers(&space, &wave, &config);
    assert!(found.is_sorted_by(|a, b| a.score >= b.score));
    found[0].goal.unwrap()
}

#[test]
fn room_by_room_finishes_the_room_and_gain_over_cost_goes_through_the_door() {
    assert!(first_goal(FrontierChoice::GainOverCost).x > 4.1);
    assert!(first_goal(FrontierChoice::RoomByRoom).x < 1.5);
}

/// A disc of floor that was seen from its centre, 2 m in radius.
fn disc() -> Grid {
    let mut grid = Grid::new(GridConfig::default()).unwrap();
    let points = scan_of((0..720).map(|beam_idx| {
        let (sin, cos) = crate::geom::sin_cos(TAU * beam_idx as f64 / 720.0);
        beam_along(beam_idx, Vector2::new(cos, sin), 2.0, false)
    }));
    for _ in 0..3 {
        grid.insert(&points, &Pose2::identity());
    }
    grid
}

#[test]
fn a_border_all_round_is_cut_into_pieces_that_hold_all_of_it() {
    let grid = disc();
    let rect = rect_around(&grid, &[Point2::origin()], 2, i32::MAX).unwrap();
    let space = GridSpace::new(&grid, rect, 0.13, Unknown::Blocked);
    let wave = Wavefront::new(&space, Point2::origin());
    let found = |longest: f64| {
        let config = FrontierConfig {
            longest,
            ..FrontierConfig::default()
        };
        find_frontiers(&space, &wave, &config)
    };
    let cells_of = |frontiers: &[Frontier]| {
        let mut cells: Vec<CellIndex> = frontiers.iter().flat_map(|f| f.cells.clone()).collect();
        cells.sort_unstable_by_key(|cell| (cell.row, cell.col));
        cells
    };
    let whole = found(100.0);
    assert_eq!(whole.len(), 1);
    let pieces = found(1.0);
    assert_eq!(cells_of(&pieces), cells_of(&whole));
    // Two arms of half the circumference each, cut from one end on; a step may be diagonal.
    assert!((8..=14).contains(&pieces.len()), "{}", pieces.len());
    for piece in &pieces {
        let apart = |a: &CellIndex, b: &CellIndex| (a.col - b.col).abs().max((a.row - b.row).abs());
        let longest = (piece.cells.iter())
            .flat_map(|a| piece.cells.iter().map(move |b| apart(a, b)))
            .max();
        // The first piece has its end in the middle.
        assert!(longest.unwrap() < 40, "{longest:?}");
    }
}

/// A floor of 2 m x 2 m, with beams that extend east of it, each a cell wide with two unknown cells
/// between them.
#[test]
fn far_beams_are_no_edge_of_the_floor() {
    let mut grid = Grid::new(GridConfig {
        miss: 0.02,
        ..GridConfig::default()
    })
    .unwrap();
    let middle = |cell: i32| (f64::from(cell) + 0.5) * CELL;
    let rows = 0..40;
    let beams = rows.map(|row| {
        let reach = if row % 3 == 0 { 80 } else { 39 };
        let [from, to] = [0, reach].map(|col| Point2::new(middle(col), middle(row)));
        beam(0, from, to, false)
    });
    grid.insert(&scan_of(beams), &Pose2::identity());
    let all = (0..81).flat_map(|col| (0..40).map(move |row| CellIndex::new(col, row)));
    let cells: Vec<CellIndex> = all
        .filter(|&cell| grid.state(cell) == CellState::Free)
        .collect();
    assert!(cells.iter().any(|cell| cell.col > 60), "beams reach far");
    let frontier = Frontier {
        cells,
        centre: Point2::origin(),
        gain: 1.0,
        goal: None,
        cost: 0.0,
        score: 0.0,
    };
    let edge: Vec<CellIndex> = frontier.edge(&grid).collect();
    assert!(edge.iter().all(|cell| cell.col <= 40), "no lone beam");
    let last: Vec<i32> = (1..39)
        .filter(|&row| edge.contains(&CellIndex::new(39, row)))
        .collect();
    assert_eq!(last.len(), 38, "the eastern edge of the floor");
}

//! Buildings with known rooms and doors, laid under the grid at any angle; and random grids.

use std::collections::BTreeSet;
use std::f64::consts::{FRAC_PI_4, PI};

use nalgebra::Vector2;
use proptest::prelude::*;

use super::*;
use crate::geom::{Length, sides_of, sin_cos};

const CELL: f64 = 0.05;
/// Thickness of the walls around what is free, m.
const WALL: f64 = 0.15;

/// Rectangles of free floor (from, to) in metres, doors among them; everything within [`WALL`] of
/// them is wall.
struct Building {
    floor: Vec<[f64; 4]>,
    furniture: Vec<[f64; 4]>,
}

fn is_in(rect: &[f64; 4], at: Point2<f64>, spare: f64) -> bool {
    let [x0, y0, x1, y1] = rect;
    at.x > x0 - spare && at.y > y0 - spare && at.x < x1 + spare && at.y < y1 + spare
}

impl Building {
    fn of(floor: &[[f64; 4]]) -> Self {
        Self {
            floor: floor.to_vec(),
            furniture: vec![],
        }
    }

    fn state(&self, at: Point2<f64>) -> CellState {
        let is_floor = |spare| self.floor.iter().any(|rect| is_in(rect, at, spare));
        match is_floor(0.0) {
            true if self.furniture.iter().any(|rect| is_in(rect, at, 0.0)) => CellState::Occupied,
            true => CellState::Free,
            false if is_floor(WALL) => CellState::Occupied,
            false => CellState::Unknown,
        }
    }

    /// The cells of the building in a grid turned by `turn` against it.
    fn cells(&self, turn: f64) -> (CellRect, Vec<CellState>) {
        let corners = self.floor.iter().flat_map(|[x0, y0, x1, y1]| {
            [(x0, y0), (x1, y0), (x1, y1), (x0, y1)].map(|(x, y)| Point2::new(*x, *y))
        });
        let (mut low, mut high) = ((i32::MAX, i32::MAX), (i32::MIN, i32::MIN));
        for corner in corners {
            let at = turned(corner, turn);
            let (col, row) = ((at.x / CELL).floor() as i32, (at.y / CELL).floor() as i32);
            low = (low.0.min(col - 5), low.1.min(row - 5));
            high = (high.0.max(col + 6), high.1.max(row + 6));
        }
        let rect = rect(low.0, low.1, high.0, high.1);
        let mut states = vec![];
        for row in low.1..high.1 {
            for col in low.0..high.0 {
                let at = Point2::new(f64::from(col) + 0.5, f64::from(row) + 0.5) * CELL;
                states.push(self.state(turned(at, -turn)));
            }
        }
        (rect, states)
    }

    fn topology(&self, turn: f64) -> Topology {
        let (rect, states) = self.cells(turn);
        Topology::of_cells(rect, CELL, &states, &TopologyConfig::default())
    }
}

fn turned(at: Point2<f64>, by: f64) -> Point2<f64> {
    let (sin, cos) = sin_cos(by);
    Point2::new(cos * at.x - sin * at.y, sin * at.x + cos * at.y)
}

/// The region of a point of the map, m.
fn region_at(found: &Topology, point: Point2<f64>) -> Option<usize> {
    found.region_of(CellIndex::holding(point / found.resolution()))
}

fn rect(x0: i32, y0: i32, x1: i32, y1: i32) -> CellRect {
    CellRect {
        min: CellIndex { col: x0, row: y0 },
        max: CellIndex { col: x1, row: y1 },
    }
}

/// Two rooms of 4 x 3 m and 3 x 3 m, with a door of this width and at this height in the wall
/// between them.
fn two_rooms(width: f64, from: f64) -> Building {
    Building::of(&[
        [0.0, 0.0, 4.0, 3.0],
        [4.15, 0.0, 7.15, 3.0],
        [3.9, from, 4.25, from + width],
    ])
}

/// A corridor with three rooms on its northern side, each behind a door of 0.9 m.
fn wing() -> Building {
    let rooms = [0.0, 4.1, 8.2];
    let mut floor = vec![[0.0, 0.0, 12.2, 1.8]];
    for x in rooms {
        floor.push([x, 1.95, x + 4.0, 5.0]);
        floor.push([x + 1.0, 1.7, x + 1.9, 2.05]);
    }
    Building::of(&floor)
}

fn kinds(topology: &Topology) -> Vec<RegionKind> {
    topology.regions().iter().map(|r| r.kind).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn two_rooms_have_one_door_of_their_width_at_any_angle(
        width in 0.6..1.2_f64, from in 0.2..1.6_f64, turn in 0.0..1.6_f64,
    ) {
        let found = two_rooms(width, from).topology(turn);
        prop_assert_eq!(kinds(&found), [RegionKind::Room; 2]);
        for (region, area) in found.regions().iter().zip([12.0, 9.0]) {
            prop_assert!((region.area - area).abs() < 0.05 * area, "{} against {area}", region.area);
        }
        prop_assert_eq!(found.doors().len(), 1);
        let door = found.doors()[0];
        prop_assert!((door.width - width).abs() < 2.0 * CELL, "{} against {width}", door.width);
        let true_centre = turned(Point2::new(4.075, from + 0.5 * width), turn);
        prop_assert!((door.centre - true_centre).length() < 5.0 * CELL, "{}", door.centre);
        prop_assert!(door.is_framed);
    }

    #[test]
    fn furniture_and_specks_make_no_doors(
        turn in 0.0..1.6_f64, x in 0.9..2.6_f64, y in 0.5..1.5_f64,
        specks in proptest::collection::vec((0.1..7.0_f64, 0.1..2.9_f64), 0..12),
    ) {
        let mut building = two_rooms(0.9, 1.0);
        // A table anywhere in the larger room, so that the ways past it are as narrow as doors.
        building.furniture.push([x, y, x + 0.7, y + 1.0]);
        for (x, y) in specks {
            building.furniture.push([x, y, x + 0.06, y + 0.06]);
        }
        let found = building.topology(turn);
        prop_assert_eq!(found.regions().len(), 2);
        prop_assert_eq!(found.doors().len(), 1);
        prop_assert!((found.doors()[0].width - 0.9).abs() < 3.0 * CELL, "{}", found.doors()[0].width);
    }

    #[test]
    fn rooms_and_doors_of_a_chessboard_are_all_found(
        open in proptest::collection::vec(any::<bool>(), 12), turn in prop_oneof![Just(0.0), Just(PI / 12.0), Just(FRAC_PI_4)],
    ) {
        let (building, truth) = chessboard(&open);
        let found = building.topology(turn);
        prop_assert_eq!(found.regions().len(), 9);
        // The building's own numbers of the rooms, by their centres.
        let region = |room: usize| region_at(&found, turned(middle(room), turn));
        let doors: BTreeSet<_> = found.doors().iter().map(|door| door.regions).collect();
        let expected: BTreeSet<_> = truth.iter().map(|[a, b]| {
            let pair = [region(*a), region(*b)].map(|r| r.unwrap_or(usize::MAX));
            [pair[0].min(pair[1]), pair[0].max(pair[1])]
        }).collect();
        prop_assert_eq!(doors, expected);
        prop_assert_eq!(found.doors().len(), truth.len());
    }

    #[test]
    fn on_grids_of_chance_regions_part_the_free_cells(
        width in 0_usize..40, height in 0_usize..40, seed in proptest::collection::vec(0_u8..12, 1600), coarse in 1_usize..9,
    ) {
        // Patches of `coarse` cells: from noise to rooms.
        let at = |i: usize| ((i / width) / coarse * 40 + (i % width) / coarse) % 1600;
        let states: Vec<_> = (0..width * height).map(|i| match seed[at(i)] {
            0..=2 => CellState::Occupied,
            3 => CellState::Unknown,
            _ => CellState::Free,
        }).collect();
        let rect = rect(-7, 3, width as i32 - 7, height as i32 + 3);
        check_partition(&Topology::of_cells(rect, CELL, &states, &TopologyConfig::default()), &states);
        let small = TopologyConfig { least_area: 0.05, island: 0.06, narrowest_door: 0.05 };
        check_partition(&Topology::of_cells(rect, CELL, &states, &small), &states);
    }
}

/// Nine rooms of 3 m; the first six doors lead east, the others north.
fn chessboard(open: &[bool]) -> (Building, Vec<[usize; 2]>) {
    let corner = |room: usize| (3.2 * (room % 3) as f64, 3.2 * (room / 3) as f64);
    let mut floor: Vec<[f64; 4]> = (0..9)
        .map(corner)
        .map(|(x, y)| [x, y, x + 3.0, y + 3.0])
        .collect();
    let mut doors = vec![];
    for (number, _) in open.iter().enumerate().filter(|(_, open)| **open) {
        let (room, other) = match number {
            0..6 => (number / 2 * 3 + number % 2, number / 2 * 3 + number % 2 + 1),
            _ => (number - 6, number - 3),
        };
        let (x, y) = corner(room);
        floor.push(match number {
            0..6 => [x + 2.9, y + 0.7, x + 3.3, y + 1.6],
            _ => [x + 1.4, y + 2.9, x + 2.3, y + 3.3],
        });
        doors.push([room, other]);
    }
    (Building::of(&floor), doors)
}

fn middle(room: usize) -> Point2<f64> {
    Point2::new(3.2 * (room % 3) as f64 + 1.5, 3.2 * (room / 3) as f64 + 1.5)
}

/// By brute force: every free cell belongs to one region, or to a scrap too small for one; no other
/// cell does; areas and centres are those of the cells; doors join the regions that they touch.
fn check_partition(found: &Topology, states: &[CellState]) {
    let cells: Vec<_> = found.cells().collect();
    assert_eq!(cells.len(), states.len());
    let width = found.rect().width();
    let mut counts = vec![0_usize; found.regions().len()];
    for (region, state) in cells.iter().zip(states) {
        assert!(region.is_none() || *state == CellState::Free);
        if let Some(region) = region {
            counts[*region] += 1;
        }
    }
    let cell = found.resolution() * found.resolution();
    for (number, (region, count)) in found.regions().iter().zip(&counts).enumerate() {
        assert!((region.area - *count as f64 * cell).abs() < 1e-9);
        assert!(*count > 0 && region_at(found, region.centre) == Some(number));
        let own = found.doors().iter().enumerate();
        let own = own.filter(|(_, door)| door.regions.contains(&number));
        assert_eq!(region.doors, own.map(|(i, _)| i).collect::<Vec<_>>());
    }
    assert!(found.regions().is_sorted_by(|a, b| a.area >= b.area));
    let is_scrap = |i: usize| states[i] == CellState::Free && cells[i].is_none();
    for scrap in components(width, cells.len(), is_scrap) {
        // Scraps joined only by a hole may lie beside one another.
        assert!(scrap.len() as f64 * cell < 4.0 * TopologyConfig::default().least_area);
    }
    for door in found.doors() {
        let [a, b] = door.regions;
        assert!(a < b && b < found.regions().len());
        assert_eq!(door.other(a), Some(b));
    }
}

fn components(width: usize, count: usize, is_in: impl Fn(usize) -> bool) -> Vec<Vec<usize>> {
    let mut left: BTreeSet<usize> = (0..count).filter(|&i| is_in(i)).collect();
    let mut found = vec![];
    while let Some(seed) = left.pop_first() {
        let mut cells = vec![seed];
        let mut next = 0;
        while next < cells.len() {
            let at = cells[next];
            next += 1;
            let (east, west) = ((at + 1) % width != 0, at % width != 0);
            let near = [
                east.then_some(at + 1),
                west.then(|| at - 1),
                Some(at + width),
                at.checked_sub(width),
            ];
            cells.extend(near.into_iter().flatten().filter(|to| left.remove(to)));
        }
        found.push(cells);
    }
    found
}

#[test]
fn a_wing_is_a_corridor_and_three_rooms_at_any_angle() {
    for degrees in [0.0, 15.0, 45.0, 77.0, 120.0] {
        let found = wing().topology(f64::to_radians(degrees));
        let mut kinds = kinds(&found);
        kinds.sort_by_key(|kind| kind.name());
        let rooms = [RegionKind::Room; 3];
        assert_eq!(kinds[0], RegionKind::Corridor, "at {degrees}°");
        assert_eq!(kinds[1..], rooms, "at {degrees}°");
        let corridor = kinds_at(&found, RegionKind::Corridor);
        assert_eq!(found.doors().len(), 3);
        for door in found.doors() {
            assert!(door.other(corridor).is_some());
            assert!((door.width - 0.9).abs() < 1.5 * CELL, "{}", door.width);
        }
    }
}

fn kinds_at(found: &Topology, kind: RegionKind) -> usize {
    let mut regions = found.regions().iter();
    regions.position(|region| region.kind == kind).unwrap()
}

#[test]
fn the_rim_of_what_was_seen_is_no_door() {
    // Of the second room a wedge was seen through the door, of the first one only the part below a
    // slanting line.
    let building = two_rooms(0.9, 1.0);
    let (rect, mut states) = building.cells(0.0);
    for (i, state) in states.iter_mut().enumerate() {
        let (col, row) = (i % rect.width(), i / rect.width());
        let at = Point2::new(
            f64::from(rect.min.col + col as i32) + 0.5,
            f64::from(rect.min.row + row as i32) + 0.5,
        ) * CELL;
        let is_behind = at.x > 4.2 && (at.y - 1.45).abs() > 0.45 + 0.3 * (at.x - 4.2);
        if is_behind || at.y > 1.3 + 0.5 * at.x {
            *state = CellState::Unknown;
        }
    }
    let found = Topology::of_cells(rect, CELL, &states, &TopologyConfig::default());
    assert_eq!((found.regions().len(), found.doors().len()), (2, 1));
    check_partition(&found, &states);
}

#[test]
fn an_opening_as_wide_as_a_hall_and_a_closet_divide_nothing() {
    let wide = two_rooms(2.0, 0.5).topology(0.3);
    assert_eq!((wide.regions().len(), wide.doors().len()), (1, 0));
    let closet = Building::of(&[
        [0.0, 0.0, 4.0, 3.0],
        [4.15, 0.0, 5.35, 1.2],
        [3.9, 0.2, 4.25, 0.9],
    ]);
    let closet = closet.topology(0.0);
    assert_eq!(closet.regions().len(), 1);
    assert!((closet.regions()[0].area - 13.5).abs() < 0.6);
}

#[test]
fn a_hole_in_a_wall_is_no_door() {
    let found = two_rooms(0.15, 1.0).topology(0.0);
    assert_eq!((found.regions().len(), found.doors().len()), (2, 0));
    assert!(found.regions().iter().all(|region| region.doors.is_empty()));
}

#[test]
fn outlines_hold_the_area_with_the_floor_on_their_left() {
    let mut building = two_rooms(0.9, 1.0);
    building.furniture.push([1.0, 1.0, 1.8, 1.6]);
    for turn in [0.0, 0.4] {
        let found = building.topology(turn);
        let outlines = found.outlines();
        assert_eq!(outlines.iter().map(Vec::len).collect::<Vec<_>>(), [2, 1]);
        for (rings, region) in outlines.iter().zip(found.regions()) {
            let area: f64 = rings.iter().map(|ring| signed_area(ring)).sum();
            assert!((area - region.area).abs() < 0.04 * region.area, "{area}");
        }
        let table = outlines[0].iter().map(|ring| signed_area(ring));
        let table = table.fold(f64::INFINITY, f64::min);
        assert!((table + 0.48).abs() < 0.1, "{table}");
    }
}

fn signed_area(ring: &[Point2<f64>]) -> f64 {
    let crosses = sides_of(ring).map(|(a, b)| a.coords.perp(&b.coords));
    0.5 * crosses.sum::<f64>()
}

#[test]
fn nothing_known_is_no_region() {
    let grid = Grid::new(crate::map::GridConfig::default()).unwrap();
    let found = Topology::of_grid(&grid, &TopologyConfig::default());
    assert!(found.regions().is_empty() && found.doors().is_empty());
    assert_eq!(
        region_at(&found, Point2::from(Vector2::new(f64::NAN, 1.0))),
        None
    );
    assert_eq!(region_at(&found, Point2::new(1e300, -1e300)), None);
}

//! Maps of built-in worlds, drawn from true poses and aligned with each other from anywhere; the
//! truth is the pose by which the loaded one was moved away.

use std::f64::consts::PI;

use proptest::prelude::*;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::geom::Segment;
use crate::map::GridConfig;
use crate::points::Points;
use crate::points::fixture::{look, normal};
use crate::sim::{reachable_area, worlds};

/// The range of the lidar, 8 m.
const MAX_RANGE: f64 = 8.0;

/// The walls of a world, and where a robot can stand in it.
struct Building {
    walls: Vec<Segment>,
    standing: Vec<Point2<f64>>,
}

impl Building {
    fn new(name: &str) -> Self {
        let world = worlds::builtin(name).unwrap();
        let area = reachable_area(&world, 0.3, 0.25);
        let low = area.low;
        let at = |index: usize| {
            let [col, row] =
                [index % area.cols, index / area.cols].map(|i| (i as f64 + 0.5) * area.resolution);
            Point2::new(low.x + col, low.y + row)
        };
        let stands = area.standing.iter().enumerate().filter(|(_, is)| **is);
        Self {
            walls: world.walls().iter().map(|wall| wall.segment).collect(),
            standing: stands.map(|(index, _)| at(index)).collect(),
        }
    }

    /// The part of the building between two fractions of its places, from left to right.
    fn seen(
        &self,
        [from, to]: [f64; 2],
        scans: usize,
        rng: &mut impl Rng,
    ) -> (Grid, Vec<Point2<f64>>) {
        let mut standing = self.standing.clone();
        standing.sort_by(|a, b| a.x.total_cmp(&b.x));
        let [from, to] = [from, to].map(|part| (part * standing.len() as f64) as usize);
        let mut grid = Grid::new(GridConfig::default()).unwrap();
        let mut way = vec![];
        for _ in 0..scans {
            let at = standing[rng.random_range(from..to)];
            let pose = Pose2::new(at.x, at.y, rng.random_range(-PI..PI));
            let scan = noisy(look(&self.walls, &pose, MAX_RANGE), rng);
            // Twice: a cell is believed only if it was seen repeatedly.
            grid.insert(&scan, &pose);
            grid.insert(&scan, &pose);
            way.push(at);
        }
        (grid, way)
    }
}

fn noisy(mut scan: Points, rng: &mut impl Rng) -> Points {
    for beam in scan.beams.iter_mut().filter(|beam| beam.is_hit) {
        let part = 1.0 + 0.01 * normal(rng) / beam.range.max(0.1);
        beam.end_in_robot.coords *= part;
        beam.range *= part;
    }
    scan
}

/// A map as read from a file, in a frame of its own.
fn loaded(
    grid: &Grid,
    way: &[Point2<f64>],
    landmarks: &[Point2<f64>],
    map_from_loaded: &Pose2,
) -> MapPoints {
    let there = map_from_loaded.inverse();
    let moved = |points: &[Point2<f64>]| points.iter().map(|p| there * *p).collect();
    MapPoints {
        walls: moved(&grid.occupied()),
        way: moved(way),
        landmarks: moved(landmarks),
        grid: None,
    }
}

fn anywhere(rng: &mut impl Rng) -> Pose2 {
    let mut shift = || rng.random_range(-40.0..40.0);
    let (x, y) = (shift(), shift());
    Pose2::new(x, y, rng.random_range(-PI..PI))
}

/// How far an alignment is from the truth, at the centre of the loaded walls, m and rad.
fn off(found: &MapAlignment, truth: &Pose2, map: &MapPoints) -> (f64, f64) {
    let sum: Vector2<f64> = map.walls.iter().map(|p| p.coords).sum();
    let middle = Point2::from(sum / map.walls.len() as f64);
    let shift = (found.map_from_loaded * middle - *truth * middle).length();
    (
        shift,
        truth.delta_to(&found.map_from_loaded).heading().abs(),
    )
}

#[test]
fn maps_of_one_building_are_found_wherever_and_however_they_lie() {
    let mut table = String::new();
    let (mut right, mut wrong, mut total) = (0, 0, 0);
    for name in ["office", "lab", "maze", "loop", "arena", "warehouse"] {
        let building = Building::new(name);
        for (seed, part) in [[0.0, 1.0], [0.0, 0.6], [0.4, 1.0], [0.2, 0.7], [0.1, 0.9]]
            .into_iter()
            .enumerate()
        {
            let rng = &mut ChaCha8Rng::seed_from_u64(seed as u64);
            let (grid, _) = building.seen([0.0, 0.75], 60, rng);
            let (other, way) = building.seen(part, 40, rng);
            let truth = anywhere(rng);
            let map = loaded(&other, &way, &[], &truth);
            let said = align_map(&map, &grid, &[]);
            total += 1;
            match &said {
                Ok(found) => {
                    let (shift, turn) = off(found, &truth, &map);
                    let is_right = shift < 0.05 && turn < 0.02;
                    right += i32::from(is_right);
                    wrong += i32::from(!is_right);
                    table += &format!(
                        "{name} {part:?}: off {shift:.3} m {turn:.4} rad, agrees {:.2}, contradicts {:.2}, residual {:.3}\n",
                        found.agrees, found.contradicts, found.residual
                    );
                }
                Err(why) => table += &format!("{name} {part:?}: {why}\n"),
            }
        }
    }
    assert_eq!(wrong, 0, "{table}");
    assert!(right >= 25, "{right} of {total}\n{table}");
}

#[test]
fn maps_of_other_buildings_are_laid_nowhere() {
    let mut table = String::new();
    let buildings = ["office", "lab", "maze", "loop", "arena"].map(Building::new);
    // Whole maps, and beginnings of maps: a map of one room fits in many.
    let seen = |part: f64, scans: usize| -> Vec<_> {
        let begun = |building: &Building| {
            building.seen([0.0, part], scans, &mut ChaCha8Rng::seed_from_u64(7))
        };
        buildings.iter().map(begun).collect()
    };
    let maps = [seen(1.0, 50), seen(0.3, 12)].concat();
    let mut laid = 0;
    let whole = buildings.len();
    for (i, (grid, _)) in maps.iter().enumerate() {
        for (j, (other, way)) in maps.iter().enumerate() {
            // Of the same building, or two beginnings.
            if j % whole == i % whole || (i >= whole && j >= whole) {
                continue;
            }
            let map = loaded(other, way, &[], &Pose2::new(3.0, -2.0, 1.0));
            match align_map(&map, grid, &[]) {
                Ok(found) => {
                    laid += 1;
                    table += &format!("{j} in {i}: {found:?}\n");
                }
                Err(why) => table += &format!("{j} in {i}: {why}\n"),
            }
        }
    }
    assert_eq!(laid, 0, "{table}");
}

/// What is assumed to be free without being known so: a grid drawn by the same scans agrees.
#[test]
fn what_is_seen_from_a_way_is_free() {
    let rng = &mut ChaCha8Rng::seed_from_u64(5);
    let building = Building::new("office");
    let (drawn, way) = building.seen([0.0, 1.0], 60, rng);
    let seen = seen_from(&way, &drawn.occupied()).unwrap();
    let rect = seen
        .rect_where(|odds| seen.state_of(odds) == CellState::Free)
        .unwrap();
    let free: Vec<_> = rect
        .cells()
        .filter(|c| seen.state(*c) == CellState::Free)
        .collect();
    let by_drawn =
        |state: CellState| free.iter().filter(|c| drawn.state(**c) == state).count() as f64;
    let total = free.len() as f64;
    assert!(total > 20_000.0, "{total}");
    assert!(
        by_drawn(CellState::Free) > 0.97 * total,
        "{} of {total}",
        by_drawn(CellState::Free)
    );
    assert!(
        by_drawn(CellState::Occupied) < 0.002 * total,
        "{}",
        by_drawn(CellState::Occupied)
    );
}

/// Two rooms that look alike, in a map that knows both.
fn twins() -> Vec<Segment> {
    let room = |x: f64| {
        let corners = [[0.0, 0.0], [5.0, 0.0], [5.0, 2.5], [3.5, 4.0], [0.0, 4.0]];
        let corner = move |i: usize| Point2::new(x + corners[i % 5][0], corners[i % 5][1]);
        (0..5).map(move |i| Segment::new(corner(i), corner(i + 1)))
    };
    room(0.0).chain(room(9.0)).collect()
}

fn room_seen(walls: &[Segment], x: f64, rng: &mut impl Rng) -> (Grid, Vec<Point2<f64>>) {
    let mut grid = Grid::new(GridConfig::default()).unwrap();
    let way: Vec<_> = [1.0, 2.0, 3.0].map(|at| Point2::new(x + at, 1.8)).to_vec();
    for at in &way {
        let pose = Pose2::new(at.x, at.y, 0.3);
        for _ in 0..3 {
            grid.insert(&noisy(look(walls, &pose, MAX_RANGE), rng), &pose);
        }
    }
    (grid, way)
}

#[test]
fn a_room_that_there_is_twice_is_laid_in_neither_unless_landmarks_tell() {
    let rng = &mut ChaCha8Rng::seed_from_u64(1);
    let walls = twins();
    let (mut grid, _) = room_seen(&walls, 0.0, rng);
    for at in [1.0, 2.0, 3.0] {
        let pose = Pose2::new(9.0 + at, 1.8, 0.0);
        for _ in 0..3 {
            grid.insert(&noisy(look(&walls, &pose, MAX_RANGE), rng), &pose);
        }
    }
    let (room, way) = room_seen(&walls, 9.0, rng);
    let truth = Pose2::new(-3.0, 7.0, 2.0);
    // Posts that only the second room has, and others in the first.
    let posts = |x: f64, of: &[[f64; 2]]| {
        of.iter()
            .map(|p| Point2::new(x + p[0], p[1]))
            .collect::<Vec<_>>()
    };
    let there = posts(
        9.0,
        &[[0.5, 0.7], [1.7, 3.1], [4.2, 0.9], [3.3, 2.2], [0.9, 2.0]],
    );
    let elsewhere = posts(0.0, &[[2.5, 0.4], [4.0, 3.0], [0.3, 3.2]]);
    let all = [elsewhere, there.clone()].concat();
    let without = loaded(&room, &way, &[], &truth);
    let said = align_map(&without, &grid, &all);
    assert!(
        matches!(said, Err(MapAlignmentError::Ambiguous { places: 2, .. })),
        "{said:?}"
    );
    let with = loaded(&room, &way, &there, &truth);
    let found = align_map(&with, &grid, &all).unwrap();
    assert_eq!((found.by, found.landmarks), (AlignedBy::Landmarks, 5));
    let (shift, turn) = off(&found, &truth, &with);
    assert!(shift < 0.05 && turn < 0.02, "{found:?}");
    // If the map has only one such room, walls and landmarks agree.
    let (alone, _) = room_seen(&walls, 9.0, rng);
    let found = align_map(&with, &alone, &there).unwrap();
    assert_eq!((found.by, found.landmarks), (AlignedBy::Both, 5));
}

#[test]
fn a_piece_of_a_corridor_has_no_place_along_it() {
    let rng = &mut ChaCha8Rng::seed_from_u64(3);
    let wall = |y: f64| Segment::new(Point2::new(-60.0, y), Point2::new(60.0, y));
    let walls = [wall(-1.0), wall(1.0)];
    let mut seen = |xs: std::ops::Range<i32>| {
        let mut grid = Grid::new(GridConfig::default()).unwrap();
        for x in xs {
            let pose = Pose2::new(f64::from(x), 0.0, 0.0);
            for _ in 0..2 {
                grid.insert(&noisy(look(&walls, &pose, MAX_RANGE), rng), &pose);
            }
        }
        grid
    };
    let (long, short) = (seen(-15..16), seen(-2..3));
    let map = loaded(&short, &[], &[], &Pose2::new(1.0, 2.0, 0.5));
    let said = align_map(&map, &long, &[]);
    assert!(
        matches!(
            said,
            Err(MapAlignmentError::Ambiguous { .. } | MapAlignmentError::Degenerate { .. })
        ),
        "{said:?}"
    );
}

#[test]
fn maps_that_are_none_are_refused_in_words() {
    let rng = &mut ChaCha8Rng::seed_from_u64(2);
    let walls = twins();
    let (grid, _) = room_seen(&walls, 0.0, rng);
    let few = MapPoints {
        walls: vec![Point2::new(1.0, 2.0); 3],
        ..MapPoints::default()
    };
    let said = align_map(&few, &grid, &[]).unwrap_err();
    let expected = MapAlignmentError::TooFewPoints {
        which: "loaded",
        found: 3,
    };
    assert_eq!(said, expected);
    assert!(
        said.to_string().contains("the loaded map has 3 points"),
        "{said}"
    );
    let nan = MapPoints {
        walls: vec![Point2::new(f64::NAN, 2.0); 100],
        ..MapPoints::default()
    };
    let said = align_map(&nan, &grid, &[]).unwrap_err();
    assert!(
        matches!(
            said,
            MapAlignmentError::Cloud {
                which: "loaded",
                ..
            }
        ),
        "{said}"
    );
    let (room, way) = room_seen(&walls, 0.0, rng);
    let map = loaded(&room, &way, &[], &Pose2::identity());
    let empty = Grid::new(GridConfig::default()).unwrap();
    let said = align_map(&map, &empty, &[]).unwrap_err();
    assert!(
        matches!(
            said,
            MapAlignmentError::TooFewPoints {
                which: "drawn",
                found: 0
            }
        ),
        "{said}"
    );
    // All at one place.
    let point = MapPoints {
        walls: vec![Point2::new(1.0, 2.0); 500],
        ..MapPoints::default()
    };
    assert!(align_map(&point, &grid, &[]).is_err());
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 12, ..ProptestConfig::default() })]
    #[test]
    fn whatever_is_loaded_nothing_panics_and_what_is_said_is_a_pose(
        walls in prop::collection::vec((-1e7..1e7_f64, -50.0..50.0_f64), 0..200),
        far in prop::collection::vec((-8.0..8.0_f64, -8.0..8.0_f64), 60..200),
        landmarks in prop::collection::vec((-1e9..1e9_f64, -9.0..9.0_f64), 0..12),
    ) {
        let (grid, _) = room_seen(&twins(), 0.0, &mut ChaCha8Rng::seed_from_u64(4));
        let points = |of: &[(f64, f64)]| of.iter().map(|(x, y)| Point2::new(*x, *y)).collect::<Vec<_>>();
        for walls in [walls, far] {
            let map = MapPoints { walls: points(&walls), way: points(&landmarks), landmarks: points(&landmarks), grid: None };
            if let Ok(found) = align_map(&map, &grid, &map.landmarks) {
                prop_assert!(found.map_from_loaded.is_finite());
                prop_assert!((0.0..=1.0).contains(&found.agrees) && (0.0..=1.0).contains(&found.contradicts));
            }
        }
    }
}

//! Each rule compared with its definition, cell by cell.

use std::collections::BTreeSet;

use nalgebra::Vector2;
use proptest::prelude::*;

use super::*;
use crate::geom::{Length, sin_cos};

type Cells = BTreeSet<(i32, i32)>;

fn grid(free_cells: FreeCells) -> Grid {
    let config = GridConfig {
        free_cells,
        ..GridConfig::default()
    };
    Grid::new(config).unwrap()
}

/// Ways from one place, in cells of 5 cm.
fn swept(free_cells: FreeCells, start: Point2<f64>, ends: &[Point2<f64>]) -> Cells {
    let mut grid = grid(free_cells);
    let evidence = Evidence {
        free: ends.iter().map(|end| [start * 0.05, *end * 0.05]).collect(),
        hits: vec![],
    };
    grid.draw(&evidence, &Pose2::identity());
    let mut found = Cells::new();
    for (block, cells) in grid.blocks_since(0) {
        for (offset, _) in cells.iter().enumerate().filter(|(_, odds)| **odds != 0.0) {
            let (col, row) = ((offset % BLOCK_CELLS) as i32, (offset / BLOCK_CELLS) as i32);
            found.insert((block.col * BLOCK + col, block.row * BLOCK + row));
        }
    }
    found
}

/// A scan of as many beams as there are ranges, `step` rad apart.
fn ends(start: Point2<f64>, first: f64, step: f64, ranges: &[f64]) -> Vec<Point2<f64>> {
    let turned = |(beam, range): (usize, &f64)| {
        let (sin, cos) = sin_cos(first + step * beam as f64);
        start + Vector2::new(cos, sin) * *range
    };
    ranges.iter().enumerate().map(turned).collect()
}

/// Twice the area of a triangle, positive if its corners go counter-clockwise.
fn area(a: Point2<f64>, b: Point2<f64>, c: Point2<f64>) -> f64 {
    (b - a).perp(&(c - a))
}

/// Whether the centre of a cell is in the fan: yes, no, or too near to a side to tell.
fn is_in_fan(
    cell: (i32, i32),
    start: Point2<f64>,
    corners: &[(Point2<f64>, Point2<f64>)],
) -> Option<bool> {
    let centre = Point2::new(f64::from(cell.0) + 0.5, f64::from(cell.1) + 0.5);
    let mut is_near = false;
    for &(a, b) in corners {
        let areas = [
            area(start, a, centre),
            area(a, b, centre),
            area(b, start, centre),
        ];
        if areas.iter().all(|area| *area > 1e-6) || areas.iter().all(|area| *area < -1e-6) {
            return Some(true);
        }
        is_near |= areas.iter().all(|area| *area > -1e-6) || areas.iter().all(|area| *area < 1e-6);
    }
    (!is_near).then_some(false)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    #[test]
    fn bresenham_is_the_rounded_line_of_each_beam(
        start in (-90.0..90.0_f64, -90.0..90.0_f64), ranges in proptest::collection::vec(0.0..200.0_f64, 1..30),
    ) {
        let start = Point2::new(start.0, start.1);
        let ends = ends(start, 0.3, 0.21, &ranges);
        let in_cells = |v: f64| (v * 0.05 * (1.0 / 0.05)).floor() as i32;
        let cell = |p: Point2<f64>| (in_cells(p.x), in_cells(p.y));
        let mut expected = Cells::new();
        for end in &ends {
            let ((ax, ay), (bx, by)) = (cell(start), cell(*end));
            let n = (bx - ax).abs().max((by - ay).abs());
            for i in 0..=n {
                let at = |d: i32| d.signum() * (f64::from(d.abs() * i) / f64::from(n.max(1)) + 0.5).floor() as i32;
                expected.insert((ax + at(bx - ax), ay + at(by - ay)));
            }
        }
        prop_assert_eq!(swept(FreeCells::Bresenham, start, &ends), expected);
    }

    #[test]
    fn area_is_all_centres_between_the_beams(
        start in (-90.0..90.0_f64, -90.0..90.0_f64), ranges in proptest::collection::vec(2.0..150.0_f64, 2..90),
        first in -3.2..3.2_f64, is_clockwise in any::<bool>(),
    ) {
        let start = Point2::new(start.0, start.1);
        // Up to 89 beams go more than once round: cells covered twice stay covered, and 79 beams
        // close the circle.
        let step = if is_clockwise { -0.08 } else { 0.08 };
        let ends = ends(start, first, step, &ranges);
        let corner = |end: &Point2<f64>| {
            let way = end - start;
            start + way * ((way.length() - 1.0) / way.length()).max(0.0)
        };
        let mut corners: Vec<_> = ends.windows(2).map(|pair| (corner(&pair[0]), corner(&pair[1]))).collect();
        let gap = std::f64::consts::TAU - 0.08 * (ends.len() - 1) as f64;
        if (0.0..0.08).contains(&gap) {
            corners.push((corner(&ends[ends.len() - 1]), corner(&ends[0])));
        }
        let found = swept(FreeCells::Area, start, &ends);
        for col in -250..250 {
            for row in -250..250 {
                if let Some(expected) = is_in_fan((col, row), start, &corners) {
                    prop_assert_eq!(found.contains(&(col, row)), expected, "{} {}", col, row);
                }
            }
        }
    }
}

/// A beam that ends where it starts has no direction, so nothing beside it lies between two beams.
#[test]
fn a_beam_of_no_length_parts_the_fan() {
    let start = Point2::new(0.5, 0.5);
    let seen = [40.0; 5];
    let parted = [40.0, 40.0, 0.0, 40.0, 40.0];
    let [whole, parted] = [seen, parted]
        .map(|ranges| swept(FreeCells::Area, start, &ends(start, 0.0, 0.08, &ranges)));
    let at = |angle: f64| {
        let (sin, cos) = sin_cos(angle);
        ((35.0 * cos) as i32, (35.0 * sin) as i32)
    };
    for (angle, is_parted) in [(0.04, true), (0.12, false), (0.20, false), (0.28, true)] {
        assert!(whole.contains(&at(angle)));
        assert_eq!(parted.contains(&at(angle)), is_parted, "{angle}");
    }
}

#[test]
fn a_whole_round_leaves_no_wedge() {
    let start = Point2::new(3.3, 4.4);
    let round = ends(start, 0.1, std::f64::consts::TAU / 360.0, &[40.0; 360]);
    let found = swept(FreeCells::Area, start, &round);
    for col in -40..48 {
        for row in -40..48 {
            let off = Point2::new(f64::from(col) + 0.5, f64::from(row) + 0.5) - start;
            let expected = off.length() < 39.0;
            if (off.length() - 39.0).abs() > 0.01 {
                assert_eq!(found.contains(&(col, row)), expected, "{col} {row}");
            }
        }
    }
}

#[test]
fn beams_far_apart_are_lines_of_their_own_and_overlapping_cones_stay_free() {
    let start = Point2::new(0.5, 0.5);
    let apart = ends(start, 0.0, 0.5, &[30.0, 30.0, 30.0]);
    assert_eq!(
        swept(FreeCells::Area, start, &apart),
        swept(FreeCells::Crossed, start, &apart)
    );
    // Two fans that half overlap, as cones of sonars do.
    let mut cones = ends(start, 0.0, 0.05, &[30.0; 12]);
    let alone = swept(FreeCells::Area, start, &cones);
    cones.extend(ends(start, 0.275, 0.05, &[30.0; 12]));
    assert!(swept(FreeCells::Area, start, &cones).is_superset(&alone));
}

/// A canvas has a limited size: lines that do not fit reach the blocks in another way.
#[test]
fn ways_far_from_the_first_are_drawn_like_any() {
    let start = Point2::new(3.3, 4.4);
    let ends = ends(
        start,
        0.4,
        0.7,
        &[40.0, 5000.0, 1500.0, 2500.0, 3000.0, 80.0],
    );
    let mut expected = Cells::new();
    for end in &ends {
        crate::map::cells_on_ray(start, *end, |cell| {
            expected.insert((cell.col, cell.row));
        });
    }
    assert_eq!(swept(FreeCells::Crossed, start, &ends), expected);
}

#[test]
fn absurd_ways_have_no_area() {
    let far = [Point2::new(1e8, 0.0), Point2::new(1e8, 1e6)];
    assert!(swept(FreeCells::Area, Point2::origin(), &far).is_empty());
    let bad = [Point2::new(f64::NAN, 0.0), Point2::new(1.0, 1.0)];
    let cells = swept(FreeCells::Area, Point2::origin(), &bad);
    assert!(cells.len() < 4, "{cells:?}");
}

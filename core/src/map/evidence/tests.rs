use std::f64::consts::TAU;

use nalgebra::Vector2;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::geom::{Length, Pose2};
use crate::map::{CellIndex, CellState, Grid, GridConfig};
use crate::points::fixture::{beam_along, normal, scan_of};

const CELL: f64 = 0.05;

/// Beams all round, a degree apart, each with the range that `range` gives for its bearing, or
/// without a return if it gives none.
fn points(range: impl Fn(f64) -> Option<f64>) -> Points {
    let beam = |beam_idx: usize| {
        let bearing = TAU * beam_idx as f64 / 360.0;
        let (range, is_hit) = range(bearing).map_or((12.0, false), |r| (r, true));
        let (sin, cos) = libm::sincos(bearing);
        beam_along(beam_idx, Vector2::new(cos, sin), range, is_hit)
    };
    scan_of((0..360).map(beam))
}

/// Range to the wall y = `y` along a bearing; nothing beyond 12 m.
fn to_wall(y: f64, bearing: f64) -> Option<f64> {
    let range = y / libm::sin(bearing);
    (range > 0.0 && range < 12.0).then_some(range)
}

fn certain(points: &Points, sigma: f64, config: &EvidenceConfig) -> Evidence {
    Evidence::certain(points, &vec![sigma; points.beams.len()], CELL, config)
}

fn turned(point: &Point2<f64>, angle: f64) -> Point2<f64> {
    Pose2::new(0.0, 0.0, angle) * *point
}

/// Whether a hit lies within this many metres of a place.
fn is_hit(evidence: &Evidence, at: &Point2<f64>, within: f64) -> bool {
    evidence.hits.iter().any(|hit| (hit - at).length() < within)
}

#[test]
fn sure_beams_without_width_are_believed_to_their_end() {
    let points = points(|bearing| to_wall(1.0, bearing));
    let config = EvidenceConfig {
        margin_cells: 0.0,
        ..EvidenceConfig::default()
    };
    let naive = Evidence::of(&config.believed(&points));
    let certain = certain(&points, 0.0, &config);
    assert_eq!(certain.hits.len(), naive.hits.len());
    for (certain, naive) in certain.hits.iter().zip(&naive.hits) {
        assert!((certain - naive).length() < 1e-9);
    }
    for (certain, naive) in certain.free.iter().zip(&naive.free) {
        assert!((certain[1] - naive[1]).length() < 1e-9);
    }
}

#[test]
fn a_beam_without_a_return_is_free_for_some_metres_only() {
    let hall = points(|bearing| (bearing < 1.0).then_some(9.0));
    for (clears, free) in [(0.0, 0.0), (3.0, 3.0), (5.0, 5.0), (50.0, 12.0)] {
        for cone in [0.0, 0.1] {
            let config = EvidenceConfig {
                no_return_clears: clears,
                sigmas: 0.0,
                margin_cells: 0.0,
                cone,
            };
            let evidence = certain(&hall, 0.0, &config);
            assert_eq!(evidence.hits.len(), 58);
            // A cone leaves its last cell unchanged.
            let least = if cone > 0.0 { CELL } else { 0.0 };
            let ways = evidence.free.iter().flatten();
            assert!(ways.flat_map(|end| end.iter()).all(|n| n.is_finite()));
            for [_, end] in &evidence.free {
                let bearing = libm::atan2(end.y, end.x).rem_euclid(TAU);
                let length = end.coords.length() + least;
                // The cones of hits reach a little to each side of them.
                if (1.2..6.1).contains(&bearing) {
                    assert!((length - free).abs() < 1e-9, "{clears} {cone}: {length}");
                } else if (0.2..0.8).contains(&bearing) {
                    assert!((length - 9.0).abs() < 1e-9, "{clears} {cone}: {length}");
                }
            }
        }
    }
}

#[test]
fn a_way_is_free_even_where_the_beam_is_off_by_its_width() {
    let points = points(|bearing| to_wall(1.0, bearing));
    for sigma in [0.0, 0.003, 0.01, 0.03, 0.1] {
        let evidence = certain(&points, sigma, &EvidenceConfig::default());
        assert_eq!(evidence.free.len(), 360);
        let mut nearest = f64::INFINITY;
        for (beam, [_, end]) in points.beams.iter().zip(&evidence.free) {
            assert!(end.coords.length() <= beam.range + 1e-9);
            for angle in [-2.0 * sigma, 2.0 * sigma] {
                // Between two beams a degree apart the wall is known to a ten-thousandth of the
                // range; the farthest beams end in the open.
                let y = turned(end, angle).y;
                if beam.is_hit && beam.range < 9.0 {
                    nearest = nearest.min(1.0 - y);
                }
            }
        }
        assert!(nearest > -2e-3, "sigma {sigma}: {nearest}");
        assert!(
            nearest < 0.05,
            "more cautious than need be, sigma {sigma}: {nearest}"
        );
    }
}

#[test]
fn ends_are_drawn_where_turning_them_leaves_them_within_a_cell_of_their_wall() {
    let points = points(|bearing| to_wall(1.0, bearing));
    for (sigma, least_drawn, least_skipped) in [(0.003, 150, 0), (0.01, 100, 20), (0.03, 50, 50)] {
        let evidence = certain(&points, sigma, &EvidenceConfig::default());
        let (mut drawn, mut skipped) = (0, 0);
        for beam in points.hits().filter(|b| b.range < 9.0) {
            let end = beam.end_in_robot;
            // Oracle: how far turning by two standard deviations takes the end off the line.
            let off = |angle| (turned(&end, angle).y - 1.0).abs();
            let off: f64 = off(2.0 * sigma).max(off(-2.0 * sigma));
            let is_drawn = is_hit(&evidence, &end, 1e-6);
            if off < 0.8 * CELL {
                assert!(is_drawn, "sigma {sigma}, {end}: {off}");
                drawn += 1;
            } else if off > 1.3 * CELL {
                assert!(!is_drawn, "sigma {sigma}, {end}: {off}");
                skipped += 1;
            }
        }
        assert!(
            drawn >= least_drawn && skipped >= least_skipped,
            "{drawn} {skipped}"
        );
    }
}

#[test]
fn a_wall_ahead_is_drawn_however_unsure_the_direction() {
    let points = points(|bearing| to_wall(3.0, bearing));
    let evidence = certain(&points, 0.02, &EvidenceConfig::default());
    let ahead = points.beams[90].end_in_robot;
    assert!((ahead - Point2::new(0.0, 3.0)).length() < 1e-9);
    assert!(is_hit(&evidence, &ahead, 1e-9));
    let [_, end] = evidence.free[90];
    assert!((end.y - 3.0).abs() < 0.01, "{end}");
}

/// Ranges with errors of 4 cm, like an RPLIDAR's at 6 m. In theory a line through 2 k + 1 hits has
/// an error of σ / √(2 k + 1) in its middle; within reach at this range are two or three on each
/// side, sometimes one fewer when noise takes it away.
#[test]
fn a_far_wall_is_thinner_than_its_ranges_scatter() {
    const SIGMA: f64 = 0.04;
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let (mut squares, mut count) = (0.0, 0.0);
    for _ in 0..100 {
        let off: Vec<f64> = (0..360).map(|_| SIGMA * normal(&mut rng)).collect();
        let mut points = points(|bearing| {
            let beam = (bearing.to_degrees().round() as usize) % 360;
            Some(to_wall(6.0, bearing)? + off[beam])
        });
        for beam in &mut points.beams {
            beam.sigma = SIGMA;
        }
        let evidence = certain(&points, 0.001, &EvidenceConfig::default());
        for hit in evidence.hits.iter().filter(|hit| hit.x.abs() < 2.0) {
            squares += (hit.y - 6.0) * (hit.y - 6.0);
            count += 1.0;
        }
    }
    let part = (squares / count).sqrt() / SIGMA;
    assert!(count > 3000.0, "{count}");
    assert!(part > 1.0 / 7.0_f64.sqrt() && part < 1.05 / 2.0, "{part}");
}

#[test]
fn beside_a_post_only_what_lies_before_it_is_surely_free() {
    // A post 2 m ahead, 10 degrees wide, and a round wall behind it, at 6 m.
    let points = points(|bearing| {
        Some(if (bearing - 1.0).abs() < 0.0875 {
            2.0
        } else {
            6.0
        })
    });
    let evidence = certain(&points, 0.02, &EvidenceConfig::default());
    let is_post = |i: usize| points.beams[i].range < 3.0;
    let edge = (0..360).rfind(|&i| is_post(i)).unwrap_or(0);
    let length = |i: usize| evidence.free[i][1].coords.length();
    // 0.04 rad and a cell at 6 m are 2.8 degrees.
    for (beam, expect) in [(edge, 2.0), (edge + 2, 2.0), (edge + 4, 6.0)] {
        assert!(
            (length(beam) - expect).abs() < 0.01,
            "{beam}: {}",
            length(beam)
        );
    }
    // The round wall is taken for the line through its neighbours.
    let is_hit = |beam: usize| is_hit(&evidence, &points.beams[beam].end_in_robot, 0.01);
    assert!(!is_hit(edge + 1) && is_hit(edge + 4));
}

/// Draws a drive of 12 m between two walls, 2 m apart and 30 m long, with heading errors of half a
/// degree.
fn corridor(evidence: impl Fn(&Points, f64) -> Evidence) -> Grid {
    const SIGMA: f64 = 0.0087;
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    let mut normal = || (0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0;
    let points = points(|bearing| to_wall(1.02, bearing).or_else(|| to_wall(-0.98, bearing)));
    let mut grid = Grid::new(GridConfig::default()).unwrap();
    for step in 0..240 {
        let pose = Pose2::new(9.0 + 0.05 * f64::from(step), 0.0, SIGMA * normal());
        grid.draw(&evidence(&points, SIGMA), &pose);
    }
    grid
}

/// Fraction of the cells of the wall y = 1.02 beside the drive that are occupied, and of the cells
/// behind it that are free.
fn wall_and_spray(grid: &Grid) -> (f64, f64) {
    let part = |rows: std::ops::Range<i32>, state: CellState| {
        let cells =
            || (180..420).flat_map(|col| rows.clone().map(move |row| CellIndex { col, row }));
        let count = cells().filter(|&cell| grid.state(cell) == state).count();
        count as f64 / cells().count() as f64
    };
    (
        part(20..21, CellState::Occupied),
        part(22..30, CellState::Free),
    )
}

#[test]
fn walls_of_a_corridor_outlast_beams_at_flat_angles() {
    let config = EvidenceConfig::default();
    let (wall, spray) = wall_and_spray(&corridor(|points, sigma| certain(points, sigma, &config)));
    assert!(wall > 0.99 && spray < 0.001, "{wall} {spray}");
    // Why this is needed: beams believed to their ends.
    let (wall, spray) = wall_and_spray(&corridor(|points, _| Evidence::of(points)));
    assert!(wall < 0.5 && spray > 0.05, "{wall} {spray}");
}

#[test]
fn strange_beams_are_harmless() {
    let mut strange = points(|_| Some(1.0));
    strange.beams.truncate(3);
    strange.beams[0].range = 0.0;
    strange.beams[0].end_in_robot = strange.beams[0].origin_in_robot;
    strange.beams[1].end_in_robot = Point2::from(Vector2::new(f64::NAN, 1.0));
    let evidence = certain(&strange, 10.0, &EvidenceConfig::default());
    assert_eq!(evidence.free.len(), 3);
    let none = Evidence::certain(&strange, &[], CELL, &EvidenceConfig::default());
    assert_eq!(none, Evidence::default());
}

#[test]
fn a_sonar_clears_its_whole_cone_up_to_what_it_heard_and_no_farther() {
    let (half, range) = (0.262, 2.0);
    let mut points = points(|_| None);
    points.beams.truncate(1);
    points.beams[0].range = range;
    points.beams[0].end_in_robot = Point2::new(range, 0.0);
    points.beams[0].is_hit = true;
    let evidence = Evidence::certain(&points, &[half], CELL, &EvidenceConfig::cones(half));
    let mut grid = Grid::new(GridConfig::default()).unwrap();
    // Cells seen only once are not yet believed.
    for _ in 0..2 {
        grid.draw(&evidence, &Pose2::identity());
    }
    assert_eq!(evidence.hits, [Point2::new(range, 0.0)]);
    // Every cell of the sector except those at its border, by an independent search.
    for col in -50..60 {
        for row in -50..50 {
            let centre = Point2::new(f64::from(col) + 0.5, f64::from(row) + 0.5) * CELL;
            let (r, angle) = (
                centre.coords.length(),
                libm::atan2(centre.y, centre.x).abs(),
            );
            let known = grid.state(CellIndex { col, row }) != CellState::Unknown;
            let margin = 0.75 * CELL / r;
            if r < range - 2.0 * CELL && angle < half - margin && r > CELL {
                assert!(known, "unknown at {centre}");
            }
            let is_hit = (centre - evidence.hits[0]).length() < CELL;
            if !is_hit && (r > range + 1e-9 || angle > half + margin) && r > 1.5 * CELL {
                assert!(!known, "known at {centre}");
            }
        }
    }
}

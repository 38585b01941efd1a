use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::features::columns::Noise;
use crate::points::fixture::hit;

fn load(points: &[Point2<f64>]) -> Columns {
    let beams: Vec<_> = (points.iter().enumerate())
        .map(|(i, &p)| hit(i, p))
        .collect();
    let mut columns = Columns::default();
    columns.load(&beams, std::iter::once(0..points.len()), Noise::default());
    columns
}

fn anywhere(seed: u64, n: usize) -> Vec<Point2<f64>> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut one = || Point2::new(rng.random_range(-3.0..5.0), rng.random_range(0.5..4.0));
    (0..n).map(|_| one()).collect()
}

#[test]
fn a_cell_has_the_votes_of_the_points_in_its_strip() {
    let points = anywhere(3, 60);
    let (columns, config, run) = (load(&points), Hough::default(), 0..60);
    let mut room = Accumulator::default();
    room.begin(&config, &columns, &run);
    assert_eq!(
        room.votes.iter().sum::<u32>() as usize,
        60 * room.normals.len()
    );
    for cell in 0..room.votes.len() {
        let (normal, r) = room.line(cell);
        // Within half a cell of the line in the cell's middle; the ends of cells are left to
        // rounding.
        let within = |slack: f64| {
            let is_in =
                |p: &&Point2<f64>| (normal.dot(&p.coords) - r).abs() <= 0.5 * room.r_step + slack;
            points.iter().filter(is_in).count() as u32
        };
        let votes = room.votes[cell];
        assert!(
            (within(-1e-9)..=within(1e-9)).contains(&votes),
            "cell {cell}"
        );
    }
    let (cell, votes) = room.highest().unwrap();
    assert!(room.votes.iter().all(|v| *v <= votes) && room.votes[cell] == votes);
}

#[test]
fn votes_taken_back_leave_what_the_others_gave() {
    let points = anywhere(4, 50);
    let (columns, config, run) = (load(&points), Hough::default(), 0..50);
    let mut room = Accumulator::default();
    room.begin(&config, &columns, &run);
    room.take_back(&columns, &run, 10..30);
    // Votes are taken back once, however often it is called.
    room.take_back(&columns, &run, 20..30);
    let mut alone = room.clone();
    alone.votes.fill(0);
    for index in (0..10).chain(30..50) {
        alone.vote(&columns, index, u32::wrapping_add);
    }
    assert_eq!(room.votes, alone.votes);
    assert!(room.is_free(9) && !room.is_free(10) && !room.is_free(29) && room.is_free(30));
}

#[test]
fn cleared_peaks_reach_round_the_end_of_the_directions() {
    let points = anywhere(5, 40);
    let (columns, config, run) = (load(&points), Hough::default(), 0..40);
    let mut room = Accumulator::default();
    room.begin(&config, &columns, &run);
    room.votes.fill(1);
    let (last, n_rows, row) = (room.normals.len() - 1, room.n_rows, 5);
    room.clear_around(row);
    let cleared = |column: usize| -> Vec<usize> {
        let rows = &room.votes[column * n_rows..][..n_rows];
        (0..n_rows).filter(|&r| rows[r] == 0).collect()
    };
    assert_eq!([cleared(0), cleared(1)], [[4, 5, 6], [4, 5, 6]]);
    // At α - π the same line has the other sign of r.
    assert_eq!(cleared(last), [n_rows - 7, n_rows - 6, n_rows - 5]);
    assert_eq!(room.votes.iter().filter(|v| **v == 0).count(), 9);
}

#[test]
fn parallel_walls_a_hand_apart_are_two() {
    // 8 cm apart, joined by a step of 2 points, σ 1 cm.
    let points: Vec<_> = (0..80)
        .map(|i| Point2::new(if i < 40 { 2.0 } else { 2.08 }, -0.8 + 0.02 * f64::from(i)))
        .collect();
    let mut columns = load(&points);
    let mut pieces = vec![];
    Hough::default().split(
        &mut columns,
        0..80,
        7,
        &mut Accumulator::default(),
        &mut pieces,
    );
    let ranges: Vec<_> = pieces.iter().map(Piece::range).collect();
    assert_eq!(ranges, [0..40, 40..80]);
}

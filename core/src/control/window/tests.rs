use proptest::prelude::*;

use super::super::strip::free_distance;
use super::*;
use crate::control::SafeConfig;
use crate::geom::Pose2;
use crate::points::fixture::scan_of_hits;

fn seen(at: &[(f64, f64)]) -> Points {
    scan_of_hits(at.iter().map(|&(x, y)| Point2::new(x, y)))
}

fn chosen(aim: (f64, f64), at: &[(f64, f64)], runs: (f64, f64)) -> Option<(f64, f64)> {
    chosen_among(aim, at, &[], runs)
}

fn chosen_among(
    aim: (f64, f64),
    at: &[(f64, f64)],
    walkers: &[Point2<f64>],
    runs: (f64, f64),
) -> Option<(f64, f64)> {
    let underway = Underway {
        commanded: runs,
        runs,
        ..Underway::default()
    };
    let safe = SafeConfig::default();
    let aim = Point2::new(aim.0, aim.1);
    let points = &seen(at);
    choose_in_window(
        aim,
        &People { points, walkers },
        &underway,
        (&RobotModel::pioneer(), &safe),
    )
}

proptest! {
    /// The oracle sweeps the disc centimetre by centimetre.
    #[test]
    fn the_free_arc_is_where_the_swept_disc_touches(
        points in proptest::collection::vec((-2.5..2.5_f64, -2.5..2.5_f64), 1..12),
        forward in 0.1..0.7_f64, turn in prop_oneof![Just(0.0), -1.5..1.5_f64], radius in 0.1..0.4_f64,
    ) {
        let points: Vec<_> = points.into_iter().filter(|(x, y)| libm::hypot(*x, *y) > radius + 0.02).collect();
        let most = 1.5;
        let swept = free_distance((forward, turn), &seen(&points), &Pose2::identity(), radius, most);
        let ends: Vec<_> = points.iter().map(|&(x, y)| Point2::new(x, y)).collect();
        let exact = free_on_arc((forward, turn), &ends, radius, most);
        // The sweep misses a graze shorter than a step, and may go on.
        let grown = free_on_arc((forward, turn), &ends, radius - 2e-3, most);
        prop_assert!(swept > exact - 0.011 && swept < grown + 0.011, "{swept} {exact} {grown}");
    }

    /// Whatever stands around: the chosen speeds can be driven next, and the robot can stop before
    /// it touches anything.
    #[test]
    fn what_is_chosen_is_in_the_window_and_admissible(
        points in proptest::collection::vec((-2.0..2.0_f64, -2.0..2.0_f64), 0..20),
        runs in (0.0..0.7_f64, -1.5..1.5_f64), aim in (-1.0..1.0_f64, -1.0..1.0_f64),
    ) {
        let (model, safe) = (RobotModel::pioneer(), SafeConfig::default());
        if let Some((forward, turn)) = chosen(aim, &points, runs) {
            prop_assert!((0.0..=model.max_speed).contains(&forward) && turn.abs() <= model.max_turn_rate);
            prop_assert!((forward - runs.0).abs() <= model.max_acceleration * PERIOD + 1e-9);
            prop_assert!((turn - runs.1).abs() <= model.max_turn_acceleration * PERIOD + 1e-9);
            let needs = forward * safe.reaction + forward * forward / (2.0 * super::super::safe::BRAKING * model.max_acceleration);
            let radius = model.radius() + safe.gap;
            let free = free_distance((forward, turn), &seen(&points), &Pose2::identity(), radius, 2.0);
            prop_assert!(free + 0.011 > needs, "{free} m free, {needs} m needed");
        }
    }
}

#[test]
fn alone_it_runs_at_its_aim_as_fast_as_it_can() {
    let model = RobotModel::pioneer();
    let (forward, turn) = chosen((1.0, 0.0), &[], (0.7, 0.0)).unwrap();
    assert!((forward - model.max_speed).abs() < 1e-9 && turn.abs() < 1e-9);
    let (_, left) = chosen((0.5, 0.5), &[], (0.3, 0.0)).unwrap();
    let (_, right) = chosen((0.5, -0.5), &[], (0.3, 0.0)).unwrap();
    assert!(left > 0.0 && right < 0.0, "{left} {right}");
}

#[test]
fn it_passes_who_stands_beside_the_way_on_the_free_side() {
    for side in [-1.0, 1.0] {
        // A body of 0.4 m, a little to one side of the way.
        let body: Vec<_> = (-4..=4)
            .map(|i| (1.0, side * (0.15 + 0.05 * f64::from(i))))
            .collect();
        let (forward, turn) = chosen((1.5, 0.0), &body, (0.5, 0.0)).unwrap();
        assert!(
            forward > 0.0 && turn * side < 0.0,
            "{side}: {forward} {turn}"
        );
    }
}

#[test]
fn nothing_is_admissible_for_who_is_too_fast_to_stand() {
    let wall: Vec<_> = (-20..=20).map(|i| (0.45, 0.05 * f64::from(i))).collect();
    assert_eq!(chosen((1.0, 0.0), &wall, (0.7, 0.0)), None);
    // A standing robot can always turn on the spot.
    assert!(chosen((1.0, 0.0), &wall, (0.0, 0.0)).is_some());
}

#[test]
fn who_may_walk_on_is_given_a_wider_berth_than_a_thing_and_no_more_speed_than_separation_leaves() {
    let at = [(1.6, 0.5)];
    let walkers = at.map(|(x, y)| Point2::new(x, y));
    let runs = (0.3, 0.0);
    let thing = chosen((1.5, 0.0), &at, runs).unwrap();
    let person = chosen_among((1.5, 0.0), &at, &walkers, runs).unwrap();
    assert!(person.1 < thing.1, "{person:?} {thing:?}");
    let underway = Underway {
        commanded: runs,
        runs,
        ..Underway::default()
    };
    let model = RobotModel::pioneer();
    let safe = limit_among_walkers(
        person,
        &walkers,
        &underway,
        (&model, &SafeConfig::default()),
    );
    assert!(person.0 > 0.0 && safe == person, "{safe:?} {person:?}");
}

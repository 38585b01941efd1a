//! Is the covariance honest over whole runs, and does the loop close?

use super::super::*;
use super::run::{Run, drive_ring};
use super::{dense, plain};
use crate::geom::{Length, Segment};

fn average_nees(config: EkfConfig, w: f64, h: f64, seeds: u64) -> (f64, f64) {
    let (mut nees, mut nis) = (0.0, 0.0);
    for seed in 0..seeds {
        let run = drive_ring(config, w, h, 1, seed);
        nees += run.nees.0 / f64::from(run.nees.1);
        nis += run.nis.0 / run.nis.1 as f64;
    }
    (nees / seeds as f64, nis / seeds as f64)
}

#[test]
fn average_nees_over_seeds_is_honest_with_first_estimates() {
    // 30 runs of one lap: the mean of a χ²(3) average over a run that is correlated all along has a
    // standard deviation of about 0.45 / sqrt(3) of 3.
    let config = plain();
    let first = EkfConfig {
        consistency: Consistency::FirstEstimates,
        ..config
    };
    let (nees, nis) = average_nees(first, 8.0, 6.0, 30);
    println!("first estimates: pose NEES {nees:.2}, NIS {nis:.2}");
    assert!((2.2..4.0).contains(&nees), "NEES {nees}, 3 is honest");
    assert!((1.7..2.2).contains(&nis), "NIS {nis}, 2 is honest");
}

#[test]
fn first_estimates_are_more_honest_than_the_textbook_on_a_long_loop() {
    // 64 m, heading noise of 6.5 degrees per root metre. Neither is honest here: before the loop
    // closes, the heading error is larger than the linear model can handle. This asserts today's
    // behaviour.
    let config = plain();
    let first = EkfConfig {
        consistency: Consistency::FirstEstimates,
        ..config
    };
    let (textbook, _) = average_nees(config, 20.0, 12.0, 12);
    let (first, _) = average_nees(first, 20.0, 12.0, 12);
    println!("64 m: textbook {textbook:.1}, first estimates {first:.1}");
    assert!(first < 0.5 * textbook && first < 30.0);
}

/// How far the pose is off at the end, m and rad, and how many walls are confirmed.
fn ended(run: &Run, seed: u64) -> (f64, f64, usize) {
    let (position, heading) = run.error();
    let confirmed = run.slam.landmarks().filter(|l| l.is_confirmed).count();
    println!(
        "seed {seed}: {position:.3} m, {:.2} deg, {confirmed} of {} walls",
        heading.to_degrees(),
        run.walls.len()
    );
    (position, heading, confirmed)
}

#[test]
fn loop_is_closed_on_the_walls_it_began_with() {
    for seed in 0..5 {
        let run = drive_ring(EkfConfig::default(), 8.0, 6.0, 2, seed);
        let (position, heading, confirmed) = ended(&run, seed);
        assert!(position < 0.1 && heading < 0.03);
        // A wall first seen in parts more than `max_gap` apart remains several landmarks.
        assert!(confirmed <= run.walls.len() + run.walls.len() / 2);
        assert!(f64::from(run.wrong) < 0.01 * run.nis.1 as f64);
    }
}

#[test]
fn ring_corridor_of_sixty_metres_is_closed() {
    for seed in 0..5 {
        let run = drive_ring(EkfConfig::default(), 20.0, 12.0, 1, seed);
        let (position, heading, _) = ended(&run, seed);
        // Odometry alone is off by metres; the test of the NEES on the same loop explains what is
        // missing.
        assert!(position < 0.7 && heading < 0.1);
    }
}

#[test]
fn covariance_stays_positive_definite_over_a_long_run() {
    let run = drive_ring(EkfConfig::default(), 8.0, 6.0, 2, 11);
    let p = dense(&run.slam);
    assert!((&p - p.transpose()).length() < 1e-300);
    assert!(p.cholesky().is_some());
}

#[test]
fn wall_through_the_origin_of_the_map_does_not_jump() {
    // The start lies on the line of a wall that begins 1 m further on: r changes its sign as the
    // estimate varies.
    let walls = vec![
        Segment::new(Point2::new(1.0, 0.0), Point2::new(4.0, 0.0)),
        Segment::new(Point2::new(5.0, -4.0), Point2::new(5.0, 4.0)),
    ];
    for (seed, side) in [(1, -1.0), (2, 1.0), (3, -1.0), (4, 1.0)] {
        let mut run = Run::new(plain(), &walls, Pose2::identity(), 8.0, seed);
        for (x, y) in [(1.0, 1.0), (3.0, 1.2), (1.5, 0.8), (3.5, 1.5), (0.5, 0.7)] {
            run.go(Point2::new(x, side * y));
        }
        let confirmed: Vec<_> = run.slam.landmarks().filter(|l| l.is_confirmed).collect();
        assert_eq!(confirmed.len(), 2, "{confirmed:?}");
        assert!(run.error().0 < 0.1);
        assert!(
            confirmed
                .iter()
                .all(|l| l.line.r() >= 0.0 && l.cov.cholesky().is_some())
        );
    }
}

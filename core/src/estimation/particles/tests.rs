//! Particles compared with brute force, and their self-assessment in rooms whose truth is known:
//! one that is unique, and one that looks the same from both ends.

use nalgebra::{Matrix3, Point2};

use super::*;
use crate::geom::{Length, Segment};
use crate::points::fixture::look_along;
use crate::robot::Stamp;

/// Both faces of walls along a closed ring.
fn ring(corners: &[[f64; 2]]) -> Vec<Segment> {
    let at = |i: usize| Point2::from(corners[i % corners.len()]);
    let faces = (0..corners.len()).flat_map(|i| {
        let (a, b) = (at(i), at(i + 1));
        [Segment::new(a, b), Segment::new(b, a)]
    });
    faces.collect()
}

/// A room with a corner cut off and a box in it: no two places look alike.
fn uneven() -> Vec<Segment> {
    let mut walls = ring(&[[0.0, 0.0], [6.0, 0.0], [6.0, 2.5], [4.5, 4.0], [0.0, 4.0]]);
    walls.extend(ring(&[[1.2, 2.6], [2.0, 2.6], [2.0, 3.4], [1.2, 3.4]]));
    walls
}

/// A hall that is the same after half a turn about its centre.
fn even() -> Vec<Segment> {
    let mut walls = ring(&[[0.0, 0.0], [8.0, 0.0], [8.0, 4.0], [0.0, 4.0]]);
    walls.extend(ring(&[[1.0, 0.6], [1.8, 0.6], [1.8, 1.2], [1.0, 1.2]]));
    walls.extend(ring(&[[7.0, 3.4], [6.2, 3.4], [6.2, 2.8], [7.0, 2.8]]));
    walls
}

fn seen_from(at: &Pose2, walls: &[Segment]) -> Points {
    let bearings = (0..180).map(|beam_idx| 0.035 * f64::from(beam_idx));
    look_along(bearings, walls, at, 20.0)
}

fn moved(motion: Pose2) -> Odometry {
    let cov = Matrix3::from_diagonal(&nalgebra::Vector3::new(1e-4, 1e-4, 1e-4));
    Odometry {
        motion,
        cov,
        ..Odometry::standing(Stamp(0))
    }
}

/// Drives round and round for this many steps of 0.1 m; returns the truth at the end.
fn drive(
    localiser: &mut MonteCarlo,
    walls: &[Segment],
    from: Pose2,
    steps: usize,
    mut see: impl FnMut(&MonteCarlo, &Pose2),
) -> Pose2 {
    let mut truth = from;
    let step = Pose2::new(0.1, 0.0, 0.12);
    for _ in 0..steps {
        truth = truth * step;
        localiser.predict(&moved(step));
        localiser.update(&seen_from(&truth, walls));
        see(localiser, &truth);
    }
    truth
}

fn off(estimate: &PoseEstimate, truth: &Pose2) -> [f64; 2] {
    let off = estimate.pose.minus(truth);
    [off.xy().length(), wrap(off.z).abs()]
}

fn is_sure(localiser: &MonteCarlo) -> bool {
    localiser.quality().localisation == Localisation::Localised
}

#[test]
fn particles_have_the_mean_and_covariance_of_the_posterior_by_brute_force() {
    let walls = uneven();
    let truth = Pose2::new(3.0, 1.5, 0.4);
    let start = PoseEstimate {
        pose: Pose2::new(3.08, 1.42, 0.46),
        cov: pose_cov(0.2, 0.1),
    };
    // A weak likelihood, so there is a posterior to compare; no noise except the odometry's own,
    // and many particles.
    let mut config = MonteCarloConfig {
        sigma: 0.2,
        independent_beams: 2.0,
        odometry_noise: [0.0; 3],
        ..MonteCarloConfig::default()
    };
    config.kld.least = 20_000;
    config.kld.most = 20_000;
    config.judgement.lost_below = 0.0;
    config.judgement.lost_part = 0.0;
    let mut particles = MonteCarlo::new(&walls, 0.01, Some(&start), config).unwrap();
    let fine = HistogramConfig {
        cell: 0.05,
        turns: 180,
        most: 4_000_000,
        ..HistogramConfig::default()
    };
    let mut histogram = HistogramLocaliser::new(&walls, 0.01, config, fine).unwrap();
    histogram.begin_at(&start);
    let mut at = truth;
    for _ in 0..3 {
        let step = Pose2::new(0.15, 0.0, 0.1);
        at = at * step;
        particles.predict(&moved(step));
        histogram.predict(&moved(step));
        let points = seen_from(&at, &walls);
        particles.update(&points);
        histogram.update(&points);
    }
    let (drawn, exact) = (particles.estimate(), histogram.estimate());
    let [way, turn] = off(&drawn, &exact.pose);
    // A tenth of the posterior's standard deviations, as good as the cells allow.
    let sigma = |axis: usize| exact.cov[(axis, axis)].sqrt();
    assert!(
        way < 0.15 * sigma(0).max(sigma(1)),
        "{way} m of {}",
        sigma(0)
    );
    assert!(turn < 0.15 * sigma(2), "{turn} rad of {}", sigma(2));
    for axis in 0..3 {
        let ratio = drawn.cov[(axis, axis)] / exact.cov[(axis, axis)];
        assert!((0.75..1.25).contains(&ratio), "{axis}: {ratio}");
    }
}

#[test]
fn a_robot_that_begins_anywhere_is_found_and_never_sure_of_a_wrong_place() {
    let walls = uneven();
    for (seed, x, y, heading) in [(1, 3.0, 1.2, 0.4), (2, 0.9, 1.0, -2.0), (3, 4.3, 2.1, 1.7)] {
        let config = MonteCarloConfig {
            seed,
            ..MonteCarloConfig::default()
        };
        let mut localiser = MonteCarlo::new(&walls, 0.01, None, config).unwrap();
        assert!(!is_sure(&localiser));
        let truth = drive(
            &mut localiser,
            &walls,
            Pose2::new(x, y, heading),
            40,
            |l, truth| {
                let [way, turn] = off(&l.estimate(), truth);
                assert!(
                    !is_sure(l) || (way < 0.1 && turn < 0.05),
                    "{way} m, {turn} rad"
                );
            },
        );
        assert!(is_sure(&localiser), "{:?}", localiser.quality());
        let [way, turn] = off(&localiser.estimate(), &truth);
        assert!(way < 0.05 && turn < 0.03, "{way} m, {turn} rad");
    }
}

#[test]
fn in_a_hall_that_looks_the_same_from_both_ends_nobody_is_sure_and_both_ends_are_named() {
    let walls = even();
    let mut localiser = MonteCarlo::new(&walls, 0.01, None, MonteCarloConfig::default()).unwrap();
    let mut named = 0;
    let truth = drive(
        &mut localiser,
        &walls,
        Pose2::new(3.0, 1.5, 0.3),
        60,
        |l, truth| {
            assert!(!is_sure(l), "{:?}", l.quality());
            let twin = Pose2::new(8.0, 4.0, std::f64::consts::PI) * *truth;
            let is_named = |pose: &Pose2| {
                l.hypotheses().any(|h| {
                    let [way, turn] = off(&h.estimate, pose);
                    way < 0.2 && turn < 0.1
                })
            };
            named += usize::from(is_named(truth) && is_named(&twin));
        },
    );
    assert!(named > 30, "both were named {named} times of 60; {truth:?}");
    // The covariance covers what is not known: at least half of the hall's length.
    assert!(localiser.estimate().cov[(0, 0)].sqrt() > 0.5);
}

#[test]
fn a_kidnapped_robot_notices_and_is_found_again() {
    let walls = uneven();
    let start = PoseEstimate {
        pose: Pose2::new(3.0, 1.2, 0.4),
        cov: pose_cov(0.02, 0.02),
    };
    let config = MonteCarloConfig::default();
    let mut localiser = MonteCarlo::new(&walls, 0.01, Some(&start), config).unwrap();
    let truth = drive(&mut localiser, &walls, start.pose, 20, |l, _| {
        assert!(is_sure(l))
    });
    assert!(off(&localiser.estimate(), &truth)[0] < 0.05);
    let elsewhere = Pose2::new(1.0, 1.5, -2.5);
    let (mut steps, mut noticed, mut deceived) = (0, None, 0);
    let truth = drive(&mut localiser, &walls, elsewhere, 60, |l, truth| {
        steps += 1;
        if !is_sure(l) {
            noticed = noticed.or(Some(steps));
        }
        let is_wrong = is_sure(l) && off(&l.estimate(), truth)[0] > 0.2;
        deceived += usize::from(is_wrong && noticed.is_some());
    });
    assert!(noticed.is_some_and(|steps| steps < 10), "{noticed:?}");
    assert_eq!(deceived, 0);
    assert!(is_sure(&localiser) && off(&localiser.estimate(), &truth)[0] < 0.05);
}

#[test]
fn the_same_seed_gives_the_same_bits_and_nothing_seen_changes_nothing() {
    let walls = uneven();
    let run = || {
        let mut l = MonteCarlo::new(&walls, 0.01, None, MonteCarloConfig::default()).unwrap();
        drive(&mut l, &walls, Pose2::new(3.0, 1.2, 0.4), 12, |_, _| {});
        l
    };
    let (mut a, b) = (run(), run());
    assert_eq!(a.particles(), b.particles());
    assert_eq!(a.estimate(), b.estimate());
    let mut blind = seen_from(&Pose2::new(3.0, 1.2, 0.4), &walls);
    blind.beams.iter_mut().for_each(|beam| beam.is_hit = false);
    a.update(&blind);
    assert_eq!(a.particles(), b.particles());
    assert!(MonteCarlo::new(&[], 0.01, None, MonteCarloConfig::default()).is_err());
}

#[test]
fn a_histogram_finds_its_robot_from_anywhere() {
    let walls = uneven();
    let cells = HistogramConfig::default();
    let mut histogram =
        HistogramLocaliser::new(&walls, 0.01, MonteCarloConfig::default(), cells).unwrap();
    let mut truth = Pose2::new(3.0, 1.2, 0.4);
    for _ in 0..6 {
        let step = Pose2::new(0.2, 0.0, 0.2);
        truth = truth * step;
        histogram.predict(&moved(step));
        histogram.update(&seen_from(&truth, &walls));
    }
    let [way, turn] = off(&histogram.estimate(), &truth);
    assert!(way < 0.1 && turn < 0.06, "{way} m, {turn} rad");
    // Its covariance says so: one cell may hold all the mass, and the robot may be anywhere in it.
    let PoseEstimate { pose, cov } = histogram.estimate();
    let error = pose.minus(&truth);
    let nees = error.dot(&(cov.try_inverse().unwrap() * error));
    assert!(nees < 11.3, "99 % of χ² of 3 degrees of freedom: {nees}");
    let [likeliest, ..] = &histogram.hypotheses()[..] else {
        panic!("it knows nothing");
    };
    assert!(likeliest.estimate.cov[(0, 0)] > 0.99 * cells.cell * cells.cell / 12.0);
    let sum: f64 = histogram.weighted().map(|p| p.weight).sum();
    assert!((sum - 1.0).abs() < 1e-6);
    let small = HistogramConfig {
        most: 1000,
        ..cells
    };
    let config = MonteCarloConfig::default();
    let refused = HistogramLocaliser::new(&walls, 0.01, config, small).unwrap_err();
    assert!(
        refused.to_string().contains("too large for a histogram"),
        "{refused}"
    );
}

/// Bayes' rule by brute force: the robot turns on the spot by whole cells and without noise, so a
/// cell's probability is the product over everything it should have seen on the way to it.
/// Distances are those of the segments themselves.
#[test]
fn a_histogram_has_the_posterior_of_a_bayes_filter_by_brute_force() {
    let walls = uneven();
    let config = MonteCarloConfig {
        sigma: 0.25,
        independent_beams: 3.0,
        ..MonteCarloConfig::default()
    };
    let cells = HistogramConfig {
        cell: 0.2,
        turns: 36,
        ..HistogramConfig::default()
    };
    let mut histogram = HistogramLocaliser::new(&walls, 0.0, config, cells).unwrap();
    let turn = Pose2::new(0.0, 0.0, std::f64::consts::TAU / 36.0);
    let (mut truth, mut scans) = (Pose2::new(3.0, 1.5, 0.4), vec![]);
    for step in 0..3 {
        if step > 0 {
            truth = truth * turn;
            histogram.predict(&Odometry {
                motion: turn,
                ..Odometry::standing(Stamp(0))
            });
        }
        let points = seen_from(&truth, &walls);
        assert!(histogram.update(&points));
        scans.push(super::recent::rays(&points, config.most_beams));
    }
    let log_likelihood = |pose: &Pose2, rays: &[super::recent::Ray]| {
        let of = |ray: &super::recent::Ray| {
            let place = *pose * ray.to;
            let near = walls.iter().map(|wall| wall.distance(place));
            let d = near.fold(f64::INFINITY, f64::min);
            let hit = libm::exp(-0.5 * d * d / (config.sigma * config.sigma));
            libm::log((1.0 - config.random_part) * hit + config.random_part)
        };
        config.independent_beams * rays.iter().map(of).sum::<f64>() / rays.len() as f64
    };
    let posterior: Vec<(Particle, f64)> = histogram
        .weighted()
        .map(|cell| {
            let mut pose = cell.pose;
            let mut log = 0.0;
            for rays in scans.iter().rev() {
                log += log_likelihood(&pose, rays);
                pose = pose * turn.inverse();
            }
            (cell, libm::exp(log))
        })
        .collect();
    let sum: f64 = posterior.iter().map(|(_, p)| p).sum();
    let off: f64 = posterior
        .iter()
        .map(|(cell, p)| (cell.weight - p / sum).abs())
        .sum();
    // The distance of the two distributions, at most 2: the remainder is due to distances in cells
    // of 5 cm.
    assert!(off < 0.05, "{off}");
    let uniform = 1.0 / posterior.len() as f64;
    let said: f64 = posterior
        .iter()
        .map(|(cell, _)| (cell.weight - uniform).abs())
        .sum();
    assert!(said > 1.0, "the scans say something: {said}");
}

#[test]
fn a_histogram_names_both_ends_of_a_hall_and_forgets_when_told() {
    let walls = even();
    let cells = HistogramConfig::default();
    let mut histogram =
        HistogramLocaliser::new(&walls, 0.01, MonteCarloConfig::default(), cells).unwrap();
    assert!(histogram.likely().is_empty(), "nothing is known yet");
    let mut truth = Pose2::new(3.0, 1.5, 0.3);
    for _ in 0..4 {
        let step = Pose2::new(0.2, 0.0, 0.1);
        truth = truth * step;
        histogram.predict(&moved(step));
        histogram.update(&seen_from(&truth, &walls));
    }
    let found = histogram.hypotheses();
    let twin = Pose2::new(8.0, 4.0, std::f64::consts::PI) * truth;
    for pose in [truth, twin] {
        let named = found.iter().find(|h| {
            let [way, turn] = off(&h.estimate, &pose);
            way < 0.2 && turn < 0.1
        });
        let weight = named.map_or(0.0, |named| named.weight);
        assert!((0.3..0.7).contains(&weight), "{weight} {found:?}");
    }
    // A robot that stands learns nothing new.
    assert!(!histogram.update(&seen_from(&truth, &walls)));
    histogram.forget();
    assert!(histogram.likely().is_empty() && histogram.hypotheses().is_empty());
}

//! A corridor where only people and objects tell how far the robot went.

use super::super::seen::Seen;
use super::*;
use crate::points::Beam;

const WIDTH: f64 = 2.4;

/// Two bare walls, and square posts at these x.
fn corridor(posts: &[f64]) -> Vec<Segment> {
    let wall = |y: f64| Segment::new(Point2::new(-40.0, y), Point2::new(60.0, y));
    let mut walls = vec![wall(0.5 * WIDTH), wall(-0.5 * WIDTH)];
    for (at, &x) in posts.iter().enumerate() {
        let y = if at % 2 == 0 { 0.7 } else { -0.7 };
        walls.extend(thing(x, y));
    }
    walls
}

/// An object 0.4 m wide and 0.3 m deep.
fn thing(x: f64, y: f64) -> [Segment; 4] {
    let corners = [
        (x, y - 0.2),
        (x, y + 0.2),
        (x + 0.3, y + 0.2),
        (x + 0.3, y - 0.2),
    ];
    let corner = |at: usize| Point2::new(corners[at % 4].0, corners[at % 4].1);
    [0, 1, 2, 3].map(|at| Segment::new(corner(at), corner(at + 1)))
}

/// How far the estimate is off along the corridor, m: the robot stands for a while and goes on for
/// 60 scans, `step` m after each, and people at these places (x, y) ahead move along with it.
/// Odometry counts each step multiplied by `counts`.
fn astray(posts: &[f64], people: &[(f64, f64)], step: f64, counts: impl Fn(usize) -> f64) -> f64 {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut matcher = ScanMatcher::new(ScanMatcherConfig::default()).unwrap();
    let (mut x, mut worst) = (0.0, 0.0_f64);
    for number in 0..70_usize {
        let step = if number < 10 { 0.0 } else { step };
        x += step;
        let (from, to) = (
            Stamp(number as u64 * 100_000),
            Stamp((number as u64 + 1) * 100_000),
        );
        let part = counts(number);
        matcher.odometry(&Odometry {
            from,
            to,
            motion: Pose2::new(
                step * part + 0.001 * normal(&mut rng),
                0.0,
                0.001 * normal(&mut rng),
            ),
            cov: Matrix3::from_diagonal(&Vector3::repeat(1e-5)),
        });
        let mut walls = corridor(posts);
        walls.extend(people.iter().flat_map(|(ahead, y)| thing(x + ahead, *y)));
        let scan = scan_at(&walls, &Pose2::new(x, 0.0, 0.0), to, &mut rng);
        update(&mut matcher, &points_of(&scan));
        worst = worst.max((matcher.estimate().pose.x() - x).abs());
    }
    worst
}

#[test]
fn who_walks_ahead_does_not_hold_the_robot_back() {
    for step in [0.02, 0.05, 0.1] {
        for people in [&[(2.0, 0.0)][..], &[(1.5, 0.5)], &[(2.0, 0.4), (2.5, -0.4)]] {
            // If believed, they hold it back all along: 1.2 to 6 m.
            let off = astray(&[], people, step, |_| 1.0);
            assert!(off < 0.05 + 4.0 * step, "{step} {people:?}: {off} m");
        }
    }
}

#[test]
fn things_that_stand_say_how_far_the_robot_went() {
    // Wheels that count a seventh too much, beside a single post.
    let off = astray(&[5.0], &[], 0.05, |_| 1.15);
    assert!(off < 0.03, "{off} m");
    // Wheels that slip by half, among several.
    let slips = |number: usize| if number < 40 { 1.0 } else { 2.0 };
    let off = astray(&[3.0, 4.5, 6.0, 7.5], &[], 0.05, slips);
    assert!(off < 0.03, "{off} m");
}

#[test]
fn without_a_thing_each_surface_keeps_its_beam_and_its_share_of_the_motion() {
    let mut walls = corridor(&[]);
    walls.extend(thing(2.0, 0.5));
    let motion = Pose2::new(0.1, 0.0, 0.02);
    let scan = sweep_of(&walls, &Pose2::new(0.0, 0.0, 0.0), &motion, Stamp(200_000));
    let points = Points::from_scan(&scan, &motion, &PointConfig::default());
    let sigmas: Vec<f64> = (0..points.beams.len()).map(|at| at as f64).collect();
    let seen = Seen::scan(&points, &sigmas, motion, 0.2);
    let is_of_thing = |beam: &Beam| {
        let end = beam.end_in_robot;
        beam.is_hit && (1.7..2.4).contains(&end.x) && (0.2..0.8).contains(&end.y)
    };
    let of_thing: Vec<usize> = (0..points.beams.len())
        .filter(|at| is_of_thing(&points.beams[*at]))
        .collect();
    let count = seen.surfaces_of(&of_thing).count();
    assert!(of_thing.len() > 5 && count > 2, "{of_thing:?} {count}");
    let rest = seen.without(&of_thing);
    assert_eq!(rest.points.beams.len() + of_thing.len(), points.beams.len());
    assert!(!rest.points.beams.iter().any(is_of_thing));
    assert!(rest.is_rolling());
    // Beam, index and position of what remains still match.
    for (at, beam) in rest.points.beams.iter().enumerate() {
        let before = points.beams.iter().position(|other| other == beam).unwrap();
        assert_eq!(rest.sigmas[at], before as f64);
        let [of_rest, of_all] = [
            rest.surfaces_of(&[at]).next(),
            seen.surfaces_of(&[before]).next(),
        ];
        assert_eq!(of_rest, of_all);
    }
    let parts = |seen: &Seen| {
        seen.parts()
            .iter()
            .map(|part| part.points.len())
            .sum::<usize>()
    };
    assert_eq!(
        parts(&rest),
        rest.surfaces_of(&(0..rest.points.beams.len()).collect::<Vec<_>>())
            .count()
    );
    assert_eq!(
        parts(&seen) - parts(&rest),
        seen.surfaces_of(&of_thing).count()
    );
}

//! A run that was saved and restored on the way ends as one without a pause, to the bit.

use nalgebra::{Matrix3, Point2, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::super::tests::{points_of, ring, scan_at, update};
use super::*;
use crate::geom::{Pose2, Segment};
use crate::points::Points;
use crate::points::fixture::normal;
use crate::robot::{Odometry, Stamp};

/// A motion and what was seen after it.
pub(in super::super) struct Step {
    pub(in super::super) odometry: Odometry,
    pub(in super::super) points: Points,
    pub(in super::super) truth: Pose2,
}

/// The ring with corridors of other widths, so that nothing in it looks like anything else.
fn lopsided() -> Vec<Segment> {
    let is_inner = |p: Point2<f64>| p.x.abs() <= 4.0 && p.y.abs() <= 3.0;
    let mut walls = ring();
    walls.retain(|wall| !(is_inner(wall.a) && is_inner(wall.b)));
    let corners = [
        (-4.3, -3.1),
        (3.2, -3.1),
        (3.2, 3.3),
        (-1.0, 3.3),
        (-1.0, 2.0),
        (-4.3, 2.0),
    ];
    let corner = |at: usize| {
        let (x, y) = corners[at % corners.len()];
        Point2::new(x, y)
    };
    walls.extend((0..corners.len()).map(|at| Segment::new(corner(at), corner(at + 1))));
    walls
}

/// A drive around the ring, corner by corner, with odometry that turns too far and slips. The truth
/// is in the frame of the building.
pub(in super::super) fn drive(corners: &[(f64, f64)], from: Pose2, seed: u64) -> Vec<Step> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let walls = lopsided();
    let (mut pose, mut stamp) = (from, Stamp(0));
    let mut steps = vec![];
    let mut visit = |pose: &Pose2, motion: Pose2| {
        let (from, to) = (stamp, Stamp(stamp.0 + 200_000));
        stamp = to;
        let motion = Pose2::new(
            motion.x() * 1.02 + 0.003 * normal(&mut rng),
            0.002 * normal(&mut rng),
            motion.heading() * 1.03 + 0.004 * normal(&mut rng),
        );
        let odometry = Odometry {
            from,
            to,
            motion,
            cov: Matrix3::from_diagonal(&Vector3::repeat(1e-4)),
        };
        steps.push(Step {
            odometry,
            points: points_of(&scan_at(&walls, pose, to, &mut rng)),
            truth: *pose,
        });
    };
    visit(&pose, Pose2::identity());
    for &(x, y) in corners {
        loop {
            let ahead = pose.inverse() * Point2::new(x, y);
            let bearing = libm::atan2(ahead.y, ahead.x);
            let motion = if ahead.coords.norm() < 0.06 {
                break;
            } else if bearing.abs() > 0.01 {
                Pose2::new(0.0, 0.0, bearing.clamp(-0.1, 0.1))
            } else {
                Pose2::new(ahead.x.min(0.1), 0.0, 0.0)
            };
            pose = pose * motion;
            visit(&pose, motion);
        }
    }
    steps
}

pub(in super::super) const LAP: [(f64, f64); 4] =
    [(5.0, -4.0), (5.0, 4.0), (-5.0, 4.0), (-5.0, -4.0)];

pub(in super::super) fn feed(matcher: &mut ScanMatcher, steps: &[Step]) {
    for step in steps {
        matcher.odometry(&step.odometry);
        update(matcher, &step.points);
    }
}

fn bytes_of(matcher: &ScanMatcher) -> Vec<u8> {
    let mut bytes = vec![];
    matcher.save(&mut bytes);
    bytes
}

fn restored(bytes: &[u8], config: ScanMatcherConfig) -> Result<ScanMatcher, RestoreError> {
    let mut from = Reader::new(bytes);
    let matcher = ScanMatcher::restore(&mut from, config)?;
    assert!(from.is_at_end());
    Ok(matcher)
}

fn two_laps() -> Vec<Step> {
    let corners = [LAP, LAP].concat();
    drive(&corners, Pose2::new(-5.0, -4.0, 0.0), 3)
}

#[test]
fn a_run_that_was_paused_ends_with_the_same_bits() {
    let config = ScanMatcherConfig::default();
    let steps = two_laps();
    let mut whole = ScanMatcher::new(config).unwrap();
    feed(&mut whole, &steps);
    let mut paused = ScanMatcher::new(config).unwrap();
    let mut rest = &steps[..];
    // Also just behind the middle, where loops are being closed and the grid is drawn anew.
    while !rest.is_empty() {
        let (now, later) = rest.split_at(rest.len().min(37));
        feed(&mut paused, now);
        let bytes = bytes_of(&paused);
        paused = restored(&bytes, config).unwrap();
        assert_eq!(bytes_of(&paused), bytes, "{} left", later.len());
        rest = later;
    }
    assert_eq!(bytes_of(&paused), bytes_of(&whole));
    whole.finish();
    paused.finish();
    assert!(whole.loop_closures() > 0 && whole.grid_version() > 0);
    assert_eq!(bytes_of(&paused), bytes_of(&whole));
}

#[test]
fn another_resolution_draws_the_grid_anew() {
    let config = ScanMatcherConfig::default();
    let mut matcher = ScanMatcher::new(config).unwrap();
    feed(&mut matcher, &two_laps()[..100]);
    let mut coarse = config;
    coarse.grid.resolution = 0.1;
    let again = restored(&bytes_of(&matcher), coarse).unwrap();
    assert_eq!(again.grid().resolution(), 0.1);
    let occupied = |matcher: &ScanMatcher| {
        let blocks = matcher.grid().blocks_since(0);
        blocks
            .map(|(_, cells)| cells.iter().filter(|odds| **odds > 0.7).count())
            .sum::<usize>()
    };
    let (fine, coarse) = (occupied(&matcher), occupied(&again));
    assert!(
        fine > 500 && coarse * 4 > fine && coarse < fine,
        "{fine} {coarse}"
    );
}

#[test]
fn damaged_bytes_are_refused_or_give_a_matcher_that_runs() {
    let config = ScanMatcherConfig::default();
    let mut matcher = ScanMatcher::new(config).unwrap();
    let steps = two_laps();
    feed(&mut matcher, &steps[..60]);
    let bytes = bytes_of(&matcher);
    let (mut refused, mut taken) = (0, 0);
    for at in (0..bytes.len()).step_by(bytes.len() / 150) {
        for value in [0, 0x7f, 0xff] {
            let mut damaged = bytes.clone();
            damaged[at] = value;
            let mut from = Reader::new(&damaged);
            match ScanMatcher::restore(&mut from, config) {
                Err(_) => refused += 1,
                Ok(mut matcher) => {
                    taken += 1;
                    if taken % 20 == 0 {
                        feed(&mut matcher, &steps[60..64]);
                        matcher.finish();
                    }
                }
            }
        }
        assert!(restored(&bytes[..at], config).is_err(), "cut at {at}");
    }
    assert!(refused > 20 && taken > 20, "{refused} {taken}");
}

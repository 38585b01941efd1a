//! Two laps of a ring with odometry that drifts, and the effect of bad input.

mod adrift;
mod companions;
pub(super) mod course;
mod odometry;
mod torn;

use nalgebra::{Point2, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use self::course::{LAP, drive, drive_along, points_of, ring, scan_at, update};
use super::super::loop_error::LoopError;
use super::super::pose_graph::differs;
use super::*;
use crate::geom::{Length, Segment, unit_vector, wrap};
use crate::map::{CellState, SEEN_OFTEN};
use crate::points::fixture::{normal, range_to};
use crate::points::{MotionHistory, PointConfig};
use crate::robot::Scan;

/// Twice around the ring at 0.1 m and 6° per scan, with odometry that turns 3 % too far and slips:
/// the true poses and the matcher.
fn run(config: ScanMatcherConfig, seed: u64) -> (Vec<Pose2>, Pose2, ScanMatcher) {
    run_with(config, seed, |_, measured| Some(measured))
}

/// The same with odometry as changed by `heard`, given the number of the scan and what was
/// measured.
fn run_with(
    config: ScanMatcherConfig,
    seed: u64,
    heard: impl FnMut(usize, Pose2) -> Option<Pose2>,
) -> (Vec<Pose2>, Pose2, ScanMatcher) {
    run_seeing(config, seed, heard, |scan| scan)
}

/// The same with a sensor that `sees` only some of each scan of 180 beams.
fn run_seeing(
    config: ScanMatcherConfig,
    seed: u64,
    mut heard: impl FnMut(usize, Pose2) -> Option<Pose2>,
    sees: impl Fn(Scan) -> Scan,
) -> (Vec<Pose2>, Pose2, ScanMatcher) {
    let mut matcher = ScanMatcher::new(config).unwrap();
    let start = Pose2::new(-5.0, -4.0, 0.0);
    let (mut truth, mut odometry) = (vec![], Pose2::identity());
    for step in drive_along(&ring(), &[LAP, LAP].concat(), start, seed) {
        let measured = step.odometry.motion;
        odometry = odometry * measured;
        if let Some(motion) = heard(truth.len(), measured) {
            matcher.odometry(&Odometry {
                motion,
                ..step.odometry
            });
        }
        update(&mut matcher, &points_of(&sees(step.scan)));
        truth.push(start.delta_to(&step.truth));
    }
    matcher.finish();
    (truth, odometry, matcher)
}

#[test]
fn two_laps_of_a_ring_come_back_to_where_they_were() {
    for seed in 0..3 {
        let (truth, odometry, matcher) = run(ScanMatcherConfig::default(), seed);
        let last = truth.last().unwrap();
        let odometry_error = (odometry.position() - last.position()).length();
        assert!(
            odometry_error > 0.5,
            "the test is too easy: {odometry_error}"
        );
        let poses: Vec<_> = matcher.trajectory().map(|(_, pose)| pose).collect();
        assert_eq!(poses.len(), truth.len());
        for (found, truth) in poses.iter().zip(&truth) {
            assert!(
                (found.position() - truth.position()).length() < 0.12,
                "{found:?} {truth:?}"
            );
            assert!(wrap(found.heading() - truth.heading()).abs() < 0.03);
        }
        assert!(matcher.loop_closures() > 0);
        let estimate = matcher.estimate();
        // The last scan lies where its keyframe was moved by refinement, the robot where it was
        // tracked.
        let off = estimate.pose.minus(poses.last().unwrap());
        assert!(off.amax() < 0.01, "{off}");
        assert!(estimate.cov.cholesky().is_some());
    }
}

/// As in a log of keyframes: submaps of fifteen of them would span two corridors each.
#[test]
fn where_scans_are_a_metre_apart_submaps_end_sooner() {
    let config = ScanMatcherConfig::default();
    let mut matcher = ScanMatcher::new(config).unwrap();
    let start = Pose2::new(-5.0, -4.0, 0.0);
    let mut truth = vec![];
    for steps in drive(&[LAP, LAP].concat(), start, 4).chunks(10) {
        for step in steps {
            matcher.odometry(&step.odometry);
        }
        let last = steps.last().unwrap();
        update(&mut matcher, &points_of(&last.scan));
        truth.push(start.delta_to(&last.truth));
    }
    matcher.finish();
    for (_, submap, submap_from_robot) in matcher.scans_in_submaps() {
        let way = submap_from_robot.position().coords.length();
        // The scan that is too far away begins the next submap.
        assert!(way < config.submap_reach + 1.1, "{submap}: {way}");
    }
    let keyframes = matcher.submaps().map(|s| s.keyframes);
    let most = keyframes.max().unwrap();
    assert!((4..config.submap_keyframes).contains(&most), "{most}");
    assert!(matcher.loop_closures() > 0);
    for ((_, found), truth) in matcher.trajectory().zip(&truth) {
        let off = found.minus(truth);
        assert!(off.xy().length() < 0.15, "{off}");
    }
    // What a submap takes over may come from the two before it. None of them saw through walls.
    for submap in &matcher.submaps {
        for place in submap.closed.free().places() {
            let place = start * submap.map_from_submap * place;
            let (x, y) = (place.x, place.y);
            let is_outside = x.abs() > 6.3 || y.abs() > 5.3;
            let is_in_block = (-4.0..2.9).contains(&x) && (-2.8..1.7).contains(&y);
            assert!(!is_outside && !is_in_block, "{x} {y}");
        }
    }
}

#[test]
fn each_closure_in_the_graph_has_its_record_and_each_submap_its_surfaces() {
    let (_, _, matcher) = run(ScanMatcherConfig::default(), 0);
    let graph = matcher.graph();
    let mut accepted = 0;
    for record in matcher.closure_records() {
        let residual = matcher.residual(record);
        if let ClosureFate::Accepted { edge } = record.fate {
            accepted += 1;
            assert_eq!(graph.edge(edge).unwrap().motion, record.motion);
            let chi2 = graph.edge_chi2(edge).unwrap();
            assert!((residual.chi2 - chi2).abs() < 1e-9 * (1.0 + chi2));
            assert_eq!(record.is_searched, record.proof.is_some());
        }
        let (old, new) = (graph.poses()[record.old], graph.poses()[record.new]);
        let present = record.motion * residual.off;
        assert!(present.minus(&old.delta_to(&new)).amax() < 1e-9);
    }
    assert_eq!(accepted, matcher.loop_closures());
    assert!(matcher.submaps_version() > 0);

    assert_eq!(matcher.submaps().len(), graph.poses().len());
    let closed = matcher.submaps().len() - 1;
    for submap in matcher.submaps().take(closed) {
        assert!(submap.surfaces().len() > 50 && submap.keyframes > 0);
        assert!(!submap.is_loose, "odometry and scans agree in the ring");
    }
}

/// The largest error of a trajectory, m and rad.
fn worst(truth: &[Pose2], matcher: &ScanMatcher) -> [f64; 2] {
    let errors = matcher.trajectory().zip(truth).map(|((_, found), truth)| {
        let off = found.minus(truth);
        [off.xy().length(), off.z.abs()]
    });
    errors.fold([0.0; 2], |w, e| [w[0].max(e[0]), w[1].max(e[1])])
}

#[test]
fn eleven_beams_of_five_metres_are_gathered_until_they_show_walls() {
    let few = |scan: Scan| {
        let kept = |beam: &usize| beam.is_multiple_of(18) || *beam == 179;
        let beams: Vec<usize> = (0..scan.len()).filter(kept).collect();
        Scan {
            bearings: beams.iter().map(|&beam| scan.bearings[beam]).collect(),
            ranges: beams.iter().map(|&beam| scan.ranges[beam]).collect(),
            sigmas: beams.iter().map(|&beam| scan.sigmas[beam]).collect(),
            max_range: 5.0,
            ..scan
        }
    };
    for seed in 0..2 {
        let heard = |_: usize, measured| Some(measured);
        let (truth, odometry, matcher) = run_seeing(ScanMatcherConfig::default(), seed, heard, few);
        let odometry_error = (odometry.position() - truth.last().unwrap().position()).length();
        assert_eq!(matcher.trajectory().count(), truth.len());
        let stamps: Vec<Stamp> = matcher.trajectory().map(|(stamp, _)| stamp).collect();
        assert!(stamps.windows(2).all(|pair| pair[0] < pair[1]));
        let [shift, turn] = worst(&truth, &matcher);
        assert!(
            shift < 0.35 * odometry_error,
            "{shift} m of {odometry_error} m"
        );
        assert!(shift < 0.3 && turn < 0.08, "{seed}: {shift} m, {turn} rad");
    }
}

#[test]
fn the_map_shows_walls_once_and_the_corridor_free() {
    let (_, _, matcher) = run(ScanMatcherConfig::default(), 5);
    let map_from_world = Pose2::new(-5.0, -4.0, 0.0).inverse();
    let grid = matcher.grid();
    let state = |x: f64, y: f64| grid.state(grid.cell_at(map_from_world * Point2::new(x, y)));
    for x in [-3.5, 0.7, 3.0] {
        assert_eq!(state(x, -4.0), CellState::Free);
        let occupied = |y: f64| state(x, y) == CellState::Occupied;
        let thickness = (-30..30)
            .filter(|i| occupied(-3.0 + f64::from(*i) * 0.02))
            .count();
        assert!(
            (1..12).contains(&thickness),
            "{thickness} steps of 2 cm at {x}"
        );
    }
}

/// The true frames of the submaps, derived from the true poses of the scans in them.
fn true_frames(truth: &[Pose2], matcher: &ScanMatcher) -> Vec<Option<Pose2>> {
    let mut frames = vec![vec![]; matcher.submaps().len()];
    for ((_, submap, submap_from_robot), truth) in matcher.scans_in_submaps().zip(truth) {
        frames[submap].push(*truth * submap_from_robot.inverse());
    }
    let mean = |frames: &Vec<Pose2>| {
        let first = frames.first()?;
        let off: Vector3<f64> = frames.iter().map(|frame| frame.minus(first)).sum();
        Some(first.plus(&(off / frames.len() as f64)))
    };
    frames.iter().map(mean).collect()
}

#[test]
fn joins_of_submaps_err_about_as_much_as_is_said_of_them() {
    let (mut squares, mut joins) = (Vector3::zeros(), 0.0);
    for seed in 0..4 {
        let (truth, _, matcher) = run(ScanMatcherConfig::default(), seed);
        let frames = true_frames(&truth, &matcher);
        for edge in matcher
            .graph()
            .edges()
            .iter()
            .filter(|e| e.cauchy.is_none())
        {
            let (Some(from), Some(to)) = (frames[edge.from], frames[edge.to]) else {
                continue;
            };
            let off = edge.motion.minus(&from.delta_to(&to));
            let variances = edge.information.try_inverse().unwrap().diagonal();
            squares += off.component_mul(&off).component_div(&variances);
            joins += 1.0;
        }
    }
    assert!(joins > 30.0);
    let nees = squares / joins;
    // A lidar this good leaves little but the floor: 0.005 rad, while its error is 0.001.
    assert!(nees.min() > 0.01 && nees.max() < 1.5, "{nees}");
}

/// The paths round the ring are known about as well as claimed, or better: joins are never claimed
/// to be known better than their floor.
#[test]
fn loops_show_how_honest_the_doubts_of_the_way_are() {
    for seed in 0..2 {
        let (_, _, matcher) = run(ScanMatcherConfig::default(), seed);
        let quality = matcher.quality();
        let accepted = matcher.closure_records().filter_map(|r| r.loop_error);
        assert!(accepted.count() >= quality.loops.len() && quality.loops.len() > 4);
        for closed in &quality.loops {
            assert!(closed.earlier < closed.later, "{closed:?}");
            let LoopError { doubt, shift, .. } = closed.error;
            assert!((0.005..0.5).contains(&doubt.shift), "{closed:?}");
            assert!(shift < 0.3, "{closed:?}");
        }
        assert!(quality.loops.is_sorted_by_key(|closed| closed.later));
        let ratio = quality.loop_ratio().unwrap();
        assert!((0.02..1.5).contains(&ratio), "{ratio}");
        assert!(!quality.is_overconfident());
    }
}

/// On the second lap a long object moves along beside the robot, for a metre and a half.
#[test]
fn what_moves_along_is_seldom_drawn() {
    const BESIDE: std::ops::Range<u64> = 450..465;
    let number = |stamp: Stamp| stamp.0 / 200_000;
    let sees = |mut scan: Scan| {
        if BESIDE.contains(&number(scan.stamp)) {
            for (range, bearing) in scan.ranges.iter_mut().zip(&scan.bearings) {
                // A flat side half a metre to the left, 2.5 m long.
                let along = 0.5 / libm::tan(*bearing);
                if *bearing > 0.0 && (0.0..2.5).contains(&along) {
                    *range = (0.5 / libm::sin(*bearing)) as f32;
                }
            }
        }
        scan
    };
    for seed in 0..3 {
        let heard = |_: usize, measured| Some(measured);
        let (truth, _, matcher) = run_seeing(ScanMatcherConfig::default(), seed, heard, sees);
        let [shift, turn] = worst(&truth, &matcher);
        assert!(shift < 0.12 && turn < 0.03, "{seed}: {shift} m, {turn} rad");
        let drawn = matcher.trajectory.iter().filter(|scan| {
            let is_of = |k: &Keyframe| k.submap_from_robot == scan.submap_from_robot;
            BESIDE.contains(&number(scan.stamp)) && matcher.keyframes.iter().any(is_of)
        });
        // Five if none waits; some agree well enough with what is known beside it.
        let drawn = drawn.count();
        assert!(drawn < 4, "{seed}: {drawn}");
    }
}

#[test]
fn the_same_input_gives_the_same_bits() {
    let bits = |matcher: &ScanMatcher| {
        let poses = matcher.trajectory().map(|(_, pose)| pose);
        let numbers = poses.flat_map(|p| [p.x(), p.y(), p.heading()].map(f64::to_bits));
        numbers.collect::<Vec<_>>()
    };
    let (a, b) = (
        run(ScanMatcherConfig::default(), 9).2,
        run(ScanMatcherConfig::default(), 9).2,
    );
    assert_eq!(bits(&a), bits(&b));
    assert_ne!(bits(&a), bits(&run(ScanMatcherConfig::default(), 10).2));
}

#[test]
fn scans_without_a_return_leave_odometry_to_itself_and_its_doubts_grow() {
    let mut matcher = ScanMatcher::new(ScanMatcherConfig::default()).unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut driven = Odometry::standing(Stamp(0));
    for i in 0..120 {
        let stamp = Stamp((i + 1) * 100_000);
        let step = Odometry {
            from: Stamp(i * 100_000),
            to: stamp,
            motion: Pose2::new(0.1, 0.0, 0.01),
            cov: Matrix3::identity() * 1e-4,
        };
        driven = driven.then(&step);
        matcher.odometry(&step);
        update(
            &mut matcher,
            &points_of(&scan_at(&[], &Pose2::identity(), stamp, &mut rng)),
        );
        let estimate = matcher.estimate();
        assert!((estimate.pose.position() - driven.motion.position()).length() < 1e-9);
        // Nothing tells the matcher this robot's odometry errors: they are larger than claimed, and
        // always in the same direction.
        let way = 0.1 * f64::from(u32::try_from(i).unwrap() + 1);
        let claimed = driven.cov.diagonal();
        let believed = estimate.cov.diagonal();
        let bias = 0.02 + 0.1 * way + 0.05 * way * way * way;
        let most = claimed * 12.0 + Vector3::from_element(bias);
        assert!(
            (believed - claimed).min() > -1e-9,
            "{i}: {believed} {claimed}"
        );
        assert!((most - believed).min() > 0.0, "{i}: {believed} {most}");
    }
    assert!(matcher.submaps.len() > 2);
}

#[test]
fn bad_configuration_is_named() {
    let config = ScanMatcherConfig {
        keyframe_turn: f64::NAN,
        ..ScanMatcherConfig::default()
    };
    let error = ScanMatcher::new(config).unwrap_err().to_string();
    assert_eq!(
        error,
        "scan matching: keyframe_turn is NaN, expected 0.02 to 3"
    );
}

/// What a lidar sees in all directions while the robot moves from `begin` by `motion`.
fn sweep_of(walls: &[Segment], begin: &Pose2, motion: &Pose2, stamp: Stamp) -> Scan {
    let bearings: Vec<f64> = (0..360).map(|i| f64::from(i).to_radians()).collect();
    let range = |(i, &bearing): (usize, &f64)| {
        let pose = *begin * motion.fraction(i as f64 / 359.0);
        range_to(walls, &pose, unit_vector(bearing)) as f32
    };
    Scan {
        stamp,
        robot_from_sensor: Pose2::identity(),
        ranges: bearings.iter().enumerate().map(range).collect(),
        sigmas: vec![0.01; bearings.len()],
        bearings,
        bearing_sigma: 0.0,
        max_range: 20.0,
        sweep: 0.2,
        qualities: vec![],
    }
}

#[test]
fn a_lidar_that_turns_slowly_knows_where_it_ends_though_tracks_slip() {
    let walls = ring();
    // With tracks that slip by a fifth, and without odometry.
    for counted in [Some(0.8), None] {
        let mut matcher = ScanMatcher::new(ScanMatcherConfig::default()).unwrap();
        let mut history = MotionHistory::new(1.0);
        let start = Pose2::new(-5.0, -4.0, 0.0);
        let (mut pose, mut worst) = (start, 0.0_f64);
        for step in 0..60_u64 {
            let (from, to) = (Stamp(step * 200_000), Stamp((step + 1) * 200_000));
            // It stands, and then turns back and forth, starting and stopping smoothly like a
            // robot.
            let turn = match step {
                0..5 => 0.0,
                _ => 0.25 * libm::sin(0.35 * (step - 5) as f64),
            };
            let motion = Pose2::new(0.0, 0.0, turn);
            if let Some(part) = counted {
                let odometry = Odometry {
                    from,
                    to,
                    motion: Pose2::new(0.0, 0.0, part * turn),
                    cov: Matrix3::from_diagonal(&Vector3::new(1e-6, 1e-6, 1e-4)),
                };
                matcher.odometry(&odometry);
                history.push(&odometry);
            }
            let scan = sweep_of(&walls, &pose, &motion, to);
            let points = Points::from_rolling_scan(&scan, &history, &PointConfig::default());
            update(&mut matcher, &points);
            pose = pose * motion;
            if step > 10 {
                let off = wrap(matcher.estimate().pose.heading() - start.delta_to(&pose).heading());
                worst = worst.max(off.abs());
            }
        }
        // If scans are matched as they are, they are off by half of the slip in a sweep: 25 mrad;
        // without odometry 125.
        assert!(worst < 0.008, "{counted:?}: {worst}");
    }
}

/// Sweeps while turning to one side.
const TURNS: u64 = 6;

/// How far surfaces of the running submap that were seen often are from the walls, root mean
/// square, how many surfaces there are, and the estimated pose, after `scans` that take `sweep`
/// seconds each. The robot first turns back and forth for some keyframes, and then stands.
fn surfaces_of_standing(scans: u64, sweep: f64) -> (f64, usize, Pose2) {
    let walls = ring();
    let start = Pose2::new(-5.0, -4.0, 0.0);
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let mut matcher = ScanMatcher::new(ScanMatcherConfig::default()).unwrap();
    let mut history = MotionHistory::new(1.0);
    let mut pose = start;
    for step in 0..scans {
        let (from, to) = (Stamp(step * 200_000), Stamp((step + 1) * 200_000));
        let turn = match step {
            1..=TURNS => 0.1,
            _ if (TURNS + 1..=2 * TURNS).contains(&step) => -0.1,
            _ => 0.0,
        };
        let motion = Pose2::new(0.0, 0.0, turn);
        let odometry = Odometry {
            from,
            to,
            motion,
            cov: Matrix3::from_diagonal(&Vector3::new(1e-6, 1e-6, 1e-4)),
        };
        matcher.odometry(&odometry);
        history.push(&odometry);
        let mut scan = sweep_of(&walls, &pose, &motion, to);
        scan.sweep = sweep;
        for range in &mut scan.ranges {
            *range += (0.02 * normal(&mut rng)) as f32;
        }
        let points = Points::from_rolling_scan(&scan, &history, &PointConfig::default());
        update(&mut matcher, &points);
        pose = pose * motion;
    }
    let surfels = matcher.running.surfels();
    let often = surfels.iter().filter(|surfel| surfel.weight >= SEEN_OFTEN);
    let count = often.clone().count();
    let squares = often.map(|surfel| {
        let place = start * surfel.position;
        let off = walls.iter().map(|wall| wall.distance(place));
        let off = off.fold(f64::INFINITY, f64::min);
        off * off
    });
    let mean = squares.sum::<f64>() / count as f64;
    (mean.sqrt(), surfels.len(), matcher.estimate().pose)
}

#[test]
fn sweeps_that_are_no_keyframes_sharpen_the_walls_and_add_none() {
    let (_, surfels, _) = surfaces_of_standing(2 * TURNS + 2, 0.2);
    let (mean, of_many, early) = surfaces_of_standing(2 * TURNS + 60, 0.2);
    assert_eq!(surfels, of_many);
    // Scans taken at one instant sharpen nothing.
    let (of_keyframes, ..) = surfaces_of_standing(2 * TURNS + 60, 0.0);
    assert!(
        mean < 0.9 * of_keyframes,
        "{mean} m, by keyframes alone {of_keyframes} m"
    );
    // A robot that stands for long does not drift away with the walls.
    let (late_mean, _, late) = surfaces_of_standing(1500, 0.2);
    assert!(late_mean < 1.3 * mean, "{late_mean} m after {mean} m");
    assert!(!differs(&early, &late, 0.004, 0.001), "{early:?} {late:?}");
}

//! Odometry that is missing, late or wrong, or fails.

use super::*;

#[test]
fn nobody_counts_the_motion_and_the_ring_closes_all_the_same() {
    for seed in 0..2 {
        let (truth, _, matcher) = run_with(ScanMatcherConfig::default(), seed, |_, _| None);
        let [shift, turn] = worst(&truth, &matcher);
        assert!(shift < 0.15 && turn < 0.03, "{seed}: {shift} m, {turn} rad");
    }
}

#[test]
fn odometry_that_stands_still_and_then_catches_up_is_counted_once() {
    // In every forty scans it reports nothing for eight, and then all at once: turns of up to 0.8
    // rad.
    let mut held = Pose2::identity();
    let late = move |scan: usize, measured: Pose2| {
        held = held * measured;
        let says_nothing = scan % 40 >= 32 && scan % 40 < 39;
        Some(match says_nothing {
            true => Pose2::identity(),
            false => std::mem::take(&mut held),
        })
    };
    let (truth, _, matcher) = run_with(ScanMatcherConfig::default(), 3, late);
    let [shift, turn] = worst(&truth, &matcher);
    assert!(shift < 0.1 && turn < 0.03, "{shift} m, {turn} rad");
}

#[test]
fn wheels_that_err_by_a_tenth_and_pull_to_a_side_do_no_harm() {
    let bent = |_: usize, measured: Pose2| {
        let way = measured.x();
        Some(Pose2::new(
            way * 1.1,
            measured.y(),
            measured.heading() + 0.09 * way,
        ))
    };
    let (truth, _, matcher) = run_with(ScanMatcherConfig::default(), 4, bent);
    let [shift, turn] = worst(&truth, &matcher);
    assert!(shift < 0.1 && turn < 0.03, "{shift} m, {turn} rad");
}

/// The largest error of the motion between two scans, m.
fn worst_step(truth: &[Pose2], matcher: &ScanMatcher) -> f64 {
    let found: Vec<Pose2> = matcher.trajectory().map(|(_, pose)| pose).collect();
    let steps = |poses: &[Pose2]| -> Vec<Pose2> {
        poses
            .windows(2)
            .map(|pair| pair[0].delta_to(&pair[1]))
            .collect()
    };
    let off = |(a, b): (&Pose2, &Pose2)| (a.position() - b.position()).length();
    let (found, truth) = (steps(&found), steps(truth));
    found.iter().zip(&truth).map(off).fold(0.0, f64::max)
}

#[test]
fn odometry_that_hangs_for_long_does_not_hold_the_robot_back() {
    // For fifty of every ninety scans: five metres, or two turns into the next corridor.
    let mut held = Pose2::identity();
    let hangs = move |scan: usize, measured: Pose2| {
        held = held * measured;
        Some(match scan % 90 >= 40 {
            true => Pose2::identity(),
            false => std::mem::take(&mut held),
        })
    };
    for seed in 0..2 {
        let (truth, _, matcher) = run_with(ScanMatcherConfig::default(), seed, hangs);
        let [shift, turn] = worst(&truth, &matcher);
        assert!(shift < 0.15 && turn < 0.03, "{seed}: {shift} m, {turn} rad");
    }
}

#[test]
fn odometry_that_jumps_ahead_is_not_followed() {
    for ahead in [0.6, 2.0] {
        let jumps = |scan: usize, measured: Pose2| {
            let jump = if scan % 50 == 30 { ahead } else { 0.0 };
            Some(measured * Pose2::new(jump, 0.0, 0.0))
        };
        let (truth, _, matcher) = run_with(ScanMatcherConfig::default(), 1, jumps);
        let [shift, turn] = worst(&truth, &matcher);
        assert!(
            shift < 0.12 && turn < 0.03,
            "{ahead}: {shift} m, {turn} rad"
        );
        let step = worst_step(&truth, &matcher);
        assert!(step < 0.12, "{ahead}: {step} m");
    }
}

/// In a corridor, only a person tells how far the robot went, walking ahead of it faster than it
/// drives, just as a submap has begun with nothing.
#[test]
fn who_walks_ahead_where_a_submap_begins_hardly_carries_the_robot_along() {
    const BEGINS: u64 = 100;
    let wall = |y: f64| Segment::new(Point2::new(-30.0, y), Point2::new(40.0, y));
    for (seed, distance) in (0..3).flat_map(|seed| [(seed, 1.0), (seed, 2.0)]) {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut matcher = ScanMatcher::new(ScanMatcherConfig::default()).unwrap();
        let mut worst = 0.0_f64;
        for step in 0..BEGINS + 12 {
            let (from, to) = (Stamp(step * 400_000), Stamp((step + 1) * 400_000));
            let truth = Pose2::new(0.1 * step as f64, 0.0, 0.0);
            let way = if step == 0 { 0.0 } else { 0.1 };
            matcher.odometry(&Odometry {
                from,
                to,
                motion: Pose2::new(way + 0.002 * normal(&mut rng), 0.0, 0.0),
                cov: Matrix3::from_diagonal(&Vector3::repeat(2e-5)),
            });
            let mut walls = vec![wall(-1.2), wall(1.2)];
            if let Some(since) = step.checked_sub(BEGINS) {
                let ahead = truth.x() + distance + 0.08 * since as f64;
                let side = |y: f64| Point2::new(ahead, y);
                walls.push(Segment::new(side(-0.1), side(0.1)));
                if since == 0 {
                    matcher.begin_submap(true);
                }
            }
            update(
                &mut matcher,
                &points_of(&scan_at(&walls, &truth, to, &mut rng)),
            );
            let off = matcher.estimate().pose.x() - truth.x();
            worst = worst.max(off.abs());
        }
        assert!(worst < 0.2, "{seed}, {distance} m ahead: {worst} m");
    }
}

//! Scans are missing while the robot drives on.

use super::super::super::map_quality::{MapVerdict, Tear, TearKind};
use super::course::{Step, feed};
use super::*;

/// The steps of two laps of the ring, except those from `FROM` to `TO`: nearly half a lap, of which
/// odometry gives only the total motion at the end.
fn two_laps() -> Vec<Step> {
    let start = Pose2::new(-5.0, -4.0, 0.0);
    drive(&[LAP, LAP].concat(), start, 1)
}

const FROM: usize = 140;
const TO: usize = 290;

/// Drives with that gap, and then `after` more steps.
fn run_with_silence(after: usize) -> (ScanMatcher, Vec<Step>) {
    let mut steps = two_laps();
    let mut odometry = steps[FROM].odometry;
    for step in &steps[FROM + 1..=TO] {
        odometry = odometry.then(&step.odometry);
    }
    // Somewhere in the gap the robot turned by half a radian that no wheel counted.
    odometry.motion = odometry.motion * Pose2::new(0.9, -0.6, 0.5);
    steps[TO].odometry = odometry;
    steps.truncate(TO.saturating_add(after));
    steps.drain(FROM..TO);
    let mut matcher = ScanMatcher::new(ScanMatcherConfig::default()).unwrap();
    feed(&mut matcher, &steps);
    matcher.finish();
    (matcher, steps)
}

#[test]
fn what_comes_after_a_silence_is_held_to_nothing_that_was_before() {
    let (matcher, steps) = run_with_silence(60);
    let silent = steps[FROM].scan.stamp.since(steps[FROM - 1].scan.stamp);
    assert!(silent > 10.0, "{silent}");
    let quality = matcher.quality();
    assert_eq!(quality.verdict, MapVerdict::Torn, "{:?}", quality.tears);
    let again = steps[FROM].scan.stamp;
    let is_told = |tear: &&Tear| {
        tear.kind == TearKind::Loose && tear.earlier[1] < again && tear.later[1] >= again
    };
    let tear = quality.tears.iter().find(is_told);
    let tear = tear.unwrap_or_else(|| panic!("{:?} {again:?}", quality.tears));
    // The odometry over the gap errs by 1.5 m where the robot looks.
    assert!(tear.off.is_some_and(|off| off > 0.75), "{tear:?}");
}

#[test]
fn a_loop_after_a_silence_sets_the_map_right() {
    let (matcher, steps) = run_with_silence(usize::MAX);
    assert_eq!(matcher.quality().verdict, MapVerdict::Good);
    let map_from_building = steps[0].truth.inverse();
    let mut most = 0.0_f64;
    for ((_, pose), step) in matcher.trajectory().zip(&steps) {
        let truth = map_from_building * step.truth;
        most = most.max((pose.position() - truth.position()).length());
    }
    assert!(most < 0.15, "{most}");
}

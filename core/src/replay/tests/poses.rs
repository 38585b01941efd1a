//! Poses from another file, as odometry and as truth.

use super::*;
use crate::format::poses::read_poses;
use crate::format::revolution_log::RevolutionLog;

/// The true poses of the robot of [`small_log`], at times between its scans, in another frame; some
/// are left out.
fn track(frame: Pose2, offset: f64, is_there: impl Fn(u32) -> bool) -> PoseTrack {
    let mut text = "yaw_deg;x;y;time\n".to_owned();
    for i in (0..42).filter(|i| is_there(*i)) {
        let x = 0.05 * (f64::from(i) - 0.7);
        let pose = frame * Pose2::new(x, 0.0, 0.0);
        let seconds = f64::from(i) + 99.8 + offset;
        let degrees = pose.heading().to_degrees();
        text += &format!("{degrees};{};{};{seconds}\n", pose.x(), pose.y());
    }
    read_poses(text.as_bytes()).unwrap().into()
}

fn run(log: Log, method: Method) -> Replay {
    let settings = log.settings();
    Replay::new(log, method, &settings).unwrap()
}

fn to_its_end(mut replay: Replay) -> Replay {
    while replay.step().unwrap() {}
    replay
}

fn posed(log: impl Into<Log>, track: PoseTrack) -> Result<Log, PosesMisfit> {
    PosedLog::new(log.into(), track, &LogSettings::default()).map(Into::into)
}

#[test]
fn poses_take_the_place_of_odometry_and_are_interpolated_at_each_scan() {
    let frame = Pose2::new(30.0, -7.0, 2.0);
    let log = posed(small_log(), track(frame, 0.0, |_| true)).unwrap();
    let replay = to_its_end(run(log, Method::Odometry));
    assert_eq!(replay.trajectory().len(), 40);
    // Between the poses the robot drives straight on: 0.05 m from scan to scan, where the log's
    // own odometry says 0.055.
    for (i, pose) in (0..).zip(replay.odometry_trajectory()) {
        let x = 0.05 * f64::from(i);
        assert!(
            (pose.x() - x).abs() < 1e-6 && pose.y().abs() < 1e-6,
            "{pose:?}"
        );
    }
    let told = frame.inverse() * replay.odom_from_robot();
    assert!((told.x() - 0.05 * 39.0).abs() < 1e-9);
}

#[test]
fn a_lidar_alone_gets_a_robot_by_poses() {
    let revolutions = run(Log::from(small_log()), Method::ScanMatching).revolution_log();
    let rate = LogSettings::default().revolution_rate;
    let alone = Log::from(revolutions.clone());
    assert!(!alone.has_odometry());
    let poses = (0..41).map(|i| {
        (
            f64::from(i) / rate,
            Pose2::new(0.05 * f64::from(i), 0.0, 0.0),
        )
    });
    let text = crate::format::tum::write(poses);
    let log = posed(alone, read_poses(text.as_bytes()).unwrap().into()).unwrap();
    assert!(log.has_odometry());
    let replay = to_its_end(run(log, Method::Odometry));
    assert_eq!(replay.session().slam().method(), Method::Odometry);
    let last = replay.odometry_trajectory().last().unwrap();
    assert!((last.x() - 0.05 * 39.0).abs() < 1e-6, "{last:?}");
    assert!(
        matches!(replay.log(), Log::Posed(posed) if posed.log().scans() == RevolutionLog::len(&revolutions))
    );
}

#[test]
fn scans_in_a_gap_are_left_out_and_that_is_said() {
    // Without poses 10 to 14, scans 9 to 14 at 109.5 to 114.5 s are not covered: the poses next to
    // the gap are of 108.8 and 114.8 s.
    let log = posed(
        small_log(),
        track(Pose2::identity(), 0.0, |i| !(10..15).contains(&i)),
    )
    .unwrap();
    let mut replay = to_its_end(run(log, Method::Odometry));
    let notes = replay.take_notes().join("\n");
    assert!(
        notes.contains("6 of 40 scans") && notes.contains("first at 109.50 s"),
        "{notes}"
    );
    let way: Vec<Pose2> = replay.odometry_trajectory().collect();
    assert_eq!(way.len(), 34);
    // The covered poses on both sides give the motion over the gap.
    assert!((way[9].x() - way[8].x() - 0.35).abs() < 1e-6);
}

#[test]
fn poses_of_another_clock_are_refused_with_both_times() {
    let words = posed(small_log(), track(Pose2::identity(), 1e6, |_| true))
        .unwrap_err()
        .to_string();
    assert!(words.contains("none of the 40 scans"), "{words}");
    assert!(
        words.contains("100.500 to 139.500") && words.contains("1000099.800"),
        "{words}"
    );
    let log = posed(small_log(), track(Pose2::identity(), 0.0, |_| true)).unwrap();
    let again = posed(log, track(Pose2::identity(), 0.0, |_| true));
    assert_eq!(again.unwrap_err(), PosesMisfit::Twice);
}

#[test]
fn errors_are_those_left_by_the_best_rigid_motion() {
    // By its wheels, the distance is a tenth too long: aligned at its middle, a pose is off by a
    // tenth of its distance from there. The mean square of -19.5 … 19.5 steps is (40² - 1) / 12.
    let frame = Pose2::new(300.0, -70.0, 2.0);
    let mut replay = run(small_log().into(), Method::Odometry);
    assert_eq!(replay.truth_errors(), None);
    let told = replay.set_truth(track(frame, 0.0, |_| true)).unwrap();
    assert_eq!(told, None);
    assert!(replay.set_truth(track(frame, 1e6, |_| true)).is_err());
    let replay = to_its_end(replay);
    let errors = replay.truth_errors().unwrap();
    assert_eq!((errors.poses.len(), errors.left_out), (40, 0));
    let step = 0.005;
    assert!((errors.max - 19.5 * step).abs() < 1e-5, "{errors:?}");
    assert!((errors.rmse - step * (1599.0_f64 / 12.0).sqrt()).abs() < 1e-5);
    assert!(errors.poses.iter().all(|error| error.heading.abs() < 1e-5));
    // The map is not deformed, so the errors on the way are the same at the end.
    let [truth, last] = [replay.truth().unwrap(), errors.poses[39].truth];
    assert!((truth.position() - last.position()).length() < 1e-6);
    // A second run is compared with the same truth.
    let again = to_its_end(replay.again().unwrap());
    assert_eq!(again.truth_errors(), replay.truth_errors());
    assert!(
        errors.words().contains("40 of 40 scans"),
        "{}",
        errors.words()
    );
}

#[test]
fn a_run_is_held_only_against_scans_that_the_truth_tells_of() {
    let mut replay = run(small_log().into(), Method::Odometry);
    let told = replay
        .set_truth(track(Pose2::identity(), 0.0, |i| i < 20))
        .unwrap();
    assert!(told.unwrap().contains("21 of 40 scans"));
    let replay = to_its_end(replay);
    let errors = replay.truth_errors().unwrap();
    assert_eq!((errors.poses.len(), errors.left_out), (19, 21));
    assert_eq!(replay.truth(), None);
}

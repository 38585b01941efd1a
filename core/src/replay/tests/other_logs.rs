//! Logs of a rover and of rangers, with and without odometry.

use super::*;
use crate::estimation::{MapVerdict, Unjudgeable};
use crate::format::rover_log::BEAMS;

/// Millimetres from `x` to the walls of a room of 8 m x 4 m, straight ahead along its middle line.
fn turn_of_lidar(x: f64) -> String {
    let range = |degree: usize| {
        let (sin, cos) = crate::geom::sin_cos(-(degree as f64).to_radians());
        let along = if cos > 0.0 { 5.0 - x } else { 3.0 + x };
        let range = (along / cos.abs().max(1e-9)).min(2.0 / sin.abs().max(1e-9));
        // An RPLIDAR of the first series has a range of 6 m.
        let seen = Some(range).filter(|range| *range < 6.0);
        format!(" {}", seen.map_or(0, |range| (1e3 * range).round() as u32))
    };
    (0..BEAMS).map(range).collect()
}

/// A rover that drives 2 m ahead: 200 counts per metre, so 400 for each wheel.
fn rover() -> Log {
    let line = |i: u32| {
        let counts = 65_400 + 10 * i;
        let ranges = turn_of_lidar(0.05 * f64::from(i));
        format!(
            "{} {} {}{ranges}\n",
            counts % 65_536,
            counts % 65_536,
            (182 * i) % 65_536
        )
    };
    read(&(0..=40).map(line).collect::<String>())
}

fn read(text: &str) -> Log {
    let mut reader = LogReader::default();
    // In pieces, and in one piece: the same log.
    for piece in text.as_bytes().chunks(3) {
        reader.push(piece).unwrap();
    }
    let mut at_once = LogReader::default();
    at_once.push(text.as_bytes()).unwrap();
    let log = reader.finish().unwrap();
    assert_eq!(
        format!("{log:?}"),
        format!("{:?}", at_once.finish().unwrap())
    );
    log
}

fn replayed(log: Log, settings: &Settings) -> Replay {
    let mut replay = Replay::new(log, Method::ScanMatching, settings).unwrap();
    while replay.step().unwrap() {}
    replay
}

#[test]
fn a_rover_is_mapped_with_its_wheels_and_without_them() {
    let log = rover();
    assert!(matches!(log, Log::Rover(_)));
    for (uses_odometry, counted) in [(true, 2.0), (false, 0.0)] {
        let mut settings = log.settings();
        let changes = [
            ("log.counts", 1000.0),
            ("log.wheel", 5.0 / std::f64::consts::PI),
            ("log.odometry", f64::from(u8::from(uses_odometry))),
        ];
        let idle = settings.take(&SCOPE, changes).unwrap();
        assert_eq!(idle, []);
        let mut replay = replayed(log.clone(), &settings);
        let session = replay.session();
        assert!((session.dead_reckoning().x() - counted).abs() < 1e-9);
        let pose = session.estimate().pose;
        assert!(
            (pose.x() - 2.0).abs() < 0.02 && pose.y().abs() < 0.02,
            "{pose:?}"
        );
        assert_eq!(session.scans(), 41);
        let notes = replay.take_notes();
        assert_eq!(notes.len(), usize::from(!uses_odometry), "{notes:?}");
        // As a CARMEN log it is the same drive.
        let carmen = replay.carmen_log();
        let last = carmen.scans[40].odom_from_robot;
        assert!((last.x() - counted).abs() < 1e-9 || !uses_odometry);
    }
}

/// The distance per count and the track width are as in the settings.
#[test]
fn what_a_rovers_log_does_not_say_is_set() {
    let turn = |left: i32, right: i32| format!("{left} {right} 0{}\n", turn_of_lidar(0.0));
    let log = read(&(turn(0, 0) + &turn(-100, 100)));
    for (width, heading) in [(0.19, 1.0), (0.38, 0.5)] {
        let mut settings = log.settings();
        let metres_per_count = 0.19 / 200.0;
        let wheel = metres_per_count * 500.0 / std::f64::consts::PI;
        let changes = [
            ("log.counts", 500.0),
            ("log.wheel", wheel),
            ("log.track", width),
        ];
        settings.take(&SCOPE, changes).unwrap();
        let replay = replayed(log.clone(), &settings);
        let turned = replay.session().dead_reckoning().heading();
        assert!((turned - heading).abs() < 1e-9, "{turned}");
    }
}

/// Four rangers driven 5 m along a corridor 1.66 m wide with a wall at its end.
#[test]
fn four_rangers_are_mapped_by_their_odometry() {
    let head = "t_s,x_m,y_m,yaw_rad,range0,range1,range2,range3,range4\n".to_owned();
    let row = |i: u32| {
        let x = 0.05 * f64::from(i);
        format!(
            "{},{x},0,0,0.83,{},0.83,nan,2.4\n",
            0.1 * f64::from(i),
            6.0 - x
        )
    };
    let text = head + &(0..=100).map(row).collect::<String>();
    let log = read(&text);
    assert!(matches!(log, Log::Rangers(_)) && log.scans() == 101);
    // As spreadsheets write it.
    assert_eq!(read(&format!("\u{feff}{text}")).scans(), 101);
    let replay = replayed(log.clone(), &log.settings());
    assert_eq!(worth(&replay).1, None);
    let pose = replay.session().estimate().pose;
    assert!(
        (pose.x() - 5.0).abs() < 0.05 && pose.y().abs() < 0.05,
        "{pose:?}"
    );
    let grid = replay.session().slam().grid();
    let at = |x: f64, y: f64| grid.probability(grid.cell_at([x, y].into()));
    // Each reading draws a thin beam, so cells between two of them may stay unknown.
    let part = |y: f64, is_so: fn(f64) -> bool| {
        let cells = (0..40).filter(|i| is_so(at(1.02 + 0.05 * f64::from(*i), y)));
        cells.count() as f64 / 40.0
    };
    for side in [0.83, -0.83] {
        assert!(part(side, |p| p > 0.5) > 0.5, "{}", part(side, |p| p > 0.5));
    }
    assert!(part(0.0, |p| p < 0.5) > 0.9 && part(0.4, |p| p > 0.5) == 0.0);
    // Four readings show no surface, and without odometry they cannot be combined: the robot seems
    // to stand, and nothing on the map could contradict that.
    let mut settings = log.settings();
    settings.take(&SCOPE, [("log.odometry", 0.0)]).unwrap();
    let why = Some(Unjudgeable::NoSurfaces);
    let replay = replayed(log, &settings);
    assert_eq!(worth(&replay), (MapVerdict::Doubtful, why));
}

fn worth(replay: &Replay) -> (MapVerdict, Option<Unjudgeable>) {
    let quality = replay.session().slam().view().map.unwrap().quality();
    (quality.verdict, quality.unjudgeable)
}

/// The same drive as a log of revolutions: without wheels and time, the room is still mapped.
/// Written out, it gives the same log again.
#[test]
fn a_lidar_alone_is_mapped_without_wheels() {
    let replay = replayed(rover(), &rover().settings());
    let text = replay.revolution_log().write();
    assert!(
        text.starts_with("S_t:0.00_d:05000.00_q:63|__t:1.00_d:"),
        "{text:.60}"
    );
    let log = read(&text);
    assert!(matches!(log, Log::Revolutions(_)) && !log.has_odometry());
    // The first line identifies it, even after comments, and even if it is the whole file.
    assert_eq!(read(&format!("# a lidar\n\n{text}")).scans(), 41);
    assert_eq!(read(text.lines().next().unwrap()).scans(), 1);
    for (rate, seconds) in [(5.5, 41.0 / 5.5), (10.0, 4.1)] {
        let mut settings = log.settings();
        settings.take(&SCOPE, [("log.revolutions", rate)]).unwrap();
        let mut replay = replayed(log.clone(), &settings);
        assert!((replay.duration() - seconds).abs() < 1e-9);
        let trajectory = replay.trajectory();
        assert_eq!(trajectory.len(), 41);
        assert!((trajectory[40].0 - seconds).abs() < 1e-6);
        // The rover did not move during any sweep of this log: a scan taken at once is treated as a
        // sweep.
        let pose = replay.session().estimate().pose;
        assert!(
            (pose.x() - 2.0).abs() < 0.05 && pose.y().abs() < 0.05,
            "{pose:?}"
        );
        assert_eq!(replay.revolution_log().write(), text);
        let notes = replay.take_notes();
        assert!(
            notes[0].starts_with("No robot is in this recording"),
            "{notes:?}"
        );
        // Nothing shows when it stood, so its noise is not fitted to scans of a moving sensor.
        assert!(replay.standing_stretches().is_empty());
    }
}

#[test]
fn prior_maps_need_odometry_that_is_used() {
    let log = rover();
    let mut settings = log.settings();
    settings.take(&SCOPE, [("log.odometry", 0.0)]).unwrap();
    let error = Replay::new(log, Method::PriorMap, &settings).unwrap_err();
    assert_eq!(error, ReplayError::NoOdometry);
}

/// The flat of the recorded rover is one map by its wheels.
#[test]
fn the_recorded_rover_maps_a_whole_flat() {
    let Some(bytes) = recorded("rplidar/data_6AUG14_16m.log") else {
        return;
    };
    let log = read(std::str::from_utf8(&bytes).unwrap());
    let replay = replayed(log.clone(), &log.settings());
    let view = replay.session().slam().view();
    assert!(view.loop_closures > 10);
    let quality = view.map.map(|map| map.quality()).unwrap();
    assert_eq!(quality.verdict, MapVerdict::Good);
    // It returns to where it set out, after 14 m of rooms.
    let poses = replay.trajectory();
    let ends = |axis: fn(&Pose2) -> f64| {
        let along = poses.iter().map(|(_, pose)| axis(pose));
        along.clone().fold(f64::MIN, f64::max) - along.fold(f64::MAX, f64::min)
    };
    assert!((10.0..12.0).contains(&ends(Pose2::x)) && (5.0..6.5).contains(&ends(Pose2::y)));
}

//! Logs of small robots, and recorded buildings.

mod odd_logs;
mod other_logs;
mod poses;

use super::*;
use crate::estimation::{Start, relation_errors};
use crate::format::carmen::CarmenLog;
use crate::format::{recorded, relations};
use crate::geom::Segment;
use crate::settings::{Scope, Source};
use crate::slam::{PriorMap, PriorMapMatching, Slam, SlamConfig};
use crate::wire::message::{FromBridge, ScanBody};
use crate::wire::recording::{Recording, fixture};

#[test]
fn from_its_beginning_a_recording_comes_to_every_earlier_state() {
    let log = small_log();
    let settings = Log::from(log.clone()).settings();
    let mut run = Replay::new(log, Method::ScanMatching, &settings).unwrap();
    let mut hashes = vec![run.state_hash()];
    while run.step().unwrap() {
        hashes.push(run.state_hash());
    }
    let mut again = run.again().unwrap();
    for hash in &hashes {
        assert_eq!(again.state_hash(), *hash);
        again.step().unwrap();
    }
    let corners = [[0.0, 0.0], [1.0, 1.0]].map(|[x, y]| Point2::new(x, y));
    again.edit(EditKind::Wall, &corners).unwrap();
    assert!(matches!(again.again(), Err(ReplayError::Untold(_))));
}

/// A robot that drives 2 m along a room of 8 m x 4 m, its laser 0.1 m ahead of its centre.
fn small_log() -> CarmenLog {
    let mut text = String::new();
    for i in 0..40 {
        let x = 0.05 * f64::from(i);
        let laser = x + 0.1;
        text += "FLASER 180";
        for beam in 0..180 {
            let (sin, cos) = crate::geom::sin_cos((f64::from(beam) - 90.0).to_radians());
            let ahead = if cos > 1e-9 {
                (5.0 - laser) / cos
            } else {
                f64::INFINITY
            };
            let side = if sin.abs() > 1e-9 {
                2.0 / sin.abs()
            } else {
                f64::INFINITY
            };
            text += &format!(" {:.3}", ahead.min(side));
        }
        // Odometry claims a tenth too much.
        let (o, l) = (1.1 * x, 1.1 * x + 0.1);
        text += &format!(" {l} 0 0 {o} 0 0 {}.5 host 0\n", 100 + i);
    }
    CarmenLog::parse(text.as_bytes()).unwrap()
}

fn replay(log: CarmenLog, method: Method) -> Replay {
    let log = Log::from(log);
    let settings = log.settings();
    let mut replay = Replay::new(log, method, &settings).unwrap();
    while replay.step().unwrap() {}
    replay
}

const SCOPE: Scope = Scope {
    source: Source::Recording,
    method: Method::LineEkf,
};

#[test]
fn matching_finds_the_way_of_the_base_where_odometry_is_wrong() {
    let matched = replay(small_log(), Method::ScanMatching);
    let trajectory = matched.trajectory();
    assert_eq!((trajectory.len(), matched.progress()), (40, 1.0));
    assert!((trajectory[39].0 - 139.5).abs() < 1e-9);
    assert!(
        (trajectory[39].1.x() - 1.95).abs() < 0.02,
        "{:?}",
        trajectory[39]
    );
    assert!(trajectory[39].1.y().abs() < 0.01);
    let raw = replay(small_log(), Method::Odometry);
    assert!((raw.session().dead_reckoning().x() - 1.1 * 1.95).abs() < 1e-6);
    assert!((raw.trajectory()[39].1.x() - 1.1 * 1.95).abs() < 1e-6);
    assert_ne!(raw.state_hash(), matched.state_hash());
}

#[test]
fn a_replay_that_was_paused_and_saved_ends_as_one_that_was_not() {
    let whole = replay(small_log(), Method::ScanMatching);
    let log = Log::from(small_log());
    let mut settings = log.settings();
    let mut first = Replay::new(log.clone(), Method::ScanMatching, &settings).unwrap();
    for _ in 0..17 {
        assert!(first.step().unwrap());
    }
    let map = std::sync::Arc::new(first.saved_map().unwrap());
    let saved = |start| {
        Some(EarlierMap {
            map: map.clone(),
            start,
        })
    };
    settings.slam.saved_map = saved(Start::Paused);
    let mut rest = Replay::new(log.clone(), Method::ScanMatching, &settings).unwrap();
    rest.skip(17);
    while rest.step().unwrap() {}
    assert_eq!(rest.trajectory(), whole.trajectory());
    assert_eq!(rest.state_hash(), whole.state_hash());
    let slam = rest.session().slam();
    assert_eq!((slam.earlier_scans(), slam.trajectory().len()), (17, 23));
    // Another day: the whole log again, whose stamps start over and are placed after the others.
    settings.slam.saved_map = saved(Start::At(Pose2::identity()));
    let mut again = Replay::new(log.clone(), Method::ScanMatching, &settings).unwrap();
    while again.step().unwrap() {}
    let stamps: Vec<Stamp> = again.scan_times().map(|(stamp, _)| stamp).collect();
    assert_eq!(stamps.len(), 57);
    assert!(stamps.windows(2).all(|pair| pair[0] < pair[1]));
    let seconds: Vec<f64> = again.scan_times().map(|(_, seconds)| seconds).collect();
    assert!((seconds[0] - 100.5).abs() < 1e-9 && (seconds[17] - 100.5).abs() < 1e-9);
    assert!(
        seconds.iter().all(|s| (100.0..140.0).contains(s)),
        "{seconds:?}"
    );
    // Other methods cannot continue in a map, nor save one.
    let refused = Replay::new(log, Method::Odometry, &settings).unwrap_err();
    assert_eq!(refused, ReplayError::Slam(SlamError::NoSavedMap));
    assert!(replay(small_log(), Method::Odometry).saved_map().is_none());
}

#[test]
fn stretches_are_where_the_odometry_stood() {
    let mut log = small_log();
    assert!(
        replay(log.clone(), Method::Odometry)
            .standing_stretches()
            .is_empty()
    );
    for scans in [10..14, 20..22, 30..37] {
        let stands = log.scans[scans.start].odom_from_robot;
        for scan in &mut log.scans[scans] {
            scan.odom_from_robot = stands;
        }
    }
    let stretches = replay(log, Method::Odometry).standing_stretches();
    let lengths: Vec<usize> = stretches.iter().map(Vec::len).collect();
    assert_eq!(lengths, [4, 7]);
}

/// The buildings on which others are measured, with the same parameters for all.
#[test]
fn recorded_buildings_are_mapped_as_well_as_published() {
    for (name, all, long) in [("intel", 0.025, 0.035), ("fr079", 0.06, 0.09)] {
        let (Some(log), Some(truth)) = (
            recorded(&format!("{name}/{name}.clf")),
            recorded(&format!("{name}/{name}.relations")),
        ) else {
            continue;
        };
        let done = replay(CarmenLog::parse(&log).unwrap(), Method::ScanMatching);
        let trajectory = done.trajectory();
        let truth = relations::parse(&truth).unwrap();
        let error = |least: f64| {
            let chosen = truth
                .iter()
                .filter(|r| (r.to_seconds - r.from_seconds).abs() >= least)
                .map(|r| (r.from_seconds, r.to_seconds, r.motion));
            relation_errors(chosen, &trajectory)
        };
        assert_eq!(error(0.0).count, truth.len());
        assert!(error(0.0).trans_abs_mean < all, "{name}: {:?}", error(0.0));
        assert!(
            error(20.0).trans_abs_mean < long,
            "{name}: {:?}",
            error(20.0)
        );
    }
}

/// A robot that stands in a room while somebody crosses 1.5 m ahead of it at 1 m/s, five scans a
/// second.
fn log_with_somebody() -> CarmenLog {
    let mut text = String::new();
    for i in 0..12 {
        let person = (1.5, 0.2 * f64::from(i) - 1.2);
        text += "FLASER 180";
        for beam in 0..180 {
            let (sin, cos) = crate::geom::sin_cos((f64::from(beam) - 90.0).to_radians());
            let wall = (3.0 / cos.max(1e-9)).min(2.0 / sin.abs().max(1e-9));
            // The disc of 0.2 m around the person.
            let (along, across) = (
                person.0 * cos + person.1 * sin,
                person.1 * cos - person.0 * sin,
            );
            let near = along - (0.04 - across * across).max(0.0).sqrt();
            let range = if across.abs() < 0.2 {
                near.min(wall)
            } else {
                wall
            };
            text += &format!(" {range:.3}");
        }
        text += &format!(" 0 0 0 0 0 0 {:.1} host 0\n", 100.0 + 0.2 * f64::from(i));
    }
    CarmenLog::parse(text.as_bytes()).unwrap()
}

#[test]
fn nobody_is_looked_for_in_a_log() {
    let log = log_with_somebody();
    let mut slam = Slam::new(Method::Odometry, SlamConfig::default()).unwrap();
    for scan in &log.scans {
        slam.scan(&log.scan(scan)).unwrap();
    }
    assert!(!slam.walkers().is_empty(), "somebody is there to be seen");
    slam.disable_walkers();
    for scan in &log.scans {
        slam.partial_scan(&log.scan(scan)).unwrap();
        assert_eq!(slam.walkers(), []);
    }
    let settings = Log::from(log.clone()).settings();
    let mut replay = Replay::new(log, Method::Odometry, &settings).unwrap();
    while replay.step().unwrap() {
        assert_eq!(replay.session().slam().walkers(), []);
    }
    assert_eq!(replay.session().scans(), 12);
}

/// Half of the drive with the old settings, half with others.
#[test]
fn a_setting_that_changes_on_the_way_is_obeyed_from_there_on() {
    let log = Log::from(small_log());
    let settings = log.settings();
    let mut replay = Replay::new(log.clone(), Method::Odometry, &settings).unwrap();
    for _ in 0..20 {
        assert!(replay.step().unwrap());
    }
    let half = replay.session().dead_reckoning().x();
    assert!((half - 1.1 * 0.95).abs() < 1e-6);
    // The odometry claims a tenth too much.
    let changes = [
        ("odometry.left", -1.0 / 11.0),
        ("odometry.right", -1.0 / 11.0),
        ("lines.rule", 1.0),
    ];
    let mut changed = settings.clone();
    changed.take(&SCOPE, changes).unwrap();
    replay.reconfigure(&changed).unwrap();
    while replay.step().unwrap() {}
    let rest = replay.session().dead_reckoning().x() - half;
    assert!((rest - 1.0).abs() < 1e-6, "{rest}");
    assert_eq!(replay.session().slam().config().lines, changed.slam.lines);
    assert_ne!(changed.slam.lines, settings.slam.lines);
    // A refused change has no effect.
    let mut wrong = changed.clone();
    wrong.slam.lines.accept.min_length = -1.0;
    assert!(replay.reconfigure(&wrong).is_err());
    assert_eq!(replay.session().slam().config().lines, changed.slam.lines);
}

#[test]
fn a_robot_in_a_log_is_found_in_a_prior_map_in_both_ways() {
    let walls = [
        ([5.0, -2.0], [5.0, 2.0]),
        ([5.0, 2.0], [-3.0, 2.0]),
        ([-3.0, -2.0], [5.0, -2.0]),
    ];
    let faces = walls.map(|(a, b)| Segment::new(a.into(), b.into()));
    for matching in [PriorMapMatching::Lines, PriorMapMatching::Surfaces] {
        let log = Log::from(small_log());
        let mut settings = log.settings();
        // Most of the tenth that the odometry claims too much is known.
        let calibration = [("odometry.left", -0.07), ("odometry.right", -0.07)];
        settings.take(&SCOPE, calibration).unwrap();
        settings.slam.prior_map = PriorMap::of_faces(&faces, 0.01, &Pose2::identity());
        settings.slam.prior_map_matching = matching;
        let mut replay = Replay::new(log, Method::PriorMap, &settings).unwrap();
        while replay.step().unwrap() {}
        let x = replay.session().estimate().pose.x();
        assert!((x - 1.95).abs() < 0.02, "{matching:?}: {x}");
    }
}

#[test]
fn what_cannot_be_found_in_a_prior_map_is_said() {
    let log = Log::from(small_log());
    let settings = log.settings();
    let error = Replay::new(log.clone(), Method::PriorMap, &settings).unwrap_err();
    assert!(matches!(error, ReplayError::Slam(_)), "{error}");
    let Log::Carmen(carmen) = &log else {
        panic!("another log");
    };
    let scans = carmen.scans.iter().map(|scan| {
        let scan = carmen.scan(scan);
        (scan.stamp.0, FromBridge::Scan(ScanBody::new(0, &scan)))
    });
    let scans: Vec<_> = scans.collect();
    let carried = Recording::parse(&fixture::write(&scans)).unwrap();
    let error = Replay::new(carried.clone(), Method::PriorMap, &settings).unwrap_err();
    assert_eq!(error, ReplayError::NoOdometry);
    let mut replay = Replay::new(carried, Method::LineEkf, &settings).unwrap();
    assert_eq!(replay.session().slam().method(), Method::ScanMatching);
    assert!(replay.take_notes()[0].contains("scan matching"));
}

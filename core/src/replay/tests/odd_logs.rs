//! Logs as other recorders write them, and as they should not be.
//!
//! A robot drives 2 m along a room of 8 m x 4 m, its laser at its centre.

use super::*;
use crate::format::carmen::BeamFan;
use crate::geom::Length;

const SCANS: u32 = 40;

/// A message of the drive, as a recorder may write it.
struct Message {
    beams: usize,
    odometry: [f64; 3],
    seconds: f64,
}

/// Where the robot is.
fn x_of(scan: u32) -> f64 {
    0.05 * f64::from(scan)
}

fn well(scan: u32) -> Message {
    Message {
        beams: 180,
        odometry: [x_of(scan), 0.0, 0.0],
        seconds: f64::from(scan),
    }
}

fn log(message: impl Fn(u32) -> Message) -> String {
    let line = |scan: u32| {
        let Message {
            beams,
            odometry: [x, y, heading],
            seconds,
        } = message(scan);
        let fan = BeamFan::half_circle(beams);
        let range = |beam: usize| {
            let (sin, cos) = crate::geom::sin_cos(fan.first + beam as f64 * fan.step);
            let ahead = (5.0 - x_of(scan)) / cos.max(1e-9);
            format!("{:.3} ", ahead.min(2.0 / sin.abs().max(1e-9)))
        };
        let ranges: String = (0..beams).map(range).collect();
        let pose = format!("{x} {y} {heading}");
        format!("FLASER {beams} {ranges}{pose} {pose} {seconds} host 0\n")
    };
    (0..SCANS).map(line).collect()
}

fn by_matching(text: &str) -> Replay {
    let log = CarmenLog::parse(text.as_bytes()).unwrap();
    replay(log, Method::ScanMatching)
}

/// The last pose is right, whatever happened before.
#[track_caller]
fn check(text: &str) {
    let trajectory = by_matching(text).trajectory();
    assert_eq!(trajectory.len(), SCANS as usize);
    let (_, last) = trajectory[trajectory.len() - 1];
    let off = last.position() - Pose2::new(x_of(SCANS - 1), 0.0, 0.0).position();
    assert!(off.length() < 0.03, "off by {off:?}");
    assert!(last.heading().abs() < 0.01, "{}", last.heading());
}

#[test]
fn the_number_of_beams_may_change_on_the_way() {
    check(&log(|scan| Message {
        beams: [180, 361, 90, 181][scan as usize % 4],
        ..well(scan)
    }));
}

/// As from a recorder that was restarted.
#[test]
fn odometry_that_leaps_does_not_take_the_robot_along() {
    let (sin, cos) = crate::geom::sin_cos(1.0);
    check(&log(|scan| match scan {
        20.. => Message {
            odometry: [300.0 + cos * x_of(scan), sin * x_of(scan) - 200.0, 1.0],
            ..well(scan)
        },
        _ => well(scan),
    }));
}

#[test]
fn odometry_that_leaps_to_and_fro_does_not_take_the_robot_along() {
    check(&log(|scan| match scan % 10 {
        5 => Message {
            odometry: [x_of(scan) + 40.0, 7.0, 2.0],
            ..well(scan)
        },
        _ => well(scan),
    }));
}

#[test]
fn an_hour_may_pass_between_two_scans() {
    check(&log(|scan| match scan {
        20.. => Message {
            seconds: 3600.0 + f64::from(scan),
            ..well(scan)
        },
        _ => well(scan),
    }));
}

#[test]
fn all_stamps_may_be_the_same() {
    check(&log(|scan| Message {
        seconds: 7.0,
        ..well(scan)
    }));
}

#[test]
fn stamps_may_run_backwards() {
    check(&log(|scan| Message {
        seconds: f64::from(scan) - if scan % 7 == 3 { 2.5 } else { 0.0 },
        ..well(scan)
    }));
}

#[test]
fn a_log_without_odometry_is_mapped_and_said_to_be_one() {
    let text = log(|scan| Message {
        odometry: [0.0; 3],
        ..well(scan)
    });
    check(&text);
    let parsed = Log::from(CarmenLog::parse(text.as_bytes()).unwrap());
    assert!(!parsed.has_odometry());
    let settings = parsed.settings();
    let mut replay = Replay::new(parsed, Method::LineEkf, &settings).unwrap();
    assert!(replay.take_notes()[0].contains("No robot"));
}

/// Beams without a measurement say nothing, and a scan without a pose is left out: the rest is
/// mapped.
#[test]
fn ranges_and_poses_that_are_none_are_told_and_the_log_is_mapped() {
    let text: String = log(well)
        .lines()
        .enumerate()
        .map(|(at, line)| {
            let mut words: Vec<&str> = line.split(' ').collect();
            for beam in (at % 7..180).step_by(7) {
                words[2 + beam] = ["nan", "inf", "-1.0"][beam % 3];
            }
            if at == 5 {
                words[182] = "nan";
            }
            words.join(" ") + "\n"
        })
        .collect();
    let mut replay = by_matching(&text);
    let trajectory = replay.trajectory();
    assert_eq!(trajectory.len(), SCANS as usize - 1);
    let (_, last) = trajectory[trajectory.len() - 1];
    let off = last.position() - Pose2::new(x_of(SCANS - 1), 0.0, 0.0).position();
    assert!(off.length() < 0.03, "off by {off:?}");
    let notes = replay.take_notes();
    assert!(notes[0].contains("ranges are no measurements"), "{notes:?}");
    assert!(notes[0].contains("line 1: field 3"), "{notes:?}");
    assert!(notes[1].contains("line 6: field 183"), "{notes:?}");
    // Not free space either: nothing was mapped behind the walls, at x from -3 to 5.
    let grid = replay.session().slam().grid();
    let outside = [6.0, 7.0, 10.0].map(|x| grid.log_odds(grid.cell_at(Point2::new(x, 0.0))));
    assert_eq!(outside, [0.0; 3]);
}

#[test]
fn parameters_of_others_are_passed_over() {
    let others = "PARAM\nPARAM robot_name\nPARAM laser_front_laser_resolution\t0.5 deg 1 2 3 4\n\
        PARAM a=b;c=\"d e\" [1,2] 0 nohost nan\nPARAM robot_length 1e999 0 host 0\n# PARAM \u{fc}\n";
    check(&(others.to_owned() + &log(well)));
    check(&(log(well) + others));
}

/// No pose is expected, because nothing was seen.
#[test]
fn scans_that_see_nothing_break_nothing() {
    for reading in ["0.0", "81.83"] {
        let ranges = format!("{reading} ").repeat(180);
        let line = |scan: u32| {
            let x = x_of(scan);
            format!("FLASER 180 {ranges}{x} 0 0 {x} 0 0 {scan} host 0\n")
        };
        let blind: String = (0..SCANS).map(line).collect();
        let trajectory = by_matching(&blind).trajectory();
        assert_eq!(trajectory.len(), SCANS as usize);
        assert!(trajectory.iter().all(|(_, pose)| pose.x().is_finite()));
    }
    let text = log(well);
    let first = text.lines().next().unwrap();
    assert_eq!(by_matching(first).trajectory().len(), 1);
}

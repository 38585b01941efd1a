//! The drive of `tests/interop/ros_files.py`, whose beams end on four known walls: an error in the
//! mount, the order of beams, a stamp or the motion between two poses moves the walls.

use nalgebra::Point2;

use super::*;
use crate::format::ros::RosReader;
use crate::geom::{Length, Pose2, unit_vector};
use crate::replay::feed::{Feed, Step};
use crate::replay::{Log, LogError, LogReader, Replay};
use crate::settings::LogSettings;
use crate::slam::Method;

const PLAIN_BAG: &[u8] = include_bytes!("../../format/ros/files/plain.bag");
const BZ2_BAG: &[u8] = include_bytes!("../../format/ros/files/bz2.bag");
const LZ4_BAG: &[u8] = include_bytes!("../../format/ros/files/lz4.bag");
const ZSTD_MCAP: &[u8] = include_bytes!("../../format/ros/files/zstd.mcap");
const LZ4_MCAP: &[u8] = include_bytes!("../../format/ros/files/lz4.mcap");
const TWO_MCAP: &[u8] = include_bytes!("../../format/ros/files/two.mcap");

/// The walls: least x, least y, most x, most y, in the frame where the robot began, m.
const ROOM: [f64; 4] = [-1.0, -1.5, 5.0, 2.5];

fn read(bytes: &[u8]) -> RosLog {
    let mut reader = RosReader::default();
    reader.push(bytes).unwrap();
    reader.finish().unwrap()
}

fn import(
    bytes: &[u8],
    scans: Option<&str>,
    odometry: Option<&str>,
) -> Result<Imported, ImportError> {
    let choice = RosChoice {
        scans: scans.map(str::to_owned),
        odometry: odometry.map(str::to_owned),
    };
    import_ros(&read(bytes), &choice)
}

fn steps(recording: Recording) -> Vec<Step> {
    let log = Log::from(recording);
    let mut feed = Feed::of(&log, &LogSettings::default());
    let robot = RobotModel::pioneer();
    std::iter::from_fn(|| feed.next(&log, &robot)).collect()
}

/// The true pose of the robot, s after the beginning.
fn truth(seconds: f64) -> Pose2 {
    let heading = 0.25 * seconds;
    let radius = 0.4 / 0.25;
    Pose2::new(
        radius * libm::sin(heading),
        radius * (1.0 - libm::cos(heading)),
        heading,
    )
}

/// How far the beams of a drive end from the walls, at most, from the true poses; how far the poses
/// of the odometry are from the truth; and how many beams hit.
fn worst(steps: &[Step]) -> (f64, f64, usize) {
    let seconds = |micros: f64| micros - 1_700_000_000.0;
    let (mut off, mut drift, mut hits) = (0.0_f64, 0.0_f64, 0);
    let begin = truth(seconds(steps[0].scan.stamp.seconds()));
    let first = steps[0].odom_from_robot;
    for step in steps {
        let scan = &step.scan;
        let last = truth(seconds(scan.stamp.seconds()));
        let moved = first.delta_to(&step.odom_from_robot);
        let apart = (begin * moved).delta_to(&last);
        drift = drift.max(apart.position().coords.length() + apart.heading().abs());
        for beam in 0..scan.len() {
            let range = f64::from(scan.ranges[beam]);
            if !range.is_finite() {
                continue;
            }
            let at = truth(seconds(scan.taken_at(beam).seconds()));
            let ray = unit_vector(scan.bearings[beam]) * range;
            let end = at * scan.robot_from_sensor * Point2::from(ray);
            let [x0, y0, x1, y1] = ROOM;
            let gaps = [end.x - x0, end.y - y0, x1 - end.x, y1 - end.y];
            let nearest = gaps
                .iter()
                .map(|gap| gap.abs())
                .fold(f64::INFINITY, f64::min);
            off = off.max(nearest);
            hits += 1;
        }
    }
    (off, drift, hits)
}

#[test]
fn beams_of_all_files_end_on_the_walls_of_the_room() {
    for bytes in [PLAIN_BAG, BZ2_BAG, LZ4_BAG, ZSTD_MCAP, LZ4_MCAP] {
        let imported = import(bytes, None, None).unwrap();
        let text = imported.notes.join("\n");
        assert!(
            text.contains("25 scans of /scan") && text.contains("upside down"),
            "{text}"
        );
        let steps = steps(imported.recording);
        assert_eq!(steps.len(), 25);
        let (off, drift, hits) = worst(&steps);
        assert!(off < 1e-3, "beams end {off} m beside the walls");
        assert!(drift < 1e-3, "poses are {drift} off");
        // Five of each scan were spoilt: infinite, NaN, too near, zero, negative infinite.
        assert_eq!(hits, 25 * 85);
        let scan = &steps[0].scan;
        let is_no_return = |range: &&f32| **range == f32::INFINITY;
        assert_eq!(scan.ranges.iter().filter(is_no_return).count(), 1);
        assert_eq!(scan.ranges.iter().filter(|range| range.is_nan()).count(), 4);
        assert!((scan.sweep - 0.12).abs() < 1e-6);
    }
}

#[test]
fn of_two_lidars_one_has_to_be_chosen() {
    let log = read(TWO_MCAP);
    let offer = RosOffer::of(&log).unwrap();
    let names: Vec<&str> = offer
        .scans
        .iter()
        .map(|scans| scans.name.as_str())
        .collect();
    assert!(
        offer.must_ask && names == ["/scan", "/rear/scan"],
        "{offer:?}"
    );
    assert!(
        offer.scans[1]
            .words
            .contains("25 scans of 90 beams in frame `rear`")
    );
    let error = import(TWO_MCAP, None, None).unwrap_err().to_string();
    assert!(
        error.contains("/rear/scan") && error.contains("choose one"),
        "{error}"
    );
    let error = import(TWO_MCAP, Some("/left"), None)
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("`/left`") && error.contains("/rear/scan"),
        "{error}"
    );
    for topic in ["/scan", "/rear/scan", "rear/scan"] {
        let (off, ..) = worst(&steps(
            import(TWO_MCAP, Some(topic), None).unwrap().recording,
        ));
        assert!(off < 1e-3, "{topic}: {off}");
    }
    let without = import(TWO_MCAP, Some("/scan"), Some("none")).unwrap();
    assert!(!without.recording.has_odometry());
}

#[test]
fn odometry_may_be_a_transform() {
    let log = read(LZ4_MCAP);
    let offer = RosOffer::of(&log).unwrap();
    assert!(!offer.must_ask);
    assert_eq!(offer.odometry[0].name, "tf:odom:base_link");
    let imported = import(LZ4_MCAP, None, Some("tf:odom:base_link")).unwrap();
    assert!(imported.recording.has_odometry());
}

#[test]
fn the_recording_reads_back_from_its_file() {
    let imported = import(PLAIN_BAG, None, None).unwrap();
    let back = Recording::parse(&imported.recording.write().unwrap()).unwrap();
    assert_eq!(back.damage(), &[]);
    let all = |recording: &Recording| recording.messages().collect::<Vec<_>>();
    // Compared as text, because NaN does not equal itself.
    let (back, imported) = (all(&back), all(&imported.recording));
    assert!(format!("{back:?}") == format!("{imported:?}"));
}

#[test]
fn what_was_cut_off_before_its_first_scan_says_both() {
    let error = import(&BZ2_BAG[..4500], None, None).unwrap_err();
    assert!(matches!(error, ImportError::NoScanLeft { .. }), "{error}");
    let text = error.to_string();
    assert!(
        text.contains("holds no scan") && text.contains("cut off"),
        "{text}"
    );
    // The same for the imported recording, wherever it is cut.
    let whole = import(PLAIN_BAG, None, None).unwrap().recording;
    let whole = whole.write().unwrap();
    let errors: Vec<LogError> = (100..whole.len())
        .step_by(20)
        .filter_map(|cut| {
            let mut reader = LogReader::default();
            let read = reader.push(&whole[..cut]);
            read.and_then(|()| reader.finish().map(drop)).err()
        })
        .collect();
    let is_told = |error: &&LogError| {
        let text = error.to_string();
        text.contains("holds no scan") && text.contains("cut off")
    };
    assert!(errors.iter().any(|error| is_told(&error)), "{errors:?}");
    assert!(!errors.contains(&LogError::NoScan));
}

#[test]
fn it_is_mapped() {
    let imported = import(PLAIN_BAG, None, None).unwrap();
    let log = Log::from(imported.recording);
    let settings = log.settings();
    let mut replay = Replay::new(log, Method::ScanMatching, &settings).unwrap();
    while replay.step().unwrap() {}
    let trajectory = replay.trajectory();
    assert_eq!(trajectory.len(), 25);
    let (begin, end) = (trajectory[0], trajectory[24]);
    let seconds = |time: f64| time - 1_700_000_000.0;
    let moved = begin.1.delta_to(&end.1);
    let truly = truth(seconds(begin.0)).delta_to(&truth(seconds(end.0)));
    let apart = moved.delta_to(&truly);
    assert!(apart.position().coords.length() < 0.03, "{apart:?}");
}

/// Changes scans and poses of the file before it is imported.
fn spoilt(spoil: impl FnOnce(&mut RosLog)) -> Result<Imported, ImportError> {
    let mut log = read(PLAIN_BAG);
    spoil(&mut log);
    import_ros(&log, &RosChoice::default())
}

fn note(imported: &Imported, part: &str) {
    let text = imported.notes.join("\n");
    assert!(text.contains(part), "{text}");
}

#[test]
fn a_lidar_with_a_clock_of_its_own_is_put_on_that_of_the_robot() {
    let imported = spoilt(|log| {
        for scan in log.scans_mut() {
            scan.stamp -= 3_600_000_000_000;
        }
    })
    .unwrap();
    note(&imported, "clock of the lidar differs");
    // The scans were recorded 0.13 s after their first beam, the poses at once. In that time the
    // robot turns by 0.03 rad, which is 0.16 m at the far wall.
    let (off, ..) = worst(&steps(imported.recording));
    assert!(off < 0.2, "{off}");
}

#[test]
fn a_clock_that_is_set_back_gives_way_to_the_times_of_recording() {
    let imported = spoilt(|log| {
        for scan in &mut log.scans_mut()[12..] {
            scan.stamp -= 5_000_000_000;
        }
    })
    .unwrap();
    note(&imported, "goes back by");
    assert_eq!(steps(imported.recording).len(), 25);
}

#[test]
fn a_second_drive_in_the_same_file_is_left_out() {
    let imported = spoilt(|log| {
        for scan in &mut log.scans_mut()[12..] {
            scan.stamp -= 3_000_000_000;
            scan.recorded -= 3_000_000_000;
        }
    })
    .unwrap();
    note(&imported, "another drive begins there");
    assert_eq!(steps(imported.recording).len(), 12);
}

#[test]
fn an_odometry_that_is_reset_says_nothing_of_that_time() {
    let imported = spoilt(|log| {
        for pose in &mut log.odometry_mut()[150..] {
            pose.parent_from_child.translation.vector.x += 40.0;
        }
    })
    .unwrap();
    note(&imported, "The odometry jumps 1 times");
    let steps = steps(imported.recording);
    assert!(steps.len() >= 24);
    assert_eq!(steps.iter().filter(|step| step.is_after_gap).count(), 1);
    let far = steps.iter().flat_map(|step| &step.odometry);
    assert!(far.map(|motion| motion.motion.x().abs()).all(|x| x < 0.2));
}

#[test]
fn sweeps_that_cannot_last_so_long_are_not_believed() {
    let imported = spoilt(|log| {
        for scan in log.scans_mut() {
            scan.scan.time_increment = 0.1;
        }
    })
    .unwrap();
    note(&imported, "time_increment");
    assert_eq!(steps(imported.recording)[3].scan.sweep, 0.0);
}

#[test]
fn beams_that_are_taken_backwards_in_time_are_turned_round() {
    let imported = spoilt(|log| {
        for scan in log.scans_mut() {
            let scan = &mut scan.scan;
            scan.ranges.reverse();
            scan.time_increment = -scan.time_increment;
            (scan.angle_min, scan.angle_increment) = (scan.angle_max, -scan.angle_increment);
        }
    })
    .unwrap();
    // Reversed in the list and in time: the same beams at the same times as before.
    let (plain, turned) = (import(PLAIN_BAG, None, None).unwrap(), imported);
    let ranges = |imported: Imported| {
        let steps = steps(imported.recording);
        let bits = steps
            .iter()
            .flat_map(|step| &step.scan.ranges)
            .map(|range| range.to_bits());
        bits.collect::<Vec<u32>>()
    };
    assert_eq!(ranges(plain), ranges(turned));
}

#[test]
fn a_lidar_that_looks_at_the_floor_is_refused_by_name() {
    let tilt = |angle: f64| {
        spoilt(move |log| {
            let laser = log.frame_number("laser").unwrap();
            let turn = nalgebra::UnitQuaternion::from_euler_angles(0.0, angle, 0.0);
            for pose in log.transforms_mut() {
                if pose.child == laser {
                    pose.parent_from_child.rotation = turn;
                }
            }
        })
    };
    let error = tilt(0.6).unwrap_err().to_string();
    assert!(
        error.contains("`laser` is tilted by 34° against `base_link`"),
        "{error}"
    );
    let tilted = tilt(0.1).unwrap();
    note(&tilted, "tilted by 5.7°");
    // Straight ahead a beam is shortened by the cosine, sideways it is not.
    let scan = &steps(tilted.recording)[0].scan;
    let ahead = scan
        .bearings
        .iter()
        .position(|bearing| bearing.abs() < 0.03)
        .unwrap();
    let log = read(PLAIN_BAG);
    let as_sent = f64::from(log.scans()[0].scan.ranges[ahead]);
    let part = f64::from(scan.ranges[ahead]) / as_sent;
    assert!((part - libm::cos(0.1)).abs() < 1e-4, "{part}");
}

#[test]
fn a_file_without_transforms_is_mapped_and_it_is_said_what_was_assumed() {
    let imported = spoilt(|log| log.transforms_mut().clear()).unwrap();
    note(&imported, "`base_link` to `laser`");
    note(&imported, "in the middle of the robot");
    assert_eq!(
        steps(imported.recording)[0].scan.robot_from_sensor,
        Pose2::identity()
    );
}

#[test]
fn files_that_hold_nothing_to_map_say_what_they_hold() {
    let error = spoilt(|log| log.scans_mut().clear())
        .unwrap_err()
        .to_string();
    assert!(error.contains("/odom (nav_msgs/Odometry)"), "{error}");
    let error = spoilt(|log| {
        for scan in log.scans_mut() {
            scan.scan.ranges.clear();
        }
    })
    .unwrap_err()
    .to_string();
    assert!(error.contains("25 scans have no beams"), "{error}");
}

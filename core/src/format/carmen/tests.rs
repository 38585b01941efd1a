//! Small logs written by hand, and damaged ones.

use proptest::prelude::*;

use super::reader::MAX_LINE;
use super::*;
use crate::geom::Length;

fn flaser(ranges: &[f64], pose: (f64, f64, f64), seconds: f64) -> String {
    let words: Vec<_> = ranges.iter().map(|r| format!("{r:.2}")).collect();
    let (x, y, t) = pose;
    format!(
        "FLASER {} {} {x:.6} {y:.6} {t:.6} {x:.6} {y:.6} {t:.6} {seconds:.6} nohost {seconds:.6}\n",
        ranges.len(),
        words.join(" ")
    )
}

fn small_log() -> String {
    let mut text = String::from("# comment \u{e9}\nPARAM robot_frontlaser_offset 0.0 nohost 0\n");
    text += "PARAM slamlab_sweep -0.25 nohost 0\n";
    for i in 0..6 {
        let x = f64::from(i);
        text += &format!("ODOM {x} 0 0 0 0 0 {x}.5 nohost {x}.5\n");
        text += &flaser(&[1.0, 2.0, 81.83, 0.0], (x, 0.0, 0.1), 100.0 - x);
    }
    text
}

fn message(bytes: &[u8]) -> String {
    CarmenLog::parse(bytes).unwrap_err().to_string()
}

#[test]
fn scans_come_sorted_by_ipc_time_with_their_odometry() {
    let log = CarmenLog::parse(small_log().as_bytes()).unwrap();
    assert_eq!(log.scans.len(), 6);
    assert!(
        log.scans
            .windows(2)
            .all(|w| w[0].ipc_seconds < w[1].ipc_seconds)
    );
    assert!((log.scans[0].odom_from_robot.x() - 5.0).abs() < 1e-12);
    assert!((log.duration() - 5.0).abs() < 1e-9);
    let scan = log.scan(&log.scans[1]);
    assert_eq!(scan.validate(), Ok(()));
    assert_eq!(scan.stamp, Stamp(1_000_000));
    // The last of its readings, 0, was taken first.
    assert_eq!((scan.ranges[2], scan.sweep), (2.0, 0.25));
    assert!(scan.ranges[1].is_infinite() && scan.ranges[0].is_nan());
    assert!((scan.bearings[3] + std::f64::consts::FRAC_PI_2).abs() < 1e-12);
    assert_eq!(
        log.params,
        [("robot_frontlaser_offset".to_owned(), "0.0".to_owned())]
    );
}

#[test]
fn any_cut_into_chunks_gives_the_same_log() {
    let text = small_log().replace('\n', "\r\n");
    let whole = CarmenLog::parse(text.as_bytes()).unwrap();
    for size in [1, 2, 7, 100] {
        let mut reader = CarmenReader::default();
        for chunk in text.as_bytes().chunks(size) {
            reader.push(chunk).unwrap();
        }
        let log = reader.finish().unwrap();
        assert_eq!(
            (log.scans, log.readings),
            (whole.scans.clone(), whole.readings.clone())
        );
    }
}

#[test]
fn half_circles_run_from_right_to_left() {
    for (beams, step, last) in [
        (180, 1.0, 89.0),
        (181, 1.0, 90.0),
        (360, 0.5, 89.5),
        (361, 0.5, 90.0),
        (1, 180.0, -90.0),
    ] {
        let fan = BeamFan::half_circle(beams);
        let degrees = |i: usize| (fan.first + i as f64 * fan.step).to_degrees();
        assert!((degrees(0) + 90.0).abs() < 1e-9);
        assert!((fan.step.to_degrees() - step).abs() < 1e-9, "{beams}");
        assert!((degrees(beams - 1) - last).abs() < 1e-9, "{beams}");
    }
}

#[test]
fn laser_offset_is_the_difference_of_the_two_poses() {
    let line = "FLASER 1 2.0 -2.994295 8.292039 -3.120965 -3.034287 8.291214 -3.120965 1211.52 magnum 0.01\n";
    let log = CarmenLog::parse(line.as_bytes()).unwrap();
    let offset = log.scans[0].robot_from_sensor;
    assert!((offset.x() + 0.04).abs() < 1e-4 && offset.y().abs() < 1e-4);
    assert!(offset.heading().abs() < 1e-9);
}

#[test]
fn robotlaser_says_its_own_fan_and_limit() {
    let line = "ROBOTLASER1 0 -1.5 3.0 1.5 30.0 0.01 0 3 1.0 2.0 30.0 0 0.1 0 0 0 0 0 0.2 0.1 1 1 0 7.5 host 0.1";
    let log = CarmenLog::parse(line.as_bytes()).unwrap();
    assert_eq!(log.laser, Laser::Robot1);
    let scan = log.scan(&log.scans[0]);
    assert_eq!(scan.bearings, [-1.5, 0.0, 1.5]);
    assert!(scan.ranges[2].is_infinite());
    assert!((scan.robot_from_sensor.x() - 0.1).abs() < 1e-12);
    assert!((log.scans[0].ipc_seconds - 7.5).abs() < 1e-12);
}

#[test]
fn the_largest_reading_is_a_code_when_it_is_repeated() {
    let mut text = String::new();
    for i in 0..50 {
        text += &flaser(&[1.0, 2.0, 7.99, 8.0], (0.0, 0.0, 0.0), f64::from(i));
    }
    let log = CarmenLog::parse(text.as_bytes()).unwrap();
    assert!(log.no_return_from > 7.98 && log.no_return_from <= 8.0);
}

#[test]
fn comments_and_parameters_may_be_in_any_encoding() {
    let good = flaser(&[1.0, 2.0], (0.0, 0.0, 0.0), 1.0);
    for line in [
        "PARAM robot_name T\u{fc}bingen\n".as_bytes(),
        b"PARAM map_name caf\xe9\n",
        b"# \xff\n",
    ] {
        let log = CarmenLog::parse(&[line, good.as_bytes()].concat()).unwrap();
        assert_eq!(log.scans.len(), 1);
    }
    let other = [b"ODOM \xe9\n", good.as_bytes()].concat();
    assert!(message(&other).starts_with("line 1: byte 6 is 0xe9"));
}

#[test]
fn bad_files_are_told_what_where_and_what_was_expected() {
    let good = flaser(&[1.0, 2.0], (0.0, 0.0, 0.0), 1.0);
    assert!(message(b"").starts_with("the file is empty"));
    assert!(message(b" \n\n").starts_with("the file is empty"));
    let jpeg = message(b"\xff\xd8\xff\xe0\x00\x10JFIF\x00\x01");
    assert_eq!(
        jpeg,
        "line 1: byte 1 is 0xff, which is not text; expected a CARMEN log, one message per line"
    );
    assert!(message(b"hello\nworld\n").starts_with("no laser message in 2 lines"));
    let word = message((good.clone() + &good.replace("2.00", "far")).as_bytes());
    assert_eq!(
        word,
        "line 2: field 4 of FLASER is `far`, expected a range in metres, finite and at least 0"
    );
    let short = message((good.replace("FLASER 2", "FLASER 3") + &good).as_bytes());
    assert_eq!(
        short,
        "line 1: the number of fields of FLASER is `13`, expected 14, of 3 readings"
    );
    let cut = format!("{good}{}", &good[..good.len() / 2]);
    let cut = message(cut.as_bytes());
    assert!(
        cut.starts_with("line 2: the file is cut off within its last message"),
        "{cut}"
    );
    let name = message(format!("{good}ROBOTLA").as_bytes());
    assert!(
        name.starts_with("line 2: the file is cut off") && name.contains("\"ROBOTLA\""),
        "{name}"
    );
    assert!(CarmenLog::parse(format!("{good}TRUEPOS 1 2").as_bytes()).is_ok());
    // Numbers so large that their sums and squares overflow; the line is left out.
    let far = flaser(&[1.0], (1e300, 0.0, 0.0), 1.0);
    assert!(message(far.as_bytes()).contains("field 4 of FLASER is `1000"));
    assert!(message(far.as_bytes()).contains("a coordinate in metres, within ±1e9"));
    let turned = flaser(&[1.0], (0.0, 0.0, 1e9), 1.0);
    assert!(message(turned.as_bytes()).contains("an angle in radians"));
    let late = flaser(&[1.0], (0.0, 0.0, 0.0), 1e15);
    assert!(message(late.as_bytes()).contains("a time in seconds"));
    let endless = vec![b'a'; MAX_LINE + 2];
    assert!(message(&endless).contains("longer than"));
}

#[test]
fn what_is_left_out_is_told_with_the_first_line() {
    let good = flaser(&[1.0, 2.0], (0.0, 0.0, 0.0), 1.0);
    let robot =
        "ROBOTLASER1 0 -1.5 3 1.5 nan 0.01 0 2 1 -1 1 nan 0.1 0 0 0 0 0 nan 0 1 1 0 7 h 0\n";
    let text = [
        good.as_str(),
        "ODOM 0 nan 0 0 0 0 1 nohost 1\n",
        "ODOM 0 0 0 nan inf 0 1 nohost 1\n",
        &good.replace("1.00 2.00", "nan -inf"),
        &good.replace("1.000000", "inf"),
        robot,
    ];
    let log = CarmenLog::parse(text.concat().as_bytes()).unwrap();
    assert_eq!(log.scans.len(), 2);
    assert_eq!(
        log.left_out.sentences(),
        [
            "3 ranges are no measurements and were left out. The first: line 4: field 3 of FLASER \
             is `nan`, expected a range in metres, finite and at least 0",
            "2 lines cannot be used and were left out. The first: line 2: field 3 of ODOM is \
             `nan`, expected a coordinate in metres, within ±1e9",
        ]
    );
    let scan = log.scan(&log.scans[1]);
    assert!(scan.ranges.iter().all(|range| range.is_nan()));
    let only = CarmenLog::parse(robot.as_bytes()).unwrap();
    assert_eq!(only.left_out.ranges.count, 1);
    assert!(only.scan(&only.scans[0]).ranges[1].is_nan());
    let whole = CarmenLog::parse(good.as_bytes()).unwrap();
    assert!(whole.left_out.sentences().is_empty());
    // A file of nothing but such lines is not a log.
    let none = message(good.replace("0.000000", "nan").repeat(3).as_bytes());
    assert!(
        none.starts_with("line 1: field 5 of FLASER is `nan`"),
        "{none}"
    );
}

/// What a recorder may write in place of a number.
fn no_number() -> impl Strategy<Value = &'static str> {
    prop_oneof![
        Just("nan"),
        Just("-nan"),
        Just("NaN"),
        Just("inf"),
        Just("-inf"),
        Just("1e400")
    ]
}

proptest! {
    /// A log with invalid ranges and poses equals the log in which those ranges are 0, which means
    /// "not measured", and those lines are missing.
    #[test]
    fn ranges_and_poses_that_are_none_cost_only_themselves(
        lines in proptest::collection::vec(
            (
                proptest::collection::vec(proptest::option::weighted(
                    0.2, prop_oneof![no_number(), Just("-0.5"), Just("-1")],
                ), 4),
                proptest::option::weighted(0.3, (0_usize..7, no_number())),
            ),
            2..12,
        ),
    ) {
        let (mut damaged, mut expected) = (String::new(), String::new());
        let (mut ranges, mut left_out, mut firsts) = (0, 0, [None, None]);
        for (index, (readings, bad)) in lines.iter().enumerate() {
            let mut words = ["1.5", "2.5", "3.5", "4.5", "1", "2", "0.5", "1", "2", "0.5", "7"];
            let mut clean = words;
            for (at, reading) in readings.iter().enumerate() {
                if let Some(word) = *reading {
                    (words[at], clean[at]) = (word, "0");
                }
            }
            if let Some((at, word)) = *bad {
                words[4 + at] = word;
            }
            damaged += &format!("FLASER 4 {} host 0\n", words.join(" "));
            if bad.is_some() {
                left_out += 1;
                firsts[1].get_or_insert(index + 1);
            } else {
                let count = readings.iter().flatten().count();
                ranges += count;
                if count > 0 {
                    firsts[0].get_or_insert(index + 1);
                }
                expected += &format!("FLASER 4 {} host 0\n", clean.join(" "));
            }
        }
        let damaged = CarmenLog::parse(damaged.as_bytes());
        if left_out == lines.len() {
            prop_assert!(matches!(damaged, Err(CarmenError::Field(_))));
            return Ok(());
        }
        let damaged = damaged.unwrap();
        prop_assert_eq!((damaged.left_out.ranges.count, damaged.left_out.lines.count), (ranges, left_out));
        let told = [&damaged.left_out.ranges, &damaged.left_out.lines]
            .map(|tally| tally.first.as_ref().map(|first| first.line));
        prop_assert_eq!(told, firsts);
        let expected = CarmenLog::parse(expected.as_bytes()).unwrap();
        prop_assert_eq!(CarmenLog { left_out: expected.left_out.clone(), ..damaged }, expected);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1000, ..ProptestConfig::default() })]
    #[test]
    fn damaged_logs_never_panic(
        edits in proptest::collection::vec((0.0..1.0_f64, 0_u8..5, any::<u8>()), 1..12),
    ) {
        let mut bytes = small_log().into_bytes();
        for (place, kind, byte) in edits {
            let at = ((bytes.len() as f64 * place) as usize).min(bytes.len().saturating_sub(1));
            match kind {
                0 => { bytes.truncate(at); }
                1 => { if let Some(b) = bytes.get_mut(at) { *b = byte; } }
                2 => { bytes.insert(at.min(bytes.len()), byte); }
                3 => { if !bytes.is_empty() { bytes.remove(at); } }
                _ => { let tail = bytes[at..].to_vec(); bytes.extend(tail); }
            }
        }
        match CarmenLog::parse(&bytes) {
            Ok(log) => for scan in &log.scans { prop_assert_eq!(log.scan(scan).validate(), Ok(())); },
            Err(error) => prop_assert!(!error.to_string().is_empty()),
        }
    }
}

/// A scan in the given directions, with a no-return and an invalid reading.
fn scan_to(bearings: Vec<f64>) -> Scan {
    let count = bearings.len();
    let mut ranges: Vec<f32> = (0..count).map(|i| 1.0 + 0.37 * i as f32).collect();
    if let [_, b, c, ..] = ranges.as_mut_slice() {
        (*b, *c) = (f32::INFINITY, f32::NAN);
    }
    Scan {
        stamp: Stamp::from_seconds(1.5),
        robot_from_sensor: Pose2::new(0.1, -0.02, 0.3),
        bearings,
        ranges,
        sigmas: vec![0.01; count],
        qualities: vec![],
        bearing_sigma: 0.001,
        max_range: 12.0,
        sweep: 0.1,
    }
}

#[test]
fn written_scans_are_read_back() {
    let even = scan_to((0..8).map(|i| -1.0 + 0.25 * f64::from(i)).collect());
    // As a lidar that turns the other way and begins at the back.
    let clockwise = scan_to((0..8).map(|i| 3.0 - 0.75 * f64::from(i)).collect());
    let mut log = CarmenLog::empty();
    for (i, scan) in [&even, &clockwise].into_iter().enumerate() {
        log.push(
            10.25 + i as f64,
            &Pose2::new(0.1 * i as f64, -2.0, 3.0),
            scan,
        );
    }
    log.params
        .push(("robot_length".to_owned(), "0.23".to_owned()));
    let back = CarmenLog::parse(log.write().as_bytes()).unwrap();
    assert_eq!((&back.readings, &back.params), (&log.readings, &log.params));
    for (back, scan) in back.scans.iter().zip(&log.scans) {
        assert_eq!(
            (back.ipc_seconds, back.max_range, back.beams),
            (scan.ipc_seconds, 12.0, 8)
        );
        assert!((back.fan.first - scan.fan.first).abs() < 1e-12);
        let off = back.odom_from_robot.delta_to(&scan.odom_from_robot);
        assert!(off.position().coords.length() < 1e-12 && off.heading().abs() < 1e-12);
        let off = back.robot_from_sensor.delta_to(&scan.robot_from_sensor);
        assert!(off.position().coords.length() < 1e-12 && off.heading().abs() < 1e-12);
    }
    let read = back.scan(&back.scans[0]);
    assert!(
        read.bearings
            .iter()
            .zip(&even.bearings)
            .all(|(a, b)| (a - b).abs() < 1e-12)
    );
    assert!(read.ranges[1].is_infinite() && read.ranges[2].is_nan());
    assert_eq!(
        (read.ranges[0], read.ranges[7]),
        (even.ranges[0], even.ranges[7])
    );
    // Every reading keeps its own direction and its own time, whichever way the lidar turned.
    assert_eq!(back.scans[1].sweep, -0.1);
    assert_same(&back.scan(&back.scans[1]), &clockwise);
}

/// The beams of a scan that was read are those that were written, in the same order.
fn assert_same(read: &Scan, written: &Scan) {
    assert_eq!((read.sweep, read.len()), (written.sweep, written.len()));
    for (a, b) in read.bearings.iter().zip(&written.bearings) {
        assert!(crate::geom::wrap(a - b).abs() < 1e-9, "{a} {b}");
    }
    for (a, b) in read.ranges.iter().zip(&written.ranges) {
        assert!(a == b || (a.is_nan() && b.is_nan()), "{a} {b}");
    }
}

proptest! {
    #[test]
    fn a_log_of_our_own_comes_back_as_it_was(
        scans in proptest::collection::vec(
            (2_usize..30, -3.0..3.0_f64, 0.01..0.2_f64, any::<bool>(), prop_oneof![Just(0.0), 0.0..0.9_f64]),
            1..6,
        ),
    ) {
        let mut log = CarmenLog::empty();
        let written: Vec<Scan> = scans
            .into_iter()
            .map(|(beams, first, step, falls, sweep)| {
                // Beams that were all taken at once have no order.
                let step = if falls && sweep > 0.0 { -step } else { step };
                let bearing = |i| crate::geom::wrap(first + i as f64 * step);
                Scan { sweep, ..scan_to((0..beams).map(bearing).collect()) }
            })
            .collect();
        for (second, scan) in (0_u8..).zip(&written) {
            log.push(f64::from(second), &Pose2::identity(), scan);
        }
        let back = CarmenLog::parse(log.write().as_bytes()).unwrap();
        prop_assert_eq!(back.scans.len(), written.len());
        for (scan, written) in back.scans.iter().zip(&written) {
            assert_same(&back.scan(scan), written);
        }
        prop_assert_eq!(back.write(), CarmenLog::parse(back.write().as_bytes()).unwrap().write());
    }
}

#[test]
fn of_beams_in_no_order_no_sweep_is_told() {
    let mut log = CarmenLog::empty();
    let pose = Pose2::identity();
    log.push(0.0, &pose, &scan_to(vec![0.0, -1.0, 1.0]));
    log.push(1.0, &pose, &scan_to(vec![1.0, 0.1, -1.0]));
    let sweeps: Vec<f64> = log.scans.iter().map(|scan| scan.sweep).collect();
    assert_eq!(sweeps, [0.0, -0.1]);
    // A sweep's duration applies until the next such line.
    let text = log.write() + &flaser(&[1.0, 2.0], (0.0, 0.0, 0.0), 2.0);
    assert_eq!(text.matches("PARAM slamlab_sweep").count(), 1);
}

#[test]
fn a_sweep_that_is_none_is_told() {
    let good = flaser(&[1.0, 2.0], (0.0, 0.0, 0.0), 1.0);
    for value in ["nan", "inf", "1e9", "long", ""] {
        let text = format!("PARAM slamlab_sweep {value}\n{good}");
        let error = message(text.as_bytes());
        let says = format!("line 1: the value of PARAM slamlab_sweep is `{value}`, expected");
        assert!(error.starts_with(&says), "{error}");
    }
}

#[test]
fn uneven_directions_become_even_ones() {
    let mut scan = scan_to(vec![-3.0, -1.5, -1.4, 1.5]);
    scan.ranges = vec![1.0, 2.0, 3.0, 4.0];
    let mut log = CarmenLog::empty();
    log.push(0.0, &Pose2::identity(), &scan);
    // From -3 in steps of 1.5: no beam looks ahead, and of two beams that look right the nearer one
    // counts.
    assert_eq!(log.readings, [1.0, 2.0, 0.0, 4.0]);
    let read = CarmenLog::parse(log.write().as_bytes()).unwrap();
    assert!(read.scan(&read.scans[0]).ranges[2].is_nan());
}

#[test]
fn a_log_of_a_plain_laser_is_written_as_it_was() {
    let log = CarmenLog::parse(small_log().as_bytes()).unwrap();
    let text = log.write();
    assert_eq!(text.matches("FLASER 4 1 2 81.83 0 ").count(), 6);
    let back = CarmenLog::parse(text.as_bytes()).unwrap();
    assert_eq!(
        (back.laser, back.no_return_from, &back.readings),
        (log.laser, log.no_return_from, &log.readings)
    );
}

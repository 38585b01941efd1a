//! The layout printed in the paper, a small room, and laws of reading and writing.

use std::f64::consts::PI;

use proptest::prelude::*;

use super::*;

/// Walls 2 m ahead, 1 m behind, 1.2 m to the left and 1.8 m to the right.
const ROOM: &str = include_str!("room.txt");
const RATE: f64 = 5.0;

fn read(text: &[u8], piece: usize) -> Result<RevolutionLog, TextLogError> {
    let mut reader = RevolutionLogReader::default();
    for piece in text.chunks(piece) {
        reader.push(piece)?;
    }
    reader.finish()
}

fn parse(text: &str) -> Result<RevolutionLog, TextLogError> {
    read(text.as_bytes(), usize::MAX)
}

#[test]
fn the_sample_that_the_paper_prints_is_read_and_written() {
    let line = "S_t:0.50_d:00000.00_q:0|__t:1.34_d:01495.75_q:29|-END-\n";
    let log = parse(line).unwrap();
    let paper = Sample {
        starts: false,
        degrees: 1.34,
        millimetres: 1495.75,
        quality: 29,
    };
    let samples = log.samples(0).unwrap();
    assert_eq!((samples.len(), samples[1]), (2, paper));
    assert!(samples[0].starts);
    assert_eq!(log.write(), line);
    // Blanks, line ends and numbers of digits may vary.
    let other = " S_t: 0.5 _d:0 _q:0 | __t:1.34_d:1495.75_q:29 |\t-END- \r\n";
    assert_eq!(parse(other).unwrap(), log);
}

#[test]
fn points_of_a_room_lie_on_its_walls_and_right_is_right() {
    let log = parse(ROOM).unwrap();
    assert_eq!(log.len(), 3);
    assert!((log.duration(RATE) - 0.6).abs() < 1e-12);
    for index in 0..log.len() {
        let scan = log.scan(index, RATE).unwrap();
        scan.validate().unwrap();
        let beams = scan.bearings.iter().zip(&scan.ranges);
        let mut on_walls = [0; 4];
        for (bearing, range) in beams.filter(|(_, range)| !range.is_nan()) {
            let (sin, cos) = crate::geom::sin_cos(*bearing);
            let (x, y) = (f64::from(*range) * cos, f64::from(*range) * sin);
            let walls = [x - 2.0, x + 1.0, y - 1.2, y + 1.8];
            let off = walls.iter().map(|off| off.abs());
            let (wall, off) = off.enumerate().min_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
            assert!(off < 2e-4, "{index}: {bearing} {range}");
            on_walls[wall] += 1;
        }
        // The third revolution lost most of its samples to the left.
        let least = [3, 3, if index == 2 { 1 } else { 3 }, 3];
        let seen = on_walls
            .iter()
            .zip(least)
            .all(|(points, least)| *points >= least);
        assert!(seen, "{on_walls:?}");
        // The open door, 50° to the right: nothing was measured.
        let door = |bearing: &f64| (bearing + 50.0 * PI / 180.0).abs() < 0.01;
        let at = scan.bearings.iter().position(door).unwrap();
        assert!(scan.ranges[at].is_nan());
        assert_eq!((scan.qualities[at], scan.qualities[0]), (0, 29));
    }
}

#[test]
fn what_was_lost_leaves_the_others_their_instants() {
    let log = parse(ROOM).unwrap();
    let [whole, torn] = [0, 2].map(|index| log.scan(index, RATE).unwrap());
    assert_eq!(log.samples(2).unwrap().len(), 28);
    assert_eq!((whole.len(), torn.len()), (36, 36));
    assert_eq!(whole.stamp, Stamp(200_000));
    assert!((whole.sweep - 0.2 * 35.0 / 36.0).abs() < 1e-12);
    for beam in 0..36 {
        let [a, b] = [&whole, &torn].map(|scan| scan.taken_at(beam).seconds());
        assert!((b - a - 0.4).abs() < 1e-9);
        let lost = (24..32).contains(&beam);
        assert_eq!(
            torn.ranges[beam].is_nan(),
            lost || whole.ranges[beam].is_nan()
        );
        assert!((whole.bearings[beam] - torn.bearings[beam]).abs() < 1e-6);
    }
}

#[test]
fn a_line_that_begins_a_little_before_the_turn_is_whole() {
    let sample = |k: u32| format!("__t:{}_d:1000_q:9|", (359 + k) % 360);
    let line: String = (0..360).map(sample).collect();
    let scan = parse(&(line + "-END-")).unwrap().scan(0, RATE).unwrap();
    assert_eq!(scan.len(), 360);
    assert!((scan.bearings[0] - PI / 180.0).abs() < 1e-6);
}

#[test]
fn what_is_wrong_is_named_with_line_sample_and_field() {
    let check = |text: &str, expected: &str| {
        let error = parse(text).unwrap_err().to_string();
        assert!(error.starts_with(expected), "{error}");
    };
    let good = "S_t:0.5_d:100_q:1|__t:1.5_d:100_q:63|-END-\n";
    let second = |sample: &str| format!("{good}\n# a comment\nS_t:0_d:1_q:1|{sample}|-END-\n");
    let all = [
        ("__t:x_d:1_q:1", "t of sample 2 is `x`, expected degrees"),
        ("__t:1_d:far_q:1", "d of sample 2 is `far`, expected milli"),
        ("__t:360.5_d:1_q:1", "t of sample 2 is `360.5`"),
        ("__t:-1_d:1_q:1", "t of sample 2 is `-1`"),
        ("__t:1_d:100000_q:1", "d of sample 2 is `100000`"),
        ("__t:1_d:1_q:64", "q of sample 2 is `64`, expected a whole"),
        ("__t:1_d:1_q:-1", "q of sample 2 is `-1`"),
        ("__t:1_d:1_q:1.5", "q of sample 2 is `1.5`"),
        (
            "__t:1_d:1",
            "sample 2 is `__t:1_d:1`, expected `__t:DEGREES",
        ),
        ("X_t:1_d:1_q:1", "sample 2 is `X_t:1_d:1_q:1`"),
        ("", "sample 2 is ``"),
    ];
    for (sample, expected) in all {
        check(&second(sample), &format!("line 4: {expected}"));
    }
    check("-END-\n", "line 1: the number of samples is `0`");
    let no_end = good.replace("-END-", "");
    check(
        &no_end,
        "line 1: what follows sample 2 is ``, expected `-END-`, or one more sample",
    );
    let many = "__t:1_d:1_q:1|".repeat(MOST_SAMPLES + 1) + "-END-\n";
    check(&many, "line 1: the number of samples is `more than 8192`");
    check("", "no scan in 0 lines");
    check("# nothing\n", "no scan in 1 lines");
    check("__t:1\u{1}\n", "line 1: byte 6 is 0x01");
}

#[test]
fn samples_that_are_none_cost_only_themselves() {
    let sample = |k: usize| format!("__t:{k}.00_d:01000.00_q:9|");
    let turn = |change: &dyn Fn(usize) -> String| {
        let samples: String = (0..360).map(change).collect();
        samples + "-END-\n"
    };
    let bad = turn(&|k| match k {
        7 => "__t:7_d:nan_q:9|".into(),
        8 => "__t:8_d:-inf_q:9|".into(),
        9 => "__t:9_d:-0.5_q:9|".into(),
        10 => "__t:inf_d:1000_q:9|".into(),
        k => sample(k),
    });
    let lost = turn(&|_| "__t:nan_d:1000_q:9|".into());
    let whole = turn(&sample);
    let log = parse(&[&whole, &lost, &bad].map(String::as_str).concat()).unwrap();
    assert_eq!(log.len(), 2);
    let [good, bad] = [0, 1].map(|index| log.scan(index, RATE).unwrap());
    bad.validate().unwrap();
    // One missing direction is not a gap: nothing is inserted for it.
    assert_eq!((good.len(), bad.len()), (360, 359));
    for (place, beam) in (0..360).filter(|beam| *beam != 10).enumerate() {
        assert!((good.bearings[beam] - bad.bearings[place]).abs() < 1e-6);
        assert_eq!(
            bad.ranges[place].is_nan(),
            (7..10).contains(&beam),
            "{beam}"
        );
    }
    let told = log.left_out.sentences();
    assert!(told[0].starts_with("4 ranges are no"), "{told:?}");
    assert!(
        told[0].contains("line 3: d of sample 8 is `nan`"),
        "{told:?}"
    );
    assert!(told[1].starts_with("1 line cannot"), "{told:?}");
    assert!(
        told[1].contains("line 2: t of sample 1 is `nan`"),
        "{told:?}"
    );
    let error = parse(&lost).unwrap_err().to_string();
    assert!(
        error.starts_with("line 1: t of sample 1 is `nan`"),
        "{error}"
    );
}

/// A file that ends within its last line is reported as cut off; a last line without a line end is
/// complete.
#[test]
fn a_log_that_is_cut_off_in_a_sample_says_so() {
    let good = "S_t:0.5_d:100_q:1|__t:1.5_d:100_q:63|-END-\n";
    let two = good.repeat(2);
    for cut in 1..good.len() - 1 {
        let error = parse(&two[..good.len() + cut]).unwrap_err();
        let text = error.to_string();
        assert!(
            matches!(error, TextLogError::CutOff { line: 2, .. }),
            "{text}"
        );
    }
    for whole in [good.len(), two.len() - 1] {
        assert!(parse(&two[..whole]).is_ok());
    }
}

#[test]
fn a_scan_becomes_a_revolution_and_comes_back() {
    let bearings: Vec<f64> = (0..90).map(|k| wrap(-0.07 * f64::from(k))).collect();
    let scan = Scan {
        stamp: Stamp(7),
        robot_from_sensor: Pose2::identity(),
        ranges: (0..90_u8)
            .map(|k| match k {
                3 => f32::NAN,
                4 => f32::INFINITY,
                5 => 120.0,
                k => 0.5 + 0.1 * f32::from(k),
            })
            .collect(),
        sigmas: vec![0.01; 90],
        qualities: vec![],
        bearing_sigma: 0.0,
        max_range: 12.0,
        sweep: 0.1,
        bearings,
    };
    let mut log = RevolutionLog::default();
    log.push(&scan);
    let nothing = Scan {
        bearings: vec![],
        ranges: vec![],
        ..scan.clone()
    };
    log.push(&nothing);
    log.push(&Scan {
        qualities: vec![200; 90],
        ..scan.clone()
    });
    assert_eq!(log.len(), 2);
    assert!(log.samples(1).unwrap()[0].starts && !log.samples(1).unwrap()[1].starts);
    let again = log.scan(0, RATE).unwrap();
    assert_eq!(again.len(), 90);
    for beam in 0..90 {
        let off = wrap(again.bearings[beam] - scan.bearings[beam]);
        assert!(off.abs() <= 0.0051 * PI / 180.0, "{beam}: {off}");
        let [range, before] = [&again, &scan].map(|scan| scan.ranges[beam]);
        match beam {
            3..=5 => assert!(range.is_nan()),
            _ => assert!((range - before).abs() < 6e-6, "{range} {before}"),
        }
        let quality = if (3..=5).contains(&beam) {
            0
        } else {
            MOST_QUALITY
        };
        assert_eq!(again.qualities[beam], quality);
    }
}

fn sample() -> impl Strategy<Value = Sample> {
    let degrees = prop_oneof![
        0.0..=360.0_f32,
        Just(0.0),
        Just(360.0),
        Just(f32::MIN_POSITIVE)
    ];
    let distance = prop_oneof![0.0..100_000.0_f32, Just(0.0), Just(1e-40), Just(99_999.99)];
    let parts = (any::<bool>(), degrees, distance, 0..=MOST_QUALITY);
    parts.prop_map(|(starts, degrees, millimetres, quality)| Sample {
        starts,
        degrees,
        millimetres,
        quality,
    })
}

fn log() -> impl Strategy<Value = RevolutionLog> {
    let line = proptest::collection::vec(sample(), 1..40);
    proptest::collection::vec(line, 1..6).prop_map(|lines| {
        let mut log = RevolutionLog::default();
        for line in lines {
            log.samples.extend(line);
            log.ends.push(log.samples.len());
        }
        log
    })
}

proptest! {
    #[test]
    fn what_is_written_reads_the_same_to_the_bit_however_it_is_cut(
        log in log(), piece in 1..200_usize,
    ) {
        let text = log.write();
        let again = read(text.as_bytes(), piece);
        prop_assert_eq!(again.as_ref(), Ok(&log));
        for index in 0..log.len() {
            prop_assert!(log.scan(index, RATE).unwrap().validate().is_ok());
        }
    }

    #[test]
    fn any_bytes_are_a_log_or_an_error_and_the_same_however_they_are_cut(
        edits in proptest::collection::vec((0.0..1.0_f64, 0_u8..3, any::<u8>()), 0..6),
        piece in 1..200_usize,
    ) {
        let mut bytes = ROOM.as_bytes().to_vec();
        for (place, kind, byte) in edits {
            let at = (bytes.len() as f64 * place) as usize;
            match (kind, bytes.get_mut(at)) {
                (0, _) => bytes.truncate(at),
                (1, Some(old)) => *old = byte,
                _ => bytes.insert(at, byte),
            }
        }
        prop_assert_eq!(read(&bytes, piece), read(&bytes, usize::MAX));
    }
}

/// Lines with the longest numbers and the most samples allowed.
#[test]
fn whatever_was_read_is_written_in_lines_that_are_read_again() {
    let sample = Sample {
        starts: true,
        degrees: f32::from_bits(1),
        millimetres: f32::from_bits(3),
        quality: 63,
    };
    let log = RevolutionLog {
        samples: vec![sample; MOST_SAMPLES],
        ends: vec![MOST_SAMPLES],
        left_out: LeftOut::default(),
    };
    assert_eq!(parse(&log.write()), Ok(log));
}

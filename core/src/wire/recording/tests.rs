use mcap::WriteOptions;

use super::super::message::{
    BatteryBody, Format, FromBridge, Header, Notice, OdometryBody, ScanBody, Severity, encode,
};
use super::*;
use crate::geom::Pose2;
use crate::robot::{Odometry, Scan, Stamp};

fn odometry(at: u64) -> FromBridge {
    let mut odometry = Odometry::standing(Stamp(at));
    odometry.motion = Pose2::new(0.01, 0.0, 0.002);
    FromBridge::Odometry(OdometryBody::new(0, &odometry))
}

fn scan(at: u64) -> FromBridge {
    let beams = 40;
    FromBridge::Scan(ScanBody::new(
        1,
        &Scan {
            stamp: Stamp(at),
            robot_from_sensor: Pose2::identity(),
            bearings: (0..beams).map(|beam| f64::from(beam) * 0.1).collect(),
            ranges: (0..beams).map(|beam| 1.0 + beam as f32 * 0.05).collect(),
            sigmas: vec![0.01; beams as usize],
            qualities: vec![],
            bearing_sigma: 0.0,
            max_range: 6.0,
            sweep: 0.1,
        },
    ))
}

/// 30 messages of several kinds.
fn drive() -> Vec<(u64, FromBridge)> {
    let message = |i: u64| match i % 5 {
        0 => scan(10_000 * i),
        1 => FromBridge::Battery(BatteryBody {
            source: 0,
            stamp: i,
            volts: 7.0,
        }),
        2 => FromBridge::Notice(Notice {
            severity: Severity::Info,
            text: format!("event {i}"),
        }),
        _ => odometry(10_000 * i),
    };
    (0..30).map(|i| (10_000 * i, message(i))).collect()
}

/// Bridge time and message of everything that can be read.
fn readable(recording: &Recording) -> Vec<(u64, FromBridge)> {
    let said = recording.messages().filter_map(Result::ok);
    said.map(|recorded| match recorded.said {
        Said::ByBridge(message) => (recorded.header.micros, message),
        Said::ToRobot(order) => panic!("{order:?}"),
    })
    .collect()
}

#[test]
fn every_message_comes_back_whatever_the_pieces() {
    let file = fixture::write(&drive());
    for piece in [1, 7, 61, 4096, file.len()] {
        let mut reader = RecordingReader::default();
        for bytes in file.chunks(piece) {
            reader.push(bytes).unwrap();
        }
        let recording = reader.finish().unwrap();
        assert_eq!(readable(&recording), drive(), "pieces of {piece}");
        assert_eq!(recording.damage(), []);
        assert_eq!((recording.len(), recording.scans()), (30, 6));
        assert!((recording.duration() - 0.29).abs() < 1e-9 && recording.has_odometry());
    }
}

#[test]
fn chunks_of_other_tools_are_opened() {
    let options = WriteOptions::new().use_chunks(true).chunk_size(Some(700));
    let file = fixture::write_with(options, &drive());
    let recording = Recording::parse(&file).unwrap();
    assert_eq!(readable(&recording), drive());
    assert_eq!(recording.damage(), []);
}

#[test]
fn a_compressed_chunk_is_refused_by_name() {
    let mut content = vec![0; 28];
    content.extend(4_u32.to_le_bytes());
    content.extend(b"zstd");
    content.extend(0_u64.to_le_bytes());
    let mut file = MAGIC.to_vec();
    file.push(6);
    file.extend((content.len() as u64).to_le_bytes());
    file.extend(content);
    let error = Recording::parse(&file).unwrap_err();
    let expect = RecordingError::Compressed {
        offset: 8,
        how: "zstd".into(),
    };
    assert_eq!(error, expect);
}

/// Wherever the file is cut, it can be read up to there, and the damage is reported.
#[test]
fn a_file_that_was_cut_off_reads_up_to_there() {
    let file = fixture::write(&drive());
    let mut most = 0;
    for end in 8..file.len() {
        match Recording::parse(&file[..end]) {
            Ok(recording) => {
                let messages = readable(&recording);
                assert_eq!(messages, drive()[..messages.len()], "cut at {end}");
                assert!(messages.len() >= most, "cut at {end}");
                most = messages.len();
                // After the data comes the summary, which we do not need.
                let is_whole = most == 30 && recording.damage().is_empty();
                let at = end as u64;
                assert!(is_whole || recording.damage() == [Damage::CutOff { at }]);
            }
            Err(error) => assert!(most == 0 && matches!(error, RecordingError::NotOurs { .. })),
        }
    }
    assert_eq!(most, 30);
}

/// Each byte of the file in turn, and each of its bits that matter. Nothing that is lost or changed
/// is ignored in silence, and at most three messages are lost: a damaged length may swallow the
/// next one, and two may lie before the next certain sign.
#[test]
fn a_flipped_bit_anywhere_costs_little_and_is_told() {
    let (file, truth) = (fixture::write(&drive()), drive());
    let data_end = file
        .windows(9)
        .position(|w| w == [15, 4, 0, 0, 0, 0, 0, 0, 0]);
    for at in 8..data_end.unwrap() {
        for bit in [0, 3, 7] {
            let mut damaged = file.clone();
            damaged[at] ^= 1 << bit;
            let Ok(recording) = Recording::parse(&damaged) else {
                // Our channel lost its name: all our messages count as those of another program.
                assert!(at < 300, "byte {at}, bit {bit}");
                continue;
            };
            let messages = readable(&recording);
            let whole = truth.iter().filter(|m| messages.contains(m)).count();
            assert!(
                whole >= 27,
                "byte {at}, bit {bit}: {whole} of 30, {:?}",
                recording.damage()
            );
            assert!(!recording.damage().is_empty(), "byte {at}, bit {bit}");
        }
    }
}

#[test]
fn a_stretch_of_rubbish_is_named_by_its_place() {
    let mut file = fixture::write(&drive());
    let (from, to) = (file.len() / 3, file.len() / 3 + 1500);
    file[from..to].fill(0xEE);
    let recording = Recording::parse(&file).unwrap();
    assert!((20..28).contains(&readable(&recording).len()));
    let [
        Damage::Bytes {
            from: first,
            to: last,
            ..
        },
    ] = recording.damage()
    else {
        panic!("{:?}", recording.damage());
    };
    assert!(*first <= to as u64 && (to as u64) <= *last && *last < to as u64 + 1500);
    let said = recording.damage()[0].to_string();
    assert!(
        said.contains(&format!("bytes {first} to {last} are damaged")),
        "{said}"
    );
}

#[test]
fn another_schema_is_told() {
    let read = |schema: String| {
        let mut bytes = std::io::Cursor::new(fixture::write(&drive()));
        let facts = [(SCHEMA_KEY.to_owned(), schema)].into();
        let mut other = std::io::Cursor::new(vec![]);
        let options = WriteOptions::new().use_chunks(false);
        let mut writer = options.create(&mut other).unwrap();
        let ours = writer.add_channel(0, CHANNEL, ENCODING, &facts).unwrap();
        for message in mcap::MessageStream::new(bytes.get_mut()).unwrap() {
            let message = message.unwrap();
            let header = mcap::records::MessageHeader {
                channel_id: ours,
                sequence: message.sequence,
                log_time: message.log_time,
                publish_time: message.publish_time,
            };
            if message.channel.topic == CHANNEL {
                writer
                    .write_to_known_channel(&header, &message.data)
                    .unwrap();
            }
        }
        writer.finish().unwrap();
        drop(writer);
        Recording::parse(&other.into_inner()).unwrap()
    };
    let theirs = "00c0ffee00c0ffee".to_owned();
    assert_eq!(read(theirs.clone()).damage(), [Damage::Schema { theirs }]);
    let same = read(format!("{:016x}", super::super::message::SCHEMA));
    assert_eq!((same.damage(), same.len()), (&[][..], 30));
}

#[test]
fn files_of_others_are_refused_in_words() {
    assert_eq!(
        Recording::parse(b"FLASER 180 ...").unwrap_err(),
        RecordingError::Magic
    );
    assert_eq!(Recording::parse(b"").unwrap_err(), RecordingError::Magic);
    let mut bytes = std::io::Cursor::new(vec![]);
    let mut writer = WriteOptions::new()
        .use_chunks(false)
        .create(&mut bytes)
        .unwrap();
    writer
        .add_channel(0, "/camera", "cdr", &Default::default())
        .unwrap();
    writer.finish().unwrap();
    drop(writer);
    let error = Recording::parse(&bytes.into_inner())
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("/camera") && error.contains("not recorded by slamlab"),
        "{error}"
    );
}

#[test]
fn kinds_are_those_of_the_messages() {
    let kind = |message| encode(Header::default(), &message, Format::Binary).unwrap()[KIND_AT];
    assert_eq!(kind(odometry(0)), ODOMETRY_KIND);
    assert_eq!(kind(scan(0)), SCAN_KIND);
}

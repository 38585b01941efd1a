//! Files written by other programs (`tests/interop/ros_files.py`), complete, cut off and damaged;
//! [`crate::replay`] tests how their scans and poses are used.

use proptest::prelude::*;

use super::collector::keep;
use super::fields::FieldsError;
use super::*;

const PLAIN_BAG: &[u8] = include_bytes!("files/plain.bag");
const BZ2_BAG: &[u8] = include_bytes!("files/bz2.bag");
const LZ4_BAG: &[u8] = include_bytes!("files/lz4.bag");
const ZSTD_MCAP: &[u8] = include_bytes!("files/zstd.mcap");
const LZ4_MCAP: &[u8] = include_bytes!("files/lz4.mcap");
const TWO_MCAP: &[u8] = include_bytes!("files/two.mcap");
const ALL: [&[u8]; 6] = [PLAIN_BAG, BZ2_BAG, LZ4_BAG, ZSTD_MCAP, LZ4_MCAP, TWO_MCAP];

fn read(bytes: &[u8], piece: usize) -> Result<RosLog, RosError> {
    let mut reader = RosReader::default();
    for piece in bytes.chunks(piece) {
        reader.push(piece)?;
    }
    reader.finish()
}

#[test]
fn each_file_holds_what_was_written_however_it_is_cut() {
    for bytes in ALL {
        let log = read(bytes, 1 << 20).unwrap();
        assert_eq!(log.damage(), Vec::<String>::new());
        let of = |name: &str| log.topics().iter().find(|topic| topic.name == name);
        assert_eq!(of("/scan").unwrap().messages, 25);
        assert_eq!(
            of("/tf_static").unwrap().kind,
            Some(TopicKind::StaticTransforms)
        );
        let scan = &log.scans()[0];
        assert_eq!(
            (log.frame(scan.frame), scan.scan.ranges.len()),
            ("laser", 90)
        );
        assert_eq!(scan.stamp, 1_700_000_000_050_000_000);
        assert!((scan.scan.angle_min + 2.0).abs() < 1e-6);
        assert!(scan.scan.ranges[4].is_nan() && scan.scan.ranges[3].is_infinite());
        let poses = log.odometry().len().max(log.transforms().len());
        assert!((270..300).contains(&poses), "{poses}");
        for piece in [1, 17, 4096] {
            assert_eq!(
                format!("{:?}", read(bytes, piece).unwrap()),
                format!("{log:?}")
            );
        }
    }
}

#[test]
fn the_mast_leads_from_the_robot_to_its_lidar() {
    let log = read(ZSTD_MCAP, 1000).unwrap();
    let tree = FrameTree::of(&log);
    let frame = |name| log.frame_number(name).unwrap();
    let (base, laser) = (frame("base_link"), frame("laser"));
    let there = tree.between(&log, base, laser).unwrap();
    let place = there.translation.vector;
    assert!(
        (place - nalgebra::Vector3::new(0.2, 0.05, 0.3)).amax() < 1e-9,
        "{place}"
    );
    // Upside down: its z axis points to the floor.
    assert!((there.rotation * nalgebra::Vector3::z()).z < -0.999);
    let back = tree.between(&log, laser, base).unwrap();
    assert!(((back * there).translation.vector).amax() < 1e-9);
    let lost = tree
        .between(&log, base, frame("odom"))
        .unwrap_err()
        .to_string();
    assert!(
        lost.contains("`base_link` to `odom`") && lost.contains("laser"),
        "{lost}"
    );
}

#[test]
fn a_file_that_was_cut_off_keeps_what_stands_before() {
    for bytes in ALL {
        let whole = read(bytes, 1 << 20).unwrap();
        for cut in [bytes.len() / 3, 2 * bytes.len() / 3] {
            let log = read(&bytes[..cut], 1000).unwrap();
            assert!(log.scans().len() < whole.scans().len());
            let scans = log.scans().iter().zip(whole.scans());
            for (found, expected) in scans {
                assert_eq!(found.stamp, expected.stamp);
            }
            let damage = log.damage().join("; ");
            assert!(damage.contains("cut off"), "{damage}");
        }
    }
}

#[test]
fn a_damaged_chunk_is_left_out_and_the_others_are_read() {
    for bytes in [BZ2_BAG, LZ4_BAG, ZSTD_MCAP, LZ4_MCAP] {
        let mut damaged = bytes.to_vec();
        // Inside the first chunk's data.
        let at = if bytes.starts_with(BAG_MAGIC) {
            4096 + 400
        } else {
            600
        };
        for byte in &mut damaged[at..at + 40] {
            *byte ^= 0x5a;
        }
        let log = read(&damaged, 1000).unwrap();
        let damage = log.damage().join("; ");
        assert!(damage.contains("left out"), "{damage}");
    }
}

#[test]
fn what_is_no_such_file_is_refused() {
    assert_eq!(read(b"", 1), Err(RosError::Magic));
    assert_eq!(
        read(b"FLASER 3 1 2 3 0 0 0 0 0 0 1 h 1", 7),
        Err(RosError::Magic)
    );
    let old = read(b"#ROSBAG V1.2\nmore of it", 5)
        .unwrap_err()
        .to_string();
    assert!(
        old.contains("version 1.2") && old.contains("rosbag fix"),
        "{old}"
    );
}

/// A scan of one beam in CDR, big-endian.
#[test]
fn the_order_of_bytes_is_that_of_the_head() {
    let mut bytes = vec![0, 0, 0, 0];
    let be = |bytes: &mut Vec<u8>, word: u32| bytes.extend(word.to_be_bytes());
    be(&mut bytes, 12);
    be(&mut bytes, 34);
    be(&mut bytes, 3);
    bytes.extend(b"ab\0\0");
    for value in [-1.0_f32, 1.0, 0.5, 0.0, 0.1, 0.2, 9.0] {
        be(&mut bytes, value.to_bits());
    }
    be(&mut bytes, 1);
    be(&mut bytes, 2.5_f32.to_bits());
    let (head, scan) = messages::scan(&bytes, Encoding::Cdr, TopicKind::Scans).unwrap();
    assert_eq!((head.stamp, head.frame.as_str()), (12_000_000_034, "ab"));
    assert_eq!((scan.ranges, scan.range_max), (vec![2.5], 9.0));
    let short = messages::scan(&bytes[..40], Encoding::Cdr, TopicKind::Scans).unwrap_err();
    assert!(short.to_string().contains("at byte"), "{short}");
    bytes[1] = 9;
    let head = messages::scan(&bytes, Encoding::Cdr, TopicKind::Scans).unwrap_err();
    assert!(matches!(head, FieldsError::Head([0, 9])));
}

/// A list that claims four thousand million elements must not allocate memory for them.
#[test]
fn lengths_that_cannot_be_are_refused_before_anything_is_set_aside() {
    let mut bytes = vec![0; 12];
    bytes.extend(0_u32.to_le_bytes());
    bytes.extend([0; 28]);
    bytes.extend(u32::MAX.to_le_bytes());
    let error = messages::scan(&bytes, Encoding::Ros1, TopicKind::Scans).unwrap_err();
    assert!(
        matches!(
            error,
            FieldsError::Short {
                field: "ranges",
                ..
            }
        ),
        "{error}"
    );
    let claimed = unpack::unpack("bz2", b"BZh9", u64::MAX).unwrap_err();
    assert!(matches!(claimed, unpack::UnpackError::TooLong { .. }));
    let unknown = unpack::unpack("xz", b"", 1).unwrap_err().to_string();
    assert!(unknown.contains("`xz`"), "{unknown}");
}

#[test]
fn a_transform_that_stands_is_kept_when_it_begins_and_when_it_ends() {
    let pose = |at: u64, x: f64| RosPose {
        topic: 0,
        recorded: at,
        stamp: at,
        parent: 0,
        child: 1,
        parent_from_child: Isometry3::translation(x, 0.0, 0.0),
    };
    let mut poses = vec![];
    for at in 0..50 {
        keep(&mut poses, pose(at, 1.0));
    }
    keep(&mut poses, pose(50, 1.1));
    let kept: Vec<u64> = poses.iter().map(|pose| pose.stamp).collect();
    assert_eq!(kept, [0, 49, 50]);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]
    #[test]
    fn a_changed_file_never_panics_and_reads_the_same_however_it_is_cut(
        which in 0..ALL.len(),
        edits in proptest::collection::vec((0.0..1.0_f64, 0_u8..3, any::<u8>()), 1..6),
    ) {
        let mut bytes = ALL[which].to_vec();
        for (place, kind, byte) in edits {
            let at = (bytes.len() as f64 * place) as usize;
            match (kind, bytes.get_mut(at)) {
                (0, _) => bytes.truncate(at.max(bytes.len() / 2)),
                (1, Some(old)) => *old = byte,
                _ => bytes.insert(at, byte),
            }
        }
        let (a, b) = (read(&bytes, 113), read(&bytes, 1 << 20));
        prop_assert_eq!(format!("{a:?}"), format!("{b:?}"));
    }
}

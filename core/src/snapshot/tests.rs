use std::collections::BTreeMap;

use nalgebra::Matrix3;
use proptest::prelude::*;

use super::*;
use crate::geom::Pose2;

fn bytes_of(value: &impl Snapshot) -> Vec<u8> {
    let mut bytes = vec![];
    value.write(&mut bytes);
    bytes
}

fn read_whole<T: Snapshot>(bytes: &[u8]) -> Result<T, SnapshotError> {
    let mut from = Reader::new(bytes);
    let value = T::read(&mut from)?;
    assert!(from.is_at_end(), "{} of {}", from.at, bytes.len());
    Ok(value)
}

#[derive(Debug, PartialEq)]
struct Inner {
    count: u32,
    list: Vec<f64>,
}
#[derive(Debug, PartialEq)]
struct Outer {
    first: bool,
    inner: Vec<Inner>,
}
snapshot!(Inner { count, list }, |i| i.count < 100, "too many");
snapshot!(Outer { first, inner });

fn outer() -> Outer {
    let inner = |count| Inner {
        count,
        list: vec![0.5, -0.0],
    };
    Outer {
        first: true,
        inner: vec![inner(1), inner(2)],
    }
}

#[test]
fn bytes_are_those_of_the_table() {
    // Computed by hand: LEB128 of 300 is AC 02; 1.5 is 3FF8000000000000.
    assert_eq!(bytes_of(&300_u64), [0xac, 0x02]);
    assert_eq!(bytes_of(&1.5_f64), [0, 0, 0, 0, 0, 0, 0xf8, 0x3f]);
    assert_eq!(bytes_of(&vec![true, false]), [2, 1, 0]);
    assert_eq!(bytes_of(&Some(7_u8)), [1, 7]);
    assert_eq!(bytes_of(&None::<u8>), [0]);
    assert_eq!(bytes_of(&"é".to_owned()), [2, 0xc3, 0xa9]);
}

#[test]
fn a_fault_is_named_with_its_place() {
    let check = |change: &dyn Fn(&mut Vec<u8>), words: &str| {
        let mut bytes = bytes_of(&outer());
        change(&mut bytes);
        let error = read_whole::<Outer>(&bytes).expect_err(words);
        assert_eq!(error.to_string(), words);
    };
    // first, length of inner, count, length of list, 2 numbers; then the second: 37 bytes.
    check(
        &|b| b.truncate(30),
        "inner[1].list[1]: the content ends here (byte 30 of the content)",
    );
    check(
        &|b| b[0] = 7,
        "first: 7 stands for nothing (byte 1 of the content)",
    );
    check(
        &|b| b[2] = 100,
        "inner[0]: too many (byte 20 of the content)",
    );
    check(
        &|b| b[4..12].copy_from_slice(&f64::NAN.to_le_bytes()),
        "inner[0].list[0]: a number is not finite (byte 12 of the content)",
    );
    check(
        &|b| b[3] = 0x7f,
        "inner[0].list: 127 entries are said to follow, and 34 bytes are left (byte 4 of the content)",
    );
}

#[test]
fn a_length_reserves_no_memory() {
    // 2^62 entries.
    let bytes = [0x80, 0x80, 0x80, 0x80, 0x80, 0x80, 0x80, 0x80, 0x40];
    assert!(read_whole::<Vec<f64>>(&bytes).is_err());
    let too_large = [0xff; 10];
    assert!(read_whole::<u64>(&too_large).is_err());
}

#[test]
fn what_is_no_turn_is_no_pose() {
    let bytes = bytes_of(&[1.0, 2.0, 0.8, 0.8]);
    let error = read_whole::<Pose2>(&bytes).expect_err("no pose");
    assert!(error.to_string().contains("no angle"), "{error}");
}

#[test]
fn keys_of_a_table_rise() {
    let bytes = bytes_of(&vec![(2_u64, 1_u64), (2, 3)]);
    assert!(read_whole::<BTreeMap<u64, u64>>(&bytes).is_err());
}

proptest! {
    #[test]
    fn what_was_written_is_read_again_to_the_bit(
        whole in any::<u64>(), small in any::<u32>(), signed in any::<i32>(),
        x in -1e7..1e7_f64, y in -1e-9..1e-9_f64, heading in -3.2..3.2_f64,
        text in ".*", list in proptest::collection::vec(any::<Option<u8>>(), 0..20),
        map in proptest::collection::btree_map(any::<u64>(), any::<bool>(), 0..20),
    ) {
        let pose = Pose2::new(x, y, heading);
        let matrix = Matrix3::new(x, y, heading, 1.0, -0.0, 3.0, 4.0, 5.0, y * y);
        prop_assert_eq!(read_whole::<u64>(&bytes_of(&whole))?, whole);
        prop_assert_eq!(read_whole::<u32>(&bytes_of(&small))?, small);
        prop_assert_eq!(read_whole::<i32>(&bytes_of(&signed))?, signed);
        prop_assert_eq!(read_whole::<String>(&bytes_of(&text))?, text);
        prop_assert_eq!(read_whole::<Vec<Option<u8>>>(&bytes_of(&list))?, list);
        prop_assert_eq!(read_whole::<BTreeMap<u64, bool>>(&bytes_of(&map))?, map);
        let again: Matrix3<f64> = read_whole(&bytes_of(&matrix))?;
        for (a, b) in again.iter().zip(matrix.iter()) {
            prop_assert_eq!(a.to_bits(), b.to_bits());
        }
        let again: Pose2 = read_whole(&bytes_of(&pose))?;
        prop_assert_eq!(bytes_of(&again), bytes_of(&pose));
    }

    #[test]
    fn any_bytes_are_read_or_refused(bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
        if let Ok(read) = Outer::read(&mut Reader::new(&bytes)) {
            prop_assert!(read.inner.iter().all(|inner| inner.count < 100));
        }
    }
}

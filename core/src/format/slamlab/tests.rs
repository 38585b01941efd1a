use proptest::prelude::*;

use super::*;

fn experiment() -> Experiment {
    Experiment {
        title: "two rooms".into(),
        program: "slamlab 0.1.0".into(),
        method: "scan-matching".into(),
        settings: vec![("grid.resolution".into(), 0.1)],
        map: SavedMap {
            state: (0..5000_u32).map(|i| (i * i) as u8).collect(),
            ..SavedMap::default()
        },
    }
}

/// A file with this content and a correct header.
fn packed(content: &[u8], says: u64) -> Vec<u8> {
    let mut file = MAGIC.to_vec();
    file.extend(VERSION.to_le_bytes());
    file.extend(says.to_le_bytes());
    file.extend(XxHash64::oneshot(0, content).to_le_bytes());
    let mut packer = ZlibEncoder::new(file, Compression::default());
    packer.write_all(content).unwrap();
    packer.finish().unwrap()
}

#[test]
fn what_was_written_is_read_again() {
    let file = write(&experiment()).unwrap();
    assert!(begins(&file));
    assert_eq!(read(&file), Ok(experiment()));
}

#[test]
fn the_header_is_that_of_the_table() {
    let file = write(&experiment()).unwrap();
    assert_eq!(&file[..12], b"\x89slamlab\x07\0\0\0");
    let mut content = vec![];
    experiment().write(&mut content);
    assert_eq!(file[12..20], (content.len() as u64).to_le_bytes());
    assert_eq!(&file[20..28], XxHash64::oneshot(0, &content).to_le_bytes());
    // 0x78: zlib with a window of 32 KiB (RFC 1950).
    assert_eq!(file[28], 0x78);
    assert_eq!(content[..10], *b"\x09two rooms");
}

#[test]
fn each_fault_has_its_words() {
    let file = write(&experiment()).unwrap();
    let check = |file: &[u8], words: &str| {
        let error = read(file).expect_err(words).to_string();
        assert!(error.contains(words), "{error}: {words}");
    };
    check(b"", "no .slamlab file");
    check(b"PK\x03\x04 something else", "no .slamlab file");
    check(&file[..10], "within its header, at byte 10");
    check(&file[..27], "within its header, at byte 27");
    let half = file.len() / 2;
    let cut = format!("is cut off: it ends at byte {half}, with ");
    check(&file[..half], &cut);
    let with = |at: usize, byte: u8| {
        let mut file = file.clone();
        file[at] = byte;
        file
    };
    check(
        &with(8, 8),
        "of version 8, and this program reads version 7: it was written by a newer one",
    );
    check(&with(8, 1), "it was written by an older one");
    check(&with(12, !file[12]), "damaged");
    check(&with(20, !file[20]), "damaged");
    check(&with(19, 0x80), "unpacks to");
    let mut content = vec![];
    experiment().write(&mut content);
    let cut = &content[..content.len() - 1];
    check(&packed(cut, cut.len() as u64), "map.");
    content.push(0);
    check(&packed(&content, content.len() as u64), "more follows");
}

#[test]
fn where_it_is_damaged_is_told_where_it_can_be() {
    let content: Vec<u8> = (0..20_000_u32)
        .flat_map(|n| (n * n).to_le_bytes())
        .collect();
    let whole = packed(&content, content.len() as u64);
    for at in (28..whole.len() - 4).step_by(whole.len() / 97) {
        let mut file = whole.clone();
        file[at] ^= 0x10;
        match read(&file).unwrap_err() {
            SlamlabError::Damaged { before } => assert!(before > at, "{at}: {before}"),
            SlamlabError::Cut { at: end, .. } => assert_eq!(end, whole.len()),
            other => panic!("{at}: {other}"),
        }
    }
}

#[test]
fn a_bomb_is_refused_by_what_it_says_and_by_what_it_is() {
    let zeros = vec![0; 50_000_000];
    let bomb = packed(&zeros, zeros.len() as u64);
    assert!(bomb.len() < 60_000);
    // The file states less than it holds: no more than that is unpacked.
    let refused = read(&packed(&zeros, 100));
    assert!(
        matches!(refused, Err(SlamlabError::Damaged { .. })),
        "{refused:?}"
    );
    let mut file = bomb;
    file[12..20].copy_from_slice(&u64::MAX.to_le_bytes());
    assert!(matches!(read(&file), Err(SlamlabError::TooLong { .. })));
}

proptest! {
    #[test]
    fn changed_bytes_are_refused(at in 0..1000_usize, byte in any::<u8>()) {
        let mut file = write(&experiment()).unwrap();
        let at = at % file.len();
        prop_assume!(file[at] != byte);
        file[at] = byte;
        // The two bytes of zlib's header and its checksum at the end do not affect the content.
        match read(&file) {
            Ok(read) => prop_assert_eq!(read, experiment()),
            Err(error) => prop_assert!(!error.to_string().is_empty()),
        }
    }

    #[test]
    fn any_bytes_are_read_or_refused(bytes in proptest::collection::vec(any::<u8>(), 0..300)) {
        let mut file = MAGIC.to_vec();
        file.extend(VERSION.to_le_bytes());
        file.extend(&bytes);
        prop_assert!(read(&file).is_err());
        // Content of nothing but zeros is an experiment with nothing in it.
        if let Ok(experiment) = read(&packed(&bytes, bytes.len() as u64)) {
            prop_assert_eq!(read(&write(&experiment)?)?, experiment);
        }
    }
}

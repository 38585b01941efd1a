//! Recordings that end in the middle of something.

use std::cell::RefCell;
use std::io::{self, Write};
use std::marker::PhantomData;
use std::rc::Rc;
use std::sync::mpsc::sync_channel;

use mcap::read::{MessageStream, Options};
use slamlab_core::wire::message::{BatteryBody, Format, Notice, Severity, decode};
use slamlab_core::wire::recording::CHANNEL;

use super::journal::Storage;
use super::pieces::Pieces;
use super::thread::{Progress, run};
use super::*;

/// A disk of a given size that, like real ones, takes part of the write that fills it.
#[derive(Clone)]
struct SmallDisk {
    bytes: Rc<RefCell<Vec<u8>>>,
    size: usize,
}

impl SmallDisk {
    fn new(size: usize) -> Self {
        Self {
            bytes: Rc::default(),
            size,
        }
    }
}

impl Write for SmallDisk {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let mut all = self.bytes.borrow_mut();
        let room = (self.size - all.len()).min(bytes.len());
        if room == 0 && !bytes.is_empty() {
            return Err(io::Error::from(io::ErrorKind::StorageFull));
        }
        all.extend(&bytes[..room]);
        Ok(room)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Storage for SmallDisk {
    fn cut(&mut self, length: u64) -> io::Result<()> {
        self.bytes.borrow_mut().truncate(length as usize);
        Ok(())
    }

    fn force(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Pieces of which only the first exists.
struct Only<S>(PhantomData<S>);

impl<S: Storage> Pieces for Only<S> {
    type File = S;

    fn next(&mut self) -> Result<Option<(S, PathBuf)>, RecordError> {
        Ok(None)
    }

    fn discard(&mut self, _: &Path) {}

    fn make_room(&mut self, _: &Path) {}
}

/// Pieces that are each on a disk of their own.
struct Disks {
    size: usize,
    all: Rc<RefCell<Vec<SmallDisk>>>,
}

impl Disks {
    fn add(&self) -> (SmallDisk, PathBuf) {
        let disk = SmallDisk::new(self.size);
        let mut all = self.all.borrow_mut();
        all.push(disk.clone());
        (disk, format!("/drives/{}.mcap", all.len()).into())
    }
}

impl Pieces for Disks {
    type File = SmallDisk;

    fn next(&mut self) -> Result<Option<(SmallDisk, PathBuf)>, RecordError> {
        Ok(Some(self.add()))
    }

    fn discard(&mut self, _: &Path) {}

    fn make_room(&mut self, _: &Path) {}
}

fn battery(stamp: u64) -> FromBridge {
    FromBridge::Battery(BatteryBody {
        source: 0,
        stamp,
        volts: 7.2,
    })
}

fn entry(stamp: u64) -> Recorded {
    Recorded {
        nanos: 1_000_000 * stamp,
        header: Header {
            sequence: 0,
            micros: 1000 * stamp,
        },
        said: Said::ByBridge(battery(stamp)),
    }
}

/// Stamps of the messages that can be read from these bytes.
fn stamps(bytes: &[u8]) -> Vec<u64> {
    let stream = MessageStream::new_with_options(bytes, Options::IgnoreEndMagic.into()).unwrap();
    let messages = stream
        .map_while(Result::ok)
        .filter(|m| m.channel.topic == CHANNEL);
    messages
        .map(
            |message| match decode(&message.data, Format::Binary).unwrap() {
                (_, FromBridge::Battery(body)) => body.stamp,
                other => panic!("{other:?}"),
            },
        )
        .collect()
}

/// Records 200 messages on a disk of this size; returns its content, the numbers acknowledged and
/// lost, and the fault.
fn record(size: usize) -> (Vec<u8>, u64, u64, Option<String>) {
    let disk = SmallDisk::new(size);
    let (entries, waiting) = sync_channel(4);
    let progress = Progress::default();
    std::thread::scope(|scope| {
        // Sending fails if the file could not even begin, because nobody receives the entries then.
        scope.spawn(move || (0..200).for_each(|stamp| _ = entries.send(entry(stamp))));
        run(
            (disk.clone(), "only.mcap".into()),
            Only(PhantomData),
            Keep::default(),
            &waiting,
            &progress,
        );
        drop(waiting);
    });
    let bytes = disk.bytes.borrow().clone();
    let status = progress.lock().clone();
    (bytes, status.acknowledged, status.lost, status.fault)
}

#[test]
fn a_whole_recording_has_all_messages_and_a_summary() {
    let (bytes, acknowledged, lost, fault) = record(usize::MAX);
    assert_eq!(stamps(&bytes), (0..200).collect::<Vec<u64>>());
    assert_eq!((acknowledged, lost, fault), (200, 0, None));
    let summary = mcap::Summary::read(&bytes).unwrap().unwrap();
    assert_eq!(summary.stats.unwrap().message_count, 200);
}

/// Wherever the disk gets full, the file holds exactly what was acknowledged.
#[test]
fn a_full_disk_loses_nothing_that_was_acknowledged() {
    let (whole, ..) = record(usize::MAX);
    let mut partly = 0;
    for size in (0..whole.len()).step_by(397) {
        let (bytes, acknowledged, lost, fault) = record(size);
        assert!(fault.is_some(), "{size}");
        if acknowledged > 0 {
            assert_eq!(
                stamps(&bytes),
                (0..acknowledged).collect::<Vec<u64>>(),
                "{size}"
            );
        }
        // If only the summary found no room, all messages are there.
        assert_eq!(
            acknowledged + lost,
            if bytes.is_empty() { lost } else { 200 },
            "{size}"
        );
        partly += u32::from(acknowledged > 0 && lost > 0);
    }
    assert!(partly > 10, "{partly}");
}

/// If the program dies, only a beginning of the file is left: of whatever length, it can be read up
/// to its last complete message.
#[test]
fn a_recording_that_is_cut_off_anywhere_reads_up_to_there() {
    let (whole, ..) = record(usize::MAX);
    let mut most = 0;
    for end in (8..whole.len()).step_by(61) {
        let stamps = stamps(&whole[..end]);
        assert_eq!(stamps, (0..stamps.len() as u64).collect::<Vec<_>>());
        assert!(stamps.len() >= most);
        most = stamps.len();
    }
    assert!(most >= 199, "{most}");
}

/// The size of one write is bounded, however many messages wait: otherwise the thread could collect
/// for ever.
#[test]
fn what_waits_is_written_in_parts() {
    struct Counting(Rc<RefCell<Vec<usize>>>);
    impl Write for Counting {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.0.borrow_mut().push(bytes.len());
            Ok(bytes.len())
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }
    impl Storage for Counting {
        fn cut(&mut self, _: u64) -> io::Result<()> {
            Ok(())
        }

        fn force(&mut self) -> io::Result<()> {
            Ok(())
        }
    }
    let (entries, waiting) = sync_channel(MOST_WAITING);
    (0..1000).for_each(|stamp| entries.send(entry(stamp)).unwrap());
    drop(entries);
    let (progress, writes) = (Progress::default(), Rc::default());
    let disk = Counting(Rc::clone(&writes));
    run(
        (disk, "only.mcap".into()),
        Only(PhantomData),
        Keep::default(),
        &waiting,
        &progress,
    );
    assert_eq!(progress.lock().acknowledged, 1000);
    // Beginning and summary are one write each.
    let writes = writes.borrow().len();
    assert_eq!(writes, 2 + 1000_usize.div_ceil(thread::MOST_AT_ONCE));
}

/// Each piece can be read alone: it begins with what its reader must know.
#[test]
fn a_long_recording_is_cut_into_pieces_that_stand_alone() {
    let disks = Disks {
        size: usize::MAX,
        all: Rc::default(),
    };
    let all = Rc::clone(&disks.all);
    let first = disks.add();
    let (entries, waiting) = sync_channel(MOST_WAITING);
    let devices = |stamp| Recorded {
        said: Said::ByBridge(FromBridge::Devices(vec![])),
        ..entry(stamp)
    };
    entries.send(devices(0)).unwrap();
    (1..2000).for_each(|stamp| entries.send(entry(stamp)).unwrap());
    drop(entries);
    let progress = Progress::default();
    let keep = Keep {
        piece_bytes: 30_000,
        ..Keep::default()
    };
    run(first, disks, keep, &waiting, &progress);
    let body = progress.lock().clone();
    assert_eq!((body.acknowledged, body.lost, body.fault), (2000, 0, None));
    let pieces = all.borrow();
    assert!(pieces.len() > 3, "{} pieces", pieces.len());
    assert_eq!(body.file, format!("{}.mcap", pieces.len()));
    let mut found = vec![];
    for piece in pieces.iter() {
        let bytes = piece.bytes.borrow();
        assert!(
            mcap::Summary::read(&bytes).unwrap().is_some(),
            "it is finished"
        );
        let messages = MessageStream::new(&bytes).unwrap().map(Result::unwrap);
        let said: Vec<_> = messages
            .filter(|message| message.channel.topic == CHANNEL)
            .map(|message| {
                decode::<FromBridge>(&message.data, Format::Binary)
                    .unwrap()
                    .1
            })
            .collect();
        assert!(matches!(said[0], FromBridge::Devices(_)));
        found.extend(said.iter().filter_map(|said| match said {
            FromBridge::Battery(body) => Some(body.stamp),
            _ => None,
        }));
    }
    assert_eq!(found, (1..2000).collect::<Vec<u64>>());
}

/// Room for the beginning and some messages.
fn room_for_some() -> usize {
    let mut sizes = (0..).step_by(200);
    let takes_some = |size: &usize| record(*size).1 > 0;
    sizes.find(takes_some).unwrap()
}

/// After a full disk a new piece begins as soon as there is room, and the fault is over.
#[test]
fn a_recording_begins_again_when_there_is_room() {
    let disks = Disks {
        size: usize::MAX,
        all: Rc::default(),
    };
    let all = Rc::clone(&disks.all);
    let full = (SmallDisk::new(room_for_some()), "/drives/full.mcap".into());
    let (entries, waiting) = sync_channel(MOST_WAITING);
    let progress = Progress::default();
    std::thread::scope(|scope| {
        scope.spawn(move || {
            for stamp in 0..80 {
                entries.send(entry(stamp)).unwrap();
                std::thread::sleep(thread::TRY_AGAIN / 50);
            }
        });
        run(full, disks, Keep::default(), &waiting, &progress);
    });
    let body = progress.lock().clone();
    assert!(body.lost > 0 && body.acknowledged > 20, "{body:?}");
    assert_eq!((body.fault, body.file.as_str()), (None, "1.mcap"));
    let last = all
        .borrow()
        .last()
        .map(|piece| stamps(&piece.bytes.borrow()));
    assert_eq!(last.and_then(|stamps| stamps.last().copied()), Some(79));
}

#[test]
fn a_full_disk_is_named_in_words_with_the_path() {
    let (_, _, _, fault) = record(room_for_some());
    let fault = fault.unwrap();
    assert!(
        fault.contains("the disk is full") && fault.contains("only.mcap"),
        "{fault}"
    );
}

#[test]
fn a_recording_is_never_written_over() {
    let folder = tempfile::TempDir::new().unwrap();
    let path = folder.path().join("a.mcap");
    std::fs::write(&path, "precious").unwrap();
    let error = Recorder::start(&path, Keep::default(), Clock::start()).unwrap_err();
    assert!(error.to_string().contains("already there"), "{error}");
    assert_eq!(std::fs::read(&path).unwrap(), b"precious");
}

#[test]
fn messages_and_orders_stand_in_the_file_when_it_is_finished() {
    let folder = tempfile::TempDir::new().unwrap();
    let path = folder.path().join("a.mcap");
    let recorder = Recorder::start(&path, Keep::default(), Clock::start()).unwrap();
    let news = FromBridge::Notice(Notice {
        severity: Severity::Info,
        text: "hello".into(),
    });
    recorder.message(&news, Duration::from_secs(1));
    let drive = slamlab_core::robot::Command::Velocity {
        forward: 0.1,
        turn: 0.0,
    };
    recorder.order(&Order::Command(drive), Duration::from_secs(2));
    let status = recorder.finish();
    assert_eq!(
        (status.acknowledged, status.lost, status.fault),
        (2, 0, None)
    );
    let bytes = std::fs::read(&path).unwrap();
    let topics: Vec<String> = MessageStream::new(&bytes)
        .unwrap()
        .map(|message| message.unwrap().channel.topic.clone())
        .collect();
    assert_eq!(topics, [CHANNEL, CHANNEL, "/cmd_vel"]);
}

/// The budget holds at any time, not only when a recording begins: a robot runs for weeks.
#[test]
fn a_folder_keeps_to_its_budget_while_it_is_written() {
    let folder = tempfile::TempDir::new().unwrap();
    let keep = Keep {
        piece_bytes: 40_000,
        all_bytes: 160_000,
        ..Keep::default()
    };
    let mut files = Files::recordings(folder.path(), keep, Clock::start()).unwrap();
    let first = files.next().unwrap().unwrap();
    let (entries, waiting) = sync_channel(MOST_WAITING);
    let progress = Progress::default();
    let path = folder.path();
    let sizes = |path: &Path| {
        let entries = std::fs::read_dir(path).unwrap().flatten();
        // A piece that was deleted meanwhile has no size.
        entries.filter_map(|entry| entry.metadata().ok().map(|data| data.len()))
    };
    let most = std::thread::scope(|scope| {
        let sends = scope.spawn(move || {
            let mut most = 0;
            for stamp in 0..20_000 {
                entries.send(entry(stamp)).unwrap();
                if stamp % 500 == 0 {
                    most = sizes(path).sum::<u64>().max(most);
                }
            }
            most
        });
        run(first, files, keep, &waiting, &progress);
        sends.join().unwrap()
    });
    let body = progress.lock().clone();
    assert_eq!((body.acknowledged, body.lost), (20_000, 0));
    let (left, pieces) = (sizes(path).sum::<u64>(), sizes(path).count());
    // The piece that has just begun, and the last write to the one before, which exceeded its size.
    let most_over = 2 * keep.piece_bytes;
    assert!(
        most > keep.all_bytes / 2 && most < keep.all_bytes + most_over,
        "{most}"
    );
    assert!(
        left < keep.all_bytes + most_over && pieces > 2,
        "{left}, {pieces}"
    );
}

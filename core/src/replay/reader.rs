//! Reads a recorded log of any kind, packed or not, and recognises it by its first bytes.
//!
//! | first | log |
//! |---|---|
//! | bytes of MCAP | a recording of the bridge; without messages of a bridge, a file to be imported |
//! | `#ROSBAG` | a bag of ROS 1, which is to be imported |
//! | bytes of another known kind | none; the error names the kind ([`known_file`]) |
//! | line: a number | a rover's: counts and ranges, nothing else |
//! | line: names separated by commas | four rangers' |
//! | line: a sample of a turning lidar, `__t:` or `S_t:` | revolutions of an RPLIDAR |
//! | line: a word that is not ASCII text | none |
//! | line: anything else | CARMEN |
//!
//! Empty lines and comments (`#`) are ignored.
//!
//! In: bytes, in pieces of any size. Out: a [`Log`]. A gzip file (RFC 1952) is unpacked as its
//! bytes arrive; several members in a row are one log. A file to be imported
//! ([`LogError::is_of_ros`]) is read by [`crate::format::ros`], because a person may have to choose
//! what to use of it.

use std::io::Write as _;

use flate2::write::MultiGzDecoder;

use super::log::Log;
use crate::format::carmen::{CarmenError, CarmenReader};
use crate::format::known_file::{self, KnownFile, known_file};
use crate::format::ranger_log::RangerLogReader;
use crate::format::revolution_log::{self, RevolutionLogReader};
use crate::format::ros::ANY_BAG;
use crate::format::rover_log::RoverLogReader;
use crate::format::{FieldError, TextLogError, is_empty_or_comment};
use crate::wire::recording::{Damage, MAGIC, RecordingError, RecordingReader};

/// The first bytes of a gzip file.
const GZIP: [u8; 2] = [0x1f, 0x8b];
/// Bytes that are unpacked at once: they give at most a thousand times as much.
const PIECE: usize = 1 << 12;

/// The bytes that some programs put before a text to mark it as UTF-8.
const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";
/// The kind of a log shows within this many bytes; with more comments at its head it is CARMEN's.
const MOST_UNDECIDED: usize = 1 << 16;

/// What can be opened.
const KINDS: &str = "a CARMEN log (FLASER, RLASER or ROBOTLASER1 messages), a rover's log (lines of \
    counts and ranges), a log of four rangers (CSV), revolutions of an RPLIDAR (samples), a \
    recording of the bridge or of ROS 2 (MCAP) or a bag of ROS 1; all but the last two may be packed by gzip";

/// Why a log cannot be opened.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LogError {
    /// Bytes of none of the known kinds.
    #[error("the file is no text, nor a recording; expected {KINDS}")]
    NoLog,
    /// A file of another kind.
    #[error("{0}")]
    Known(KnownFile),
    /// A bag of ROS 1: it is to be imported.
    #[error(
        "this is a bag of ROS 1, which has to be imported; if it is packed by gzip, unpack it first"
    )]
    Bag,
    /// The error of a CARMEN log.
    #[error(transparent)]
    Carmen(#[from] CarmenError),
    /// The error of a rover's log, one of four rangers, or one of revolutions.
    #[error(transparent)]
    Text(#[from] TextLogError),
    /// The error of a recording.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// A recording without any scan.
    #[error("the recording holds no scan: nothing can be mapped")]
    NoScan,
    /// The same for a damaged file: it may have contained some.
    #[error("{error}; {damage}", error = Self::NoScan)]
    NoScanLeft {
        /// The first damage.
        damage: Damage,
    },
    /// A text in which no range is valid.
    #[error("nothing was measured in any scan: nothing can be mapped; the first: {0}")]
    NothingMeasured(FieldError),
    /// A gzip file that cannot be unpacked.
    #[error("the gzip file is damaged, or not all of it is here: {0}")]
    Gzip(String),
    /// A gzip file inside another one.
    #[error("the gzip file holds another gzip file; unpack it once")]
    GzipInGzip,
}

impl LogError {
    /// Whether the file may be from ROS, to be read by [`crate::format::ros`] and
    /// [`super::import_ros`].
    #[must_use]
    pub fn is_of_ros(&self) -> bool {
        match self {
            Self::Bag => true,
            Self::Recording(error) => matches!(
                error,
                RecordingError::NotOurs { .. } | RecordingError::Compressed { .. }
            ),
            _ => false,
        }
    }
}

/// Reads a log, piece by piece.
#[derive(Debug, Default)]
pub struct LogReader {
    file: File,
}

/// The kind of the file.
#[derive(Debug)]
enum File {
    /// Too few bytes to tell.
    Undecided(Vec<u8>),
    Plain(Box<PlainReader>),
    Gzip(Box<GzipReader>),
}

impl Default for File {
    fn default() -> Self {
        Self::Undecided(vec![])
    }
}

impl LogReader {
    /// Takes the next bytes, any number.
    ///
    /// # Errors    [`LogError`]: what is wrong, and where.
    pub fn push(&mut self, bytes: &[u8]) -> Result<(), LogError> {
        match &mut self.file {
            File::Undecided(begun) => {
                begun.extend_from_slice(bytes);
                if begun.len() < GZIP.len() {
                    return Ok(());
                }
                let begun = std::mem::take(begun);
                self.file = match begun.starts_with(&GZIP) {
                    true => File::Gzip(Box::default()),
                    false => File::Plain(Box::default()),
                };
                self.push(&begun)
            }
            File::Plain(reader) => reader.push(bytes),
            File::Gzip(reader) => reader.push(bytes),
        }
    }

    /// Ends the log and returns it.
    ///
    /// # Errors    [`LogError`]: what is wrong, and where.
    pub fn finish(self) -> Result<Log, LogError> {
        match self.file {
            File::Undecided(begun) => PlainReader::Undecided(begun).finish(),
            File::Plain(reader) => reader.finish(),
            File::Gzip(reader) => reader.finish(),
        }
    }
}

/// Reads a packed log.
#[derive(Debug)]
struct GzipReader {
    decoder: MultiGzDecoder<Vec<u8>>,
    unpacked: PlainReader,
}

impl Default for GzipReader {
    fn default() -> Self {
        Self {
            decoder: MultiGzDecoder::new(vec![]),
            unpacked: PlainReader::default(),
        }
    }
}

impl GzipReader {
    fn push(&mut self, bytes: &[u8]) -> Result<(), LogError> {
        for piece in bytes.chunks(PIECE) {
            let written = self.decoder.write_all(piece);
            written.map_err(|error| LogError::Gzip(error.to_string()))?;
            let unpacked = std::mem::take(self.decoder.get_mut());
            self.unpacked.push(&unpacked)?;
        }
        Ok(())
    }

    fn finish(mut self) -> Result<Log, LogError> {
        let rest = self.decoder.finish();
        let rest = rest.map_err(|error| LogError::Gzip(error.to_string()))?;
        self.unpacked.push(&rest)?;
        self.unpacked.finish()
    }
}

/// Reads a log that is not packed, or has been unpacked.
#[derive(Debug)]
enum PlainReader {
    /// Too few bytes to tell what it is.
    Undecided(Vec<u8>),
    /// Text with names of messages.
    Carmen(CarmenReader),
    /// Text of numbers alone.
    Rover(RoverLogReader),
    /// Text of columns.
    Rangers(RangerLogReader),
    /// Text of samples.
    Revolutions(RevolutionLogReader),
    /// MCAP.
    Recording(RecordingReader),
}

impl Default for PlainReader {
    fn default() -> Self {
        Self::Undecided(vec![])
    }
}

impl PlainReader {
    fn push(&mut self, bytes: &[u8]) -> Result<(), LogError> {
        match self {
            Self::Undecided(begun) => {
                begun.extend_from_slice(bytes);
                if let Some(kind) = Kind::of(begun, false) {
                    self.begin(kind)?;
                }
            }
            Self::Carmen(reader) => reader.push(bytes)?,
            Self::Rover(reader) => reader.push(bytes)?,
            Self::Rangers(reader) => reader.push(bytes)?,
            Self::Revolutions(reader) => reader.push(bytes)?,
            Self::Recording(reader) => reader.push(bytes)?,
        }
        Ok(())
    }

    fn begin(&mut self, kind: Kind) -> Result<(), LogError> {
        let Self::Undecided(begun) = self else {
            return Ok(());
        };
        let begun = std::mem::take(begun);
        *self = match kind {
            Kind::Gzip => return Err(LogError::GzipInGzip),
            Kind::None => return Err(LogError::NoLog),
            Kind::Known(known) => return Err(LogError::Known(known)),
            Kind::Bag => return Err(LogError::Bag),
            Kind::Recording => Self::Recording(RecordingReader::default()),
            Kind::Carmen => Self::Carmen(CarmenReader::default()),
            Kind::Rover => Self::Rover(RoverLogReader::default()),
            Kind::Rangers => Self::Rangers(RangerLogReader::default()),
            Kind::Revolutions => Self::Revolutions(RevolutionLogReader::default()),
        };
        self.push(without_mark(&begun))
    }

    fn finish(mut self) -> Result<Log, LogError> {
        if let Self::Undecided(begun) = &self {
            self.begin(Kind::of(begun, true).unwrap_or(Kind::Carmen))?;
        }
        let log = match self {
            Self::Recording(reader) => {
                let recording = reader.finish()?;
                match (recording.scans(), recording.damage()) {
                    (0, []) => return Err(LogError::NoScan),
                    (0, [damage, ..]) => {
                        let damage = damage.clone();
                        return Err(LogError::NoScanLeft { damage });
                    }
                    _ => Log::Recording(recording),
                }
            }
            Self::Carmen(reader) => Log::Carmen(reader.finish()?),
            Self::Rover(reader) => Log::Rover(reader.finish()?),
            Self::Rangers(reader) => Log::Rangers(reader.finish()?),
            Self::Revolutions(reader) => Log::Revolutions(reader.finish()?),
            // Decided above.
            Self::Undecided(_) => return Err(CarmenError::Empty.into()),
        };
        match log.without_ranges() {
            Some(first) => Err(LogError::NothingMeasured(first.clone())),
            None => Ok(log),
        }
    }
}

fn without_mark(begun: &[u8]) -> &[u8] {
    begun.strip_prefix(BYTE_ORDER_MARK).unwrap_or(begun)
}

/// The kind of a file that is not packed, or has been unpacked, by its first bytes.
#[derive(Clone, Copy)]
enum Kind {
    /// A picture, or another file whose bytes are not text.
    None,
    Known(KnownFile),
    Gzip,
    Bag,
    Recording,
    Carmen,
    Rover,
    Rangers,
    Revolutions,
}

impl Kind {
    /// `None` if more bytes are needed to tell; at the `end` there are no more.
    fn of(begun: &[u8], end: bool) -> Option<Self> {
        if begun.starts_with(&GZIP) {
            return Some(Self::Gzip);
        }
        if begun.starts_with(&MAGIC) {
            return Some(Self::Recording);
        }
        // The importer reports the version.
        if begun.starts_with(ANY_BAG) {
            return Some(Self::Bag);
        }
        let signs = [&MAGIC[..], &GZIP, ANY_BAG];
        if !end && signs.iter().any(|sign| sign.starts_with(begun)) {
            return None;
        }
        // So that the result does not depend on how the file is cut.
        if !end && begun.len() < known_file::ENOUGH {
            return None;
        }
        if let Some(known) = known_file(begun.get(..known_file::ENOUGH).unwrap_or(begun)) {
            return Some(Self::Known(known));
        }
        // So that the result does not depend on how the file is cut.
        let (head, end) = match begun.get(..MOST_UNDECIDED) {
            Some(head) => (head, true),
            None => (begun, end),
        };
        let mut lines = without_mark(head).split_inclusive(|b| *b == b'\n');
        let Some(first) = lines.find(|line| !is_empty_or_comment(line)) else {
            return end.then_some(Self::Carmen);
        };
        let word = first.trim_ascii_start();
        if revolution_log::is_beginning(word) {
            return Some(Self::Revolutions);
        }
        let length = word
            .iter()
            .position(|b| *b == b',' || b.is_ascii_whitespace());
        // Names of messages and columns, and numbers, are ASCII.
        let is_text = |word: &[u8]| word.iter().all(u8::is_ascii_graphic);
        match (length.map(|at| word[at]), word.first()) {
            (None, _) if !end => None,
            _ if !is_text(&word[..length.unwrap_or(word.len())]) => Some(Self::None),
            (Some(b','), _) => Some(Self::Rangers),
            (_, Some(b'0'..=b'9' | b'-' | b'+')) => Some(Self::Rover),
            _ => Some(Self::Carmen),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::carmen::CarmenLog;
    use flate2::Compression;
    use flate2::write::GzEncoder;
    use proptest::prelude::*;

    fn log_text() -> String {
        let scan = |i: u32| {
            let x = 0.1 * f64::from(i);
            format!("FLASER 3 1.0 2.0 3.0 {x} 0 0 {x} 0 0 {i}.5 host {i}.5\n")
        };
        (0..500).map(scan).collect()
    }

    fn packed(bytes: &[u8]) -> Vec<u8> {
        let mut encoder = GzEncoder::new(vec![], Compression::default());
        encoder.write_all(bytes).unwrap();
        encoder.finish().unwrap()
    }

    fn read(bytes: &[u8], piece: usize) -> Result<CarmenLog, LogError> {
        let mut reader = LogReader::default();
        for piece in bytes.chunks(piece) {
            reader.push(piece)?;
        }
        match reader.finish()? {
            Log::Carmen(log) => Ok(log),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn what_is_no_log_is_told_what_would_be_one() {
        let pictures: [(&[u8], &str); 6] = [
            (
                b"\xff\xd8\xff\xe0\x00\x10JFIF\x00\x01\x01,\x00\n,",
                "this is a JPEG picture",
            ),
            (
                b"\x89PNG\r\n\x1a\n\x00\x00\x00\rIHDR",
                "this is a PNG picture",
            ),
            (b"PK\x03\x04\x14\x00\x00\x00", "this is a ZIP archive"),
            (b"<!doctype html><p>Not found", "this is an HTML page"),
            (b"#ROSBAG V1.2\n", "this is a bag of ROS 1"),
            (b"\xef\xbb\xbf\x00,", "the file is no text"),
        ];
        for (picture, what) in pictures {
            for bytes in [picture.to_vec(), packed(picture)] {
                for piece in [1, 5, 100] {
                    let error = read(&bytes, piece).unwrap_err();
                    let text = error.to_string();
                    assert!(text.starts_with(what), "{text}");
                    assert_eq!(error.is_of_ros(), what.contains("ROS"));
                    // If a file's true kind was reported, the list of expected kinds is not needed.
                    if matches!(error, LogError::Known(_)) || error.is_of_ros() {
                        continue;
                    }
                    for kind in ["CARMEN", "rover", "rangers", "bridge"] {
                        assert!(text.contains(kind), "{text}");
                    }
                }
            }
        }
    }

    #[test]
    fn a_log_in_which_nothing_was_measured_is_refused() {
        let rover = format!("0 0 0{}\n", " nan".repeat(360));
        let texts = [
            "FLASER 3 nan inf nan 0 0 0 0 0 0 1.5 host 1.5\n",
            "t_s,x_m,y_m,yaw_rad,range0,range1,range2,range3\n0,0,0,0,inf,inf,nan,\n",
            "__t:1.0_d:inf_q:47|__t:2.0_d:nan_q:47|-END-\n",
            &rover,
        ];
        for text in texts {
            let mut reader = LogReader::default();
            let read = reader.push(text.as_bytes()).and_then(|()| reader.finish());
            let error = read.unwrap_err();
            assert!(matches!(error, LogError::NothingMeasured(_)), "{error}");
        }
    }

    #[test]
    fn a_packed_log_is_the_log_however_it_is_cut() {
        let text = log_text();
        let plain = read(text.as_bytes(), 100).unwrap();
        assert_eq!(plain.scans.len(), 500);
        let one = packed(text.as_bytes());
        let (first, second) = text.split_at(text.len() / 2);
        let members = [packed(first.as_bytes()), packed(second.as_bytes())].concat();
        for file in [&one, &members] {
            for piece in [1, 7, 100_000] {
                assert_eq!(read(file, piece).unwrap(), plain);
            }
        }
    }

    #[test]
    fn a_damaged_gzip_file_is_refused_in_words() {
        let whole = packed(log_text().as_bytes());
        for cut in [3, 9, whole.len() / 2, whole.len() - 1] {
            let error = read(&whole[..cut], 64).unwrap_err();
            assert!(matches!(error, LogError::Gzip(_)), "{cut}: {error}");
            assert!(error.to_string().contains("not all of it is here"));
        }
        let mut damaged = whole.clone();
        let middle = damaged.len() / 2;
        damaged[middle] ^= 0xff;
        // The part unpacked before the damage may already not be a log.
        read(&damaged, 64).unwrap_err();
        // A wrong checksum.
        let mut wrong = whole.clone();
        let checksum = wrong.len() - 6;
        wrong[checksum] ^= 0xff;
        assert!(matches!(read(&wrong, 64), Err(LogError::Gzip(_))));
        assert_eq!(read(&packed(&whole), 64), Err(LogError::GzipInGzip));
        let nothing = read(&packed(b""), 64).unwrap_err();
        assert_eq!(nothing, LogError::Carmen(CarmenError::Empty));
    }

    proptest! {
        #[test]
        fn a_changed_gzip_file_never_panics_and_is_the_same_log_if_it_is_one(
            edits in proptest::collection::vec((0.0..1.0_f64, 0_u8..3, any::<u8>()), 1..4),
        ) {
            let mut bytes = packed(log_text().as_bytes());
            for (place, kind, byte) in edits {
                let at = (bytes.len() as f64 * place) as usize;
                match (kind, bytes.get_mut(at)) {
                    (0, _) => bytes.truncate(at),
                    (1, Some(old)) => *old = byte,
                    _ => bytes.insert(at, byte),
                }
            }
            if let (Ok(a), Ok(b)) = (read(&bytes, 7), read(&bytes, 100_000)) {
                prop_assert_eq!(a, b);
            }
        }
    }
}

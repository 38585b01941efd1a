//! Experiment files (`.slamlab`): a map with everything that a later run needs to go on in it.
//!
//! In: an [`Experiment`]. Out: bytes. And back, or what is wrong and where.
//!
//! | bytes | what |
//! |---|---|
//! | 8 | `89` and `slamlab` |
//! | 4 | version of the format: 7 |
//! | 8 | length of the content, unpacked |
//! | 8 | XXH64 of the content, unpacked |
//! | rest | the content, packed (RFC 1950, zlib) |
//!
//! Numbers are little-endian. The content is the fields of [`Experiment`], encoded as in
//! [`crate::snapshot`]. A file of another version is refused: the content of a newer version is
//! unknown, and maps of version 1, which was never released, lack what is learned of the sensor's
//! angle. Unpacking stops at the length that the file states, and that length is believed only as
//! far as the packed bytes can expand to it.

use std::io::{ErrorKind, Read as _, Write as _};

use flate2::Compression;
use flate2::read::ZlibDecoder;
use flate2::write::ZlibEncoder;
use twox_hash::XxHash64;

use crate::estimation::SavedMap;
use crate::snapshot::{Reader, Snapshot as _, SnapshotError, snapshot};

/// The first bytes of a file.
pub const MAGIC: [u8; 8] = *b"\x89slamlab";
/// The version that is written and read.
pub const VERSION: u32 = 7;
/// The longest content that is unpacked, bytes: some tens of kilometres of driving.
pub const MOST_UNPACKED: u64 = 1 << 29;
/// Zlib packs at most this many bytes into one, ...
const MOST_RATIO: u64 = 1032;
/// ... plus this many.
const HEAD: u64 = 64;

/// What an experiment file holds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Experiment {
    /// What people call it.
    pub title: String,
    /// The program that wrote it, with its version.
    pub program: String,
    /// Name of the method that made the map.
    pub method: String,
    /// Settings that differed from their defaults, by their keys.
    pub settings: Vec<(String, f64)>,
    /// The map.
    pub map: SavedMap,
}

snapshot!(Experiment {
    title,
    program,
    method,
    settings,
    map,
});

/// Why a file is not an experiment that can be opened.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SlamlabError {
    /// A file of another kind.
    #[error("this is no .slamlab file: it does not begin as one")]
    NotSlamlab,
    /// A file of another version.
    #[error(
        "the .slamlab file is of version {found}, and this program reads version {VERSION}: it was written by {} one",
        if *found > VERSION { "a newer" } else { "an older" }
    )]
    Version {
        /// The version in the file.
        found: u32,
    },
    /// The file ends within its header.
    #[error("the .slamlab file ends within its header, at byte {at}")]
    Header {
        /// Its length.
        at: usize,
    },
    /// The content is too long.
    #[error("the .slamlab file says that it unpacks to {bytes} bytes; {most} are possible")]
    TooLong {
        /// The length that the file states.
        bytes: u64,
        /// The most that this number of packed bytes, or this program, can hold.
        most: u64,
    },
    /// The content cannot be packed.
    #[error("the .slamlab file cannot be packed: {0}")]
    Packing(String),
    /// A part of the content is missing.
    #[error(
        "the .slamlab file is cut off: it ends at byte {at}, with {has} of the {of} bytes that it unpacks to"
    )]
    Cut {
        /// Its length.
        at: usize,
        /// Bytes that could be unpacked.
        has: usize,
        /// The length that the file states.
        of: u64,
    },
    /// The content is not what was written.
    #[error(
        "the .slamlab file is damaged: what stands before byte {before} is not what was written"
    )]
    Damaged {
        /// Where the damage was detected: it lies before this byte, but not in the first 12 bytes.
        before: usize,
    },
    /// The content is inconsistent.
    #[error("the .slamlab file cannot be read: {0}")]
    Content(#[from] SnapshotError),
}

/// Writes a file.
///
/// # Errors   [`SlamlabError::TooLong`] for a map too large to be read back,
/// [`SlamlabError::Packing`].
pub fn write(experiment: &Experiment) -> Result<Vec<u8>, SlamlabError> {
    let mut content = vec![];
    experiment.write(&mut content);
    let bytes = content.len() as u64;
    if bytes > MOST_UNPACKED {
        let most = MOST_UNPACKED;
        return Err(SlamlabError::TooLong { bytes, most });
    }
    let mut file = MAGIC.to_vec();
    file.extend(VERSION.to_le_bytes());
    file.extend(bytes.to_le_bytes());
    file.extend(XxHash64::oneshot(0, &content).to_le_bytes());
    let words = |error: std::io::Error| SlamlabError::Packing(error.to_string());
    let mut packer = ZlibEncoder::new(file, Compression::default());
    packer.write_all(&content).map_err(words)?;
    packer.finish().map_err(words)
}

/// Reads a file.
///
/// # Errors   [`SlamlabError`]: what is wrong, and where.
pub fn read(file: &[u8]) -> Result<Experiment, SlamlabError> {
    let content = unpacked(file)?;
    let mut from = Reader::new(&content);
    let experiment = Experiment::read(&mut from)?;
    from.rule(from.is_at_end(), "more follows than an experiment")?;
    Ok(experiment)
}

/// Whether a file begins like one of these.
#[must_use]
pub fn begins(file: &[u8]) -> bool {
    file.starts_with(&MAGIC)
}

fn unpacked(file: &[u8]) -> Result<Vec<u8>, SlamlabError> {
    let rest = file.strip_prefix(&MAGIC).ok_or(SlamlabError::NotSlamlab)?;
    let ends = || SlamlabError::Header { at: file.len() };
    let (version, rest) = rest.split_first_chunk().ok_or_else(ends)?;
    let found = u32::from_le_bytes(*version);
    if found != VERSION {
        return Err(SlamlabError::Version { found });
    }
    let (bytes, rest) = rest.split_first_chunk().ok_or_else(ends)?;
    let (sum, packed) = rest.split_first_chunk().ok_or_else(ends)?;
    let bytes = u64::from_le_bytes(*bytes);
    let most = MOST_UNPACKED.min(packed.len() as u64 * MOST_RATIO + HEAD);
    if bytes > most {
        return Err(SlamlabError::TooLong { bytes, most });
    }
    let mut content = vec![];
    // One more byte would show that the data goes on.
    let mut unpacker = ZlibDecoder::new(packed).take(bytes + 1);
    let read = unpacker.read_to_end(&mut content);
    let has = content.len();
    if read.is_ok()
        && has as u64 == bytes
        && XxHash64::oneshot(0, &content) == u64::from_le_bytes(*sum)
    {
        return Ok(content);
    }
    let ends = matches!(&read, Err(error) if error.kind() == ErrorKind::UnexpectedEof);
    if ends && (has as u64) < bytes {
        let (at, of) = (file.len(), bytes);
        return Err(SlamlabError::Cut { at, has, of });
    }
    let unread = match read {
        Ok(_) => 0,
        Err(_) => packed.len() - unpacker.get_ref().total_in() as usize,
    };
    Err(SlamlabError::Damaged {
        before: file.len() - unread,
    })
}

#[cfg(test)]
mod tests;

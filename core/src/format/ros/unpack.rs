//! Decompresses chunks of bags and of MCAP files.
//!
//! In: the bytes of a chunk, the name of its compression, and its claimed length. Out: exactly that
//! many bytes: decompression stops at the claimed length, even if the data would expand to
//! gigabytes.

use std::io::Read;

use bzip2::read::BzDecoder;
use lz4_flex::frame::FrameDecoder;
use ruzstd::decoding::StreamingDecoder;

/// No recorder writes longer chunks: they are some megabytes long.
const LONGEST: u64 = 256 << 20;

/// Why a chunk cannot be decompressed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub(super) enum UnpackError {
    /// The compression method is not supported.
    #[error("the chunk is compressed by `{0}`; known are none, bz2, lz4 and zstd")]
    Unknown(String),
    /// It claims to hold more than any recorder writes.
    #[error("the chunk claims to hold {claimed} bytes; at most {LONGEST} are unpacked")]
    TooLong {
        /// The claimed length.
        claimed: u64,
    },
    /// The data cannot be decompressed.
    #[error("the chunk does not unpack by {how}: {why}")]
    Damaged {
        /// Name of the method.
        how: String,
        /// The decompressor's message.
        why: String,
    },
    /// The decompressed length is not the claimed one.
    #[error("the chunk unpacks to {found} bytes and claims {claimed}")]
    Length {
        /// The claimed length.
        claimed: u64,
        /// Bytes that came out; one more than claimed if the data goes on.
        found: u64,
    },
}

/// Decompresses a chunk. `how` is the name used in bags and MCAP files: empty or `none`, `bz2`,
/// `lz4` (a frame), `zstd`.
///
/// # Errors    [`UnpackError`].
pub(super) fn unpack(how: &str, packed: &[u8], claimed: u64) -> Result<Vec<u8>, UnpackError> {
    if claimed > LONGEST {
        return Err(UnpackError::TooLong { claimed });
    }
    let damaged = |why: String| UnpackError::Damaged {
        how: how.to_owned(),
        why,
    };
    let unpacked = match how {
        "" | "none" => Ok(packed.to_vec()),
        "bz2" => all(BzDecoder::new(packed), claimed),
        "lz4" => all(FrameDecoder::new(packed), claimed),
        "zstd" => match StreamingDecoder::new(packed) {
            Ok(decoder) => all(decoder, claimed),
            Err(error) => return Err(damaged(error.to_string())),
        },
        other => return Err(UnpackError::Unknown(other.to_owned())),
    };
    let unpacked = unpacked.map_err(|error| damaged(error.to_string()))?;
    let found = unpacked.len() as u64;
    match found == claimed {
        true => Ok(unpacked),
        false => Err(UnpackError::Length { claimed, found }),
    }
}

/// Reads one byte more than claimed, which shows whether the data goes on; memory grows with the
/// bytes read.
fn all(reader: impl Read, claimed: u64) -> std::io::Result<Vec<u8>> {
    let mut bytes = vec![];
    reader.take(claimed + 1).read_to_end(&mut bytes)?;
    Ok(bytes)
}

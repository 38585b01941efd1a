//! Chunks of bags and of MCAP files, unpacked.
//!
//! In: the bytes of a chunk, the name of its compression, and how many bytes it claims to hold.
//! Out: those bytes, no more and no fewer: a chunk that claims little and unpacks to gigabytes ends
//! at what it claims.

use std::io::Read;

use bzip2::read::BzDecoder;
use lz4_flex::frame::FrameDecoder;
use ruzstd::decoding::StreamingDecoder;

/// No chunk of a recorder holds more: they are some megabytes long.
const LONGEST: u64 = 256 << 20;

/// Why a chunk cannot be unpacked.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub(super) enum UnpackError {
    /// By a method that is not known here.
    #[error("the chunk is compressed by `{0}`; known are none, bz2, lz4 and zstd")]
    Unknown(String),
    /// It claims to hold more than any recorder writes.
    #[error("the chunk claims to hold {claimed} bytes; at most {LONGEST} are unpacked")]
    TooLong {
        /// By its own word.
        claimed: u64,
    },
    /// It does not unpack.
    #[error("the chunk does not unpack by {how}: {why}")]
    Damaged {
        /// Name of the method.
        how: String,
        /// In the words of the decompressor.
        why: String,
    },
    /// It unpacks to another length.
    #[error("the chunk unpacks to {found} bytes and claims {claimed}")]
    Length {
        /// By its own word.
        claimed: u64,
        /// Bytes that came out; one more than claimed where it did not end there.
        found: u64,
    },
}

/// Unpacks a chunk. `how` is the name that bags and MCAP files have for it: empty or `none`,
/// `bz2`, `lz4` (a frame), `zstd`.
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

/// What is claimed and a byte more, so that one that goes on is seen; memory grows as bytes come.
fn all(reader: impl Read, claimed: u64) -> std::io::Result<Vec<u8>> {
    let mut bytes = vec![];
    reader.take(claimed + 1).read_to_end(&mut bytes)?;
    Ok(bytes)
}

//! A world file as letters of an address, and back.
//!
//! The text is packed (RFC 1951, raw deflate) and written in the letters of RFC 4648, section 5,
//! without padding, as the page's editor does for `#world=`. It is kept letter for letter: reading
//! and rewriting a world rounds its headings, and a run in it would end in another state.

use std::io::Write as _;

use base64::Engine as _;
use base64::engine::general_purpose::URL_SAFE_NO_PAD;
use flate2::write::DeflateEncoder;
use flate2::{Compression, Decompress, FlushDecompress, Status};

use super::LinkError;

/// Longest text of a world in a link, bytes: a building of ten thousand walls. A long text may be
/// packed into a few letters.
pub(super) const MOST_TEXT: usize = 1_000_000;
/// Memory is reserved in steps of this many bytes, so a few letters cannot claim all of it.
const GROWS: usize = 1 << 16;

pub(super) fn pack(text: &str) -> Result<String, LinkError> {
    if text.len() > MOST_TEXT {
        return Err(LinkError::DrawingTooLong(text.len()));
    }
    let mut packer = DeflateEncoder::new(vec![], Compression::best());
    // Writing to memory cannot fail.
    let packed = packer
        .write_all(text.as_bytes())
        .and_then(|()| packer.finish());
    Ok(URL_SAFE_NO_PAD.encode(packed.map_err(|_| LinkError::Damaged)?))
}

pub(super) fn unpack(letters: &str) -> Result<String, LinkError> {
    let packed = URL_SAFE_NO_PAD.decode(letters);
    let packed = packed.map_err(|_| LinkError::Damaged)?;
    let mut unpacker = Decompress::new(false);
    let mut text = vec![];
    loop {
        text.reserve(GROWS);
        let rest = packed.get(unpacker.total_in() as usize..);
        let rest = rest.unwrap_or_default();
        let status = unpacker.decompress_vec(rest, &mut text, FlushDecompress::None);
        let status = status.map_err(|_| LinkError::Damaged)?;
        if text.len() > MOST_TEXT {
            return Err(LinkError::DrawingTooLong(text.len()));
        }
        match status {
            Status::StreamEnd => break,
            // There was room, and nothing more to fill it with: the link was cut short.
            _ if text.len() < text.capacity() => return Err(LinkError::Damaged),
            Status::Ok | Status::BufError => {}
        }
    }
    String::from_utf8(text).map_err(|_| LinkError::Damaged)
}

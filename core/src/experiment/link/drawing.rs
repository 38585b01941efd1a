//! A world file as letters of an address, and back.
//!
//! The text is packed (RFC 1951, raw deflate) and written in the letters of RFC 4648, section 5,
//! without padding: what the page's editor shares behind `#world=`, too. It is kept letter for
//! letter: a world that was read and written again has its headings rounded, and a run in it would
//! come to another state.

use std::io::Write as _;

use base64::Engine as _;
use base64::engine::general_purpose::URL_SAFE_NO_PAD;
use flate2::write::DeflateEncoder;
use flate2::{Compression, Decompress, FlushDecompress, Status};

use super::LinkError;

/// Longest text of a world in a link, bytes: a building of ten thousand walls. Little can be packed
/// that is much.
pub(super) const MOST_TEXT: usize = 1_000_000;
/// Room is made for so many bytes at a time, so that a few letters cannot ask for all of it.
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
            // There was room, and nothing more to fill it with: it was cut.
            _ if text.len() < text.capacity() => return Err(LinkError::Damaged),
            Status::Ok | Status::BufError => {}
        }
    }
    String::from_utf8(text).map_err(|_| LinkError::Damaged)
}

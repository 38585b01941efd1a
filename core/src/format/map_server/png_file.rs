//! PNG images, through the crate `png`, row by row: 100 million pixels in four channels of two
//! bytes would take 800 MB at once.

use std::io::Cursor;

use png::{BitDepth, ColorType, Decoder, DecodingError, Encoder, EncodingError, Limits, Reader};

use super::MapImageError;
use super::read::{Pixel, Size};

/// Deflate expands one byte to at most this many.
const MOST_INFLATED: usize = 1032;
/// Most memory for an interlaced image, bytes. It comes in seven passes, none of which is complete,
/// so it is assembled in memory.
const MOST_INTERLACED: usize = 1 << 26;

/// Reads an image and passes its pixels to `see`, row by row from the top.
pub(super) fn read(bytes: &[u8], mut see: impl FnMut(Pixel)) -> Result<Size, MapImageError> {
    let mut decoder = Decoder::new_with_limits(Cursor::new(bytes), Limits { bytes: 1 << 24 });
    decoder.set_transformations(png::Transformations::EXPAND);
    decoder.ignore_checksums(false);
    let header = decoder.read_header_info()?;
    let size = Size::checked(header.width.into(), header.height.into())?;
    // Palettes are expanded and bits become bytes: a pixel in the file may take an eighth of the
    // byte that it becomes.
    let least = header.raw_row_length().saturating_mul(size.height);
    if least / MOST_INFLATED > bytes.len() {
        return Err(size.but_found(format!("{} bytes", bytes.len())));
    }
    let mut reader = decoder.read_info()?;
    let (colour, depth) = reader.output_color_type();
    let (channels, has_alpha) = match colour {
        ColorType::Grayscale | ColorType::Indexed => (1, false),
        ColorType::GrayscaleAlpha => (2, true),
        ColorType::Rgb => (3, false),
        ColorType::Rgba => (4, true),
    };
    let each = if depth == BitDepth::Sixteen { 2 } else { 1 };
    let mut seen = 0;
    let mut see_all = |samples: &[u8]| {
        for pixel in samples.chunks_exact(channels * each) {
            seen += 1;
            see(pixel_of(pixel, each, has_alpha));
        }
    };
    if reader.info().interlaced {
        see_all(&whole(&mut reader)?);
    } else {
        while let Some(row) = reader.next_row()? {
            see_all(row.data());
        }
    }
    if seen != size.pixels() {
        return Err(size.but_found(seen.to_string()));
    }
    Ok(size)
}

/// All samples of an interlaced image.
fn whole(reader: &mut Reader<Cursor<&[u8]>>) -> Result<Vec<u8>, MapImageError> {
    let most = MOST_INTERLACED;
    let length = reader.output_buffer_size().filter(|&length| length <= most);
    let mut samples = vec![0; length.ok_or(MapImageError::Interlaced { most })?];
    reader.next_frame(&mut samples)?;
    Ok(samples)
}

impl From<DecodingError> for MapImageError {
    fn from(error: DecodingError) -> Self {
        Self::Png(error.to_string())
    }
}

/// The mean of the colour channels.
fn pixel_of(bytes: &[u8], each: usize, has_alpha: bool) -> Pixel {
    let max = if each == 2 { 65535.0 } else { 255.0 };
    let sample = |b: &[u8]| f64::from(b.iter().fold(0_u32, |sum, &b| (sum << 8) | u32::from(b)));
    let (colours, alpha) = bytes.split_at(bytes.len() - usize::from(has_alpha) * each);
    let count = (colours.len() / each) as f64;
    Pixel {
        shade: colours.chunks_exact(each).map(sample).sum::<f64>() / (count * max),
        alpha: has_alpha.then(|| sample(alpha) / max),
    }
}

/// Writes rows of greys from the top; each grey is followed by its opacity if there are twice as
/// many bytes as pixels.
pub(super) fn write(
    (width, height): (usize, usize),
    samples: &[u8],
) -> Result<Vec<u8>, MapImageError> {
    let mut bytes = vec![];
    encode(&mut bytes, width, height, samples)
        .map_err(|error| MapImageError::Png(error.to_string()))?;
    Ok(bytes)
}

fn encode(
    bytes: &mut Vec<u8>,
    width: usize,
    height: usize,
    samples: &[u8],
) -> Result<(), EncodingError> {
    let side = |cells: usize| u32::try_from(cells).unwrap_or(0);
    let mut encoder = Encoder::new(bytes, side(width), side(height));
    encoder.set_depth(BitDepth::Eight);
    encoder.set_color(match samples.len() == 2 * width * height {
        true => ColorType::GrayscaleAlpha,
        false => ColorType::Grayscale,
    });
    let mut writer = encoder.write_header()?;
    writer.write_image_data(samples)?;
    writer.finish()
}

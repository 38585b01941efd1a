//! PGM images, plain (P2) and binary (P5).
//!
//! Source: Netpbm, pgm(5): magic number, width, height and largest grey, separated by spaces, with
//! comments from `#` to the end of a line; then, after one space, one byte per pixel, or two, high
//! byte first, if the largest grey is above 255. A file holds one image here.

use std::fmt::Write as _;
use std::str::FromStr;

use super::MapImageError;
use super::read::{Pixel, Size};
use crate::format::field_error::short;

/// Reads an image and passes its pixels to `see`, row by row from the top.
pub(super) fn read(bytes: &[u8], mut see: impl FnMut(Pixel)) -> Result<Size, MapImageError> {
    let mut words = Words { rest: bytes };
    let is_plain = words.next() == b"P2";
    let mut side = |field| words.read(field, "a whole number", |_| true);
    let size = Size::checked(side("width")?, side("height")?)?;
    let expected = "a whole number from 1 to 65535";
    let max = words.read("largest grey", expected, |max: &u16| *max > 0)?;
    let mut grey = |value: u16| {
        see(Pixel {
            shade: f64::from(value) / f64::from(max),
            alpha: None,
        });
    };
    if is_plain {
        read_plain(&mut words, size, max, &mut grey)?;
    } else {
        read_binary(words.rest, size, max, &mut grey)?;
    }
    Ok(size)
}

/// Writes rows of greys from 0 to 255, from the top.
pub(super) fn write(is_plain: bool, (width, height): (usize, usize), greys: &[u8]) -> Vec<u8> {
    let magic = if is_plain { "P2" } else { "P5" };
    let mut text = format!("{magic}\n# slamlab\n{width} {height}\n255\n");
    if !is_plain {
        let mut bytes = text.into_bytes();
        bytes.extend_from_slice(greys);
        return bytes;
    }
    // A line holds at most 70 characters.
    for line in greys.chunks(width.max(1)).flat_map(|row| row.chunks(17)) {
        for (place, grey) in line.iter().enumerate() {
            // Writing to a string does not fail.
            let _ = write!(text, "{}{grey}", if place == 0 { "" } else { " " });
        }
        text.push('\n');
    }
    text.into_bytes()
}

fn read_plain(
    words: &mut Words,
    size: Size,
    max: u16,
    grey: &mut impl FnMut(u16),
) -> Result<(), MapImageError> {
    for index in 0..size.pixels() {
        let word = words.next();
        if word.is_empty() {
            return Err(size.but_found(format!("{index}")));
        }
        let text = String::from_utf8_lossy(word);
        let value = text.parse().ok().filter(|&value| value <= max);
        grey(value.ok_or_else(|| MapImageError::Pixel {
            index,
            found: short(&text),
            max,
        })?);
    }
    match words.next() {
        [] => Ok(()),
        _ => Err(size.but_found("more".to_owned())),
    }
}

fn read_binary(
    rest: &[u8],
    size: Size,
    max: u16,
    grey: &mut impl FnMut(u16),
) -> Result<(), MapImageError> {
    let each = if max > 255 { 2 } else { 1 };
    // One space ends the header.
    let pixels = rest.get(1..).unwrap_or(&[]);
    let (pixels, after) = pixels
        .split_at_checked(size.pixels() * each)
        .ok_or_else(|| size.but_found(format!("{}", pixels.len() / each)))?;
    if !after.iter().all(u8::is_ascii_whitespace) {
        return Err(size.but_found(format!("{} bytes more", after.len())));
    }
    for (index, pixel) in pixels.chunks_exact(each).enumerate() {
        let value = pixel.iter().fold(0, |sum, &b| (sum << 8) | u16::from(b));
        if value > max {
            return Err(MapImageError::Pixel {
                index,
                found: value.to_string(),
                max,
            });
        }
        grey(value);
    }
    Ok(())
}

/// Words of a header, without comments.
struct Words<'a> {
    rest: &'a [u8],
}

impl<'a> Words<'a> {
    /// The next word; empty at the end.
    fn next(&mut self) -> &'a [u8] {
        loop {
            self.rest = self.rest.trim_ascii_start();
            if self.rest.first() != Some(&b'#') {
                break;
            }
            let end = self.rest.iter().position(|&b| b == b'\n');
            self.rest = end.map_or(&[], |end| &self.rest[end..]);
        }
        let end = self.rest.iter().position(u8::is_ascii_whitespace);
        let (word, rest) = self.rest.split_at(end.unwrap_or(self.rest.len()));
        self.rest = rest;
        word
    }

    /// The value of the next word, if it fits.
    fn read<T: FromStr>(
        &mut self,
        field: &'static str,
        expected: &'static str,
        fits: impl Fn(&T) -> bool,
    ) -> Result<T, MapImageError> {
        let word = String::from_utf8_lossy(self.next());
        let number = word.parse().ok().filter(fits);
        number.ok_or_else(|| MapImageError::Header {
            field,
            found: short(&word),
            expected,
        })
    }
}

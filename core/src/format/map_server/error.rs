//! What can be wrong with a map's files.

use crate::format::FieldError;

/// Why a map cannot be written or read.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MapServerError {
    /// Nothing was ever inserted into the grid.
    #[error("the map is empty; expected at least one known cell")]
    Empty,
    /// The known cells span too large an area.
    #[error(
        "the map is {width} times {height} cells; expected at most {} together",
        super::MOST_CELLS
    )]
    TooLarge {
        /// Columns.
        width: usize,
        /// Rows.
        height: usize,
    },
    /// The number of cells does not match width and height.
    #[error("the map has {found} cells, expected {width} x {height}")]
    Cells {
        /// Number of cells.
        found: usize,
        /// Cells in a row.
        width: usize,
        /// Rows.
        height: usize,
    },
    /// PGM has no transparency, which mode `scale` needs.
    #[error("mode `scale` shows the unknown as transparent, which PGM cannot; write it as PNG")]
    NeedsPng,
    /// The YAML file.
    #[error("the map's YAML: {0}")]
    Info(#[from] MapInfoError),
    /// The image.
    #[error("the map's image: {0}")]
    Image(#[from] MapImageError),
}

/// Why bytes are not the YAML file of a map.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MapInfoError {
    /// Longer than any such file.
    #[error("{bytes} bytes, expected at most {most}")]
    TooLong {
        /// Its length.
        bytes: usize,
        /// The longest that is accepted.
        most: usize,
    },
    /// Not valid YAML, or the outermost level is not a mapping of keys to values.
    #[error("line {line}: {what}")]
    Syntax {
        /// Line, from 1.
        line: usize,
        /// What is wrong.
        what: String,
    },
    /// A required key is missing.
    #[error("the key `{key}` is missing")]
    Missing {
        /// The key.
        key: &'static str,
    },
    /// An invalid value, or a key that appears twice.
    #[error(transparent)]
    Field(#[from] FieldError),
}

/// Why bytes are not the image of a map.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MapImageError {
    /// Neither PGM nor PNG.
    #[error("neither PGM (P2, P5) nor PNG: it begins with {found:?}")]
    Format {
        /// The first bytes, as text.
        found: String,
    },
    /// A field of the header of a PGM.
    #[error("the PGM's {field} is `{found}`, expected {expected}")]
    Header {
        /// The field.
        field: &'static str,
        /// What was found.
        found: String,
        /// What was expected.
        expected: &'static str,
    },
    /// More pixels than a map may have, or none.
    #[error("{width} x {height} pixels, expected at least one and at most {most}")]
    Size {
        /// Columns.
        width: u64,
        /// Rows.
        height: u64,
        /// Most pixels.
        most: usize,
    },
    /// The pixels do not match the header.
    #[error("the header promises {width} x {height} pixels, the file holds {found}")]
    Pixels {
        /// Columns.
        width: usize,
        /// Rows.
        height: usize,
        /// What was found, in words.
        found: String,
    },
    /// A pixel of a plain PGM that is not a valid grey.
    #[error("pixel {index} is `{found}`, expected a whole number from 0 to {max}")]
    Pixel {
        /// Its number, from 0, row by row from the top.
        index: usize,
        /// What was found.
        found: String,
        /// The largest grey.
        max: u16,
    },
    /// An interlaced PNG that is too large to be assembled in memory.
    #[error("the PNG is interlaced and larger than {most} bytes; save it without interlacing")]
    Interlaced {
        /// The most bytes that its samples may take.
        most: usize,
    },
    /// A PNG that cannot be decoded, with the decoder's message.
    #[error("the PNG cannot be read: {0}")]
    Png(String),
}

//! From the files to the map.

use super::{
    MOST_CELLS, MapImageError, MapInfo, MapMode, MapServerError, NOTHING_KNOWN, OccupancyMap, pgm,
    png_file,
};

/// Reads a map: the YAML file, and the image that it names.
///
/// # Errors    [`MapServerError::Info`] and [`MapServerError::Image`], with what was found where
/// and what was expected.
pub fn read(yaml: &[u8], image: &[u8]) -> Result<OccupancyMap, MapServerError> {
    read_image(&MapInfo::parse(yaml)?, image)
}

/// Reads the image of a map whose YAML file has been read.
///
/// # Errors    [`MapServerError::Image`].
pub fn read_image(info: &MapInfo, image: &[u8]) -> Result<OccupancyMap, MapServerError> {
    // Grows with what the file holds, not with what it promises.
    let mut from_top = vec![];
    let see = |pixel: Pixel| from_top.push(occupancy(info, &pixel));
    let Size { width, height } = match image {
        [b'P', b'2' | b'5', after, ..] if after.is_ascii_whitespace() => pgm::read(image, see)?,
        [0x89, b'P', b'N', b'G', ..] => png_file::read(image, see)?,
        _ => {
            let found = String::from_utf8_lossy(image.get(..8).unwrap_or(image)).into_owned();
            return Err(MapImageError::Format { found }.into());
        }
    };
    Ok(OccupancyMap {
        width,
        height,
        resolution: info.resolution,
        origin: info.origin,
        cells: from_top.rchunks(width).flatten().copied().collect(),
    })
}

/// One pixel of an image.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pixel {
    /// From 0 (black) to 1.
    pub(super) shade: f64,
    /// From 0 (transparent) to 1; `None` in an image without transparency.
    pub(super) alpha: Option<f64>,
}

/// What a pixel says of its cell, as in `loadMapFromFile` of nav2_map_server.
fn occupancy(info: &MapInfo, pixel: &Pixel) -> i8 {
    let shade = match (info.mode, pixel.alpha) {
        // In this mode opacity counts as a fourth colour.
        (MapMode::Trinary, Some(alpha)) => 0.75 * pixel.shade + 0.25 * alpha,
        _ => pixel.shade,
    };
    let p = if info.negate { shade } else { 1.0 - shade };
    let (free, occupied) = (info.free_thresh, info.occupied_thresh);
    match info.mode {
        MapMode::Raw => match (255.0 * shade).round() {
            value if value <= 100.0 => value as i8,
            _ => NOTHING_KNOWN,
        },
        MapMode::Scale if pixel.alpha.is_some_and(|alpha| alpha < 1.0) => NOTHING_KNOWN,
        _ if occupied < p => 100,
        _ if p < free => 0,
        MapMode::Trinary => NOTHING_KNOWN,
        MapMode::Scale if occupied > free => {
            ((p - free) / (occupied - free) * 100.0).round_ties_even() as i8
        }
        // Both thresholds are equal, and p equals them.
        MapMode::Scale => 50,
    }
}

/// Size of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Size {
    pub(super) width: usize,
    pub(super) height: usize,
}

impl Size {
    /// # Errors    [`MapImageError::Size`].
    pub(super) fn checked(width: u64, height: u64) -> Result<Self, MapImageError> {
        let pixels = width.checked_mul(height);
        if pixels.is_none_or(|pixels| pixels == 0 || pixels > MOST_CELLS as u64) {
            return Err(MapImageError::Size {
                width,
                height,
                most: MOST_CELLS,
            });
        }
        let (width, height) = (width as usize, height as usize);
        Ok(Self { width, height })
    }

    pub(super) fn pixels(self) -> usize {
        self.width * self.height
    }

    /// The error for pixels that do not match the header; `found` says in words what is there.
    pub(super) fn but_found(self, found: String) -> MapImageError {
        MapImageError::Pixels {
            width: self.width,
            height: self.height,
            found,
        }
    }
}

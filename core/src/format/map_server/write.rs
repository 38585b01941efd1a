//! From the map to the files.

use super::{
    FREE, MapMode, MapServerError, NOTHING_KNOWN, OCCUPIED, OccupancyMap, UNKNOWN, pgm, png_file,
};

/// Cells above this percentage are written as occupied in mode `trinary`, and the YAML says so.
const OCCUPIED_THRESH: f64 = 0.65;
/// Cells below this percentage are written as free in mode `trinary`. The grey of the unknown, 205,
/// is 50/255 = 0.19608, just above.
const FREE_THRESH: f64 = 0.196;

/// The file format of the image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MapImage {
    /// Binary PGM (P5).
    #[default]
    Pgm,
    /// Plain PGM (P2): text, four times as long.
    PlainPgm,
    /// PNG.
    Png,
}

impl MapImage {
    /// PNG if the name ends in `.png`, else binary PGM.
    #[must_use]
    pub fn of_name(name: &str) -> Self {
        match name.to_ascii_lowercase().ends_with(".png") {
            true => Self::Png,
            false => Self::Pgm,
        }
    }
}

/// The two files of a map.
#[derive(Clone, Debug, PartialEq)]
pub struct MapFiles {
    /// The image.
    pub image: Vec<u8>,
    /// The YAML file; it names the image as given to [`write()`].
    pub yaml: String,
}

/// Writes a map. `image_name` is the path of the image relative to the folder of the YAML file.
///
/// # Errors    [`MapServerError::Empty`] and [`MapServerError::Cells`] for an invalid map,
/// [`MapServerError::NeedsPng`].
pub fn write(
    map: &OccupancyMap,
    mode: MapMode,
    image: MapImage,
    image_name: &str,
) -> Result<MapFiles, MapServerError> {
    check(map)?;
    let size = (map.width, map.height);
    let pixels = || map.cells.rchunks(map.width).flatten();
    let image = match (mode, image) {
        (MapMode::Scale, MapImage::Png) => {
            let samples: Vec<u8> = pixels().flat_map(|&cell| scale(cell)).collect();
            png_file::write(size, &samples)?
        }
        (MapMode::Scale, _) => return Err(MapServerError::NeedsPng),
        (MapMode::Trinary | MapMode::Raw, file) => {
            let grey = if mode == MapMode::Raw { raw } else { trinary };
            let greys: Vec<u8> = pixels().map(|&cell| grey(cell)).collect();
            match file {
                MapImage::Png => png_file::write(size, &greys)?,
                other => pgm::write(other == MapImage::PlainPgm, size, &greys),
            }
        }
    };
    let yaml = yaml(map, mode, image_name);
    Ok(MapFiles { image, yaml })
}

fn check(map: &OccupancyMap) -> Result<(), MapServerError> {
    let &OccupancyMap { width, height, .. } = map;
    let found = map.cells.len();
    if found == 0 {
        return Err(MapServerError::Empty);
    }
    if width.checked_mul(height) != Some(found) {
        return Err(MapServerError::Cells {
            found,
            width,
            height,
        });
    }
    Ok(())
}

fn yaml(map: &OccupancyMap, mode: MapMode, image_name: &str) -> String {
    let entry = MapMode::ALL.iter().find(|(_, known)| *known == mode);
    let name = entry.map_or("", |(name, _)| name);
    // In mode `scale` what lies between the thresholds keeps its probability; with 0 and 1 that is
    // everything.
    let (free, occupied) = match mode {
        MapMode::Scale => (0.0, 1.0),
        MapMode::Trinary | MapMode::Raw => (FREE_THRESH, OCCUPIED_THRESH),
    };
    let (image, resolution, origin) = (yaml_string(image_name), map.resolution, &map.origin);
    format!(
        "image: {image}\nmode: {name}\nresolution: {resolution}\norigin: [{:.6}, {:.6}, {}]\nnegate: 0\n\
         occupied_thresh: {occupied}\nfree_thresh: {free}\n",
        origin.x(),
        origin.y(),
        origin.heading(),
    )
}

fn trinary(cell: i8) -> u8 {
    let p = f64::from(cell) / 100.0;
    match cell {
        0..=100 if p < FREE_THRESH => FREE,
        0..=100 if p > OCCUPIED_THRESH => OCCUPIED,
        _ => UNKNOWN,
    }
}

fn raw(cell: i8) -> u8 {
    u8::try_from(cell).ok().filter(|&p| p <= 100).unwrap_or(255)
}

/// Grey and opacity.
fn scale(cell: i8) -> [u8; 2] {
    if (0..=100).contains(&cell) {
        [(255.0 - 2.55 * f64::from(cell)).round() as u8, 255]
    } else {
        debug_assert!(cell == NOTHING_KNOWN, "a percentage of {cell}");
        [128, 0]
    }
}

/// A plain word unchanged; anything else in double quotes, escaped (YAML 1.2 §7.3.1: as in JSON).
fn yaml_string(text: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '.' | '_' | '-' | '/');
    if text.starts_with(|c: char| c.is_ascii_alphabetic()) && text.chars().all(is_plain) {
        text.to_owned()
    } else {
        serde_json::Value::from(text).to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn odd_names_of_images_are_quoted() {
        for (name, written) in [
            ("map.pgm", "map.pgm"),
            ("my map: 1.pgm", "\"my map: 1.pgm\""),
            ("a#b.pgm", "\"a#b.pgm\""),
            ("1.5", "\"1.5\""),
            ("say \"hi\".pgm", "\"say \\\"hi\\\".pgm\""),
            ("Küche.pgm", "\"Küche.pgm\""),
            ("", "\"\""),
        ] {
            assert_eq!(yaml_string(name), written);
        }
    }
}

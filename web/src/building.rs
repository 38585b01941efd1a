//! Buildings from files of others, for the page.

use slamlab_core::format::{building, map_server, world};
use wasm_bindgen::prelude::{JsError, wasm_bindgen};

/// A building as a world file.
#[wasm_bindgen(getter_with_clone)]
#[derive(Clone, Debug, PartialEq)]
pub struct Building {
    /// Text of the world file.
    pub world: String,
    /// What of the file is not in it, in words.
    pub left_out: Vec<String>,
}

impl From<building::Imported> for Building {
    fn from(imported: building::Imported) -> Self {
        Self {
            world: world::write(&imported.world),
            left_out: imported.left_out,
        }
    }
}

/// The building that a map of ROS map_server shows: the text of its YAML and the bytes of its image.
///
/// # Errors    A sentence on what stands where and what was expected.
#[wasm_bindgen]
pub fn building_of_map(yaml: &[u8], image: &[u8], name: &str) -> Result<Building, JsError> {
    let map = map_server::read(yaml, image)?;
    Ok(building::of_map(&map, name)?.into())
}

/// The building that a floor plan drawn as SVG shows.
///
/// # Errors    A sentence on what stands where and what was expected.
#[wasm_bindgen]
pub fn building_of_svg(bytes: &[u8], name: &str) -> Result<Building, JsError> {
    Ok(building::of_svg(bytes, None, name)?.into())
}

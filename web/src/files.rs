//! Buildings from the files of other programs, for the page: to drive in, and to localise in.
#![allow(
    clippy::needless_pass_by_value,
    reason = "lists cross the border by value only"
)]

use serde::{Deserialize, Serialize};
use slamlab_core::format::building::BuildingFile;
use slamlab_core::format::world;
use tsify::{Ts, Tsify};
use wasm_bindgen::prelude::wasm_bindgen;

use crate::border::{Typed, Uint8Array, WebError, typed};
use crate::building::PriorMapFile;

/// A file that was dropped or chosen; its name shows its kind.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
pub struct GivenFile {
    /// Name without its folder.
    pub name: String,
    /// Its content.
    pub bytes: Uint8Array,
}

/// A building as a world file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
#[serde(rename_all = "camelCase")]
pub struct Building {
    /// Text of the world file.
    pub world_json: String,
    /// What was left out of the file, in words.
    pub skipped: Vec<String>,
}

/// A building to drive in, from files that show it: a floor plan, a world, an `OGmap.txt`, a submap
/// (`.smap`), or the YAML and the image of a map of ROS.
///
/// # Errors    A sentence on what was found where, and what was expected.
#[wasm_bindgen]
pub fn read_building(name: &str, files: Vec<Ts<GivenFile>>) -> Typed<Building> {
    let imported = read(&files)?.into_world(name)?;
    typed(&Building {
        world_json: world::write(&imported.world),
        skipped: imported.skipped,
    })
}

/// The building's walls, to localise a robot by.
///
/// # Errors    A sentence on what was found where, and what was expected.
#[wasm_bindgen]
pub fn read_prior_map(name: &str, files: Vec<Ts<GivenFile>>) -> Typed<PriorMapFile> {
    typed(&PriorMapFile::of(name, &read(&files)?)?)
}

fn read(files: &[Ts<GivenFile>]) -> Result<BuildingFile, WebError> {
    let files: Vec<GivenFile> = files.iter().map(Ts::to_rust).collect::<Result<_, _>>()?;
    let files: Vec<(&str, &[u8])> = files.iter().map(|f| (f.name.as_str(), &*f.bytes)).collect();
    Ok(BuildingFile::read(&files, None)?)
}

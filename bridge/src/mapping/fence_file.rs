//! The geofence beside its map: `office.geofence.json` beside `office.slamlab`.
//!
//! ```json
//! { "zones": [{ "kind": "keep-in", "corners": [[0, 0], [4, 0], [4, 3]] }] }
//! ```
//!
//! Corners are x, y in the frame of the map, m. This file is the only place where a fence is kept:
//! drawn on a page, or written by hand while the bridge is not running.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use slamlab_core::wire::message::{ZoneBody, fence_of};

use super::MapError;
use crate::replaced_file::{Readers, replace, sync_folder};

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Content {
    zones: Vec<ZoneBody>,
}

/// Where the fence of a map is kept.
pub(super) fn beside(map: &Path) -> PathBuf {
    map.with_extension("geofence.json")
}

/// The zones in the file; none if there is no file.
///
/// # Errors    [`MapError::Fence`]: a fence that cannot be read must not count as no fence.
pub(super) fn read(map: &Path) -> Result<Vec<ZoneBody>, MapError> {
    let path = beside(map);
    let fault = |why: String| MapError::Fence {
        path: path.clone(),
        why,
    };
    let text = match fs::read_to_string(&path) {
        Ok(text) => text,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(vec![]),
        Err(error) => return Err(fault(error.to_string())),
    };
    let content: Content = serde_json::from_str(&text).map_err(|error| fault(error.to_string()))?;
    fence_of(&content.zones).map_err(|error| fault(error.to_string()))?;
    Ok(content.zones)
}

/// Keeps these zones; without any, removes the file.
pub(super) fn write(map: &Path, zones: &[ZoneBody]) -> io::Result<()> {
    let path = beside(map);
    if zones.is_empty() {
        return match fs::remove_file(&path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(()),
            removed => removed.and_then(|()| sync_folder(&path)),
        };
    }
    let zones = zones.to_vec();
    let text = serde_json::to_string_pretty(&Content { zones })?;
    replace(&path, text.as_bytes(), Readers::Anyone)
}

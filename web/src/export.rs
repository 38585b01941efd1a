//! What a person takes away from a run: the map, the walls, the way, the scans, as files of other programs.

use serde::{Deserialize, Serialize};
use slamlab_core::format::carmen::CarmenLog;
use slamlab_core::format::map_server::{self, MapImage, MapMode, OccupancyMap};
use slamlab_core::format::{floor_plan, og_map, rooms, tum};
use slamlab_core::geom::Pose2;
use slamlab_core::map::{Topology, TopologyConfig};
use slamlab_core::slam::Slam;
use tsify::Tsify;

use crate::border::{Uint8Array, WebError};

/// Why something cannot be saved.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ExportError {
    /// No scan yet.
    #[error("there is no scan yet: let the robot look around first")]
    NoScans,
    /// A robot's scans are not kept here.
    #[error(
        "the bridge records a robot's scans: open its recording here to save them as a CARMEN log"
    )]
    Recorded,
}

/// A file to save.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
pub struct SavedFile {
    /// Without a folder.
    pub name: String,
    /// What kind of file it is.
    pub mime: String,
    /// What stands in it.
    #[tsify(type = "Uint8Array<ArrayBuffer>")]
    pub bytes: Uint8Array,
}

impl SavedFile {
    fn new(name: impl Into<String>, mime: &str, bytes: impl Into<Vec<u8>>) -> Self {
        Self {
            name: name.into(),
            mime: mime.to_owned(),
            bytes: bytes.into().into(),
        }
    }
}

/// The grid as files of map_server.
///
/// # Errors    An empty map.
pub(crate) fn map(
    slam: &Slam,
    mode: MapMode,
    image: MapImage,
    name: &str,
) -> Result<Vec<SavedFile>, WebError> {
    let map = OccupancyMap::of_grid(slam.grid(), mode)?;
    let files = map_server::write(&map, mode, image, name)?;
    let (stem, mime) = match image {
        MapImage::Png => (name.trim_end_matches(".png"), "image/png"),
        _ => (name.trim_end_matches(".pgm"), "image/x-portable-graymap"),
    };
    Ok(vec![
        SavedFile::new(name, mime, files.image),
        SavedFile::new(format!("{stem}.yaml"), "application/yaml", files.yaml),
    ])
}

/// The grid as text.
///
/// # Errors    An empty map.
pub(crate) fn og_map(slam: &Slam) -> Result<Vec<SavedFile>, WebError> {
    let text = og_map::write(&og_map::of_grid(slam.grid())?);
    Ok(vec![SavedFile::new("OGmap.txt", "text/plain", text)])
}

/// The walls as a floor plan.
///
/// # Errors    No walls.
pub(crate) fn plan(slam: &Slam, stem: &str) -> Result<Vec<SavedFile>, WebError> {
    let walls = slam.vector_map().walls();
    let began = slam.trajectory().first().map(|(_, pose)| pose.position());
    let svg = floor_plan::svg(&walls, began)?;
    let dxf = floor_plan::dxf(&walls)?;
    let geojson = floor_plan::geojson(&walls)?;
    Ok(vec![
        SavedFile::new(format!("{stem}.svg"), "image/svg+xml", svg),
        SavedFile::new(format!("{stem}.dxf"), "image/vnd.dxf", dxf),
        SavedFile::new(format!("{stem}.geojson"), "application/geo+json", geojson),
    ])
}

/// Rooms and doors.
///
/// # Errors    No rooms.
pub(crate) fn rooms(slam: &Slam, stem: &str) -> Result<Vec<SavedFile>, WebError> {
    let rooms = Topology::of_grid(slam.grid(), &TopologyConfig::default());
    let text = rooms::geojson(&rooms)?;
    let name = format!("{stem}-rooms.geojson");
    Ok(vec![SavedFile::new(name, "application/geo+json", text)])
}

/// Where the robot was, as far as is known now: a TUM trajectory.
///
/// # Errors    [`ExportError::NoScans`].
pub(crate) fn trajectory(poses: &[(f64, Pose2)], stem: &str) -> Result<Vec<SavedFile>, WebError> {
    if poses.is_empty() {
        return Err(ExportError::NoScans.into());
    }
    let text = tum::write(poses.iter().copied());
    Ok(vec![SavedFile::new(
        format!("{stem}.tum"),
        "text/plain",
        text,
    )])
}

/// The scans with their odometry: a CARMEN log.
///
/// # Errors    [`ExportError::NoScans`].
pub(crate) fn carmen(log: &CarmenLog, stem: &str) -> Result<Vec<SavedFile>, WebError> {
    if log.is_empty() {
        return Err(ExportError::NoScans.into());
    }
    let name = format!("{stem}.clf");
    Ok(vec![SavedFile::new(name, "text/plain", log.write())])
}

/// Seconds instead of stamps.
pub(crate) fn trajectory_of(slam: &Slam) -> Vec<(f64, Pose2)> {
    let poses = slam.trajectory();
    poses
        .into_iter()
        .map(|(stamp, pose)| (stamp.seconds(), pose))
        .collect()
}

//! What a person can save of a run: the map, the walls, the path, the scans, as files for other
//! programs.

use serde::{Deserialize, Serialize};
use slamlab_core::format::carmen::CarmenLog;
use slamlab_core::format::g2o::{self, G2oGraph};
use slamlab_core::format::map_server::{self, MapImage, MapMode, OccupancyMap};
use slamlab_core::format::revolution_log::RevolutionLog;
use slamlab_core::format::smap::Smap;
use slamlab_core::format::{floor_plan, og_map, rooms, tum};
use slamlab_core::geom::Pose2;
use slamlab_core::map::{Topology, TopologyConfig};
use slamlab_core::robot::Stamp;
use slamlab_core::slam::Slam;
use tsify::{Ts, Tsify};
use wasm_bindgen::prelude::wasm_bindgen;

use crate::border::{SavedKind, Uint8Array, WebError, typed};
use crate::run::{Source, WebRun};

/// Why something cannot be saved.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ExportError {
    /// There is no scan yet.
    #[error("there is no scan yet: let the robot scan first")]
    NoScans,
    /// This method has no pose graph.
    #[error("this method keeps no pose graph: choose scan matching")]
    NoGraph,
    /// This method has no submaps.
    #[error("this method makes no submaps: choose scan matching")]
    NoSubmaps,
    /// The scans of a robot behind a bridge are not kept in the page.
    #[error("the bridge records a robot's scans: open its recording here to save them as a log")]
    Recorded,
}

crate::border::kinds! { Save: ExportError; }

/// A file to save.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
pub struct SavedFile {
    /// Name without a folder.
    pub name: String,
    /// Its MIME type.
    pub mime: String,
    /// Its content.
    #[tsify(type = "Uint8Array<ArrayBuffer>")]
    pub bytes: Uint8Array,
}

#[wasm_bindgen]
impl WebRun {
    /// Files to save, named after `stem`.
    ///
    /// # Errors    A sentence on why there is no such file.
    pub fn export(&self, what: &Ts<SavedKind>, stem: &str) -> Result<Vec<Ts<SavedFile>>, WebError> {
        let slam = self.slam();
        let files = match what.to_rust()? {
            SavedKind::Map => map(slam, MapMode::Trinary, MapImage::Pgm, stem),
            SavedKind::MapScale => map(slam, MapMode::Scale, MapImage::Png, &format!("{stem}-map")),
            SavedKind::MapRaw => map(slam, MapMode::Raw, MapImage::Pgm, &format!("{stem}-raw")),
            SavedKind::OgMap => og_map(slam),
            SavedKind::Smap => smap(slam, stem),
            SavedKind::Plan => plan(slam, stem),
            SavedKind::Rooms => rooms(slam, stem),
            SavedKind::Tum => trajectory(&self.trajectory(), stem),
            SavedKind::Slamlab => Ok(vec![self.experiment_file(stem)?]),
            SavedKind::G2o => graph(slam, stem),
            SavedKind::Revolutions => match &self.source {
                Source::Simulation(sim) => {
                    revolutions(&RevolutionLog::of_carmen(sim.experiment.log()), stem)
                }
                Source::Recording(replay) => revolutions(&replay.revolution_log(), stem),
                Source::Live(_) => Err(ExportError::Recorded.into()),
            },
            SavedKind::Carmen => match &self.source {
                Source::Simulation(sim) => carmen(sim.experiment.log(), stem),
                Source::Recording(replay) => carmen(&replay.carmen_log(), stem),
                Source::Live(_) => Err(ExportError::Recorded.into()),
            },
        };
        files?.iter().map(typed).collect()
    }
}

impl SavedFile {
    pub(crate) fn new(name: impl Into<String>, mime: &str, bytes: impl Into<Vec<u8>>) -> Self {
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
fn map(
    slam: &Slam,
    mode: MapMode,
    image: MapImage,
    stem: &str,
) -> Result<Vec<SavedFile>, WebError> {
    let map = OccupancyMap::of_grid(slam.grid(), mode)?;
    let (ending, mime) = match image {
        MapImage::Png => ("png", "image/png"),
        _ => ("pgm", "image/x-portable-graymap"),
    };
    let name = format!("{stem}.{ending}");
    let files = map_server::write(&map, mode, image, &name)?;
    Ok(vec![
        SavedFile::new(name, mime, files.image),
        SavedFile::new(format!("{stem}.yaml"), "application/yaml", files.yaml),
    ])
}

/// The grid as text.
///
/// # Errors    An empty map.
fn og_map(slam: &Slam) -> Result<Vec<SavedFile>, WebError> {
    let text = og_map::write(&og_map::of_grid(slam.grid())?);
    Ok(vec![SavedFile::new("OGmap.txt", "text/plain", text)])
}

/// Points, path and landmarks as a submap.
///
/// # Errors    An empty map, or one with more points than a submap may have.
fn smap(slam: &Slam, stem: &str) -> Result<Vec<SavedFile>, WebError> {
    let poses = slam.whole_trajectory().into_iter();
    let way = poses.map(|(_, pose)| pose.position());
    let (walls, points) = (slam.vector_map().walls(), slam.view().landmark_points());
    let smap = Smap::of_run(slam.grid(), way, &walls, points)?;
    let name = format!("{stem}.smap");
    Ok(vec![SavedFile::new(name, "text/plain", smap.write())])
}

/// The walls as a floor plan.
///
/// # Errors    No walls.
fn plan(slam: &Slam, stem: &str) -> Result<Vec<SavedFile>, WebError> {
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
fn rooms(slam: &Slam, stem: &str) -> Result<Vec<SavedFile>, WebError> {
    let rooms = Topology::of_grid(slam.grid(), &TopologyConfig::default());
    let text = rooms::geojson(&rooms)?;
    let name = format!("{stem}-rooms.geojson");
    Ok(vec![SavedFile::new(name, "application/geo+json", text)])
}

/// The poses at all scans, by the present estimate: a TUM trajectory.
///
/// # Errors    [`ExportError::NoScans`].
fn trajectory(poses: &[(f64, Pose2)], stem: &str) -> Result<Vec<SavedFile>, WebError> {
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

/// The pose graph: submaps, and the motions measured between them.
///
/// # Errors    [`ExportError::NoGraph`].
fn graph(slam: &Slam, stem: &str) -> Result<Vec<SavedFile>, WebError> {
    let graph = slam.view().graph.ok_or(ExportError::NoGraph)?;
    let text = g2o::write(&G2oGraph::from(graph));
    Ok(vec![SavedFile::new(
        format!("{stem}.g2o"),
        "text/plain",
        text,
    )])
}

/// The scans with their odometry: a CARMEN log.
///
/// # Errors    [`ExportError::NoScans`].
fn carmen(log: &CarmenLog, stem: &str) -> Result<Vec<SavedFile>, WebError> {
    if log.is_empty() {
        return Err(ExportError::NoScans.into());
    }
    let name = format!("{stem}.clf");
    Ok(vec![SavedFile::new(name, "text/plain", log.write())])
}

/// The scans without odometry: a log of revolutions.
///
/// # Errors    [`ExportError::NoScans`].
fn revolutions(log: &RevolutionLog, stem: &str) -> Result<Vec<SavedFile>, WebError> {
    if log.is_empty() {
        return Err(ExportError::NoScans.into());
    }
    let name = format!("{stem}-revolutions.txt");
    Ok(vec![SavedFile::new(name, "text/plain", log.write())])
}

impl WebRun {
    /// Times in seconds, and poses.
    fn trajectory(&self) -> Vec<(f64, Pose2)> {
        let seconds = |(stamp, pose): (Stamp, Pose2)| (stamp.seconds(), pose);
        match &self.source {
            Source::Recording(replay) => replay.trajectory(),
            _ => self.slam().trajectory().into_iter().map(seconds).collect(),
        }
    }
}

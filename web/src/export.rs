//! What a person takes away from a run: the map, the walls, the way, the scans, as files of other programs.

use slamlab_core::format::carmen::CarmenLog;
use slamlab_core::format::map_server::{self, MapImage, MapMode, OccupancyMap};
use slamlab_core::format::{floor_plan, og_map, rooms, tum};
use slamlab_core::geom::Pose2;
use slamlab_core::map::{Topology, TopologyConfig};
use slamlab_core::slam::Slam;
use wasm_bindgen::prelude::{JsError, wasm_bindgen};

/// Why something cannot be saved.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ExportError {
    /// Nothing of that name can be saved.
    #[error("there is no `{0}` to save")]
    Unknown(String),
    /// No scan yet.
    #[error("there is no scan yet: let the robot look around first")]
    NoScans,
    /// A robot's scans are not kept here.
    #[error(
        "the bridge records a robot's scans: open its recording here to save them as a CARMEN log"
    )]
    Recorded,
}

/// Files to save.
#[wasm_bindgen]
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Files {
    files: Vec<File>,
}

#[derive(Clone, Debug, PartialEq)]
struct File {
    name: String,
    mime: &'static str,
    bytes: Vec<u8>,
}

#[wasm_bindgen]
impl Files {
    /// How many.
    #[must_use]
    pub fn count(&self) -> usize {
        self.files.len()
    }

    /// Name of a file; empty where there is none.
    #[must_use]
    pub fn name(&self, index: usize) -> String {
        self.files
            .get(index)
            .map(|f| f.name.clone())
            .unwrap_or_default()
    }

    /// What kind of file it is.
    #[must_use]
    pub fn mime(&self, index: usize) -> String {
        self.files.get(index).map_or("", |f| f.mime).to_owned()
    }

    /// What stands in it.
    #[must_use]
    pub fn bytes(&self, index: usize) -> Vec<u8> {
        self.files
            .get(index)
            .map(|f| f.bytes.clone())
            .unwrap_or_default()
    }
}

impl Files {
    /// What every source has: `map`, `map-scale` and `map-raw` are files of map_server in its three modes.
    ///
    /// # Errors    An empty map, no walls, or no such thing.
    pub(crate) fn of(slam: &Slam, what: &str, stem: &str) -> Result<Self, JsError> {
        match what {
            "map" => Self::map(
                slam,
                MapMode::Trinary,
                MapImage::Pgm,
                &format!("{stem}.pgm"),
            ),
            "map-scale" => Self::map(
                slam,
                MapMode::Scale,
                MapImage::Png,
                &format!("{stem}-map.png"),
            ),
            "map-raw" => Self::map(
                slam,
                MapMode::Raw,
                MapImage::Pgm,
                &format!("{stem}-raw.pgm"),
            ),
            "og-map" => {
                let text = og_map::write(&og_map::of_grid(slam.grid())?);
                Ok(Self::default().with("OGmap.txt", "text/plain", text))
            }
            "plan" => {
                let walls = slam.vector_map().walls();
                let began = slam.trajectory().first().map(|(_, pose)| pose.position());
                let svg = floor_plan::svg(&walls, began)?;
                let dxf = floor_plan::dxf(&walls)?;
                let geojson = floor_plan::geojson(&walls)?;
                Ok(Self::default()
                    .with(&format!("{stem}.svg"), "image/svg+xml", svg)
                    .with(&format!("{stem}.dxf"), "image/vnd.dxf", dxf)
                    .with(&format!("{stem}.geojson"), "application/geo+json", geojson))
            }
            "rooms" => {
                let rooms = Topology::of_grid(slam.grid(), &TopologyConfig::default());
                let (name, text) = (format!("{stem}-rooms.geojson"), rooms::geojson(&rooms)?);
                Ok(Self::default().with(&name, "application/geo+json", text))
            }
            other => Err(ExportError::Unknown(other.to_owned()).into()),
        }
    }

    /// Where the robot was, as far as is known now: a TUM trajectory.
    ///
    /// # Errors    [`ExportError::NoScans`].
    pub(crate) fn trajectory(poses: &[(f64, Pose2)], stem: &str) -> Result<Self, JsError> {
        if poses.is_empty() {
            return Err(ExportError::NoScans.into());
        }
        let text = tum::write(poses.iter().copied());
        Ok(Self::default().with(&format!("{stem}.tum"), "text/plain", text))
    }

    /// The scans with their odometry: a CARMEN log.
    ///
    /// # Errors    [`ExportError::NoScans`].
    pub(crate) fn carmen(log: &CarmenLog, stem: &str) -> Result<Self, JsError> {
        if log.is_empty() {
            return Err(ExportError::NoScans.into());
        }
        Ok(Self::default().with(&format!("{stem}.clf"), "text/plain", log.write()))
    }

    fn map(slam: &Slam, mode: MapMode, image: MapImage, name: &str) -> Result<Self, JsError> {
        let map = OccupancyMap::of_grid(slam.grid(), mode)?;
        let files = map_server::write(&map, mode, image, name)?;
        let (stem, mime) = match image {
            MapImage::Png => (name.trim_end_matches(".png"), "image/png"),
            _ => (name.trim_end_matches(".pgm"), "image/x-portable-graymap"),
        };
        Ok(Self::default().with(name, mime, files.image).with(
            &format!("{stem}.yaml"),
            "application/yaml",
            files.yaml,
        ))
    }

    fn with(mut self, name: &str, mime: &'static str, bytes: impl Into<Vec<u8>>) -> Self {
        let (name, bytes) = (name.to_owned(), bytes.into());
        self.files.push(File { name, mime, bytes });
        self
    }
}

/// Seconds instead of stamps.
pub(crate) fn trajectory_of(slam: &Slam) -> Vec<(f64, Pose2)> {
    let poses = slam.trajectory();
    poses
        .into_iter()
        .map(|(stamp, pose)| (stamp.seconds(), pose))
        .collect()
}

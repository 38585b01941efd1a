//! A map in a file, to find a robot in.
//!
//! In: the path of a map's YAML (ROS map_server) or of a floor plan (SVG), and where the robot begins in it. Out: its walls, in the
//! frame of the robot's first pose. The programs that take `--known` share this file.

use std::path::Path;

use anyhow::{Context, Result};
use slamlab_core::estimation::KnownLine;
use slamlab_core::format::building;
use slamlab_core::format::map_server::{self, MapInfo, OccupancyMap};
use slamlab_core::geom::{Pose2, Segment};
use slamlab_core::slam::KnownMap;

/// A map to be found in. `svg_unit`: metres in a unit of a floor plan, where the drawing does not say. `start`: `map_from_robot` at
/// the beginning.
pub(crate) fn known_map(path: &Path, svg_unit: Option<f64>, start: &Pose2) -> Result<KnownMap> {
    let bytes = std::fs::read(path).with_context(|| format!("reading {}", path.display()))?;
    let mut known = KnownMap::default();
    let walls: Vec<Segment> = match path.extension().and_then(|e| e.to_str()) {
        Some("svg") => {
            let plan = building::of_svg(&bytes, svg_unit, "plan").context("--known")?;
            plan.world.walls().iter().map(|wall| wall.segment).collect()
        }
        _ => {
            let map = load_map(path, &bytes)?;
            known.sigma = map.resolution / 3.0;
            let outlines = building::walls_of_map(&map).context("--known")?;
            building::sides(&outlines).collect()
        }
    };
    known.lines = KnownLine::of_walls(&walls, &start.inverse());
    Ok(known)
}

/// A map of ROS map_server, with the image that its YAML names.
pub(crate) fn load_map(path: &Path, yaml: &[u8]) -> Result<OccupancyMap> {
    let told = || format!("{} is no map", path.display());
    let info = MapInfo::parse(yaml).with_context(told)?;
    let image = info.image_beside(path);
    let bytes = std::fs::read(&image).with_context(|| format!("reading {}", image.display()))?;
    map_server::read_image(&info, &bytes).with_context(told)
}

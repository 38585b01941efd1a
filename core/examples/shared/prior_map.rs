//! A building in a file: to drive in, or to localise a robot in.
//!
//! In: the path of a map's YAML (ROS map_server), of an `OGmap.txt`, of a submap (`.smap`), of a
//! floor plan (SVG) or of a world (JSON). Out: its content. The programs that take `--prior-map`
//! share this file.

use std::path::Path;

use anyhow::{Context, Result, bail};
use slamlab_core::format::building::BuildingFile;
use slamlab_core::format::map_server::MapInfo;
use slamlab_core::geom::Pose2;
use slamlab_core::slam::PriorMap;

/// Where the robot begins in a map.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Start {
    /// `map_from_robot`.
    At(Pose2),
    Anywhere,
}

/// A map to localise the robot in. `svg_unit`: metres per unit of a floor plan, if the drawing does
/// not say. If the robot may begin anywhere, the map keeps the frame of its file.
pub(crate) fn read(path: &Path, svg_unit: Option<f64>, start: &Start) -> Result<PriorMap> {
    let walls = load(path, svg_unit)?
        .prior_walls()
        .with_context(|| format!("{} is no map", path.display()))?;
    for what in &walls.skipped {
        eprintln!("{}: skipped {what}", path.display());
    }
    let (at, anywhere) = match start {
        Start::At(pose) => (*pose, false),
        Start::Anywhere => (Pose2::identity(), true),
    };
    Ok(PriorMap {
        anywhere,
        ..PriorMap::of_faces(&walls.faces, walls.sigma, &at)
    })
}

/// The content of a file; with the YAML of a map, the image that it names is read.
pub(crate) fn load(path: &Path, svg_unit: Option<f64>) -> Result<BuildingFile> {
    let read =
        |path: &Path| std::fs::read(path).with_context(|| format!("reading {}", path.display()));
    let is_none = || format!("{} is no building", path.display());
    let mut files = vec![(path.to_path_buf(), read(path)?)];
    if path.extension().is_some_and(|e| e == "yaml" || e == "yml") {
        let info = MapInfo::parse(&files[0].1).with_context(is_none)?;
        let image = info.image_beside(path);
        let bytes = read(&image)?;
        files.push((image, bytes));
    }
    let names: Vec<_> = files.iter().map(|(p, _)| p.to_string_lossy()).collect();
    let bytes = files.iter().map(|(_, bytes)| bytes.as_slice());
    let files: Vec<(&str, &[u8])> = names.iter().map(AsRef::as_ref).zip(bytes).collect();
    BuildingFile::read(&files, svg_unit).with_context(is_none)
}

/// `anywhere`, or a pose as [`pose`] reads it.
pub(crate) fn start(text: &str) -> Result<Start> {
    match text {
        "anywhere" => Ok(Start::Anywhere),
        text => Ok(Start::At(pose(text)?)),
    }
}

/// A pose from `x,y,heading`, the heading in degrees.
pub(crate) fn pose(text: &str) -> Result<Pose2> {
    let Some([x, y, degrees]) = numbers(text) else {
        bail!("`{text}` is no pose; expected three finite numbers `x,y,heading`")
    };
    Ok(Pose2::new(x, y, degrees.to_radians()))
}

/// `N` finite numbers, separated by commas.
pub(crate) fn numbers<const N: usize>(text: &str) -> Option<[f64; N]> {
    let number = |word: &str| word.trim().parse().ok().filter(|n: &f64| n.is_finite());
    let numbers: Option<Vec<f64>> = text.split(',').map(number).collect();
    numbers?.try_into().ok()
}

//! The files that are written: all of them or none, and never over one that was read.

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use slamlab_core::estimation::{DriveFit, FittedParameter};
use slamlab_core::format::map_server::{self, MapImage, MapMode, OccupancyMap};
use slamlab_core::format::preset::{self, FittedLine, PresetFile};
use slamlab_core::format::{og_map, tum};
use slamlab_core::geom::Pose2;
use slamlab_core::replay::Replay;

use super::Arguments;

/// Finds what would go wrong at the end of a long run before it begins.
///
/// # Errors    A folder that is missing, a file that two options name.
pub(super) fn check(arguments: &Arguments) -> anyhow::Result<()> {
    let mut taken = vec![("--log", arguments.log.clone())];
    taken.extend(
        arguments
            .relations
            .clone()
            .map(|path| ("--relations", path)),
    );
    taken.extend(arguments.preset.clone().map(|path| ("--preset", path)));
    let map = arguments.map.as_deref();
    let outputs = [
        ("--tum", arguments.tum.clone()),
        ("--map", map.map(Path::to_owned)),
        ("the YAML of --map", map.map(yaml_of)),
        ("--fit", arguments.fit.clone()),
        ("--og-map", arguments.og_map.clone()),
        ("--carmen", arguments.carmen.clone()),
    ];
    for (option, path) in outputs {
        let Some(path) = path else { continue };
        let folder = path
            .parent()
            .filter(|folder| !folder.as_os_str().is_empty());
        if path.file_name().is_none() || path.is_dir() {
            bail!("{option}: {} is no name of a file", path.display());
        }
        if let Some(folder) = folder.filter(|folder| !folder.is_dir()) {
            bail!("{option}: there is no folder {}", folder.display());
        }
        if let Some((other, _)) = taken.iter().find(|(_, known)| *known == path) {
            bail!("{option}: {} is also the file of {other}", path.display());
        }
        taken.push((option, path));
    }
    Ok(())
}

/// Writes trajectory and map as asked for.
///
/// # Errors    An empty map, or a file that cannot be written; what stood there before is kept then.
pub(super) fn save(
    arguments: &Arguments,
    replay: &Replay,
    trajectory: &[(f64, Pose2)],
    fit: Option<&DriveFit>,
) -> anyhow::Result<()> {
    let mut files: Vec<(PathBuf, Vec<u8>)> = vec![];
    if let Some(path) = &arguments.tum {
        let text = tum::write(trajectory.iter().copied());
        files.push((path.clone(), text.into_bytes()));
    }
    if let Some(path) = &arguments.map {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let map = map_files(arguments, replay, &name)
            .with_context(|| format!("cannot write {}", path.display()))?;
        files.push((path.clone(), map.image));
        files.push((yaml_of(path), map.yaml.into_bytes()));
    }
    if let (Some(path), Some(fit)) = (&arguments.fit, fit) {
        let name = format!("fitted to {}", arguments.log.display());
        let settings = fit.settings().into_iter();
        let settings = settings
            .map(|(key, value)| (key.to_owned(), value))
            .collect();
        let text = preset::write(&PresetFile { name, settings }, &fitted_lines(fit));
        files.push((path.clone(), text.into_bytes()));
    }
    if let Some(path) = &arguments.og_map {
        let map = og_map::of_grid(replay.session().slam().grid())?;
        files.push((path.clone(), og_map::write(&map).into_bytes()));
    }
    if let Some(path) = &arguments.carmen {
        files.push((path.clone(), replay.carmen_log().write().into_bytes()));
    }
    // Beside the file first: a full disk spoils nothing.
    for (path, bytes) in &files {
        if let Err(error) = std::fs::write(part_of(path), bytes) {
            for (path, _) in &files {
                // It may never have come to be.
                let _ = std::fs::remove_file(part_of(path));
            }
            return Err(error).with_context(|| format!("cannot write {}", path.display()));
        }
    }
    for (path, _) in &files {
        std::fs::rename(part_of(path), path)
            .with_context(|| format!("cannot write {}", path.display()))?;
    }
    Ok(())
}

/// The parameters as people read them.
pub(super) fn fitted_lines(fit: &DriveFit) -> Vec<FittedLine> {
    let line = |p: FittedParameter| FittedLine {
        name: p.name.to_owned(),
        unit: p.unit.to_owned(),
        value: p.value,
        sigma: Some(p.sigma).filter(|sigma| sigma.is_finite()),
        unknown: p.verdict.reason().to_owned(),
    };
    fit.parameters().into_iter().map(line).collect()
}

/// The image is what its name says, PGM unless it ends in `.png`.
fn map_files(
    arguments: &Arguments,
    replay: &Replay,
    name: &str,
) -> anyhow::Result<map_server::MapFiles> {
    let mode: MapMode = arguments.map_mode.parse().context("--map-mode")?;
    let map = OccupancyMap::of_grid(replay.session().slam().grid(), mode)?;
    Ok(map_server::write(
        &map,
        mode,
        MapImage::of_name(name),
        name,
    )?)
}

fn yaml_of(map: &Path) -> PathBuf {
    map.with_extension("yaml")
}

fn part_of(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".part");
    name.into()
}

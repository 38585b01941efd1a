//! Options shared by `evaluate` and `simulate`: settings to run with, and files to write.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, anyhow, bail};
use slamlab_core::format::carmen::CarmenLog;
use slamlab_core::format::g2o::{self, G2oGraph};
use slamlab_core::format::map_server::{self, MapImage, MapMode, OccupancyMap};
use slamlab_core::format::revolution_log::RevolutionLog;
use slamlab_core::format::smap::Smap;
use slamlab_core::format::{og_map, preset, tum};
use slamlab_core::geom::Pose2;
use slamlab_core::settings::{Scope, Settings};
use slamlab_core::slam::Slam;

/// Settings other than their defaults.
#[derive(clap::Args)]
pub(crate) struct Changes {
    /// A setting other than its default, `KEY=NUMBER`; as often as wanted. Keys are those of
    /// `core::settings`. One that has no effect on the run is refused.
    #[arg(long = "set", value_name = "KEY=NUMBER", value_parser = setting)]
    pub(crate) settings: Vec<(String, f64)>,
    /// Settings from a preset file, as `evaluate --fit` writes one; `--set` overrules it. Those
    /// that have no effect on the run are named and left out.
    #[arg(long, value_name = "FILE")]
    pub(crate) preset: Option<PathBuf>,
}

/// A setting as `KEY=NUMBER`.
fn setting(text: &str) -> Result<(String, f64), String> {
    let (key, number) = text.split_once('=').ok_or("expected KEY=NUMBER")?;
    let number = number
        .parse()
        .map_err(|error| format!("{number}: {error}"))?;
    Ok((key.to_owned(), number))
}

impl Changes {
    /// Applies them to the settings of a run of this scope.
    pub(crate) fn apply_to(&self, settings: &mut Settings, scope: &Scope) -> Result<()> {
        if let Some(path) = &self.preset {
            let name = || format!("preset {}", path.display());
            let bytes = std::fs::read(path).with_context(name)?;
            let preset = preset::read(&bytes).with_context(name)?;
            for idle in settings.take(scope, preset.settings).with_context(name)? {
                eprintln!("{}: left out: {idle}", path.display());
            }
        }
        let idle = settings
            .take(scope, self.settings.clone())
            .context("--set")?;
        match idle.into_iter().next() {
            Some(idle) => Err(anyhow!(idle).context("--set")),
            None => Ok(()),
        }
    }
}

/// Files that a run can be written to.
#[derive(clap::Args)]
pub(crate) struct Outputs {
    /// Write where the robot was at each scan, as it believes at the end, as a TUM trajectory.
    #[arg(long, value_name = "FILE")]
    tum: Option<PathBuf>,
    /// Write the grid for ROS map_server: PGM, or PNG where the name ends in .png, and a YAML
    /// beside it.
    #[arg(long, value_name = "FILE")]
    map: Option<PathBuf>,
    /// What the greys of --map mean: trinary, scale (PNG only) or raw.
    #[arg(long, default_value = "trinary")]
    map_mode: MapMode,
    /// Write the grid as text, the layout of OGmap.txt.
    #[arg(long, value_name = "FILE")]
    og_map: Option<PathBuf>,
    /// Write the map as a submap of Pilch's program: the middles of occupied cells as points, where
    /// the robot was, and walls as edges, of methods with lines.
    #[arg(long, value_name = "FILE")]
    smap: Option<PathBuf>,
    /// Write the scans with their odometry as a CARMEN log.
    #[arg(long, value_name = "FILE")]
    carmen: Option<PathBuf>,
    /// Write the scans as a log of revolutions, without odometry and time: each a line of samples,
    /// `__t:DEGREES_d:MILLIMETRES_q:QUALITY|`, as Pilch's program reads them.
    #[arg(long, value_name = "FILE")]
    revolutions: Option<PathBuf>,
    /// Write the pose graph as g2o text: submaps, and the motions measured between them. Only of
    /// methods that keep one.
    #[arg(long, value_name = "FILE")]
    g2o: Option<PathBuf>,
}

/// A file to be written, with what it holds.
pub(crate) type File = (PathBuf, Vec<u8>);

impl Outputs {
    /// The files, each with its option.
    pub(crate) fn paths(&self) -> Vec<(&'static str, PathBuf)> {
        let yaml = self.map.as_deref().map(yaml_of);
        let all = [
            ("--tum", &self.tum),
            ("--map", &self.map),
            ("the YAML of --map", &yaml),
            ("--og-map", &self.og_map),
            ("--smap", &self.smap),
            ("--carmen", &self.carmen),
            ("--revolutions", &self.revolutions),
            ("--g2o", &self.g2o),
        ];
        given(all)
    }

    /// Refuses outputs that the method of a run cannot give; before the run.
    pub(crate) fn check_method(&self, slam: &Slam, name: &str) -> Result<()> {
        if self.g2o.is_some() && slam.view().graph.is_none() {
            bail!("--g2o: the method {name} keeps no pose graph; scan-matching does");
        }
        Ok(())
    }

    /// The files of a run.
    pub(crate) fn files(
        &self,
        slam: &Slam,
        trajectory: impl IntoIterator<Item = (f64, Pose2)>,
        log: impl FnOnce() -> CarmenLog,
        revolutions: impl FnOnce() -> RevolutionLog,
    ) -> Result<Vec<File>> {
        let mut files: Vec<File> = vec![];
        if let Some(path) = &self.tum {
            files.push((path.clone(), tum::write(trajectory).into()));
        }
        if let Some(path) = &self.map {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            let write = || {
                let map = OccupancyMap::of_grid(slam.grid(), self.map_mode)?;
                map_server::write(&map, self.map_mode, MapImage::of_name(&name), &name)
            };
            let map = write().with_context(|| format!("cannot write {}", path.display()))?;
            files.push((yaml_of(path), map.yaml.into()));
            files.push((path.clone(), map.image));
        }
        if let Some(path) = &self.og_map {
            let map = og_map::of_grid(slam.grid())?;
            files.push((path.clone(), og_map::write(&map).into()));
        }
        if let Some(path) = &self.smap {
            let poses = slam.whole_trajectory().into_iter();
            let way = poses.map(|(_, pose)| pose.position());
            let (walls, points) = (slam.vector_map().walls(), slam.view().landmark_points());
            let smap = Smap::of_run(slam.grid(), way, &walls, points);
            let smap = smap.with_context(|| format!("cannot write {}", path.display()))?;
            files.push((path.clone(), smap.write().into()));
        }
        if let Some(path) = &self.carmen {
            files.push((path.clone(), log().write().into()));
        }
        if let Some(path) = &self.revolutions {
            files.push((path.clone(), revolutions().write().into()));
        }
        if let (Some(path), Some(graph)) = (&self.g2o, slam.view().graph) {
            files.push((path.clone(), g2o::write(&G2oGraph::from(graph)).into()));
        }
        Ok(files)
    }
}

/// Of options with files, those that were given.
pub(crate) fn given<const N: usize>(
    options: [(&'static str, &Option<PathBuf>); N],
) -> Vec<(&'static str, PathBuf)> {
    let given = options.into_iter();
    given
        .filter_map(|(option, path)| Some((option, path.clone()?)))
        .collect()
}

/// Refuses files that cannot be written, or that would overwrite another file of the run; before
/// the run, which may take minutes.
pub(crate) fn check(
    read: Vec<(&'static str, PathBuf)>,
    written: Vec<(&'static str, PathBuf)>,
) -> Result<()> {
    let mut taken = read;
    for (option, path) in written {
        if path.file_name().is_none() || path.is_dir() {
            bail!("{option}: {} is no name of a file", path.display());
        }
        let folder = path.parent().filter(|f| !f.as_os_str().is_empty());
        if let Some(folder) = folder.filter(|folder| !folder.is_dir()) {
            bail!("{option}: there is no folder {}", folder.display());
        }
        if let Some((other, _)) = taken.iter().find(|(_, other)| *other == path) {
            bail!("{option}: {} is also the file of {other}", path.display());
        }
        taken.push((option, path));
    }
    Ok(())
}

/// Writes all of them or none: under temporary names first.
pub(crate) fn write(files: &[File]) -> Result<()> {
    for (path, bytes) in files {
        if let Err(error) = std::fs::write(part_of(path), bytes) {
            for (path, _) in files {
                let _ = std::fs::remove_file(part_of(path));
            }
            return Err(error).with_context(|| format!("cannot write {}", path.display()));
        }
    }
    for (path, _) in files {
        std::fs::rename(part_of(path), path)
            .with_context(|| format!("cannot write {}", path.display()))?;
    }
    Ok(())
}

fn yaml_of(map: &Path) -> PathBuf {
    map.with_extension("yaml")
}

fn part_of(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".part");
    name.into()
}

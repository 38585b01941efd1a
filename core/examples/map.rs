//! Inspects saved maps (`.slamlab`), finds where a map lies in another, merges two, removes what
//! newer parts cover, and edits what is drawn.
//!
//! `cargo run --release -p slamlab-core --example map -- info MAP.slamlab`
//! `cargo run --release -p slamlab-core --example map -- merge FIRST.slamlab SECOND.slamlab --out
//! OUT.slamlab`
//! `cargo run --release -p slamlab-core --example map -- align LOADED.smap|LOADED.slamlab
//! MAP.slamlab`
//! `cargo run --release -p slamlab-core --example map -- prune MAP.slamlab --out OUT.slamlab`
//! `cargo run --release -p slamlab-core --example map -- edit MAP.slamlab [--undo]
//! [--erase X0,Y0,X1,Y1] [--wall X0,Y0,X1,Y1] [--glass X0,Y0,X1,Y1] --out OUT.slamlab`
//!
//! The exit status is 1 if something failed, including when it is not proved how two maps lie
//! relative to each other. Figures are printed as one JSON object; if the map is torn or doubtful,
//! it is also said in words.
#![allow(
    clippy::disallowed_methods,
    reason = "the edge: files are here and nowhere below"
)]

#[path = "shared/quality.rs"]
mod quality;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Context, Result, bail};
use clap::{Parser, Subcommand};
use nalgebra::Point2;
use serde_json::{Value, json};
use slamlab_core::estimation::{EditKind, ScanMatcher, align_map};
use slamlab_core::format::map_points;
use slamlab_core::format::slamlab::{self, Experiment};
use slamlab_core::robot::RobotModel;
use slamlab_core::settings::{Scope, Settings, Source};
use slamlab_core::slam::Method;

/// Works on saved maps.
#[derive(Parser)]
struct Arguments {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Prints what a map holds.
    Info {
        /// The map.
        map: PathBuf,
    },
    /// Makes one map of two that show a part of the same building.
    Merge {
        /// The first map; the new one is in its frame.
        first: PathBuf,
        /// The second.
        second: PathBuf,
        /// The new map.
        #[arg(long, value_name = "FILE")]
        out: PathBuf,
    },
    /// Says where a submap or a saved map lies in a saved map, found without a start.
    Align {
        /// The map to be laid on the other: `.smap` or `.slamlab`.
        loaded: PathBuf,
        /// The map that it is laid on.
        map: PathBuf,
    },
    /// Takes out of a map what newer parts of it cover.
    Prune {
        /// The map.
        map: PathBuf,
        /// The new map.
        #[arg(long, value_name = "FILE")]
        out: PathBuf,
    },
    /// Changes what is drawn: as often as wanted, the last changes of earlier calls first taken
    /// back, then erased, then drawn.
    Edit {
        /// The map.
        map: PathBuf,
        /// Take back so many changes.
        #[arg(long, default_value_t = 0)]
        undo: usize,
        /// Make what lies between two corners unknown, m.
        #[arg(long, value_name = "X0,Y0,X1,Y1", value_parser = ends, allow_hyphen_values = true)]
        erase: Vec<Ends>,
        /// Draw a wall from one place to another, m.
        #[arg(long, value_name = "X0,Y0,X1,Y1", value_parser = ends, allow_hyphen_values = true)]
        wall: Vec<Ends>,
        /// Draw glass, which beams go through.
        #[arg(long, value_name = "X0,Y0,X1,Y1", value_parser = ends, allow_hyphen_values = true)]
        glass: Vec<Ends>,
        /// The new map.
        #[arg(long, value_name = "FILE")]
        out: PathBuf,
    },
}

/// Two places.
type Ends = [Point2<f64>; 2];

fn ends(text: &str) -> Result<Ends> {
    let numbers: Vec<f64> = (text.split(','))
        .map(|word| {
            word.trim()
                .parse()
                .with_context(|| format!("`{word}` is no number"))
        })
        .collect::<Result<_>>()?;
    match numbers[..] {
        [x0, y0, x1, y1] => Ok([Point2::new(x0, y0), Point2::new(x1, y1)]),
        _ => bail!("`{text}`: expected four numbers `x0,y0,x1,y1`"),
    }
}

fn main() -> ExitCode {
    match run(Arguments::parse().task) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("map: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn run(task: Task) -> Result<()> {
    let figures = match task {
        Task::Info { map } => {
            let (experiment, matcher) = open(&map)?;
            json!({
                "title": experiment.title,
                "program": experiment.program,
                "method": experiment.method,
                "map": figures(&matcher),
            })
        }
        Task::Merge { first, second, out } => merge(&first, &second, &out)?,
        Task::Align { loaded, map } => align(&loaded, &map)?,
        Task::Prune { map, out } => {
            let (experiment, mut matcher) = open(&map)?;
            matcher.finish();
            let pruned = matcher.prune();
            save(&out, experiment, &matcher)?;
            json!({
                "submaps_taken_out": pruned.submaps,
                "keyframes_taken_out": pruned.keyframes,
                "map": figures(&matcher),
            })
        }
        Task::Edit {
            map,
            undo,
            erase,
            wall,
            glass,
            out,
        } => {
            let (experiment, mut matcher) = open(&map)?;
            for _ in 0..undo {
                if !matcher.undo_edit() {
                    bail!("there are not so many changes to take back");
                }
            }
            let rectangles = erase.iter().map(|[a, b]| {
                let corners = [*a, Point2::new(b.x, a.y), *b, Point2::new(a.x, b.y)];
                (EditKind::Erase, corners.to_vec())
            });
            let line = |kind: EditKind| move |ends: &Ends| (kind, ends.to_vec());
            let walls = wall.iter().map(line(EditKind::Wall));
            let panes = glass.iter().map(line(EditKind::Glass));
            for (kind, corners) in rectangles.chain(walls).chain(panes) {
                matcher.edit(kind, &corners)?;
            }
            save(&out, experiment, &matcher)?;
            json!({ "map": figures(&matcher) })
        }
    };
    println!("{figures:#}");
    Ok(())
}

fn merge(first: &Path, second: &Path, out: &Path) -> Result<Value> {
    let (mut experiment, one) = open(first)?;
    let (other_experiment, other) = open(second)?;
    let merged = one.merged(other).with_context(|| {
        let (first, second) = (first.display(), second.display());
        format!("{first} and {second} cannot be made one map")
    })?;
    let times = [&experiment.map.times[..], &other_experiment.map.times[..]];
    experiment.map = merged.saved(times);
    experiment.title = format!("{} and {}", experiment.title, other_experiment.title);
    write(out, experiment)?;
    Ok(json!({ "map": figures(&merged.matcher) }))
}

fn align(loaded: &Path, map: &Path) -> Result<Value> {
    let (_, matcher) = open(map)?;
    let name = || format!("map {}", loaded.display());
    let bytes = std::fs::read(loaded).with_context(name)?;
    let points = map_points::read(&bytes).with_context(name)?.points;
    let landmarks = matcher.landmarks().into_iter();
    let landmarks: Vec<_> = landmarks.map(|landmark| landmark.position).collect();
    let found = align_map(&points, matcher.grid(), &landmarks)?;
    let pose = found.map_from_loaded;
    Ok(json!({
        "map_from_loaded": [pose.x(), pose.y(), pose.heading()],
        "agrees": found.agrees,
        "contradicts": found.contradicts,
        "residual": found.residual,
        "landmarks": found.landmarks,
        "by": format!("{:?}", found.by),
    }))
}

fn open(path: &Path) -> Result<(Experiment, ScanMatcher)> {
    let name = || format!("saved map {}", path.display());
    let bytes = std::fs::read(path).with_context(name)?;
    let experiment = slamlab::read(&bytes).with_context(name)?;
    let mut settings = Settings::of_robot(&RobotModel::pioneer(), false);
    let scope = Scope {
        source: Source::Recording,
        method: Method::ScanMatching,
    };
    let changed = experiment.settings.clone();
    settings.take(&scope, changed).with_context(name)?;
    let config = settings.slam.matcher;
    let matcher = experiment.map.matcher(config).with_context(name)?;
    Ok((experiment, matcher))
}

fn save(path: &Path, experiment: Experiment, matcher: &ScanMatcher) -> Result<()> {
    let map = matcher.saved(experiment.map.times);
    write(path, Experiment { map, ..experiment })
}

fn write(path: &Path, experiment: Experiment) -> Result<()> {
    let experiment = Experiment {
        program: concat!("slamlab ", env!("CARGO_PKG_VERSION")).to_owned(),
        ..experiment
    };
    let bytes = slamlab::write(&experiment)?;
    std::fs::write(path, bytes).with_context(|| format!("cannot write {}", path.display()))
}

fn figures(matcher: &ScanMatcher) -> Value {
    let quality = matcher.quality();
    for line in quality::words(&quality) {
        eprintln!("map: {line}");
    }
    json!({
        "scans": matcher.trajectory().count(),
        "submaps": matcher.submaps().len(),
        "keyframes": matcher.submaps().map(|submap| submap.keyframes).sum::<usize>(),
        "edges": matcher.graph().edges().len(),
        "loop_closures": matcher.loop_closures(),
        "grid_blocks": matcher.grid().block_count(),
        "changes": matcher.edits().len(),
        "is_placed": matcher.is_placed(),
        "quality": quality::figures(&quality),
    })
}

//! The readers of files, each with files of real programs to begin with and the laws that it keeps
//! whatever the input.
//!
//! What was read can be written, and is then read the same. A map or a drawing becomes a world that
//! can be saved.

use crc::{CRC_32_ISO_HDLC, Crc};
use slamlab_core::estimation::{SavedMap, ScanMatcherConfig, Start};
use slamlab_core::format::building::{self, BuildingFile, Imported};
use slamlab_core::format::map_server::{
    MapImage, MapInfo, MapMode, OccupancyMap, read_image, write,
};
use slamlab_core::format::poses::read_poses;
use slamlab_core::format::ros::{RosLog, RosReader};
use slamlab_core::format::{
    LeftOut, TextLogError, calibration, carmen, g2o, og_map, point_list, preset, ranger_log,
    relations, revolution_log, rover_log, slamlab, smap, tum, world,
};
use slamlab_core::geom::Pose2;
use slamlab_core::replay::{LogReader, RosChoice, RosOffer, import_ros};
use slamlab_core::robot::{RobotModel, Scan, Variable};
use slamlab_core::settings::{Scope, Settings, Source, table};
use slamlab_core::sim::SensorModel;
use slamlab_core::slam::Method;
use slamlab_core::wire::message::FromBridge;
use slamlab_core::wire::recording::{Recording, RecordingReader, Said};

use super::file_seeds as seeds;
use super::targets::{Target, outcome, pieces, same};

/// The targets for files.
pub(super) const FILES: &[Target] = &[
    Target {
        name: "calibration",
        seeds: seeds::calibration,
        run: calibration_run,
    },
    Target {
        name: "point-list",
        seeds: seeds::point_lists,
        run: point_list_run,
    },
    Target {
        name: "world",
        seeds: seeds::worlds,
        run: world_run,
    },
    Target {
        name: "carmen",
        seeds: seeds::carmen,
        run: carmen_run,
    },
    Target {
        name: "rover-log",
        seeds: seeds::rover_logs,
        run: rover_log_run,
    },
    Target {
        name: "ranger-log",
        seeds: seeds::ranger_logs,
        run: ranger_log_run,
    },
    Target {
        name: "revolution-log",
        seeds: seeds::revolution_logs,
        run: revolution_log_run,
    },
    Target {
        name: "log",
        seeds: seeds::logs,
        run: log_run,
    },
    Target {
        name: "relations",
        seeds: || vec![b"# t1 t2\n1.5 2.5 0.1 0.2 0 0 0 0.3\n".to_vec()],
        run: |input| {
            Ok(outcome(
                &relations::parse(input).map_err(words).map(|r| r.len()),
            ))
        },
    },
    Target {
        name: "poses",
        seeds: seeds::poses,
        run: poses_run,
    },
    Target {
        name: "g2o",
        seeds: seeds::pose_graphs,
        run: g2o_run,
    },
    Target {
        name: "map-yaml",
        seeds: seeds::map_yaml,
        run: map_yaml_run,
    },
    Target {
        name: "map-pgm",
        seeds: seeds::pgm,
        run: map_image_run,
    },
    Target {
        name: "map-png",
        seeds: seeds::png,
        run: |input| map_image_run(&with_right_sums(input)),
    },
    Target {
        name: "building-svg",
        seeds: seeds::drawings,
        run: |input| {
            Ok(outcome(&imported(building::of_svg(
                input, None, "drawing",
            ))?))
        },
    },
    Target {
        name: "og-map",
        seeds: seeds::og_maps,
        run: og_map_run,
    },
    Target {
        name: "smap",
        seeds: seeds::smaps,
        run: smap_run,
    },
    Target {
        name: "preset",
        seeds: seeds::presets,
        run: preset_run,
    },
    Target {
        name: "slamlab",
        seeds: seeds::slamlab,
        run: slamlab_run,
    },
    Target {
        name: "slamlab-state",
        seeds: seeds::matcher_states,
        run: matcher_state_run,
    },
    Target {
        name: "ros",
        seeds: seeds::ros_files,
        run: ros_run,
    },
    Target {
        name: "recording",
        seeds: seeds::recordings,
        run: recording_run,
    },
];

/// Larger maps are not made into a building here: slowness on them is not a crash.
const MOST_CELLS: usize = 100_000;

/// The beginning of an error message.
fn words(error: impl std::fmt::Display) -> String {
    error.to_string().chars().take(60).collect()
}

fn calibration_run(input: &[u8]) -> Result<u64, String> {
    let read = calibration::read(input)
        .map(|pairs| pairs.len().min(9))
        .map_err(words);
    let fit = calibration::fit(input, Variable::PerVolt)
        .map(|_| ())
        .map_err(words);
    Ok(outcome(&(read, fit)))
}

fn point_list_run(input: &[u8]) -> Result<u64, String> {
    let read = point_list::read(input)
        .map(|points| points.len().min(9))
        .map_err(words);
    Ok(outcome(&read))
}

/// Poses are finite, in the order of time, and read the same again after they are written.
fn poses_run(input: &[u8]) -> Result<u64, String> {
    let read = read_poses(input);
    if let Ok(file) = &read {
        let is_sound = |(seconds, pose): &(f64, Pose2)| {
            [*seconds, pose.x(), pose.y(), pose.heading()]
                .iter()
                .all(|number| number.is_finite())
        };
        same(&true, &file.poses.iter().all(is_sound))?;
        same(
            &true,
            &file.poses.windows(2).all(|pair| pair[0].0 < pair[1].0),
        )?;
        let again = read_poses(tum::write(file.poses.iter().copied()).as_bytes());
        let again = again.map_err(|error| format!("not read again: {error}"))?;
        // Times are written to the microsecond.
        same(&file.poses.len(), &(again.poses.len() + again.repeated))?;
    }
    Ok(outcome(
        &read.map(|file| file.poses.len().min(9)).map_err(words),
    ))
}

fn world_run(input: &[u8]) -> Result<u64, String> {
    let read = world::read(input);
    if let Ok(read) = &read {
        let again = world::read(world::write(read).as_bytes())
            .map_err(|error| format!("not read again: {error}"))?;
        same(&format!("{read:?}"), &format!("{again:?}"))?;
    }
    Ok(outcome(
        &read
            .map(|world| world.wall_count().min(99))
            .map_err(|e| e.to_string()),
    ))
}

fn carmen_run(input: &[u8]) -> Result<u64, String> {
    let at_once = carmen::CarmenLog::parse(input).map_err(|e| e.to_string());
    let mut reader = carmen::CarmenReader::default();
    let in_pieces = pieces(input)
        .try_for_each(|piece| reader.push(piece))
        .and_then(|()| reader.finish())
        .map_err(|e| e.to_string());
    same(
        &at_once.as_ref().map(|log| format!("{log:?}")),
        &in_pieces.as_ref().map(|log| format!("{log:?}")),
    )?;
    Ok(outcome(&at_once.map(|log| log.scans.len().min(9))))
}

fn slamlab_run(input: &[u8]) -> Result<u64, String> {
    let read = slamlab::read(input);
    if let Ok(read) = &read {
        let again = slamlab::write(read).and_then(|file| slamlab::read(&file));
        same(&Ok(read), &again.as_ref())?;
    }
    Ok(outcome(&read.map(|_| ()).map_err(words)))
}

/// The state of a matcher without the checksum that guards it in a file: a state that is accepted
/// can go on, and is saved unchanged.
fn matcher_state_run(input: &[u8]) -> Result<u64, String> {
    let restored = |state: Vec<u8>| {
        let times = vec![];
        SavedMap { state, times }.matcher(ScanMatcherConfig::default())
    };
    let outcomes = match restored(input.to_vec()) {
        Err(error) => Err(words(error)),
        Ok(mut matcher) => {
            let mut state = vec![];
            matcher.save(&mut state);
            let again = restored(state.clone()).map_err(|e| format!("not read again: {e}"))?;
            let mut second = vec![];
            again.save(&mut second);
            same(&state, &second)?;
            matcher.finish();
            matcher.go_on(Start::Anywhere);
            Ok(matcher.submaps().len().min(9))
        }
    };
    Ok(outcome(&outcomes))
}

fn rover_log_run(input: &[u8]) -> Result<u64, String> {
    let read = |pieces: &mut dyn Iterator<Item = &[u8]>| {
        let mut reader = rover_log::RoverLogReader::default();
        for piece in pieces {
            reader.push(piece)?;
        }
        reader.finish()
    };
    let scans = |log: &rover_log::RoverLog| {
        let scans = (0..log.scans.len()).filter_map(|index| log.scan(index));
        scans.collect()
    };
    text_log(input, read, scans)
}

fn ranger_log_run(input: &[u8]) -> Result<u64, String> {
    let read = |pieces: &mut dyn Iterator<Item = &[u8]>| {
        let mut reader = ranger_log::RangerLogReader::default();
        for piece in pieces {
            reader.push(piece)?;
        }
        reader.finish()
    };
    let scans = |log: &ranger_log::RangerLog| {
        let scans = log.scans.iter().map(|scan| log.scan(scan, 2.0));
        scans.collect()
    };
    text_log(input, read, scans)
}

fn revolution_log_run(input: &[u8]) -> Result<u64, String> {
    let read = |pieces: &mut dyn Iterator<Item = &[u8]>| {
        let mut reader = revolution_log::RevolutionLogReader::default();
        for piece in pieces {
            reader.push(piece)?;
        }
        reader.finish()
    };
    if let Ok(mut log) = read(&mut std::iter::once(input)) {
        let text = log.write();
        let again = read(&mut std::iter::once(text.as_bytes()));
        // What was left out of the one is not in the other.
        log.left_out = LeftOut::default();
        same(&Ok(log), &again)?;
    }
    let scans = |log: &revolution_log::RevolutionLog| {
        let scans =
            (0..log.len()).filter_map(|index| log.scan(index, revolution_log::NOMINAL_RATE));
        scans.collect()
    };
    text_log(input, read, scans)
}

/// Reading in pieces gives the same as at once, and every scan is usable.
fn text_log<T: std::fmt::Debug>(
    input: &[u8],
    read: impl Fn(&mut dyn Iterator<Item = &[u8]>) -> Result<T, TextLogError>,
    scans: impl Fn(&T) -> Vec<Scan>,
) -> Result<u64, String> {
    let at_once = read(&mut std::iter::once(input));
    let in_pieces = read(&mut pieces(input));
    same(&format!("{at_once:?}"), &format!("{in_pieces:?}"))?;
    let scans = at_once.as_ref().map(&scans).unwrap_or_default();
    for scan in &scans {
        scan.validate().map_err(|error| error.to_string())?;
    }
    Ok(outcome(&(
        scans.len().min(9),
        at_once.map(drop).map_err(words),
    )))
}

/// A log of any kind, compressed or not: which kind it is does not depend on how it is cut.
fn log_run(input: &[u8]) -> Result<u64, String> {
    let read = |pieces: &mut dyn Iterator<Item = &[u8]>| {
        let mut reader = LogReader::default();
        for piece in pieces {
            reader.push(piece)?;
        }
        reader.finish().map(|log| {
            let kind: String = format!("{log:?}").chars().take(12).collect();
            (kind, log.scans(), log.has_odometry())
        })
    };
    let at_once = read(&mut std::iter::once(input)).map_err(words);
    same(&at_once, &read(&mut pieces(input)).map_err(words))?;
    Ok(outcome(&at_once))
}

fn map_yaml_run(input: &[u8]) -> Result<u64, String> {
    let info = MapInfo::parse(input);
    if let Ok(info) = &info {
        map_is_sound(info, b"P5 2 2 255 \x00\xcd\xfe\x60")?;
    }
    let outcomes = info.map(|info| (info.mode, info.negate)).map_err(words);
    Ok(outcome(&outcomes))
}

fn map_image_run(input: &[u8]) -> Result<u64, String> {
    let outcomes = MapMode::ALL.map(|(_, mode)| {
        let info = MapInfo {
            image: "map".to_owned(),
            mode,
            resolution: 0.1,
            origin: Pose2::identity(),
            negate: false,
            occupied_thresh: 0.65,
            free_thresh: 0.196,
        };
        map_is_sound(&info, input)
    });
    let outcomes: Result<Vec<String>, String> = outcomes.into_iter().collect();
    Ok(outcome(&outcomes?))
}

/// Reads a map: its cells have valid values, they read the same again after they are written, and a
/// building made of the map is a world.
fn map_is_sound(info: &MapInfo, image: &[u8]) -> Result<String, String> {
    let map = match read_image(info, image) {
        Ok(map) => map,
        Err(error) => return Ok(words(error)),
    };
    same(&map.cells.len(), &(map.width * map.height))?;
    if let Some(cell) = map.cells.iter().find(|cell| !(-1..=100).contains(*cell)) {
        return Err(format!("a cell of {cell} %"));
    }
    if map.cells.len() > MOST_CELLS {
        return Ok("large".to_owned());
    }
    for file in [MapImage::Pgm, MapImage::Png] {
        reads_again(&map, file)?;
    }
    let built = imported(building::of_map(&map, "map"))?;
    Ok(format!("{} {built:?}", map.cells.len().min(2)))
}

fn reads_again(map: &OccupancyMap, file: MapImage) -> Result<(), String> {
    let files = write(map, MapMode::Raw, file, "map").map_err(|e| format!("not written: {e}"))?;
    let info = MapInfo::parse(files.yaml.as_bytes()).map_err(|e| format!("its YAML: {e}"))?;
    let again = read_image(&info, &files.image).map_err(|e| format!("not read again: {e}"))?;
    same(&map.cells, &again.cells)
}

/// What was imported can be saved and loaded again; otherwise the error message.
fn imported<E: std::fmt::Display>(built: Result<Imported, E>) -> Result<String, String> {
    match built {
        Err(error) => Ok(words(error)),
        Ok(built) => {
            world::read(world::write(&built.world).as_bytes())
                .map_err(|error| format!("the building cannot be loaded: {error}"))?;
            Ok(format!("{} walls", built.world.wall_count().ilog2()))
        }
    }
}

/// Corrects each chunk's checksum: a wrong one would hide any other error.
fn with_right_sums(png: &[u8]) -> Vec<u8> {
    let crc = Crc::<u32>::new(&CRC_32_ISO_HDLC);
    let mut png = png.to_vec();
    let mut at = 8;
    // Length, kind, content, checksum.
    while let Some(length) = png.get(at..).and_then(|rest| rest.first_chunk()) {
        let content = at + 4..(at + 8).saturating_add(u32::from_be_bytes(*length) as usize);
        let end = content.end.saturating_add(4);
        if end > png.len() {
            break;
        }
        let sum = crc.checksum(&png[content.clone()]);
        png[content.end..end].copy_from_slice(&sum.to_be_bytes());
        at = end;
    }
    png
}

fn og_map_run(input: &[u8]) -> Result<u64, String> {
    let map = og_map::parse(input);
    if let Ok(map) = &map {
        same(&map.probabilities.len(), &(map.width * map.height))?;
        let text = og_map::write(map);
        let again = og_map::parse(text.as_bytes()).map_err(|e| format!("not read again: {e}"))?;
        same(&text, &og_map::write(&again))?;
    }
    Ok(outcome(&map.map(|map| map.width.min(9)).map_err(words)))
}

/// What was read is written the same again, and becomes a building or a reason why not.
fn smap_run(input: &[u8]) -> Result<u64, String> {
    let map = match smap::parse(input) {
        Ok(map) => map,
        Err(error) => return Ok(outcome(&words(error))),
    };
    let text = map.write();
    let again = smap::parse(text.as_bytes()).map_err(|e| format!("not read again: {e}"))?;
    same(&text, &again.write())?;
    let size = |axis: fn(&smap::Smap) -> Vec<f64>| {
        let along = axis(&map);
        along.iter().fold(0.0, |most: f64, at| most.max(at.abs()))
    };
    let x = size(|map| map.points.iter().chain(&map.path).map(|p| p.x).collect());
    let y = size(|map| map.points.iter().chain(&map.path).map(|p| p.y).collect());
    // Slowness on a large one is not a crash.
    let built = match x * y < 100.0 {
        true => BuildingFile::read(&[("a.smap", input)], None)
            .map_err(words)
            .and_then(|file| file.into_world("submap").map_err(words))
            .map(|built| built.world.wall_count().ilog2()),
        false => Err("large".to_owned()),
    };
    Ok(outcome(&(map.points.len().min(9), built)))
}

fn g2o_run(input: &[u8]) -> Result<u64, String> {
    let mut graph = match g2o::parse(input) {
        Ok(graph) => graph,
        Err(error) => return Ok(outcome(&words(error))),
    };
    graph.left_out.clear();
    let again = g2o::parse(g2o::write(&graph).as_bytes());
    same(&graph, &again.map_err(|e| format!("not read again: {e}"))?)?;
    let solved = graph.to_pose_graph().map(|mut solved| {
        let cost = solved.optimize_with_figures(5).cost;
        (solved, cost)
    });
    let solved = match solved {
        Ok((solved, [before, after])) => {
            if after > before {
                return Err(format!("cost {before} rose to {after}"));
            }
            graph.set_poses(&solved).map_err(words)?;
            Ok(solved.edges().len().min(9))
        }
        Err(error) => Err(words(error)),
    };
    Ok(outcome(&(graph.vertices.len().min(9), solved)))
}

fn preset_run(input: &[u8]) -> Result<u64, String> {
    let read = match preset::read(input) {
        Ok(read) => read,
        Err(error) => return Ok(outcome(&words(error))),
    };
    let again = preset::read(preset::write(&read, &[]).as_bytes());
    same(&read, &again.map_err(|e| format!("not read again: {e}"))?)?;
    let mut settings = Settings::of(SensorModel::lidar(), &RobotModel::rp6());
    let scope = Scope {
        source: Source::Simulation,
        method: Method::LineEkf,
    };
    let set = settings.take(&scope, read.settings).map_err(words);
    let outside = |setting: &&slamlab_core::settings::Setting| {
        let [low, high] = setting.range;
        settings
            .get(setting)
            .is_some_and(|value| !(low..=high).contains(&value))
    };
    match table().find(outside) {
        Some(setting) => Err(format!("{} was set outside of its range", setting.key)),
        None => Ok(outcome(&set)),
    }
}

/// What is imported from it are usable readings, and a file of ours.
fn ros_run(input: &[u8]) -> Result<u64, String> {
    let read = |pieces: &mut dyn Iterator<Item = &[u8]>| {
        let mut reader = RosReader::default();
        for piece in pieces {
            reader.push(piece).map_err(words)?;
        }
        reader.finish().map_err(words)
    };
    let at_once = read(&mut std::iter::once(input));
    let text = |log: &Result<RosLog, String>| format!("{log:?}");
    same(&text(&at_once), &text(&read(&mut pieces(input))))?;
    let imported = at_once.and_then(|log| {
        let first = RosOffer::of(&log).map_err(words)?.scans.into_iter().next();
        let choice = RosChoice {
            scans: first.map(|offered| offered.name),
            odometry: None,
        };
        import_ros(&log, &choice).map_err(words)
    });
    if let Ok(imported) = &imported {
        for message in imported.recording.messages() {
            match message.map_err(words)?.said {
                Said::ByBridge(FromBridge::Scan(body)) => drop(body.scan().map_err(words)?),
                Said::ByBridge(FromBridge::Odometry(body)) => drop(body.odometry().map_err(words)?),
                other => return Err(format!("a drive has {other:?}")),
            }
        }
        let back = Recording::parse(&imported.recording.write().map_err(words)?).map_err(words)?;
        same(&imported.recording.len(), &back.len())?;
        same(&0, &back.damage().len())?;
    }
    let outcomes = imported.map(|imported| (imported.recording.scans().min(9), imported.notes));
    Ok(outcome(&outcomes))
}

fn recording_run(input: &[u8]) -> Result<u64, String> {
    let mut reader = RecordingReader::default();
    let in_pieces = pieces(input)
        .try_for_each(|piece| reader.push(piece))
        .and_then(|()| reader.finish())
        .map_err(words);
    let at_once = Recording::parse(input).map_err(words);
    let all = |recording: &Recording| {
        let messages = recording.messages().map(|message| format!("{message:?}"));
        (
            messages.collect::<Vec<_>>(),
            format!("{:?}", recording.damage()),
        )
    };
    same(&at_once.as_ref().map(all), &in_pieces.as_ref().map(all))?;
    let outcomes = at_once.map(|recording| {
        let damage = recording.damage().first().map(words);
        (recording.len().min(40), recording.scans().min(9), damage)
    });
    Ok(outcome(&outcomes))
}

//! `people`: is a map among people as good as without them, and are the people tracked? Some
//! seconds for each run, seven runs for each seed.
//!
//! 1. In `crowd`, where ten people walk, the lidar robot explores until everything is seen; it
//!    fails after half an hour of simulated time. 4 seeds (`--seeds`). The runs of a seed: without
//!    people; with them, kept out of pose and map, by each association; and with them kept in. Scan
//!    matching is judged; the line filter is shown beside it.
//! 2. Walls: the distance of the centre of an occupied cell from the nearest true wall, over the
//!    cells of all seeds, after the map is moved to where its trajectory fits the true one best.
//! 3. Map: intersection over union of occupied cells and cells of true walls that a run without
//!    people has seen; cells at most one cell apart count as the same. Ghosts are occupied cells
//!    farther than [`GHOST`] from any wall.
//! 4. Tracks, at each scan: those that move and are seen, assigned to people within [`FAR`]. Their
//!    position error includes that of the robot's pose. A person who gets a track that was somebody
//!    else's has a switched identity; one who gets a new track after losing the old one has a
//!    renewed identity. Also the part of all people walking in sight within [`NEAR`] that have a
//!    track. OSPA is that of Schuhmacher et al. (2008) with a cutoff of 1 m, among those in sight.

use std::collections::BTreeMap;

use anyhow::{Context, Result};
use nalgebra::{Point2, Vector2};
use serde_json::{Value, json};
use slamlab_core::association::assign;
use slamlab_core::estimation::align;
use slamlab_core::experiment::{Experiment, ExperimentConfig};
use slamlab_core::geom::Pose2;
use slamlab_core::sim::{Caster, Disc, SensorModel};
use slamlab_core::slam::Method;
use slamlab_core::tracking::{TrackAssociation, TrackMotion, ospa};

use super::{Args, Outcome};
use crate::ride::{carry_out, world_named};
use crate::statistics::{median, quantile};
use crate::threads::each;

const SEEDS: u64 = 4;
const WORLD: &str = "crowd";
/// An exploration that takes longer has failed, s.
const LONGEST: f64 = 1800.0;
/// Walls farther away are not searched for, m.
const REACH: f64 = 2.0;
const GHOST: f64 = 0.15;
/// A track farther from a person is not that person's, m.
const FAR: f64 = 0.5;
/// People nearer than this should be seen, m.
const NEAR: f64 = 5.0;
/// A person is walking above this speed since the previous step, m/s.
const WALKS: f64 = 0.1;
const CUTOFF: f64 = 1.0;
/// Maximum relative loss of walls and map among people.
const MOST_WORSE: f64 = 0.1;
const MOST_TRACK_ERROR: f64 = 0.1;
/// Maximum part of the scans without people in which something seems to walk.
const MOST_FALSE: f64 = 0.002;

/// A kind of run.
#[derive(Clone, Copy)]
struct Kind {
    name: &'static str,
    method: Method,
    has_people: bool,
    keeps_out: bool,
    association: TrackAssociation,
}

const fn kind(name: &'static str, people: [bool; 2], association: TrackAssociation) -> Kind {
    Kind {
        name,
        method: Method::ScanMatching,
        has_people: people[0],
        keeps_out: people[1],
        association,
    }
}

const fn by_lines(kind: Kind) -> Kind {
    Kind {
        method: Method::LineEkf,
        ..kind
    }
}

/// The first is without people, the second with them and default settings, the last keeps them in.
const KINDS: [Kind; 5] = [
    kind("without_people", [false, true], TrackAssociation::Jpda),
    kind("jpda", [true, true], TrackAssociation::Jpda),
    kind("nearest", [true, true], TrackAssociation::Nearest),
    kind("gm_phd", [true, true], TrackAssociation::GmPhd),
    kind("kept_in", [true, false], TrackAssociation::Jpda),
];
const BY_LINES: [Kind; 3] = [by_lines(KINDS[0]), by_lines(KINDS[1]), by_lines(KINDS[4])];

pub(crate) fn measure(args: &Args) -> Result<Outcome> {
    let mut outcome = Outcome::default();
    let seeds: Vec<u64> = args.seeds(SEEDS).collect();
    for kinds in [&KINDS[..], &BY_LINES[..]] {
        let runs = each(seeds.len() * kinds.len(), |index| {
            let (kind, seed) = (kinds[index % kinds.len()], seeds[index / kinds.len()]);
            let run = Run::of(kind, seed)?;
            eprintln!(
                "{} seed {seed} {}: {}",
                kind.method.name(),
                kind.name,
                run.told()
            );
            Ok(run)
        })?;
        let of =
            |place: usize| -> Vec<&Run> { runs.iter().skip(place).step_by(kinds.len()).collect() };
        let rows: Vec<Row> = (0..kinds.len())
            .map(|place| Row::of(&of(place), &of(0)))
            .collect();
        let name = kinds[0].method.name().replace('-', "_");
        for (kind, row) in kinds.iter().zip(&rows) {
            outcome.figure(format!("{name}_{}", kind.name), row.to_json());
        }
        if kinds[0].method == Method::ScanMatching {
            judge(&mut outcome, &rows);
        }
    }
    Ok(outcome)
}

fn judge(outcome: &mut Outcome, rows: &[Row]) {
    let [alone, among, ..] = rows else { return };
    let not_done: usize = rows.iter().map(|row| row.not_done).sum();
    outcome.at_most("runs_that_do_not_end", f64::from(not_done as u32), 0.0);
    let wall = among.wall_error / alone.wall_error;
    outcome.at_most(
        "wall_error_with_over_without_people",
        wall,
        1.0 + MOST_WORSE,
    );
    outcome.at_least(
        "map_iou_with_over_without_people",
        among.iou / alone.iou,
        1.0 - MOST_WORSE,
    );
    outcome.at_most(
        "track_position_error_m_median",
        among.track_error,
        MOST_TRACK_ERROR,
    );
    outcome.at_most(
        "scans_without_people_in_which_somebody_walks",
        alone.false_part,
        MOST_FALSE,
    );
    outcome.figure("identities_switched", among.switched);
    outcome.figure("identities_renewed", among.renewed);
}

/// The figures of all runs of a kind.
struct Row {
    runs: usize,
    not_done: usize,
    wall_error: f64,
    iou: f64,
    ghosts: usize,
    seconds: f64,
    contacts: u32,
    track_error: f64,
    track_error_p95: f64,
    recall: f64,
    false_part: f64,
    false_tracks: usize,
    switched: usize,
    renewed: usize,
    ospa: f64,
}

impl Row {
    fn of(runs: &[&Run], alone: &[&Run]) -> Self {
        let runs = runs.iter().copied();
        let sum = |of: fn(&Run) -> usize| runs.clone().map(of).sum::<usize>();
        let errors = || runs.clone().flat_map(|run| &run.tracking.errors);
        let part = |a: usize, b: usize| a as f64 / b as f64;
        let ious = runs
            .clone()
            .zip(alone.iter().copied())
            .map(|(run, alone)| run.iou(alone));
        Self {
            runs: runs.clone().count(),
            not_done: sum(|run| usize::from(!run.is_done)),
            wall_error: quantile(runs.clone().flat_map(|run| &run.wall_errors), 0.95),
            iou: median(ious),
            ghosts: sum(|run| run.wall_errors.iter().filter(|off| **off > GHOST).count()),
            seconds: median(runs.clone().map(|run| run.seconds)),
            contacts: runs.clone().map(|run| run.contacts).sum(),
            track_error: median(errors()),
            track_error_p95: quantile(errors(), 0.95),
            recall: part(
                sum(|run| run.tracking.found),
                sum(|run| run.tracking.in_sight),
            ),
            false_part: part(sum(|r| r.tracking.false_scans), sum(|r| r.tracking.scans)),
            false_tracks: sum(|run| run.tracking.false_tracks),
            switched: sum(|run| run.tracking.switched),
            renewed: sum(|run| run.tracking.renewed),
            ospa: median(runs.clone().flat_map(|run| &run.tracking.ospa)),
        }
    }

    fn to_json(&self) -> Value {
        json!({
            "runs": self.runs,
            "done": self.runs - self.not_done,
            "wall_error_m_p95": self.wall_error,
            "map_iou_median": self.iou,
            "ghost_cells": self.ghosts,
            "simulated_s_median": self.seconds,
            "contacts": self.contacts,
            "track_position_error_m_median": self.track_error,
            "track_position_error_m_p95": self.track_error_p95,
            "walking_in_sight_tracked": self.recall,
            "false_tracks_scans": self.false_tracks,
            "scans_with_false_track": self.false_part,
            "identities_switched": self.switched,
            "identities_renewed": self.renewed,
            "ospa_m_median": self.ospa,
        })
    }
}

/// The result of one exploration.
struct Run {
    is_done: bool,
    seconds: f64,
    /// Contacts with walls, and with people who did not walk into the robot.
    contacts: u32,
    /// Wall error of each occupied cell, m.
    wall_errors: Vec<f64>,
    /// The centres of the same cells, world frame; and the side of a cell, m.
    occupied: Vec<Point2<f64>>,
    resolution: f64,
    tracking: Tracking,
}

impl Run {
    fn of(kind: Kind, seed: u64) -> Result<Self> {
        let mut world = world_named(WORLD)?;
        if !kind.has_people {
            world.movers.clear();
        }
        let caster = Caster::new(world.walls());
        let (start, robot) = (world.start, world.robot.model());
        let mut config = ExperimentConfig::new(world, robot, SensorModel::lidar(), seed);
        config.method = kind.method;
        config.slam.tracking.association = kind.association;
        config.slam.tracking.keeps_out = kind.keeps_out;
        let mut experiment = Experiment::new(config)?;
        let mut tracking = Tracking::default();
        let is_done = carry_out(&mut experiment, LONGEST, |experiment| {
            tracking.see(experiment, &caster, &start);
            Ok(())
        })?;
        let samples = experiment.record().samples().iter();
        let places = samples.map(|s| (s.truth.position(), s.estimate.pose.position()));
        let (truth, estimated): (Vec<_>, Vec<_>) = places.unzip();
        let aligned = align(&truth, &estimated).context("the robot never moved")?;
        let world_from_map = start * aligned;
        let grid = experiment.session().slam().grid();
        let occupied: Vec<Point2<f64>> = (grid.occupied().into_iter())
            .map(|at| world_from_map * at)
            .collect();
        let contacts = experiment.sim().contacts();
        Ok(Self {
            is_done,
            seconds: experiment.seconds(),
            contacts: contacts.walls + contacts.drove_into_mover,
            wall_errors: occupied
                .iter()
                .map(|at| caster.clearance(*at, REACH))
                .collect(),
            occupied,
            resolution: grid.resolution(),
            tracking,
        })
    }

    /// Step 3; cells of walls are those that a run without people saw on walls.
    fn iou(&self, alone: &Self) -> f64 {
        let reach = 1.5 * self.resolution;
        let cells = alone.occupied.iter().zip(&alone.wall_errors);
        let walls: Vec<Point2<f64>> = cells
            .filter(|(_, off)| **off <= reach)
            .map(|(at, _)| *at)
            .collect();
        let (near_map, near_walls) = (Near::new(&self.occupied, reach), Near::new(&walls, reach));
        let found = walls.iter().filter(|at| near_map.holds(**at)).count();
        let wrong = self
            .occupied
            .iter()
            .filter(|at| !near_walls.holds(**at))
            .count();
        found as f64 / (walls.len() + wrong) as f64
    }

    fn told(&self) -> String {
        let tracking = &self.tracking;
        format!(
            "{}{:.0} s, 95 % of the walls within {:.3} m, {} contacts; tracks {:.3} m off, {} of {} in sight, {} false in {} scans, {} switched, {} renewed",
            if self.is_done { "" } else { "not done, " },
            self.seconds,
            quantile(&self.wall_errors, 0.95),
            self.contacts,
            median(&tracking.errors),
            tracking.found,
            tracking.in_sight,
            tracking.false_tracks,
            tracking.scans,
            tracking.switched,
            tracking.renewed,
        )
    }
}

/// Answers whether a place has a point nearby.
struct Near {
    cells: BTreeMap<(i64, i64), Vec<Point2<f64>>>,
    reach: f64,
}

impl Near {
    fn new(points: &[Point2<f64>], reach: f64) -> Self {
        let mut cells: BTreeMap<_, Vec<_>> = BTreeMap::new();
        for point in points {
            cells
                .entry(Self::cell(*point, reach))
                .or_default()
                .push(*point);
        }
        Self { cells, reach }
    }

    fn cell(at: Point2<f64>, reach: f64) -> (i64, i64) {
        ((at.x / reach).floor() as i64, (at.y / reach).floor() as i64)
    }

    fn holds(&self, at: Point2<f64>) -> bool {
        let (col, row) = Self::cell(at, self.reach);
        let around = (col - 1..=col + 1).flat_map(|c| (row - 1..=row + 1).map(move |r| (c, r)));
        let mut points = around.filter_map(|cell| self.cells.get(&cell)).flatten();
        points.any(|point| (point - at).norm() <= self.reach)
    }
}

/// What became of the tracks, scan by scan.
#[derive(Default)]
struct Tracking {
    errors: Vec<f64>,
    ospa: Vec<f64>,
    scans: usize,
    false_scans: usize,
    false_tracks: usize,
    in_sight: usize,
    found: usize,
    switched: usize,
    renewed: usize,
    /// The last track of each person, and all people that each track belonged to.
    track_of: BTreeMap<usize, u32>,
    people_of: BTreeMap<u32, usize>,
    /// The previous step: its time, and where people were.
    before: Option<(f64, Vec<Disc>)>,
    newest_scan: Option<f64>,
}

impl Tracking {
    fn see(&mut self, experiment: &Experiment, caster: &Caster, start: &Pose2) {
        let (now, people) = (experiment.seconds(), experiment.sim().movers().to_vec());
        let slam = experiment.session().slam();
        let scan = slam.points().map(|points| points.stamp.seconds());
        let before = self.before.replace((now, people.clone()));
        if scan == self.newest_scan {
            return;
        }
        self.newest_scan = scan;
        let (Some(scan), Some((then, before))) = (scan, before) else {
            return;
        };
        // Where people were when the scan was taken, and how fast they walked.
        let part = ((scan - then) / (now - then)).clamp(0.0, 1.0);
        let pairs = before.iter().zip(&people);
        let at: Vec<(Point2<f64>, f64)> = pairs
            .map(|(a, b)| {
                let way: Vector2<f64> = b.centre - a.centre;
                (a.centre + way * part, way.norm() / (now - then))
            })
            .collect();
        let map_from_robot = slam.estimate().pose * slam.motion_since_scan().inverse();
        let world_from_robot = *start * map_from_robot;
        let moving = slam.tracks().iter();
        let moving = moving.filter(|t| t.motion == TrackMotion::Moving && t.is_seen);
        let tracks: Vec<(u32, Point2<f64>)> = moving
            .map(|t| (t.id, world_from_robot * t.position))
            .collect();
        let eye = world_from_robot.position();
        let is_in_sight = |to: Point2<f64>| {
            let way = to - eye;
            let distance = way.norm();
            let wall = caster.cast(eye, way / distance, distance);
            distance < NEAR && wall.is_none() && !hidden(eye, to, &at)
        };
        self.judge(&tracks, &at, &is_in_sight);
    }

    fn judge(
        &mut self,
        tracks: &[(u32, Point2<f64>)],
        people: &[(Point2<f64>, f64)],
        is_in_sight: &dyn Fn(Point2<f64>) -> bool,
    ) {
        self.scans += 1;
        let cost = |track: Point2<f64>, person: Point2<f64>| {
            let off = (track - person).norm();
            if off <= FAR { off } else { f64::INFINITY }
        };
        let costs: Vec<Vec<f64>> = (tracks.iter())
            .map(|(_, at)| {
                people
                    .iter()
                    .map(|(person, _)| cost(*at, *person))
                    .collect()
            })
            .collect();
        let mut is_found = vec![false; people.len()];
        let mut false_now = 0;
        for (((id, _), row), chosen) in tracks.iter().zip(&costs).zip(assign(&costs)) {
            let Some(person) = chosen else {
                false_now += 1;
                continue;
            };
            is_found[person] = true;
            self.errors.push(row[person]);
            let had = self.track_of.insert(person, *id);
            let was_of = self.people_of.insert(*id, person);
            if was_of.is_some_and(|other| other != person) {
                self.switched += 1;
            } else if had.is_some_and(|other| other != *id) {
                self.renewed += 1;
            }
        }
        self.false_tracks += false_now;
        self.false_scans += usize::from(false_now > 0);
        let near: Vec<bool> = people.iter().map(|(at, _)| is_in_sight(*at)).collect();
        for (((_, speed), near), found) in people.iter().zip(&near).zip(&is_found) {
            let counts = *near && *speed > WALKS;
            self.in_sight += usize::from(counts);
            self.found += usize::from(counts && *found);
        }
        let walking = people
            .iter()
            .zip(&near)
            .filter(|((_, speed), near)| **near && *speed > WALKS);
        let walking: Vec<Point2<f64>> = walking.map(|((at, _), _)| *at).collect();
        let near_tracks = tracks.iter().filter(|(_, at)| is_in_sight(*at));
        let near_tracks: Vec<Point2<f64>> = near_tracks.map(|(_, at)| *at).collect();
        if !(walking.is_empty() && near_tracks.is_empty()) {
            self.ospa.push(ospa(&near_tracks, &walking, CUTOFF));
        }
    }
}

/// Whether a person stands in the line of sight between an eye and another person.
fn hidden(eye: Point2<f64>, to: Point2<f64>, people: &[(Point2<f64>, f64)]) -> bool {
    let way = to - eye;
    let distance = way.norm();
    people.iter().any(|(other, _)| {
        let off = other - eye;
        let along = off.dot(&way) / distance;
        let aside = (off.norm_squared() - along * along).max(0.0).sqrt();
        along > 0.0 && along < distance - 0.3 && aside < 0.3
    })
}

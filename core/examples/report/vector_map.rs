//! `vector-map`: does the vector map stay as small as the building? About 1 min for each seed.
//!
//! 1. A robot with a lidar goes through all rooms of `office` ten times with the line filter,
//!    driving by its own estimate.
//! 2. What could be seen, from the true pose with one degree between beams: each decimetre of each
//!    true wall that was hit at least five times. Its stretches of 0.3 m and more are the true
//!    segments; the two faces of a partition count separately, and ends of partitions and facets of
//!    pillars are too short.
//! 3. The map's segments of the same length are counted after each lap. The error of the map is the
//!    distance of points on it, 5 cm apart, from the nearest true wall, including the error of the
//!    pose; the parts of the true segments within 5 cm of the map are covered.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use anyhow::{Context, Result, ensure};
use nalgebra::Point2;
use serde_json::json;
use slamlab_core::experiment::{Experiment, ExperimentConfig};
use slamlab_core::geom::{Length, Segment};
use slamlab_core::pilot::Mode;
use slamlab_core::sim::{Fan, SensorKind};

use super::{Args, Outcome};
use crate::ride::{carry_out, world_named};
use crate::statistics::{median, quantile};

const SEEDS: u64 = 3;
const LAPS: usize = 10;
/// A place in each room, world frame, m; the corridor lies between.
#[rustfmt::skip]
const ROOMS: [(f64, f64); 8] = [
    (2.3, 2.5), (6.2, 1.8), (9.5, 1.5), (14.2, 3.9),
    (14.0, 10.0), (10.8, 10.6), (6.8, 8.2), (2.0, 8.5),
];
/// An errand that takes longer has failed, s.
const LONGEST: f64 = 300.0;
/// Shorter segments are not counted, m.
const LEAST_LENGTH: f64 = 0.3;
/// Smaller gaps are ignored, m.
const GAP: f64 = 0.25;
/// Length of a part of a wall, and how often it has to be hit.
const PART: f64 = 0.1;
const MET: u32 = 5;
const RANGE: f64 = 8.0;

pub(crate) fn measure(args: &Args) -> Result<Outcome> {
    let mut outcome = Outcome::default();
    let (mut ratios, mut errors, mut covered) = (vec![], vec![], vec![]);
    for seed in args.seeds(SEEDS) {
        let run = Run::of(seed)?;
        let last = run.counts.last().copied().unwrap_or(0);
        ratios.push(last as f64 / run.truth.len() as f64);
        errors.push(run.error_p95);
        covered.push(run.covered);
        outcome.figure(
            format!("seed_{seed}"),
            json!({
                "true_segments": run.truth.len(),
                "segments_after_each_lap": run.counts,
                "all_lengths_after_last_lap": run.all,
                "landmarks_of_filter": run.landmarks,
                "wall_error_p95_m": run.error_p95,
                "wall_error_median_m": run.error_median,
                "covered": run.covered,
            }),
        );
    }
    let worst = |values: &[f64], far: fn(f64) -> f64| {
        let worst = values.iter().max_by(|a, b| far(**a).total_cmp(&far(**b)));
        worst.copied().unwrap_or(f64::NAN)
    };
    let ratio = worst(&ratios, |ratio| (ratio - 1.0).abs());
    outcome.within("segments_over_true_worst", ratio, [0.8, 1.2]);
    outcome.at_most("wall_error_p95_m_worst", worst(&errors, |e| e), 0.02);
    outcome.at_least("covered_least", worst(&covered, |c| -c), 0.9);
    Ok(outcome)
}

struct Run {
    truth: Vec<Segment>,
    counts: Vec<usize>,
    all: usize,
    landmarks: usize,
    error_p95: f64,
    error_median: f64,
    covered: f64,
}

impl Run {
    fn of(seed: u64) -> Result<Self> {
        let world = world_named("office")?;
        let robot = world.robot.model();
        let mut config = ExperimentConfig::new(world, robot, SensorKind::Lidar.model(), seed);
        config.mode = Mode::Manual;
        let mut experiment = Experiment::new(config)?;
        let mut witness = Witness::default();
        let mut counts = vec![];
        for _ in 0..LAPS {
            for (x, y) in ROOMS {
                let goal = experiment.map_from_world() * Point2::new(x, y);
                experiment.set_mode(Mode::GoTo(goal));
                let mut steps = 0;
                carry_out(&mut experiment, LONGEST, |experiment| {
                    steps += 1;
                    if steps % 10 == 1 && steps > 1 {
                        witness.cast_beams(experiment)
                    } else {
                        Ok(())
                    }
                })?;
            }
            counts.push(long(&map_of(&experiment)).len());
        }
        let walls = experiment.sim().caster().walls().iter();
        let walls: Vec<Segment> = walls.map(|wall| wall.segment).collect();
        let truth = witness.segments(&walls);
        let world_from_map = experiment.map_from_world().inverse();
        let map = map_of(&experiment);
        let map: Vec<Segment> = map.iter().map(|s| world_from_map * *s).collect();
        let errors: Vec<f64> = points_on(&map).map(|p| nearest(&walls, p)).collect();
        ensure!(!errors.is_empty(), "seed {seed}: the map is empty");
        let is_near = |p: &Point2<f64>| nearest(&map, *p) <= 0.05;
        let near = points_on(&truth).filter(is_near).count();
        Ok(Self {
            counts,
            all: map.len(),
            landmarks: experiment.session().slam().view().landmarks.len(),
            error_p95: quantile(&errors, 0.95),
            error_median: median(&errors),
            covered: near as f64 / points_on(&truth).count() as f64,
            truth,
        })
    }
}

fn map_of(experiment: &Experiment) -> Vec<Segment> {
    let walls = experiment.session().slam().vector_map().walls();
    walls.iter().map(|wall| wall.segment).collect()
}

fn long(segments: &[Segment]) -> Vec<Segment> {
    let is_long = |s: &&Segment| s.length() >= LEAST_LENGTH;
    segments.iter().filter(is_long).copied().collect()
}

fn points_on(segments: &[Segment]) -> impl Iterator<Item = Point2<f64>> {
    segments.iter().flat_map(|s| {
        let pieces = (s.length() / 0.05).ceil().max(1.0) as usize;
        (0..=pieces).map(move |i| s.a + s.vector() * (i as f64 / pieces as f64))
    })
}

fn nearest(segments: &[Segment], point: Point2<f64>) -> f64 {
    let distances = segments.iter().map(|s| s.distance(point));
    distances.fold(f64::INFINITY, f64::min)
}

/// How often each part of each true wall was hit by a beam from the true pose.
#[derive(Default)]
struct Witness {
    met: BTreeMap<(usize, usize), u32>,
}

impl Witness {
    fn cast_beams(&mut self, experiment: &Experiment) -> Result<()> {
        let pose = experiment.sim().truth();
        let caster = experiment.sim().caster();
        let mut fan = Fan::new(360, -PI, PI / 180.0).context("no fan of beams")?;
        caster.cast_fan(pose.position(), pose.heading(), RANGE, &mut fan);
        for beam in 0..360 {
            let (Some(wall), Some(direction)) = (fan.surface(beam), fan.direction(beam)) else {
                continue;
            };
            let Some(segment) = caster.walls().get(wall).map(|wall| wall.segment) else {
                continue;
            };
            let hit = pose.position() + direction * fan.distances()[beam];
            let part = ((hit - segment.a).length() / PART) as usize;
            *self.met.entry((wall, part)).or_insert(0) += 1;
        }
        Ok(())
    }

    fn segments(&self, walls: &[Segment]) -> Vec<Segment> {
        let mut segments = vec![];
        for (number, wall) in walls.iter().enumerate() {
            let parts = self.met.range((number, 0)..(number + 1, 0));
            let mut stretches: Vec<[f64; 2]> = vec![];
            for ((_, part), _) in parts.filter(|(_, met)| **met >= MET) {
                let (low, high) = (*part as f64 * PART, (part + 1) as f64 * PART);
                match stretches.last_mut() {
                    Some(last) if low - last[1] <= GAP => last[1] = high,
                    _ => stretches.push([low, high]),
                }
            }
            let along = wall.vector() / wall.length();
            let at = |way: f64| wall.a + along * way.min(wall.length());
            segments.extend(stretches.iter().map(|s| Segment::new(at(s[0]), at(s[1]))));
        }
        long(&segments)
    }
}

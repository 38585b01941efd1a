//! `split_and_merge`: the lines of 1000 scans of 360 beams in `world_hall.csv`, time per scan.
//!
//! The points are made beforehand, like the peers', but only some scans at a time, so they are
//! still in the cache, like those that a robot has just made. The peer gives only the ends of its
//! pieces; here each line comes with its covariance and χ². The quality of the lines is judged as
//! in `report -- split-merge`: TPR, the share of the beams on walls that a line claims; PPV, the
//! share of the claims that are right.

use std::f64::consts::{PI, TAU};

use anyhow::{Result, ensure};
use nalgebra::{Point2, Vector2};
use slamlab_core::features::{AcceptConfig, LineConfig, LineExtractor};
use slamlab_core::geom::{Pose2, Segment, unit_vector};
use slamlab_core::points::{PointConfig, Points};
use slamlab_core::robot::{Scan, Stamp};

use crate::inputs::Inputs;
use crate::score::{Scene, Score};
use crate::timing::{cpu_ms, emit, median};

const WORKLOAD: &str = "lines_per_scan_360";
const BEAMS: usize = 360;
const MAX_RANGE: f64 = 30.0;
/// σ of the ranges, m, as in the inputs.
const SIGMA: f64 = 0.01;
const REPEATS: usize = 21;
/// Number of scans whose points are made at a time: 0.6 MB.
const BATCH: usize = 25;

pub(crate) fn run(inputs: &Inputs) -> Result<()> {
    let scans = inputs.rows::<{ 3 + BEAMS }>("map_scans_1000x360.csv")?;
    let walls = inputs.segments("world_hall.csv")?;
    let scenes: Vec<_> = scans.iter().map(|row| scene(row, &walls)).collect();
    let is_whole = scenes.iter().all(|scene| scene.points.beams.len() == BEAMS);
    ensure!(is_whole, "a scan has lost beams on the way to points");
    let every_line = LineConfig {
        accept: AcceptConfig::all(7, 0.5),
        ..LineConfig::default()
    };
    for (peer, config) in [
        ("slamlab(noise-aware)", every_line),
        ("slamlab(noise-aware,SLAM's-gates)", LineConfig::default()),
        ("slamlab(classic)", LineConfig::classic(0.05)),
    ] {
        measure(peer, config, &scenes)?;
    }
    Ok(())
}

fn measure(peer: &str, config: LineConfig, scenes: &[Scene]) -> Result<()> {
    let mut extractor = LineExtractor::new(config);
    let mut count = 0;
    let (mut lines, mut rounds) = (vec![], vec![]);
    for _ in 0..=REPEATS {
        count = 0;
        let mut ms = 0.0;
        for batch in scenes.chunks(BATCH) {
            let fresh: Vec<_> = batch.iter().map(|scene| scene.points.clone()).collect();
            let begin = cpu_ms();
            for points in &fresh {
                extractor.extract(points, &mut lines)?;
                count += lines.len();
            }
            ms += cpu_ms() - begin;
        }
        rounds.push(ms);
    }
    // The first was a warm-up.
    let ms = median(&mut rounds[1..]);
    let mut score = Score::default();
    for scene in scenes {
        extractor.extract(&scene.points, &mut lines)?;
        score.add(scene, &lines);
    }
    let (n, ratios) = (scenes.len() as f64, score.ratios());
    let extra = format!(
        "lines_per_scan={:.1} ppv={:.3} tpr={:.3}",
        count as f64 / n,
        ratios["ppv"],
        ratios["tpr"]
    );
    emit(peer, WORKLOAD, ms / n, &extra);
    Ok(())
}

/// A row of the file: the pose, then a range for each beam, -1 if there is none.
fn scene(row: &[f64], walls: &[Segment]) -> Scene {
    let (pose, ranges) = row.split_at(3);
    let pose = Pose2::new(pose[0], pose[1], pose[2]);
    let bearings: Vec<f64> = (0..BEAMS)
        .map(|beam| TAU * beam as f64 / BEAMS as f64 - PI)
        .collect();
    let seen = |range: &f64| {
        if *range > 0.0 {
            *range as f32
        } else {
            f32::INFINITY
        }
    };
    let scan = Scan {
        stamp: Stamp(0),
        robot_from_sensor: Pose2::identity(),
        ranges: ranges.iter().map(seen).collect(),
        sigmas: vec![SIGMA as f32; bearings.len()],
        bearings,
        bearing_sigma: 0.0,
        max_range: MAX_RANGE,
        sweep: 0.0,
        qualities: vec![],
    };
    let points = Points::from_scan(&scan, &Pose2::identity(), &PointConfig::default());
    let truth = (scan.bearings.iter().zip(&scan.ranges))
        .map(|(bearing, range)| {
            let direction = unit_vector(*bearing);
            let (range, wall) = nearest(walls, &pose, direction).filter(|_| range.is_finite())?;
            Some((wall, Point2::from(direction * range)))
        })
        .collect();
    Scene {
        points,
        truth,
        sigma: SIGMA,
    }
}

/// Range and number of the wall that a beam truly hits; `direction` in the robot frame.
fn nearest(walls: &[Segment], pose: &Pose2, direction: Vector2<f64>) -> Option<(f64, usize)> {
    let direction = pose.rotate(direction);
    let hits = walls.iter().enumerate().filter_map(|(index, wall)| {
        let range = wall.hit_by_ray(pose.position(), direction)?;
        Some((range, index))
    });
    hits.min_by(|a, b| a.0.total_cmp(&b.0))
}

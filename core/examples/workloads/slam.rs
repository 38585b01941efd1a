//! `slam`: the whole of `slam_log.csv`, 1 398 scans of 360 beams on two laps, time per scan; with
//! its odometry and without.
//!
//! The time is that of the whole run with default settings, from ranges to trajectory and map. As
//! with the peers, the error is the root mean square distance of all poses from the truth, with the
//! first pose placed on the true one. One scan per second is assumed, because the log has no times.

use std::f64::consts::{PI, TAU};

use anyhow::{Context, Result, ensure};
use slamlab_core::format::carmen::CarmenLog;
use slamlab_core::geom::{Length, Pose2};
use slamlab_core::replay::{Log, Replay};
use slamlab_core::robot::{Scan, Stamp};
use slamlab_core::slam::Method;

use crate::inputs::Inputs;
use crate::timing::{emit, median_ms};

const BEAMS: usize = 360;
/// Columns before the ranges: the true pose, and that of the odometry.
const POSES: usize = 6;
const MAX_RANGE: f64 = 20.0;
const REPEATS: usize = 5;

pub(crate) fn run(inputs: &Inputs) -> Result<()> {
    let rows = inputs.rows::<{ POSES + BEAMS }>("slam_log.csv")?;
    let pose = |row: &[f64], at: usize| Pose2::new(row[at], row[at + 1], row[at + 2]);
    let truth: Vec<Pose2> = rows.iter().map(|row| pose(row, 0)).collect();
    let mut log = CarmenLog::empty();
    for (index, row) in (0_u32..).zip(&rows) {
        let seconds = f64::from(index);
        log.push(seconds, &pose(row, 3), &scan(seconds, &row[POSES..]));
    }
    for (name, uses_odometry) in [("odometry", true), ("no odometry", false)] {
        let log = Log::from(log.clone());
        let mut settings = log.settings();
        settings.log.uses_odometry = uses_odometry;
        let mut done = None;
        let ms = median_ms(REPEATS, || {
            let mut replay = Replay::new(log.clone(), Method::ScanMatching, &settings)?;
            while replay.step()? {}
            done = Some(replay);
            Ok(())
        })?;
        let replay = done.context("nothing was mapped")?;
        let trajectory = replay.trajectory();
        ensure!(trajectory.len() == truth.len(), "scans were left out");
        let poses = trajectory.iter().map(|(_, pose)| *pose);
        let (rmse, most) = errors(&truth, poses).context("no scans")?;
        let closures = replay.session().slam().view().loop_closures;
        let extra = format!(
            "ms per scan; total_ms={ms:.0} ate_rmse_m={rmse:.4} max_m={most:.3} \
             loops={closures} scans={}",
            truth.len()
        );
        let peer = format!("slamlab-scan-matching({name})");
        emit(&peer, "slam_office_log", ms / truth.len() as f64, &extra);
    }
    Ok(())
}

/// -1 means that nothing was within the sensor's range.
fn scan(seconds: f64, ranges: &[f64]) -> Scan {
    let range = |range: &f64| match *range {
        range if range > 0.0 => range as f32,
        _ => f32::INFINITY,
    };
    let beams = 0..ranges.len();
    Scan {
        stamp: Stamp::from_seconds(seconds),
        robot_from_sensor: Pose2::identity(),
        bearings: beams.map(|i| TAU * i as f64 / BEAMS as f64 - PI).collect(),
        ranges: ranges.iter().map(range).collect(),
        sigmas: vec![],
        bearing_sigma: 0.0,
        max_range: MAX_RANGE,
        sweep: 0.0,
        qualities: vec![],
    }
}

/// Root mean square and largest distance, m, with the first pose placed on the true one.
fn errors(truth: &[Pose2], poses: impl Iterator<Item = Pose2> + Clone) -> Option<(f64, f64)> {
    let world_from_map = *truth.first()? * poses.clone().next()?.inverse();
    let off = |(truth, pose): (&Pose2, Pose2)| {
        (truth.position() - (world_from_map * pose).position()).length()
    };
    let off = truth.iter().zip(poses).map(off);
    let squares: f64 = off.clone().map(|off| off * off).sum();
    let rmse = (squares / truth.len() as f64).sqrt();
    Some((rmse, off.fold(0.0, f64::max)))
}

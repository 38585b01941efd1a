//! `register`: 100 pairs of scans of 360 points per set, like the peers' `icp_*`: from raw points
//! to the pose, trees and normals included. A pair counts as found within 3 cm and 0.5°.

use anyhow::{Result, ensure};
use nalgebra::Point2;
use slamlab_core::geom::{Length, Pose2};
use slamlab_core::registration::{Cloud, CloudMethod, JudgeConfig, Verdict, register_clouds};

use crate::inputs::Inputs;
use crate::timing::{emit, median, median_ms};

const SETS: [&str; 3] = ["room_easy", "office_easy", "office_hard"];
const REPEATS: usize = 21;

struct Pair {
    /// The fixed cloud, and the moving one.
    clouds: [Vec<Point2<f64>>; 2],
    truth: Pose2,
}

pub(crate) fn run(inputs: &Inputs) -> Result<()> {
    for set in SETS {
        let pairs = pairs(inputs, set)?;
        for (name, method) in CloudMethod::all() {
            let mut errors = (vec![], vec![]);
            let (mut found, mut believed) = (0, 0);
            let ms = median_ms(REPEATS, || {
                errors = (vec![], vec![]);
                (found, believed) = (0, 0);
                for pair in &pairs {
                    let [fixed, moving] = &pair.clouds;
                    let fixed = Cloud::scan(fixed.clone())?;
                    let moving = Cloud::scan(moving.clone())?;
                    let start = Pose2::identity();
                    let judge = JudgeConfig::default();
                    let result = register_clouds(&moving, &fixed, &start, &method, &judge);
                    let off = result.estimate.pose.minus(&pair.truth);
                    let (shift, turn) = (off.xy().length(), off.z.abs().to_degrees());
                    found += usize::from(shift < 0.03 && turn < 0.5);
                    believed += usize::from(result.verdict == Verdict::Converged);
                    errors.0.push(shift);
                    errors.1.push(turn);
                }
                Ok(())
            })?;
            let count = pairs.len() as f64;
            let part = |n: usize| 100.0 * n as f64 / count;
            let extra = format!(
                "ok={:.0}% trans_err_median_mm={:.2} rot_err_median_deg={:.4} converged={:.0}%",
                part(found),
                1e3 * median(&mut errors.0),
                median(&mut errors.1),
                part(believed),
            );
            emit(
                &format!("slamlab({name})"),
                &format!("icp_{set}"),
                ms / count,
                &extra,
            );
        }
    }
    Ok(())
}

fn pairs(inputs: &Inputs, set: &str) -> Result<Vec<Pair>> {
    let points = inputs.table::<4>(&format!("icp_{set}_points.csv"))?;
    let truths = inputs.table::<4>(&format!("icp_{set}_truth.csv"))?;
    let cloud = |pair: f64, which: f64| {
        let its = points
            .iter()
            .filter(|row| row[0] == pair && row[1] == which);
        its.map(|row| Point2::new(row[2], row[3]))
            .collect::<Vec<_>>()
    };
    let pair = |[pair, x, y, heading]: [f64; 4]| {
        let clouds = [0.0, 1.0].map(|which| cloud(pair, which));
        ensure!(
            clouds.iter().all(|cloud| !cloud.is_empty()),
            "{set}: pair {pair} is empty"
        );
        Ok(Pair {
            clouds,
            truth: Pose2::new(x, y, heading),
        })
    };
    truths.into_iter().map(pair).collect()
}

//! The cost of an update of the line filter, a scan of scan matching and the registration of two
//! scans, by a clock that is passed in: the same code natively and in the browser.

#[path = "../../core/examples/shared/mapped_filter.rs"]
mod mapped_filter;

use nalgebra::Point2;
use slamlab_core::association::AssociationMethod;
use slamlab_core::estimation::EkfError;
use slamlab_core::format::carmen::CarmenLog;
use slamlab_core::geom::Pose2;
use slamlab_core::registration::{
    Cloud, CloudError, CloudMethod, JudgeConfig, Verdict, register_clouds,
};
use slamlab_core::replay::{Log, Replay};
use slamlab_core::sim::{Caster, worlds};
use slamlab_core::slam::Method;

use mapped_filter::{mapped, observe, wall};

use crate::numbers;
use crate::recorded_loop::recorded_loop;

/// Landmarks in the map.
const SIZES: [usize; 3] = [100, 300, 1000];
/// Duration of one measurement, ms, or a little more: less than a time slice of a busy system, and
/// many times the resolution of a browser's clock (0.1 ms at worst).
const MEASUREMENT_MS: f64 = 3.0;
const MEASUREMENTS: usize = 200;
/// Number of registrations of two scans. A browser first compiles a program quickly, and meanwhile
/// recompiles what runs often with optimisation: after a second of one method that is done.
const REGISTRATIONS: usize = 400;
/// Number of replays of the recorded loop, some tens of milliseconds each.
const REPLAYS: usize = 20;
/// Number of replays of a log of a building, some seconds each.
const LOG_REPLAYS: usize = 4;
/// Number of scans of a replay that are measured together, some milliseconds.
const STRETCH: usize = 10;

/// Why nothing could be measured.
#[derive(Debug, thiserror::Error)]
pub enum CostError {
    /// The filter refused its map.
    #[error(transparent)]
    Filter(#[from] EkfError),
    /// A log could not be replayed.
    #[error("{log}: {why}")]
    Replay {
        /// Which log.
        log: &'static str,
        /// The message of its reader or of the mapper.
        why: String,
    },
    /// Scans were refused as clouds.
    #[error("two scans: {0}")]
    Clouds(#[from] CloudError),
}

/// Lines `cost NAME MS`: milliseconds of an update with one match at some sizes of the map, of the
/// registration of two scans by each method, and of a scan by scan matching, including its share of
/// the work at the end: for the recorded loop, and for `log`, a CARMEN log of a building, if there
/// is one. Each is the minimum of several measurements, because other programs on the machine only
/// ever add.
///
/// # Errors    Of filter, clouds and replays.
pub fn costs(now_ms: impl Fn() -> f64, log: Option<&[u8]>) -> Result<Vec<String>, CostError> {
    let mut lines = vec![];
    for n in SIZES {
        let ms = update_ms(n, &now_ms)?;
        lines.push(format!("cost update_with_{n}_landmarks {ms:?}"));
    }
    let scans = two_scans();
    for (name, method) in CloudMethod::all() {
        let ms = registration_ms(&scans, &method, &now_ms)?;
        lines.push(format!("cost two_scans_by_{name} {ms:?}"));
    }
    let ms = scan_ms(
        "recorded loop",
        recorded_loop().as_bytes(),
        REPLAYS,
        &now_ms,
    )?;
    lines.push(format!("cost scan_of_recorded_loop {ms:?}"));
    if let Some(log) = log {
        let ms = scan_ms("log of a building", log, LOG_REPLAYS, &now_ms)?;
        lines.push(format!("cost scan_of_building {ms:?}"));
    }
    Ok(lines)
}

fn update_ms(n: usize, now_ms: impl Fn() -> f64) -> Result<f64, EkfError> {
    let mut shortest = f64::INFINITY;
    let mut slam = mapped(n, AssociationMethod::Nearest)?;
    for _ in 0..MEASUREMENTS {
        let (begin, mut updates) = (now_ms(), 0.0);
        let mut passed = 0.0;
        while passed < MEASUREMENT_MS {
            for _ in 0..(4000 / n).max(1) {
                let matched = observe(&mut slam, &[wall(0)])?;
                assert_eq!(matched, 1, "the wall was not recognised");
                updates += 1.0;
            }
            passed = now_ms() - begin;
        }
        shortest = shortest.min(passed / updates);
    }
    Ok(shortest)
}

/// What a laser with 360 beams sees of the office from two places, each in its own frame.
#[allow(clippy::expect_used)] // without its world nothing is measured
fn two_scans() -> [Vec<Point2<f64>>; 2] {
    let caster = Caster::new(worlds::builtin("office").expect("a built-in world").walls());
    let mut noise = numbers().map(|u| 0.02 * u - 0.01);
    [Pose2::new(2.0, 2.0, 0.3), Pose2::new(2.15, 1.92, 0.38)].map(|pose| {
        let origin = Point2::new(pose.x(), pose.y());
        let bearings = (0..360).map(|beam| f64::from(beam).to_radians());
        let points = bearings.filter_map(|bearing| {
            let (cos, sin) = (pose * Pose2::new(0.0, 0.0, bearing)).cos_sin();
            let hit = caster.cast(origin, [cos, sin].into(), 30.0)?;
            let range = hit.distance + noise.next().unwrap_or(0.0);
            let (cos, sin) = Pose2::new(0.0, 0.0, bearing).cos_sin();
            Some(Point2::new(range * cos, range * sin))
        });
        points.collect()
    })
}

fn registration_ms(
    [fixed, moving]: &[Vec<Point2<f64>>; 2],
    method: &CloudMethod,
    now_ms: impl Fn() -> f64,
) -> Result<f64, CloudError> {
    let (start, judge) = (Pose2::identity(), JudgeConfig::default());
    let mut shortest = f64::INFINITY;
    for _ in 0..REGISTRATIONS {
        let (begin, mut registrations, mut passed) = (now_ms(), 0.0, 0.0);
        while passed < MEASUREMENT_MS {
            // Everything that is derived from the points is computed first.
            let (fixed, moving) = (Cloud::scan(fixed.clone())?, Cloud::scan(moving.clone())?);
            let found = register_clouds(&moving, &fixed, &start, method, &judge);
            assert_eq!(found.verdict, Verdict::Converged, "it did not find the way");
            registrations += 1.0;
            passed = now_ms() - begin;
        }
        shortest = shortest.min(passed / registrations);
    }
    Ok(shortest)
}

/// For each stretch of the log the minimum time counts.
fn scan_ms(
    name: &'static str,
    text: &[u8],
    replays: usize,
    now_ms: impl Fn() -> f64,
) -> Result<f64, CostError> {
    let failed = |error: &dyn std::error::Error| CostError::Replay {
        log: name,
        why: error.to_string(),
    };
    let log = Log::from(CarmenLog::parse(text).map_err(|e| failed(&e))?);
    let mut shortest: Vec<f64> = vec![];
    let mut steps = 0.0;
    for _ in 0..replays {
        let mut replay = Replay::new(log.clone(), Method::ScanMatching, &log.settings())
            .map_err(|e| failed(&e))?;
        let (mut stretch, mut goes_on) = (0, true);
        steps = 0.0;
        while goes_on {
            let begin = now_ms();
            for _ in 0..STRETCH {
                goes_on = goes_on && replay.step().map_err(|e| failed(&e))?;
                steps += f64::from(u8::from(goes_on));
            }
            let passed = now_ms() - begin;
            match shortest.get_mut(stretch) {
                Some(shortest) => *shortest = shortest.min(passed),
                None => shortest.push(passed),
            }
            stretch += 1;
        }
    }
    Ok(shortest.iter().sum::<f64>() / steps)
}

//! What an update of the line filter and a scan of scan matching cost, by a clock that is handed
//! in: the same code natively and in the browser.

#[path = "../../core/examples/shared/mapped_filter.rs"]
mod mapped_filter;

use slamlab_core::association::AssociationMethod;
use slamlab_core::estimation::EkfError;
use slamlab_core::format::carmen::CarmenLog;
use slamlab_core::replay::{Log, Replay};
use slamlab_core::slam::Method;

use mapped_filter::{mapped, observe, wall};

use crate::recorded_loop::recorded_loop;

/// Landmarks in the map.
const SIZES: [usize; 3] = [100, 300, 1000];
/// Milliseconds of one measurement, or a little more: less than what a busy system grants at a
/// time, many times the grain of a browser's clock (0.1 ms at most).
const MEASUREMENT_MS: f64 = 3.0;
const MEASUREMENTS: usize = 200;
/// Replays of the recorded loop, some tens of milliseconds each.
const REPLAYS: usize = 20;

/// Why nothing could be measured.
#[derive(Debug, thiserror::Error)]
pub enum CostError {
    /// The filter refused its map.
    #[error(transparent)]
    Filter(#[from] EkfError),
    /// The recording could not be replayed.
    #[error("recorded loop: {0}")]
    Replay(String),
}

/// Lines `cost NAME MS`: milliseconds of an update with one match at some sizes of the map, and of
/// a scan of the recorded loop by scan matching, with its part of the work at the end. Of some
/// measurements each is the shortest, for what other programs take of the machine only ever adds.
///
/// # Errors    Of filter and replay.
pub fn costs(now_ms: impl Fn() -> f64) -> Result<Vec<String>, CostError> {
    let mut lines = vec![];
    for n in SIZES {
        let ms = update_ms(n, &now_ms)?;
        lines.push(format!("cost update_with_{n}_landmarks {ms:?}"));
    }
    let ms = scan_ms(&now_ms)?;
    lines.push(format!("cost scan_of_recorded_loop {ms:?}"));
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

fn scan_ms(now_ms: impl Fn() -> f64) -> Result<f64, CostError> {
    let failed = |error: &dyn std::error::Error| CostError::Replay(error.to_string());
    let log = CarmenLog::parse(recorded_loop().as_bytes()).map_err(|e| failed(&e))?;
    let log = Log::from(log);
    let mut shortest = f64::INFINITY;
    for _ in 0..REPLAYS {
        let mut replay = Replay::new(log.clone(), Method::ScanMatching, &log.settings())
            .map_err(|e| failed(&e))?;
        let (begin, mut steps) = (now_ms(), 0.0);
        while replay.step().map_err(|e| failed(&e))? {
            steps += 1.0;
        }
        shortest = shortest.min((now_ms() - begin) / steps);
    }
    Ok(shortest)
}

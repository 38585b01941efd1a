//! What an update of the line filter costs, by a clock that is handed in: the same code natively
//! and in the browser.

#[path = "../../core/examples/shared/mapped_filter.rs"]
mod mapped_filter;

use slamlab_core::association::AssociationMethod;
use slamlab_core::estimation::EkfError;

use mapped_filter::{mapped, observe, wall};

/// Landmarks in the map.
pub const SIZES: [usize; 3] = [100, 300, 1000];
/// Milliseconds of one measurement, or a little more: less than what a busy system grants at a
/// time, many times the grain of a browser's clock (0.1 ms at most).
const MEASUREMENT_MS: f64 = 3.0;
const MEASUREMENTS: usize = 200;

/// Milliseconds of an update with one match for each of [`SIZES`]: of some measurements the
/// shortest, for what other programs take of the machine only ever adds.
///
/// # Errors    Of the filter.
pub fn update_ms(now_ms: impl Fn() -> f64) -> Result<[f64; SIZES.len()], EkfError> {
    let mut shortest = [f64::INFINITY; SIZES.len()];
    for (shortest, n) in shortest.iter_mut().zip(SIZES) {
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
            *shortest = shortest.min(passed / updates);
        }
    }
    Ok(shortest)
}

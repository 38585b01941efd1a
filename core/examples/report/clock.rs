//! How long work takes.

pub(crate) use crate::cpu_clock::cpu_seconds;

const REPEATS: usize = 5;

/// Minimum processor time of several runs, s: disturbances only add.
pub(crate) fn least_seconds(mut work: impl FnMut()) -> f64 {
    let once = |_| {
        let begin = cpu_seconds();
        work();
        cpu_seconds() - begin
    };
    (0..REPEATS).map(once).fold(f64::INFINITY, f64::min)
}

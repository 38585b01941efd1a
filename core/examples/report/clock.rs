//! Processor time.

use rustix::time::{ClockId, clock_gettime};

const REPEATS: usize = 5;

/// Processor time of this process, s: what a quiet machine's clock would show, on any machine.
pub(crate) fn cpu_seconds() -> f64 {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}

/// The least processor time of several runs, s: what disturbs them only adds.
pub(crate) fn least_seconds(mut work: impl FnMut()) -> f64 {
    let once = |_| {
        let begin = cpu_seconds();
        work();
        cpu_seconds() - begin
    };
    (0..REPEATS).map(once).fold(f64::INFINITY, f64::min)
}

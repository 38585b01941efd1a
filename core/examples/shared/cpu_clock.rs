//! Processor time: what the wall clock of an idle machine would show, on any machine.

use rustix::time::{ClockId, clock_gettime};

/// Processor time that this process has used, s.
pub(crate) fn cpu_seconds() -> f64 {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}

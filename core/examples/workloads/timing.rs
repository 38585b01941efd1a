//! Processor time and medians, as in the peers' programs.

use anyhow::Result;

use crate::cpu_clock::cpu_seconds;

/// Milliseconds of processor time that this process has used.
pub(crate) fn cpu_ms() -> f64 {
    1e3 * cpu_seconds()
}

/// Median processor time of `work`, ms, over `times` runs after one warm-up run.
pub(crate) fn median_ms(times: usize, mut work: impl FnMut() -> Result<()>) -> Result<f64> {
    work()?;
    let mut all = vec![];
    for _ in 0..times {
        let begin = cpu_ms();
        work()?;
        all.push(cpu_ms() - begin);
    }
    Ok(median(&mut all))
}

/// The median; NaN of no values.
pub(crate) fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

/// Prints a measurement in the peers' form.
pub(crate) fn emit(peer: &str, workload: &str, ms: f64, extra: &str) {
    println!("{peer} {workload} {ms:.6} {extra}");
}

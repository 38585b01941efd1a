//! `browser-cost`: what does the browser add to an update of the line filter?
//!
//! In: a machine with Chromium. Out: one JSON object with the milliseconds of an update with one
//! match at 100, 300 and 1 000 landmarks, one build right after the other:
//!
//! | build | vector instructions |
//! |---|---|
//! | `native` | cargo profile `release`, as everybody builds it: 256 bits, where the machine turns out to have them |
//! | `narrow` | the same with the feature `narrow`: 128 bits, as every x86-64 has |
//! | `browser` | profile `wasm`: 128 bits, as `.cargo/config.toml` says; WebAssembly has no wider ones |
//!
//! An error where the browser takes more than `MOST` times as long as `narrow`: that is what the
//! browser adds. What it lacks, the wider instructions, is the ratio to `native`, which stands
//! beside it.

use std::process::Command;

use anyhow::{Context, Result, bail};

use crate::tools;

/// How many times as long as natively, with instructions as wide, an update may take in the
/// browser.
const MOST: f64 = 1.5;
const SIZES: [usize; 3] = [100, 300, 1000];

/// Measures both, prints the figures, and judges.
///
/// # Errors
/// If something cannot be built or run, or the browser is too slow.
pub fn report() -> Result<()> {
    tools::need_wasm_target()?;
    let native_args = "run --release --package slamlab-tests --example update_cost";
    let native = update_ms(tools::cargo().args(native_args.split(' ')))?;
    let narrow = update_ms(
        tools::cargo()
            .args(native_args.split(' '))
            .args(["--features", "narrow"]),
    )?;
    let browser = update_ms(
        tools::cargo()
            .env("CHROME", tools::chrome()?)
            .env("CHROMEDRIVER", tools::chromedriver()?)
            .args("test --profile wasm --target wasm32-unknown-unknown".split(' '))
            .args("--package slamlab-tests --test update_cost -- --nocapture".split(' ')),
    )?;
    let over = |others: &[f64]| -> Vec<f64> {
        let pairs = browser.iter().zip(others);
        pairs.map(|(browser, other)| browser / other).collect()
    };
    let ratios = over(&narrow);
    println!("{{");
    println!("  \"report\": \"browser-cost\",");
    println!("  \"landmarks\": {SIZES:?},");
    println!("  \"native_ms\": {native:?},");
    println!("  \"narrow_ms\": {narrow:?},");
    println!("  \"browser_ms\": {browser:?},");
    println!("  \"browser_in_native\": {:?},", over(&native));
    println!("  \"browser_in_narrow\": {ratios:?},");
    println!("  \"browser_in_narrow_at_most\": {MOST:?}");
    println!("}}");
    let is_slow = |ratio: f64| ratio.is_nan() || ratio > MOST;
    match (ratios.iter().zip(SIZES)).find(|(ratio, _)| is_slow(**ratio)) {
        None => Ok(()),
        Some((ratio, n)) => bail!(
            "at {n} landmarks the browser takes {ratio:.2} times as long as natively with instructions as wide, expected at most {MOST}"
        ),
    }
}

/// Runs a command and reads the line `update_ms [a, b, c]` from what it prints.
fn update_ms(command: &mut Command) -> Result<[f64; SIZES.len()]> {
    let output = tools::output(command)?;
    let found = output.lines().find_map(numbers);
    found.with_context(|| format!("no line `update_ms [..]` in the output:\n{output}"))
}

fn numbers(line: &str) -> Option<[f64; SIZES.len()]> {
    let (_, list) = line.split_once("update_ms [")?;
    let (list, _) = list.split_once(']')?;
    let numbers: Vec<f64> =
        (list.split(',').map(|n| n.trim().parse().ok())).collect::<Option<_>>()?;
    numbers.try_into().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_are_found_within_what_else_is_printed() {
        let line = "    log: update_ms [0.01, 2e-2, 3.5]";
        assert_eq!(numbers(line), Some([0.01, 0.02, 3.5]));
        for bad in ["update_ms [0.01, 2]", "update_ms [a, b, c]", "nothing"] {
            assert_eq!(numbers(bad), None);
        }
    }
}

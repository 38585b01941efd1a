//! `browser-cost`: how much slower is the browser for an update of the line filter, for a
//! registration, and for a scan?
//!
//! In: a machine with Chromium. Out: one JSON object with the milliseconds of an update of the line
//! filter with one match at 100, 300 and 1 000 landmarks, of the registration of two scans by each
//! method, and of a scan by scan matching: in a loop of our own and, if the recorded data is there,
//! in Intel. The builds run one right after the other:
//!
//! | build | vector instructions |
//! |---|---|
//! | `native` | cargo profile `release`, as everybody builds it: 256 bits, if the machine has them |
//! | `narrow` | the same with the feature `narrow`: 128 bits, as every x86-64 has |
//! | `browser` | profile `wasm`: 128 bits, as `.cargo/config.toml` says; WebAssembly has no wider ones |
//!
//! It is an error if the browser takes more than `MOST` times as long as `narrow`: that is the cost
//! of the browser itself. The cost of lacking wider instructions shows in the ratio to `native`,
//! which is printed beside it.

use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;
use std::process::Command;

use anyhow::{Context, Result, bail};

use crate::tools;

/// Maximum ratio of the time in the browser to the native time with equally wide instructions.
const MOST: f64 = 1.5;

/// Measures both, prints the figures, and judges.
///
/// # Errors
/// If something cannot be built or run, or the browser is too slow.
pub fn report() -> Result<()> {
    tools::need_wasm_target()?;
    let log = tools::data_folder().join("intel/intel.clf");
    let log = log.is_file().then_some(log);
    let run = |features: &[&str]| {
        let native = "run --release --package slamlab-tests --example browser_cost";
        let mut cargo = tools::cargo();
        cargo.args(native.split(' ')).args(features).arg("--");
        costs(cargo.args(&log))
    };
    let native = run(&[])?;
    let narrow = run(&["--features", "narrow"])?;
    let lent = log.as_ref().map(Lent::new).transpose()?;
    let browser = costs(
        tools::cargo()
            .env("CHROME", tools::chrome()?)
            .env("CHROMEDRIVER", tools::chromedriver()?)
            .args("test --profile wasm --target wasm32-unknown-unknown".split(' '))
            .args("--package slamlab-tests --test browser_cost -- --nocapture".split(' ')),
    )?;
    drop(lent);
    if !(native.keys().eq(browser.keys()) && narrow.keys().eq(browser.keys())) {
        bail!("the builds measured different things: {native:?}, {narrow:?}, {browser:?}");
    }
    let mut slow = vec![];
    println!("{{");
    println!("  \"report\": \"browser-cost\",");
    for (name, browser) in &browser {
        let of = |costs: &Costs| costs.get(name).copied().unwrap_or(f64::NAN);
        let (native, narrow) = (of(&native), of(&narrow));
        let ratio = browser / narrow;
        println!("  \"{name}\": {{");
        println!("    \"native_ms\": {native:?},");
        println!("    \"narrow_ms\": {narrow:?},");
        println!("    \"browser_ms\": {browser:?},");
        println!("    \"browser_in_native\": {:?},", browser / native);
        println!("    \"browser_in_narrow\": {ratio:?}");
        println!("  }},");
        if ratio.is_nan() || ratio > MOST {
            slow.push(format!("{name}: {ratio:.2}"));
        }
    }
    if log.is_none() {
        println!("  \"scan_of_building\": \"not measured: no recorded data\",");
    }
    println!("  \"browser_in_narrow_at_most\": {MOST:?}");
    println!("}}");
    if slow.is_empty() {
        return Ok(());
    }
    bail!(
        "times as long in the browser as natively with instructions as wide: {}; expected at most {MOST}",
        slow.join(", ")
    )
}

/// A copy of a log where the server of the browser's test finds it, until this is dropped: the
/// server only knows that package's folder.
struct Lent(PathBuf);

impl Lent {
    fn new(log: &PathBuf) -> Result<Self> {
        let lent = Self(tools::root().join("tests/browser_cost.log.tmp"));
        fs::copy(log, &lent.0).with_context(|| format!("cannot copy {}", log.display()))?;
        Ok(lent)
    }
}

impl Drop for Lent {
    fn drop(&mut self) {
        if let Err(error) = fs::remove_file(&self.0) {
            eprintln!("cannot remove {}: {error}", self.0.display());
        }
    }
}

/// Milliseconds, by the name of what was measured.
type Costs = BTreeMap<String, f64>;

/// Runs a command and reads the lines `cost NAME MS` from what it prints.
fn costs(command: &mut Command) -> Result<Costs> {
    let output = tools::output(command)?;
    let found: Costs = output.lines().filter_map(cost).collect();
    if found.is_empty() {
        bail!("no line `cost NAME MS` in the output:\n{output}");
    }
    Ok(found)
}

fn cost(line: &str) -> Option<(String, f64)> {
    let (_, words) = line.split_once("cost ")?;
    let (name, ms) = words.trim().split_once(' ')?;
    Some((name.to_owned(), ms.parse().ok()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_are_found_within_what_else_is_printed() {
        assert_eq!(
            cost("    log: cost scan 0.01"),
            Some(("scan".to_owned(), 0.01))
        );
        assert_eq!(cost("cost scan 2e-2"), Some(("scan".to_owned(), 0.02)));
        for bad in ["cost scan", "cost scan a", "cost", "nothing"] {
            assert_eq!(cost(bad), None);
        }
    }
}

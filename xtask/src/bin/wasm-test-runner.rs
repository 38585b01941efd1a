//! Runs tests that are compiled for wasm32 in headless Chromium; called by cargo
//! (`.cargo/config.toml`).
//!
//! It is wasm-bindgen's own runner, pinned to the version of the crate; Chromium and chromedriver
//! are found first. The runner takes its settings from the environment, so this program starts
//! itself once more with them.

use std::env;
use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result};
use serde_json::{Value, json};
use xtask::tools;

const SETTINGS: &str = "WASM_BINDGEN_TEST_WEBDRIVER_JSON";

fn main() -> Result<()> {
    if env::var_os(SETTINGS).is_some() {
        return wasm_bindgen_cli::wasm_bindgen_test_runner::run_cli_with_args(env::args_os());
    }
    let folder = tempfile::tempdir()?;
    let settings = folder.path().join("webdriver.json");
    std::fs::write(&settings, capabilities(&tools::chrome()?).to_string())?;
    let status = Command::new(env::current_exe()?)
        .args(env::args_os().skip(1))
        .env(SETTINGS, &settings)
        .env("CHROMEDRIVER", tools::chromedriver()?)
        .env("WASM_BINDGEN_TEST_TIMEOUT", timeout_seconds())
        .status()
        .context("cannot start the test runner")?;
    // `exit` runs no destructors, so the folder is removed first.
    drop(folder);
    std::process::exit(status.code().unwrap_or(1))
}

/// How Chromium is started: no window, no traffic of its own, and no sandbox, which does not work
/// for root.
fn capabilities(chrome: &Path) -> Value {
    json!({ "goog:chromeOptions": {
        "binary": chrome,
        "args": [
            "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--disable-dev-shm-usage",
            "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync",
        ],
    } })
}

/// Whole experiments run in the browser too; the runner's default of 20 s is meant for unit tests.
fn timeout_seconds() -> String {
    env::var("WASM_BINDGEN_TEST_TIMEOUT").unwrap_or_else(|_| "300".to_owned())
}

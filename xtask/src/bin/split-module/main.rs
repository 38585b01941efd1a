//! Splits a WebAssembly module into the part that a first visit runs and the rest, which is loaded
//! at the first call of a function in it.
//!
//! ```text
//! split-module count MODULE OUT          the module, with a mark for each function that was called
//! split-module split MODULE CALLED OUT   in folder OUT, both parts; CALLED: numbers of functions
//! ```
//!
//! `xtask::wasm` calls both, and `www/first_visit.mjs` between them: it makes a first visit with
//! the counting module and writes the numbers. A function missing in that list only makes a visitor
//! load the second part sooner: every call still works.

mod count;
mod numbers;
mod parts;
mod rest;

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};

fn main() -> Result<()> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    match words.as_slice() {
        ["count", module, out] => write(Path::new(out), &count::counting(&read(module)?)?),
        ["split", module, called, out] => {
            let (module, called) = (read(module)?, fs::read_to_string(called));
            let called = called.context("cannot read the numbers of what was called")?;
            let called: Vec<usize> = serde_json::from_str(&called)?;
            let parts = parts::split(&module, &called)?;
            let out = PathBuf::from(out);
            fs::create_dir_all(&out)?;
            write(&out.join("slamlab_web_bg.wasm"), &parts.first)?;
            write(&out.join("slamlab_web_rest.wasm"), &parts.rest)
        }
        _ => bail!("expected: split-module count MODULE OUT, or split MODULE CALLED OUT"),
    }
}

fn read(path: &str) -> Result<Vec<u8>> {
    fs::read(path).with_context(|| format!("cannot read {path}"))
}

fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    fs::write(path, bytes).with_context(|| format!("cannot write {}", path.display()))
}

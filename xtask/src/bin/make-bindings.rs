//! Makes the JavaScript bindings of a WebAssembly module: `make-bindings MODULE FOLDER [--debug]`;
//! `xtask::wasm` calls it.
//!
//! The library form of wasm-bindgen's tool is part of this program. Nothing has to be installed,
//! and cargo pins it to the version of the crate: the two must be equal.

use std::path::PathBuf;

use anyhow::{Context, Result, bail};
use wasm_bindgen_cli_support::Bindgen;

fn main() -> Result<()> {
    let words: Vec<PathBuf> = std::env::args_os().skip(1).map(PathBuf::from).collect();
    let (module, folder, debug) = match words.as_slice() {
        [module, folder] => (module, folder, false),
        [module, folder, flag] if flag.as_os_str() == "--debug" => (module, folder, true),
        _ => bail!("expected: make-bindings MODULE FOLDER [--debug]"),
    };
    Bindgen::new()
        .input_path(module)
        .web(true)?
        .typescript(true)
        .debug(debug)
        // The names are a tenth of the module. A panic reports its file and line without them.
        .remove_name_section(!debug)
        .remove_producers_section(true)
        .generate(folder)
        .with_context(|| format!("wasm-bindgen cannot process {}", module.display()))
}

//! Reads a recorded log from a file, in chunks, so that the text is never in memory as a whole.

use std::io::BufRead as _;
use std::path::Path;

use anyhow::Context;
use slamlab_core::replay::{Log, LogReader};

/// Bytes read at once.
const CHUNK: usize = 1 << 16;

pub(crate) fn read(path: &Path) -> anyhow::Result<Log> {
    let name = || format!("log {}", path.display());
    let file = std::fs::File::open(path).with_context(name)?;
    let mut file = std::io::BufReader::with_capacity(CHUNK, file);
    let mut reader = LogReader::default();
    loop {
        let chunk = file.fill_buf().with_context(name)?;
        if chunk.is_empty() {
            return reader.finish().with_context(name);
        }
        reader.push(chunk).with_context(name)?;
        let count = chunk.len();
        file.consume(count);
    }
}

//! `--graph`: optimises a pose graph from the poses of its file, and reports the result.

use std::path::Path;
use std::time::Instant;

use anyhow::Context;
use serde_json::json;
use slamlab_core::format::g2o;

use crate::{options, print};

pub(crate) fn solve(path: &Path, out: Option<&Path>, on_one_line: bool) -> anyhow::Result<()> {
    let written = out.map(|out| ("--out", out.to_owned()));
    options::check(vec![], written.into_iter().collect())?;
    let name = || format!("graph {}", path.display());
    let bytes = std::fs::read(path).with_context(name)?;
    let mut file = g2o::parse(&bytes).with_context(name)?;
    for (tag, lines) in &file.left_out {
        eprintln!("{}: left out: {lines} of {tag}", path.display());
    }
    let begin = Instant::now();
    let solved = file.solve().with_context(name)?;
    let ms = 1e3 * begin.elapsed().as_secs_f64();
    if let Some(out) = out {
        options::write(&[(out.to_owned(), g2o::write(&file).into())])?;
    }
    let figures = json!({
        "graph": path.display().to_string(),
        "poses": file.vertices.len(),
        "edges": file.edges.len(),
        "chi2_before": solved.chi2_before,
        "chi2_after": solved.chi2_after,
        "converged": solved.converged,
        "iterations": solved.iterations,
        "ms": ms,
    });
    print(&figures, on_one_line)
}

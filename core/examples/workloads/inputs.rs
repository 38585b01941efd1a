//! In: the peers' text files. Out: rows of numbers. Errors name file, line and column.

use std::path::PathBuf;

use anyhow::{Context, Result, ensure};
use nalgebra::Point2;
use slamlab_core::geom::Segment;

/// The folder of inputs.
pub(crate) struct Inputs {
    pub(crate) folder: PathBuf,
}

impl Inputs {
    /// The rows of a file of comma-separated numbers, each with at least `N` of them. Lines that
    /// begin with `#` are headers.
    pub(crate) fn rows<const N: usize>(&self, name: &str) -> Result<Vec<Vec<f64>>> {
        let text = self.text(name)?;
        let lines = (1..).zip(text.lines());
        let lines = lines.filter(|(_, line)| !line.is_empty() && !line.starts_with('#'));
        let read = |(number, line): (usize, &str)| {
            let row = row(line).with_context(|| format!("{name}, line {number}"))?;
            let n = row.len();
            ensure!(
                n >= N,
                "{name}, line {number}: {n} numbers, expected at least {N}"
            );
            Ok(row)
        };
        lines.map(read).collect()
    }

    /// A text file.
    pub(crate) fn text(&self, name: &str) -> Result<String> {
        let path = self.folder.join(name);
        std::fs::read_to_string(&path).with_context(|| format!("cannot read {}", path.display()))
    }

    /// As [`Self::rows`], but exactly `N` numbers in each row.
    pub(crate) fn table<const N: usize>(&self, name: &str) -> Result<Vec<[f64; N]>> {
        let exact = |row: Vec<f64>| {
            let n = row.len();
            let row = row.try_into().ok();
            row.with_context(|| format!("{name}: a row of {n} numbers, expected {N}"))
        };
        self.rows::<N>(name)?.into_iter().map(exact).collect()
    }

    /// The segments of a file, by the coordinates of their ends.
    pub(crate) fn segments(&self, name: &str) -> Result<Vec<Segment>> {
        let rows = self.table::<4>(name)?.into_iter();
        let segment =
            |[ax, ay, bx, by]: [f64; 4]| Segment::new(Point2::new(ax, ay), Point2::new(bx, by));
        Ok(rows.map(segment).collect())
    }
}

fn row(line: &str) -> Result<Vec<f64>> {
    let parts = line.split(',').enumerate();
    parts
        .map(|(column, part)| {
            let number = part.trim().parse();
            number.with_context(|| format!("column {}: `{part}` is no number", column + 1))
        })
        .collect()
}

//! In: the peers' text files. Out: rows of numbers; what cannot be read is named by file, line and
//! column.

use std::path::PathBuf;

use anyhow::{Context, Result, ensure};

/// The folder of inputs.
pub(crate) struct Inputs {
    folder: PathBuf,
}

impl Inputs {
    pub(crate) fn in_folder(folder: PathBuf) -> Self {
        Self { folder }
    }

    /// The rows of a file of comma-separated numbers, each with at least `N` of them. Lines that
    /// begin with `#` are headers.
    pub(crate) fn rows<const N: usize>(&self, name: &str) -> Result<Vec<Vec<f64>>> {
        let path = self.folder.join(name);
        let text = std::fs::read_to_string(&path)
            .with_context(|| format!("cannot read {}", path.display()))?;
        let lines = text.lines().enumerate();
        let lines = lines.filter(|(_, line)| !line.is_empty() && !line.starts_with('#'));
        lines
            .map(|(index, line)| {
                let row = row(line).with_context(|| format!("{name}, line {}", index + 1))?;
                ensure!(
                    row.len() >= N,
                    "{name}, line {}: {} numbers, expected at least {N}",
                    index + 1,
                    row.len()
                );
                Ok(row)
            })
            .collect()
    }

    /// The lines of a text file.
    pub(crate) fn lines(&self, name: &str) -> Result<Vec<String>> {
        let path = self.folder.join(name);
        let text = std::fs::read_to_string(&path)
            .with_context(|| format!("cannot read {}", path.display()))?;
        Ok(text.lines().map(str::to_owned).collect())
    }

    /// As [`Self::rows`], but exactly `N` numbers in each row.
    pub(crate) fn table<const N: usize>(&self, name: &str) -> Result<Vec<[f64; N]>> {
        let rows = self.rows::<N>(name)?;
        rows.into_iter()
            .map(|row| {
                let n = row.len();
                let row = row.try_into().ok();
                row.with_context(|| format!("{name}: a row of {n} numbers, expected {N}"))
            })
            .collect()
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

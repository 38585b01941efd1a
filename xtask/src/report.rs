//! Runs steps to the end even when one fails, and closes with a table of what passed.

use std::time::Instant;

use anyhow::{Result, bail};

/// Steps that have run: name, error if it failed, seconds.
#[derive(Debug, Default)]
pub struct Report {
    steps: Vec<(String, Option<String>, f64)>,
}

impl Report {
    /// Runs one step, shows its name before and its error after.
    pub fn step(&mut self, name: &str, work: impl FnOnce() -> Result<()>) {
        eprintln!("\n=== {name}");
        let start = Instant::now();
        let error = work().err().map(|error| format!("{error:#}"));
        if let Some(error) = &error {
            eprintln!("error: {error}");
        }
        self.steps
            .push((name.to_owned(), error, start.elapsed().as_secs_f64()));
    }

    /// Prints the table.
    ///
    /// # Errors
    /// If a step failed.
    pub fn finish(self) -> Result<()> {
        eprintln!();
        for (name, error, seconds) in &self.steps {
            let verdict = if error.is_none() { "ok    " } else { "FAILED" };
            eprintln!("{verdict} {seconds:7.1} s  {name}");
        }
        let failed: Vec<&str> = self
            .steps
            .iter()
            .filter(|(_, error, _)| error.is_some())
            .map(|(name, ..)| name.as_str())
            .collect();
        if failed.is_empty() {
            return Ok(());
        }
        bail!(
            "{} of {} failed: {}",
            failed.len(),
            self.steps.len(),
            failed.join(", ")
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_step_does_not_stop_the_next_and_is_named_at_the_end() {
        let mut report = Report::default();
        let mut ran = false;
        report.step("first", || bail!("broken"));
        report.step("second", || {
            ran = true;
            Ok(())
        });
        let error = report.finish().unwrap_err();
        assert!(ran);
        assert_eq!(error.to_string(), "1 of 2 failed: first");
    }

    #[test]
    fn nothing_failed_is_success() {
        let mut report = Report::default();
        report.step("only", || Ok(()));
        assert!(report.finish().is_ok());
    }
}

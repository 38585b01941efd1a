//! Runs steps to the end even if one fails, and closes with a table of what passed and a list of
//! what was skipped.

use std::time::Instant;

use anyhow::{Result, bail};

use crate::skips::Skip;

/// Steps that have run: name, error if it failed, seconds.
#[derive(Debug, Default)]
pub struct Report {
    steps: Vec<(String, Option<String>, f64)>,
}

impl Report {
    /// Runs one step; prints its name before, and its error after.
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
        self.finish_with(&[], false)
    }

    /// Prints the table, and what was skipped. With `in_ci`, only [`Skip::is_fine_in_ci`] may be
    /// skipped.
    ///
    /// # Errors
    /// If a step failed, or something was skipped that may not be.
    pub fn finish_with(self, skips: &[Skip], in_ci: bool) -> Result<()> {
        eprintln!();
        for (name, error, seconds) in &self.steps {
            let verdict = if error.is_none() { "ok    " } else { "FAILED" };
            eprintln!("{verdict} {seconds:7.1} s  {name}");
        }
        eprintln!("{} skipped", skips.len());
        for Skip { what, why } in skips {
            eprintln!("  {what}: {why}");
        }
        let failed: Vec<&str> = self
            .steps
            .iter()
            .filter(|(_, error, _)| error.is_some())
            .map(|(name, ..)| name.as_str())
            .collect();
        if !failed.is_empty() {
            bail!(
                "{} of {} failed: {}",
                failed.len(),
                self.steps.len(),
                failed.join(", ")
            );
        }
        let forbidden = skips.iter().filter(|skip| !skip.is_fine_in_ci()).count();
        if in_ci && forbidden > 0 {
            bail!("{forbidden} skipped that may not be where CI is set; they are named above");
        }
        Ok(())
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

    #[test]
    fn what_is_skipped_fails_only_in_ci() {
        let skips = [Skip {
            what: "the firmware".into(),
            why: "it needs avr-gcc".into(),
        }];
        assert!(Report::default().finish_with(&skips, false).is_ok());
        assert!(Report::default().finish_with(&skips, true).is_err());
    }
}

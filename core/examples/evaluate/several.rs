//! Several logs, several methods: one run for each pair, and a table of the results.
//!
//! Each run is a process of its own: this program with one log and one method. So the peak memory
//! is that of the run, and a run that crashes does not end the others.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};

use anyhow::{Context, Result, bail, ensure};
use clap::parser::ValueSource;
use clap::{ArgMatches, CommandFactory as _};
use serde_json::{Value, json};
use slamlab_core::slam::Method;

use crate::table::Table;
use crate::worth::NOT_BELIEVED;
use crate::{Arguments, options, print};

/// Options that each [`Run`] sets for itself.
const OF_A_RUN: [&str; 5] = ["logs", "more_logs", "relations", "truth", "methods"];

/// One log by one method, with its references.
struct Run<'a> {
    log: &'a Path,
    method: &'a str,
    relations: Option<PathBuf>,
    truth: Option<PathBuf>,
}

pub(crate) fn evaluate(
    logs: &[PathBuf],
    methods: &[String],
    arguments: &Arguments,
    matches: &ArgMatches,
) -> Result<ExitCode> {
    check(logs, methods, arguments)?;
    let runs: Vec<Run> = logs
        .iter()
        .flat_map(|log| methods.iter().map(move |method| (log, method)))
        .map(|(log, method)| Run {
            log,
            method,
            relations: reference(&arguments.relations, log, "relations"),
            truth: reference(&arguments.truth, log, "tum"),
        })
        .collect();
    let table = Table::new(
        runs.iter().any(|run| run.relations.is_some()),
        runs.iter().any(|run| run.truth.is_some()),
    );
    if !arguments.json {
        table.print_head()?;
    }
    let passed_on = passed_on(matches);
    let (mut failed, mut is_doubted) = (0, false);
    for run in &runs {
        let (figures, is_believed) = run.figures(&passed_on).unwrap_or_else(|error| {
            failed += 1;
            eprintln!("evaluate: {error:#}");
            (run.failure(&format!("{error:#}")), false)
        });
        is_doubted |= !is_believed;
        match arguments.json {
            true => print(&figures, true)?,
            false => table.print_row(&figures)?,
        }
    }
    ensure!(failed == 0, "{failed} of {} runs failed", runs.len());
    Ok(match is_doubted {
        true => ExitCode::from(NOT_BELIEVED),
        false => ExitCode::SUCCESS,
    })
}

/// Refuses options that only a single run can have, and unknown names.
fn check(logs: &[PathBuf], methods: &[String], arguments: &Arguments) -> Result<()> {
    for method in methods {
        method.parse::<Method>().context("--method")?;
    }
    let fit = options::given([("--fit", &arguments.fit)]);
    let saved = arguments.saved_map.written_paths();
    let mut written = [arguments.outputs.paths(), fit, saved].concat().into_iter();
    if let Some((option, _)) = written.next() {
        bail!("{option}: only one log by one method can be written");
    }
    if logs.len() > 1 && arguments.poses.is_some() {
        bail!("--poses are those of one log");
    }
    if logs.len() > 1 && (arguments.relations.is_some() || arguments.truth.is_some()) {
        bail!(
            "--relations and --truth are of one log; those of several are looked for beside them, as NAME.relations and NAME.tum"
        );
    }
    Ok(())
}

/// The given file, or else the one beside the log that has its name.
fn reference(given: &Option<PathBuf>, log: &Path, extension: &str) -> Option<PathBuf> {
    let is_packed = log.extension().is_some_and(|extension| extension == "gz");
    let unpacked = if is_packed {
        log.with_extension("")
    } else {
        log.to_owned()
    };
    let beside = || Some(unpacked.with_extension(extension)).filter(|path| path.is_file());
    given.clone().or_else(beside)
}

/// The arguments of the command line other than logs, methods and references.
fn passed_on(matches: &ArgMatches) -> Vec<OsString> {
    let mut words = vec![];
    let command = Arguments::command();
    for argument in command.get_arguments() {
        let id = argument.get_id().as_str();
        let is_given = matches.value_source(id) == Some(ValueSource::CommandLine);
        let Some(option) = argument.get_long().filter(|_| is_given) else {
            continue;
        };
        if OF_A_RUN.contains(&id) || !argument.get_action().takes_values() {
            continue;
        }
        for value in matches.get_raw(id).into_iter().flatten() {
            words.extend([format!("--{option}").into(), value.to_owned()]);
        }
    }
    words
}

impl Run<'_> {
    /// The figures of the run, and whether they can be trusted.
    fn figures(&self, passed_on: &[OsString]) -> Result<(Value, bool)> {
        let program = std::env::current_exe().context("cannot find this program")?;
        let mut command = Command::new(program);
        command.arg("--log").arg(self.log);
        command.args(["--method", self.method, "--json"]);
        for (option, path) in [("--relations", &self.relations), ("--truth", &self.truth)] {
            if let Some(path) = path {
                command.arg(option).arg(path);
            }
        }
        let command = command.args(passed_on).stdin(Stdio::null());
        let output = command.output().context("cannot start a run")?;
        let said = String::from_utf8_lossy(&output.stderr);
        let is_believed = output.status.success();
        if is_believed || output.status.code() == Some(NOT_BELIEVED.into()) {
            eprint!("{said}");
            let figures = serde_json::from_slice(&output.stdout);
            return Ok((figures.context("a run printed no figures")?, is_believed));
        }
        // The error message stands last, unless the run crashed.
        let last = said.trim().lines().last();
        let Some(reason) = last.and_then(|line| line.strip_prefix("evaluate: ")) else {
            eprint!("{said}");
            bail!("log {}: {}", self.log.display(), output.status);
        };
        bail!("{reason}")
    }

    fn failure(&self, error: &str) -> Value {
        json!({
            "log": self.log.display().to_string(),
            "method": self.method,
            "error": error,
        })
    }
}

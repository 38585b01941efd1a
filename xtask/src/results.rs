//! `RESULTS.md`: every measured figure with its command, date, machine and commit, and whether the
//! measured code has changed since.
//!
//! 1. `table` names each result: what is claimed, the command, and the folders whose code it
//!    measures.
//! 2. `measure` runs the command and puts its section into the file, in the order of the table. The
//!    measured folders must be committed: their git hashes stand in the section, and are the only
//!    record of what was measured.
//! 3. [`name_stale`] compares those hashes with the commit that is checked out. A section whose
//!    result is no longer in the table is removed.

mod section;
mod table;

use std::fs;
use std::process::Command;

use anyhow::{Context, Result, bail};
use clap::builder::PossibleValuesParser;

use crate::report::Report;
use crate::tools;
use section::Section;
use table::{Entry, TABLE};

const FILE: &str = "RESULTS.md";

const HEAD: &str = "# Results\n\n\
    Every figure here was measured by the command above it, on the day, machine and commit beside it, and\n\
    `cargo xtask results NAME` measures it again. `cargo xtask check` names those that are older than the\n\
    code that they measure. `holds` says whether each requirement of the report is met.\n";

/// Which results are meant, and whether to measure them.
#[derive(Debug, clap::Args)]
pub struct Choice {
    /// Only these; all of them, which takes days, if none is named
    #[arg(value_parser = PossibleValuesParser::new(TABLE.iter().map(|entry| entry.name)))]
    names: Vec<String>,
    /// Only those that are missing or older than the code that they measure
    #[arg(long)]
    stale: bool,
    /// Only those that take less than two minutes
    #[arg(long)]
    quick: bool,
    /// Measure nothing: name them all, with their commands and how old they are
    #[arg(long)]
    list: bool,
}

/// Measures the chosen results, one after the other, and writes each into the file at once; or only
/// lists them.
///
/// # Errors
/// If code that is to be measured is not committed, or a command prints no figures.
pub fn run(choice: &Choice) -> Result<()> {
    let entries = chosen(choice)?;
    if choice.list {
        return list(&entries);
    }
    let mut report = Report::default();
    for entry in entries {
        report.step(entry.name, || {
            let section = section_of(entry)?;
            let mut sections = read()?;
            sections.retain(|other| other.name != entry.name);
            sections.push(section);
            write(&sections)
        });
    }
    report.finish()
}

fn list(entries: &[&Entry]) -> Result<()> {
    let sections = read()?;
    for entry in entries {
        let state = format!("{:?}", state(entry, &sections)?);
        println!("{:16} {state:8} {}", entry.name, entry.command_line());
    }
    Ok(())
}

/// Lists on standard error the results that are older than the measured code. They are not
/// failures, because measuring them takes days.
///
/// # Errors
/// If the file or git cannot be read.
pub fn name_stale() -> Result<()> {
    let sections = read()?;
    let states = TABLE
        .iter()
        .map(|entry| Ok((entry.name, state(entry, &sections)?)));
    let states: Vec<(&str, State)> = states.collect::<Result<_>>()?;
    // One line for all of a kind: in CI only the end of a log may be kept.
    for kind in [State::Old, State::Missing] {
        let names = states.iter().filter(|(_, state)| *state == kind);
        let names: Vec<&str> = names.map(|(name, _)| *name).collect();
        if !names.is_empty() {
            eprintln!("  {kind:?}: {}", names.join(", "));
        }
    }
    let count = states.iter().filter(|(_, s)| *s != State::Measured).count();
    eprintln!("{count} of {} results are old or missing", TABLE.len());
    Ok(())
}

/// Whether a result is as new as the code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Measured,
    Old,
    Missing,
}

fn state(entry: &Entry, sections: &[Section]) -> Result<State> {
    Ok(match sections.iter().find(|s| s.name == entry.name) {
        None => State::Missing,
        Some(section) if section.code == code_of(entry)? => State::Measured,
        Some(_) => State::Old,
    })
}

fn chosen(choice: &Choice) -> Result<Vec<&'static Entry>> {
    let sections = read()?;
    let mut chosen = vec![];
    for entry in TABLE {
        let is_named = choice.names.is_empty() || choice.names.iter().any(|n| n == entry.name);
        let is_wanted = is_named && (entry.is_quick() || !choice.quick);
        if is_wanted && (!choice.stale || state(entry, &sections)? != State::Measured) {
            chosen.push(entry);
        }
    }
    Ok(chosen)
}

fn section_of(entry: &Entry) -> Result<Section> {
    let changed = tools::git(&format!(
        "status --porcelain -- {}",
        entry.measures.join(" ")
    ))?;
    if !changed.is_empty() {
        bail!("commit first, so that the figures have a commit:\n{changed}");
    }
    let code = code_of(entry)?;
    let commit = tools::git("rev-parse --short=12 HEAD")?;
    let date = tools::quiet_output(Command::new("date").args(["-u", "+%Y-%m-%d"]))?;
    Ok(Section {
        name: entry.name.to_owned(),
        claim: entry.claim.to_owned(),
        command: entry.command_line(),
        facts: format!("{date}, {}, commit {commit}", machine()),
        code,
        figures: entry.run()?,
    })
}

/// Git's hashes of the folders that an entry measures, as committed.
fn code_of(entry: &Entry) -> Result<String> {
    let hash_of = |folder: &&str| {
        let hash = tools::git(&format!("rev-parse --short=12 HEAD:{folder}"));
        let hash = hash.with_context(|| format!("`{}` measures {folder}", entry.name))?;
        Ok(format!("{folder}={hash}"))
    };
    let hashes: Result<Vec<_>> = entry.measures.iter().map(hash_of).collect();
    Ok(hashes?.join(" "))
}

/// Processors and operating system, in words.
fn machine() -> String {
    let model = fs::read_to_string("/proc/cpuinfo").ok().and_then(|facts| {
        let line = facts.lines().find(|line| line.starts_with("model name"))?;
        Some(line.split_once(':')?.1.trim().to_owned())
    });
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    format!(
        "{cores} x {}, {}",
        model.unwrap_or_else(|| std::env::consts::ARCH.to_owned()),
        std::env::consts::OS
    )
}

fn read() -> Result<Vec<Section>> {
    let file = tools::root().join(FILE);
    let text = match fs::read_to_string(&file) {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(vec![]),
        text => text.with_context(|| format!("cannot read {}", file.display()))?,
    };
    section::parse(&text)
}

fn write(sections: &[Section]) -> Result<()> {
    let file = tools::root().join(FILE);
    let mut text = HEAD.to_owned();
    let in_order = TABLE
        .iter()
        .filter_map(|entry| sections.iter().find(|section| section.name == entry.name));
    for section in in_order {
        text.push_str(&section.to_string());
    }
    fs::write(&file, text).with_context(|| format!("cannot write {}", file.display()))
}

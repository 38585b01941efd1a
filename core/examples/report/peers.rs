//! In: a file of lines `peer workload median_ms extra`, as printed by the peers' programs and the
//! example `workloads`. Out: our time as a multiple of a peer's.
//!
//! The beginning of a peer's name is enough, because its version stands in it; of several lines the
//! last one counts.

use std::path::Path;

use anyhow::{Context, Result, ensure};

use crate::outcome::Outcome;

/// What programs have measured.
pub(crate) struct Peers {
    lines: Vec<Line>,
}

struct Line {
    peer: String,
    workload: String,
    ms: f64,
    extra: String,
}

/// Our program and a peer, and the allowed ratio of times.
pub(crate) struct Race<'a> {
    pub(crate) workload: &'a str,
    pub(crate) ours: &'a str,
    pub(crate) theirs: &'a str,
    pub(crate) at_most: f64,
}

impl Peers {
    pub(crate) fn read(path: &Path) -> Result<Self> {
        let text = std::fs::read_to_string(path)
            .with_context(|| format!("cannot read {}", path.display()))?;
        let lines = text.lines().filter(|line| !line.starts_with('#'));
        let lines: Vec<_> = lines.filter_map(line).collect();
        let path = path.display();
        ensure!(
            !lines.is_empty(),
            "{path} has no line `peer workload median_ms`"
        );
        Ok(Self { lines })
    }

    /// Adds both times and their ratio, which must be at most what the race allows.
    pub(crate) fn race(&self, outcome: &mut Outcome, race: &Race) -> Result<()> {
        let ours = self.line(race.workload, race.ours)?;
        let theirs = self.line(race.workload, race.theirs)?;
        let times = format!("{}_ms_{}", race.workload, theirs.peer);
        outcome.figure(times, vec![ours.ms, theirs.ms]);
        let key = format!("{}_in_{}", ours.peer, theirs.peer);
        outcome.at_most(&key, ours.ms / theirs.ms, race.at_most);
        Ok(())
    }

    /// A figure `name=value` that stands beside a peer's time; a percent sign is dropped.
    pub(crate) fn extra(&self, workload: &str, peer: &str, name: &str) -> Result<f64> {
        let line = self.line(workload, peer)?;
        let value = line
            .extra(name)
            .with_context(|| format!("{} tells no {name}", line.peer))?;
        Ok(value.trim_end_matches('%').parse()?)
    }

    /// Time, ms, and a figure beside it, from all lines of peers whose names begin with `peer`.
    pub(crate) fn all<'a>(
        &'a self,
        workload: &'a str,
        peer: &'a str,
        name: &'a str,
    ) -> impl Iterator<Item = (f64, f64)> + 'a {
        let lines = self.lines.iter().filter(move |l| l.workload == workload);
        let lines = lines.filter(move |l| l.peer.starts_with(peer));
        lines.filter_map(move |l| Some((l.ms, l.extra(name)?.parse().ok()?)))
    }

    fn line(&self, workload: &str, peer: &str) -> Result<&Line> {
        let lines = || (self.lines.iter().rev()).filter(|l| l.workload == workload);
        let exactly = lines().find(|l| l.peer == peer);
        let found = exactly.or_else(|| lines().find(|l| l.peer.starts_with(peer)));
        found.with_context(|| format!("no line of `{peer}` for {workload}"))
    }
}

impl Line {
    fn extra(&self, name: &str) -> Option<&str> {
        let mut parts = self.extra.split_whitespace();
        parts.find_map(|part| part.strip_prefix(name)?.strip_prefix('='))
    }
}

/// Names may contain blanks: the workload is the word before the first number.
fn line(text: &str) -> Option<Line> {
    let words: Vec<&str> = text.split_whitespace().collect();
    let at = (2..words.len()).find(|at| words[*at].parse::<f64>().is_ok())?;
    Some(Line {
        peer: words[..at - 1].join(" "),
        workload: words[at - 1].to_owned(),
        ms: words[at].parse().ok()?,
        extra: words[at + 1..].join(" "),
    })
}

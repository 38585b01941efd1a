//! The section of a result in the file: writing and reading it.

use std::fmt;

use anyhow::{Context, Result};

/// One result.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Section {
    pub(super) name: String,
    /// The claim, one sentence.
    pub(super) claim: String,
    pub(super) command: String,
    /// Date, machine, commit.
    pub(super) facts: String,
    /// Folders and their git hashes.
    pub(super) code: String,
    /// What the command printed.
    pub(super) figures: String,
}

impl fmt::Display for Section {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            name,
            claim,
            command,
            facts,
            code,
            figures,
        } = self;
        write!(
            f,
            "\n## {name}\n\n{claim}\n\n`{command}`\n\n{facts}\n\n<!-- code: {code} -->\n\n```json\n{}\n```\n",
            figures.trim()
        )
    }
}

/// The sections of such a file.
pub(super) fn parse(text: &str) -> Result<Vec<Section>> {
    let sections = text.split("\n## ").skip(1);
    sections.map(parse_one).collect()
}

fn parse_one(text: &str) -> Result<Section> {
    let name = text.lines().next().unwrap_or_default();
    let parts: Vec<&str> = text.splitn(6, "\n\n").collect();
    let read = || -> Option<Section> {
        let [name, claim, command, facts, code, figures] = parts.as_slice() else {
            return None;
        };
        let code = code.strip_prefix("<!-- code: ")?.strip_suffix(" -->")?;
        let figures = figures.trim().strip_prefix("```json\n")?;
        Some(Section {
            name: (*name).to_owned(),
            claim: (*claim).to_owned(),
            command: command.trim_matches('`').to_owned(),
            facts: (*facts).to_owned(),
            code: code.to_owned(),
            figures: figures.strip_suffix("\n```")?.to_owned(),
        })
    };
    read().with_context(|| {
        format!("the section `{name}` is not as `cargo xtask results` writes it: delete it")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn example(name: &str) -> Section {
        Section {
            name: name.into(),
            claim: "It is fast.".into(),
            command: "cargo run".into(),
            facts: "2026-11-22, 2 x that, linux, commit 0123456789ab".into(),
            code: "core/src=0123456789ab web=ba9876543210".into(),
            figures: "{\n  \"ms\": [1.5, 2],\n\n  \"holds\": true\n}".into(),
        }
    }

    #[test]
    fn what_is_written_is_read_back() {
        let sections = [example("a"), example("b")];
        let text = format!("# Results\n\nwords\n{}{}", sections[0], sections[1]);
        assert_eq!(parse(&text).unwrap(), sections);
    }

    #[test]
    fn a_section_that_was_changed_by_hand_is_named() {
        let error = parse("# Results\n\n## a\n\nwords\n").unwrap_err();
        assert!(error.to_string().contains("`a`"), "{error}");
    }
}

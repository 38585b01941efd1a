//! House rules that no compiler checks: how wide comments are, how long the README is, and that no
//! text names a folder of somebody's machine.

use std::path::Path;

use anyhow::{Result, bail};

use crate::tools;

/// Maximum width of a comment line, in columns.
const COLUMNS: usize = 100;
/// Maximum length of the README, in lines: what a newcomer still reads.
const README_LINES: usize = 120;

/// Folders of a machine, in pieces, because this file must not name them either.
const OF_A_MACHINE: [&[&str]; 4] = [
    &["/wo", "rk/"],
    &["/ho", "me/"],
    &["/ro", "ot/"],
    &["/Us", "ers/"],
];

/// Checks every file known to git.
///
/// # Errors
/// If a rule is broken; standard error lists each place.
pub fn check() -> Result<()> {
    let root = tools::root();
    let names = tools::git("ls-files -z --cached --others --exclude-standard")?;
    let mut broken = 0;
    for name in names.split_terminator('\0') {
        // Some files are not text, and a deleted one is still listed.
        let Ok(text) = std::fs::read_to_string(root.join(name)) else {
            continue;
        };
        for complaint in complaints(name, &text) {
            eprintln!("{complaint}");
            broken += 1;
        }
    }
    if broken > 0 {
        bail!("house rules are broken in {broken} places");
    }
    Ok(())
}

fn complaints(name: &str, text: &str) -> Vec<String> {
    let mut found = vec![];
    let lines = text.lines().count();
    if name == "README.md" && lines > README_LINES {
        found.push(format!(
            "{name}: {lines} lines, expected at most {README_LINES}"
        ));
    }
    let language = Language::of(name);
    // Code and drawings inside a comment keep their lines.
    let mut is_fenced = false;
    for (index, line) in text.lines().enumerate() {
        let is_fence = line
            .trim_start()
            .trim_start_matches(['/', '!', '*', ' '])
            .starts_with("```");
        is_fenced ^= is_fence;
        let at = || format!("{name}:{}", index + 1);
        if let Some(folder) = folder_of_a_machine(line) {
            found.push(format!("{}: names {folder}, a folder of one machine", at()));
        }
        let columns = line.chars().count();
        if !is_fenced && columns > COLUMNS && language.is_some_and(|l| l.wraps(line)) {
            found.push(format!(
                "{}: a comment of {columns} columns, expected at most {COLUMNS}",
                at()
            ));
        }
    }
    found
}

fn folder_of_a_machine(line: &str) -> Option<String> {
    OF_A_MACHINE
        .iter()
        .map(|pieces| pieces.concat())
        .find(|folder| begins_a_path(line, folder))
}

/// Whether `folder` appears as the beginning of a path, not inside one.
fn begins_a_path(line: &str, folder: &str) -> bool {
    line.match_indices(folder).any(|(at, _)| {
        let before = line[..at].chars().next_back();
        before.is_none_or(|c| !(c.is_alphanumeric() || "._-/~}".contains(c)))
    })
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Language {
    Rust,
    /// TypeScript, JavaScript and C, which also have block comments.
    WithBlocks,
}

impl Language {
    fn of(name: &str) -> Option<Self> {
        match Path::new(name).extension()?.to_str()? {
            "rs" => Some(Self::Rust),
            "ts" | "mjs" | "js" | "c" | "h" => Some(Self::WithBlocks),
            _ => None,
        }
    }

    /// Whether a line is a comment that can be wrapped: not a table row, nor a single word such as
    /// an address.
    fn wraps(self, line: &str) -> bool {
        let line = line.trim_start();
        let words = match self {
            _ if line.starts_with("//") => line.trim_start_matches(['/', '!']),
            Self::WithBlocks if line.starts_with("/*") => line.trim_start_matches(['/', '*']),
            Self::WithBlocks if line.starts_with("* ") => &line[1..],
            _ => return false,
        };
        let words = words.trim();
        let is_row = words.starts_with('|');
        !is_row && words.trim_start_matches(['-', '*', ' ']).contains(' ')
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_readme_is_named() {
        assert_eq!(complaints("README.md", &"x\n".repeat(120)), [""; 0]);
        assert_eq!(complaints("README.md", &"x\n".repeat(121)).len(), 1);
        assert_eq!(complaints("OTHER.md", &"x\n".repeat(121)), [""; 0]);
    }

    #[test]
    fn a_folder_of_a_machine_is_named_but_not_one_of_a_path() {
        let home = OF_A_MACHINE[1].concat();
        assert_eq!(complaints("a.md", &format!("see {home}me/x")).len(), 1);
        assert_eq!(complaints("a.md", &format!("`{home}me`")).len(), 1);
        assert_eq!(complaints("a.md", &format!("frame{home}")), [""; 0]);
    }

    #[test]
    fn comments_wrap_but_tables_code_and_addresses_do_not() {
        use Language::{Rust, WithBlocks};
        for (line, expected) in [
            ("/// some words", true),
            ("    // some words", true),
            ("//! - some words", true),
            ("//! | a | table |", false),
            ("/// https://example.org/one-word", false),
            ("let x = 1; // some words", false),
            ("* x as code in Rust", false),
        ] {
            assert_eq!(Rust.wraps(line), expected, "{line}");
        }
        assert!(WithBlocks.wraps("  /** some words */"));
        assert!(WithBlocks.wraps("   * some words"));
    }
}

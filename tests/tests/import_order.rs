//! Inside `core`, data flows one way and imports follow: each module imports only what the table allows.
#![cfg(not(target_family = "wasm"))] // reads the sources
#![allow(missing_docs)] // a test binary has no public interface

use std::fs;
use std::path::{Path, PathBuf};

/// What each module of `core` may import, beside itself. `sim`, `wire` and `format` are sources and sinks that no stage
/// imports, so a real robot, the simulator and a recording can stand in for each other.
const MAY_IMPORT: [(&str, &[&str]); 20] = [
    ("geom", &[]),
    ("hash", &["geom"]),
    ("robot", &["geom"]),
    ("points", &["geom", "robot"]),
    ("features", &["geom", "robot", "points"]),
    ("map", &["geom", "robot", "points", "features"]),
    ("association", &["geom", "points", "features", "map"]),
    ("registration", &["geom", "robot", "points", "map"]),
    ("estimation", BELOW_ESTIMATION),
    (
        "tracking",
        &["geom", "robot", "points", "map", "association"],
    ),
    ("plan", &["geom", "robot", "points", "map"]),
    ("control", &["geom", "robot", "points", "plan"]),
    ("slam", STAGES),
    ("pilot", STAGES),
    ("sim", &["geom", "robot"]),
    ("wire", &["geom", "robot"]),
    ("format", &["geom", "robot", "map", "sim"]),
    ("replay", EVERYTHING),
    ("experiment", EVERYTHING),
    ("lib", &[]),
];
const BELOW_ESTIMATION: &[&str] = &[
    "geom",
    "robot",
    "points",
    "features",
    "map",
    "association",
    "registration",
];
const STAGES: &[&str] = &[
    "geom",
    "hash",
    "robot",
    "points",
    "features",
    "map",
    "association",
    "registration",
    "estimation",
    "tracking",
    "plan",
    "control",
    "slam",
];
const EVERYTHING: &[&str] = &[
    "geom",
    "hash",
    "robot",
    "points",
    "features",
    "map",
    "association",
    "registration",
    "estimation",
    "tracking",
    "plan",
    "control",
    "slam",
    "pilot",
    "sim",
    "wire",
    "format",
    "replay",
];

#[test]
fn modules_of_core_import_only_what_stands_before_them() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("../core/src");
    let mut files = Vec::new();
    collect(&src, &mut files);
    assert!(files.len() > 10, "no sources in {}", src.display());
    let violations: Vec<String> = files
        .iter()
        .flat_map(|file| violations(&src, file))
        .collect();
    assert!(
        violations.is_empty(),
        "imports against the direction of data (see MAY_IMPORT):\n{}",
        violations.join("\n")
    );
}

/// `file:line: a imports b` for each import that the table does not allow, tests and doc comments aside.
fn violations(src: &Path, file: &Path) -> Vec<String> {
    let shown = file.strip_prefix(src).unwrap_or(file);
    let importer = shown
        .iter()
        .next()
        .and_then(|part| part.to_str())
        .unwrap_or("");
    let importer = importer.strip_suffix(".rs").unwrap_or(importer);
    let text =
        fs::read_to_string(file).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
    let Some((_, allowed)) = MAY_IMPORT.iter().find(|(name, _)| *name == importer) else {
        return vec![format!(
            "{}: module `{importer}` is not in the table",
            shown.display()
        )];
    };
    imports(&text)
        .into_iter()
        .filter(|(_, imported)| *imported != importer && !allowed.contains(imported))
        .map(|(line, imported)| {
            format!(
                "{}:{line}: `{importer}` imports `{imported}`",
                shown.display()
            )
        })
        .collect()
}

/// The modules of this crate that the code names, with their lines: `crate::x`, and each x of `crate::{x::…, y}`.
fn imports(text: &str) -> Vec<(usize, &str)> {
    // Unit tests stand at the end and may use what comes later, for instance to make scans.
    let code = text.split("#[cfg(test)]").next().unwrap_or(text);
    let mut found = Vec::new();
    for (at, path) in code.match_indices("crate::") {
        let start_of_line = code[..at].rfind('\n').map_or(0, |newline| newline + 1);
        if code[start_of_line..at].contains("//") {
            continue;
        }
        let line = code[..at].matches('\n').count() + 1;
        let rest = &code[at + path.len()..];
        found.extend(heads(rest).into_iter().map(|head| (line, head)));
    }
    found
}

/// The first names of a path: one, or those of a group in braces at its outer level.
fn heads(path: &str) -> Vec<&str> {
    let Some(group) = path.strip_prefix('{') else {
        return vec![name(path)];
    };
    let (mut depth, mut expecting, mut heads) = (0_usize, true, Vec::new());
    for (at, symbol) in group.char_indices() {
        match symbol {
            '{' => depth += 1,
            '}' if depth == 0 => break,
            '}' => depth -= 1,
            ',' if depth == 0 => expecting = true,
            _ if expecting && !symbol.is_whitespace() => {
                heads.push(name(&group[at..]));
                expecting = false;
            }
            _ => (),
        }
    }
    heads
}

fn name(path: &str) -> &str {
    let end = path.find(|c: char| !c.is_alphanumeric() && c != '_');
    &path[..end.unwrap_or(path.len())]
}

fn collect(folder: &Path, files: &mut Vec<PathBuf>) {
    let entries =
        fs::read_dir(folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    for path in entries.filter_map(|entry| entry.ok().map(|entry| entry.path())) {
        if path.is_dir() {
            collect(&path, files);
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            files.push(path);
        }
    }
}

#[test]
fn every_form_of_import_is_seen() {
    let text = "use crate::geom::Pose2;\nuse crate::{map::{Grid, ray}, robot::Scan};\n// crate::sim is not used\n\
                fn f() -> crate::plan::Path {}\n#[cfg(test)]\nmod tests { use crate::sim::World; }";
    let expected = [(1, "geom"), (2, "map"), (2, "robot"), (4, "plan")];
    assert_eq!(imports(text), expected);
}

//! Inside `core`, data flows one way and imports follow: each module imports only what the table
//! allows.
#![cfg(not(target_family = "wasm"))] // reads the sources
#![allow(missing_docs)] // a test binary has no public interface

use std::fs;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// What a module may import besides itself.
enum Imports {
    These(&'static [&'static str]),
    AllBefore,
}
use Imports::{AllBefore, These};

/// The modules of `core`, each after those that it may import. `sim` and `format` are sources and
/// sinks that no stage imports, so a real robot, the simulator and a recording can stand in for
/// each other.
const MAY_IMPORT: [(&str, Imports); 28] = [
    ("geom", These(&[])),
    ("hash", These(&["geom"])),
    ("bounds", These(&[])),
    ("lanes", These(&[])),
    ("robot", These(&["bounds", "geom"])),
    ("snapshot", These(&["geom", "robot"])),
    (
        "points",
        These(&["bounds", "geom", "lanes", "robot", "snapshot"]),
    ),
    (
        "features",
        These(&["bounds", "geom", "lanes", "robot", "points"]),
    ),
    (
        "map",
        These(&[
            "bounds", "geom", "lanes", "robot", "snapshot", "points", "features",
        ]),
    ),
    (
        "association",
        These(&["bounds", "geom", "points", "features", "map"]),
    ),
    (
        "registration",
        These(&["bounds", "geom", "lanes", "robot", "points", "map"]),
    ),
    (
        "estimation",
        These(&[
            "bounds",
            "geom",
            "lanes",
            "robot",
            "snapshot",
            "points",
            "features",
            "map",
            "association",
            "registration",
        ]),
    ),
    (
        "tracking",
        These(&["bounds", "geom", "robot", "points", "map", "association"]),
    ),
    ("plan", These(&["bounds", "geom", "robot", "points", "map"])),
    (
        "control",
        These(&["bounds", "geom", "robot", "points", "plan"]),
    ),
    ("slam", AllBefore),
    ("pilot", AllBefore),
    ("sim", These(&["bounds", "geom", "robot"])),
    (
        "format",
        These(&[
            "geom",
            "robot",
            "snapshot",
            "map",
            "registration",
            "estimation",
            "sim",
        ]),
    ),
    ("wire", These(&["geom", "robot", "points", "format"])),
    ("settings", AllBefore),
    ("twin", AllBefore),
    ("session", AllBefore),
    ("experiment", AllBefore),
    ("lesson", AllBefore),
    ("replay", AllBefore),
    ("live", AllBefore),
    (
        "device",
        These(&["geom", "robot", "points", "control", "wire"]),
    ),
];

/// Whether `importer` may import `imported`; `None` if the table does not know the importer.
fn may_import(importer: &str, imported: &str) -> Option<bool> {
    if importer == "lib" {
        return Some(false);
    }
    let place = |module: &str| MAY_IMPORT.iter().position(|(name, _)| *name == module);
    let (at, other) = (place(importer)?, place(imported));
    Some(match &MAY_IMPORT[at].1 {
        _ if importer == imported => true,
        These(modules) => modules.contains(&imported),
        AllBefore => other.is_some_and(|other| other < at),
    })
}

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

/// `file:line: a imports b` for each import that the table does not allow, except in tests and doc
/// comments.
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
    if may_import(importer, importer).is_none() {
        return vec![format!(
            "{}: module `{importer}` is not in the table",
            shown.display()
        )];
    }
    imports(&text)
        .into_iter()
        .filter(|(_, imported)| may_import(importer, imported) != Some(true))
        .map(|(line, imported)| {
            format!(
                "{}:{line}: `{importer}` imports `{imported}`",
                shown.display()
            )
        })
        .collect()
}

/// The modules of this crate that the code names, with their lines: `crate::x`, and each x of
/// `crate::{x::…, y}`.
fn imports(text: &str) -> Vec<(usize, &str)> {
    let tests = test_items(text);
    let mut found = Vec::new();
    for (at, path) in text.match_indices("crate::") {
        let start_of_line = text[..at].rfind('\n').map_or(0, |newline| newline + 1);
        let is_comment = text[start_of_line..at].contains("//");
        if is_comment || tests.iter().any(|item| item.contains(&at)) {
            continue;
        }
        let line = text[..at].matches('\n').count() + 1;
        let rest = &text[at + path.len()..];
        found.extend(heads(rest).into_iter().map(|head| (line, head)));
    }
    found
}

/// Where the items are that are for tests only; those may use later modules, for instance to make
/// scans. An item ends at its semicolon or with its outermost braces.
fn test_items(text: &str) -> Vec<Range<usize>> {
    text.match_indices("#[cfg(test)]")
        .map(|(start, _)| {
            let mut depth = 0_usize;
            let end = text[start..].find(|symbol| {
                match symbol {
                    '{' => depth += 1,
                    '}' => depth = depth.saturating_sub(1),
                    _ => (),
                }
                depth == 0 && matches!(symbol, ';' | '}')
            });
            start..end.map_or(text.len(), |end| start + end)
        })
        .collect()
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
        } else if path.extension().is_some_and(|ending| ending == "rs") && !is_for_tests(&path) {
            files.push(path);
        }
    }
}

/// Files of tests may use later modules, as items of tests may.
fn is_for_tests(path: &Path) -> bool {
    let ends = |name: &std::ffi::OsStr| name.to_string_lossy().ends_with("tests");
    path.file_stem().is_some_and(ends) || path.parent().and_then(Path::file_name).is_some_and(ends)
}

#[test]
fn the_table_holds_the_modules_of_core_and_no_others() {
    let lib = Path::new(env!("CARGO_MANIFEST_DIR")).join("../core/src/lib.rs");
    let text = fs::read_to_string(&lib).unwrap_or_else(|error| panic!("{lib:?}: {error}"));
    let modules = text.lines().filter_map(|line| {
        line.strip_prefix("pub mod ")
            .or_else(|| line.strip_prefix("mod "))
    });
    let mut modules: Vec<_> = modules.map(|rest| rest.trim_end_matches(';')).collect();
    let mut table: Vec<_> = MAY_IMPORT.iter().map(|(module, _)| *module).collect();
    modules.sort_unstable();
    table.sort_unstable();
    assert_eq!(modules, table);
}

#[test]
fn every_form_of_import_is_seen() {
    let text = "use crate::geom::Pose2;\n#[cfg(test)]\nmod tests;\nuse crate::{map::{Grid, ray}, robot::Scan};\n\
                // crate::sim is not used\n#[cfg(test)]\nfn g() { if crate::hash::g() {} }\n\
                fn f() -> crate::plan::Path {}\n#[cfg(test)]\nmod tests { use crate::sim::World; }";
    let expected = [(1, "geom"), (4, "map"), (4, "robot"), (8, "plan")];
    assert_eq!(imports(text), expected);
}

#[test]
fn the_table_is_read_in_the_direction_of_the_data() {
    for (importer, imported, expected) in [
        ("points", "robot", Some(true)),
        ("points", "points", Some(true)),
        ("points", "sim", Some(false)),
        ("slam", "control", Some(true)),
        ("slam", "pilot", Some(false)),
        ("pilot", "sim", Some(false)),
        ("experiment", "sim", Some(true)),
        ("lib", "geom", Some(false)),
        ("unheard_of", "geom", None),
    ] {
        assert_eq!(may_import(importer, imported), expected, "{importer}");
    }
}

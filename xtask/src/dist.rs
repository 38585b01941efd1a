//! A folder that any web server can serve, under any path and without special headers: the page as
//! embedded in the bridge, without what only the bridge uses.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};

use crate::wasm::Profile;
use crate::{page, tools};

/// The answer to the page's first request to its server. A bridge answers with what is behind it.
const NO_BRIDGE: &str = "{ \"static\": true }\n";

/// The file that identifies a folder filled before.
const SIGN: &str = "offline_worker.js";

/// Builds the page and fills `out` with it, `target/dist` if none is named. Files of an earlier
/// build are replaced; other files there stay.
///
/// # Errors
/// If the page cannot be built, or `out` has something else in it.
pub fn fill(out: Option<PathBuf>) -> Result<PathBuf> {
    let out = out.unwrap_or_else(|| tools::target_dir().join("dist"));
    refuse_foreign(&out)?;
    page::build(Profile::Release)?;
    fill_from(&tools::root().join("www/dist"), &out)?;
    Ok(out)
}

/// As [`fill`], from a page that is already built.
///
/// # Errors
/// If a file cannot be copied.
pub fn fill_from(built: &Path, out: &Path) -> Result<()> {
    copy(built, out)?;
    let about = out.join("bridge.json");
    fs::write(&about, NO_BRIDGE).with_context(|| format!("cannot write {}", about.display()))
}

fn refuse_foreign(out: &Path) -> Result<()> {
    let is_empty = match fs::read_dir(out) {
        Ok(mut entries) => entries.all(|entry| entry.is_ok_and(|entry| is_hidden(&entry))),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => true,
        Err(error) => return Err(error).with_context(|| format!("cannot read {}", out.display())),
    };
    if !is_empty && !out.join(SIGN).is_file() {
        bail!(
            "{} has something else in it; name a folder that is empty, or that was filled before",
            out.display()
        );
    }
    Ok(())
}

/// Like `.git`.
fn is_hidden(entry: &fs::DirEntry) -> bool {
    entry.file_name().to_string_lossy().starts_with('.')
}

/// Copies all but source maps, which are as large as the rest, and compressed files, which plain
/// servers do not look for.
fn copy(from: &Path, to: &Path) -> Result<()> {
    fs::create_dir_all(to).with_context(|| format!("cannot make {}", to.display()))?;
    for entry in fs::read_dir(from).with_context(|| format!("cannot read {}", from.display()))? {
        let entry = entry?;
        let (path, target) = (entry.path(), to.join(entry.file_name()));
        if path.is_dir() {
            copy(&path, &target)?;
        } else if !is_left_out(&path) {
            fs::copy(&path, &target).with_context(|| format!("cannot copy {}", path.display()))?;
        }
    }
    Ok(())
}

fn is_left_out(path: &Path) -> bool {
    let ending = path.extension();
    ending.is_some_and(|ending| ["map", "br", "gz"].iter().any(|other| ending == *other))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_with_something_else_in_it_is_refused() {
        let folder = tools::target_dir().join("dist-test");
        let _ = fs::remove_dir_all(&folder);
        refuse_foreign(&folder).unwrap();
        fs::create_dir_all(folder.join(".git")).unwrap();
        refuse_foreign(&folder).unwrap();
        fs::write(folder.join("thesis.tex"), "").unwrap();
        let refused = refuse_foreign(&folder).unwrap_err().to_string();
        assert!(refused.contains("something else in it"), "{refused}");
        fs::write(folder.join(SIGN), "").unwrap();
        refuse_foreign(&folder).unwrap();
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn maps_and_what_is_compressed_beforehand_are_left_out() {
        let folder = tools::target_dir().join("dist-test-copy");
        let _ = fs::remove_dir_all(&folder);
        let (built, out) = (folder.join("built"), folder.join("out"));
        fs::create_dir_all(built.join("icons")).unwrap();
        for name in [
            "main.js",
            "main.js.map",
            "main.js.br",
            "main.js.gz",
            "icons/a.png",
        ] {
            fs::write(built.join(name), name).unwrap();
        }
        fill_from(&built, &out).unwrap();
        let there = |name: &str| out.join(name).is_file();
        assert!(there("main.js") && there("icons/a.png") && there("bridge.json"));
        assert!(!there("main.js.map") && !there("main.js.br") && !there("main.js.gz"));
        fs::remove_dir_all(folder).unwrap();
    }
}

//! Puts the built page into the program where `SLAMLAB_PAGE` names its folder;
//! `cargo xtask package` does.
//!
//! Without the variable the program holds no page and serves a folder, which is what one wants
//! while working on the page. Source maps are left out: they are as large as all the rest. Of a
//! file that is there as `NAME.br` only that form is taken: the others are made from it.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::{env, fs, io};

fn main() -> ExitCode {
    println!("cargo:rerun-if-env-changed=SLAMLAB_PAGE");
    println!("cargo:rustc-check-cfg=cfg(has_page)");
    let Some(folder) = env::var_os("SLAMLAB_PAGE").filter(|name| !name.is_empty()) else {
        return ExitCode::SUCCESS;
    };
    let folder = Path::new(&folder);
    println!("cargo:rerun-if-changed={}", folder.display());
    if !folder.is_absolute() || !folder.join("index.html").is_file() {
        println!(
            "cargo:error=SLAMLAB_PAGE is {}: expected the absolute path of a built page, in which index.html lies; \
             `cargo xtask build` makes it in www/dist",
            folder.display()
        );
        return ExitCode::FAILURE;
    }
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets it")).join("page");
    if let Err(error) = copy_once(folder, &out) {
        println!(
            "cargo:error=cannot copy {} to {}: {error}",
            folder.display(),
            out.display()
        );
        return ExitCode::FAILURE;
    }
    println!("cargo:rustc-env=SLAMLAB_PAGE_FOLDER={}", out.display());
    println!("cargo:rustc-cfg=has_page");
    ExitCode::SUCCESS
}

fn copy_once(from: &Path, to: &Path) -> io::Result<()> {
    if to.exists() {
        fs::remove_dir_all(to)?;
    }
    fs::create_dir_all(to)?;
    for entry in fs::read_dir(from)? {
        let entry = entry?;
        let (name, target) = (entry.file_name(), to.join(entry.file_name()));
        // Maps may be compressed: `NAME.map.br`.
        let is_map = name
            .to_string_lossy()
            .split('.')
            .any(|ending| ending == "map");
        let has_smaller = |plain: &str| from.join(format!("{plain}.br")).exists();
        let path = entry.path();
        let is_doubled = match path.extension().is_some_and(|ending| ending == "gz") {
            true => path.file_stem().and_then(|stem| stem.to_str()),
            false => name.to_str(),
        }
        .is_some_and(has_smaller);
        if entry.file_type()?.is_dir() {
            copy_once(&path, &target)?;
        } else if !is_map && !is_doubled {
            fs::copy(path, target)?;
        }
    }
    Ok(())
}

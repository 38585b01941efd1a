//! Puts the built page into the program where `SLAMLAB_PAGE` names its folder;
//! `cargo xtask package` does.
//!
//! Without the variable the program holds no page and serves a folder, which is what one wants
//! while working on the page.

use std::path::Path;
use std::process::ExitCode;

fn main() -> ExitCode {
    println!("cargo:rerun-if-env-changed=SLAMLAB_PAGE");
    println!("cargo:rustc-check-cfg=cfg(has_page)");
    let Some(folder) = std::env::var_os("SLAMLAB_PAGE").filter(|name| !name.is_empty()) else {
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
    println!("cargo:rustc-env=SLAMLAB_PAGE_FOLDER={}", folder.display());
    println!("cargo:rustc-cfg=has_page");
    ExitCode::SUCCESS
}

//! From `www`, in TypeScript, and the module in `www/pkg`, to `www/dist`: the page as a browser loads it.
//!
//! What does not wait for each other runs side by side: the module and the programs of this machine
//! have build folders of their own, and npm has nothing to do with either.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::mpsc;
use std::thread;

use anyhow::{Context, Result, anyhow};

use crate::wasm::{self, Profile};
use crate::{serve, tools};

/// Compiles the module, bundles the page, and compresses its files where they are for use.
///
/// # Errors
/// If a tool is missing or a step fails.
pub fn build(profile: Profile) -> Result<()> {
    make_beside(profile, || Ok(()))
}

/// [`build`], and the bridge beside it, by cargo's profile `bridge`; its program is returned.
///
/// # Errors
/// As [`build`], and if the bridge does not compile.
pub fn build_with_bridge(profile: Profile, bridge: &str) -> Result<PathBuf> {
    make_beside(profile, || serve::build_bridge(bridge))
}

/// Type-checks the page.
///
/// # Errors
/// If a tool is missing or a type is wrong.
pub fn check_types() -> Result<()> {
    make_module_beside(Profile::Release, || Ok(()))?;
    check_types_of_last_build()
}

/// Type-checks the page against the bindings that the last build left, and makes them quickly where there are none.
///
/// # Errors
/// If a tool is missing or a type is wrong.
pub fn check_types_of_last_build() -> Result<()> {
    let www = tools::root().join("www");
    if !www.join("pkg/slamlab_web.d.ts").is_file() {
        make_module_beside(Profile::Dev, || Ok(()))?;
    }
    install(&www)?;
    tools::run(tools::npm(&www)?.args(["run", "--silent", "types"]))
}

/// Type-checks the page's tests.
///
/// # Errors
/// If a tool is missing or a type is wrong.
pub fn check_types_of_tests() -> Result<()> {
    // They name types of the page, which name those of its packages.
    install(&tools::root().join("www"))?;
    let folder = tools::root().join("tests/page");
    install(&folder)?;
    tools::run(tools::npm(&folder)?.args(["run", "--silent", "types"]))
}

/// The page in `www/dist`, while `other` compiles for this machine.
fn make_beside<T: Send>(profile: Profile, other: impl FnOnce() -> Result<T> + Send) -> Result<T> {
    let www = tools::root().join("www");
    thread::scope(|scope| {
        let (tell, is_bound) = mpsc::channel();
        let www = &www;
        let bundle = scope.spawn(move || -> Result<()> {
            install(www)?;
            // Closed without a word where the module failed, which is told there.
            if is_bound.recv().is_ok() {
                tools::run(tools::npm(www)?.args(["run", "--silent", "build"]))?;
                // Packing what is tried once takes longer than sending it.
                if profile == Profile::Release {
                    compress(&www.join("dist"))?;
                }
            }
            Ok(())
        });
        let made = make_module(profile, other, tell);
        made.and_then(|other| joined(bundle.join()).map(|()| other))
    })
}

fn make_module_beside<T: Send>(
    profile: Profile,
    other: impl FnOnce() -> Result<T> + Send,
) -> Result<T> {
    make_module(profile, other, mpsc::channel().0)
}

/// The module and its bindings in `www/pkg`, told to `done`, while `other` compiles for this machine.
fn make_module<T: Send>(
    profile: Profile,
    other: impl FnOnce() -> Result<T> + Send,
    done: mpsc::Sender<()>,
) -> Result<T> {
    thread::scope(|scope| {
        let (give, binder) = mpsc::channel();
        let rest = scope.spawn(move || -> Result<T> {
            // Nobody takes it where the module has failed.
            let _ = give.send(wasm::build_binder()?);
            other()
        });
        let bound = wasm::compile(profile).and_then(|module| match binder.recv() {
            Ok(binder) => wasm::bind(&binder, &module, profile).map(|()| {
                // Nobody listens where only the module is wanted.
                let _ = done.send(());
            }),
            // Its own error is told below.
            Err(mpsc::RecvError) => Ok(()),
        });
        drop(done);
        let rest = joined(rest.join());
        bound.and(rest)
    })
}

/// What a thread gave; one that panicked has told why on its own.
fn joined<T>(result: thread::Result<Result<T>>) -> Result<T> {
    result.unwrap_or_else(|_| Err(anyhow!("a step of the build panicked")))
}

/// Installs the packages that `folder`'s lock file names, unless they are there. Browsers are never downloaded.
///
/// # Errors
/// If npm is missing or cannot install.
pub fn install(folder: &Path) -> Result<()> {
    let lock = folder.join("package-lock.json");
    let lock = fs::read(&lock).with_context(|| format!("cannot read {}", lock.display()))?;
    let installed = folder.join("node_modules/.installed-lock.json");
    if fs::read(&installed).is_ok_and(|installed| installed == lock) {
        return Ok(());
    }
    tools::run(
        tools::npm(folder)?
            .args(["ci", "--no-audit", "--no-fund", "--loglevel", "error"])
            .env("PLAYWRIGHT_SKIP_BROWSER_DOWNLOAD", "1"),
    )?;
    fs::create_dir_all(folder.join("node_modules"))?;
    fs::write(&installed, lock).with_context(|| format!("cannot write {}", installed.display()))
}

/// Puts `.br` and `.gz` beside each file that shrinks by it; the bridge sends those. Node has both codecs built in.
fn compress(dist: &Path) -> Result<()> {
    let script = tools::root().join("xtask/compress.mjs");
    tools::run(tools::node(dist)?.arg(script).arg("."))
}

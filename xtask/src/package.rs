//! A package to install on the robot's computer: the page in the program, the program in a `.deb`,
//! and a test that it works.
//!
//! 1. The page is built and compressed, then the bridge with the page in it (`SLAMLAB_PAGE`),
//!    linked statically against musl: one file that needs nothing from the system that it is
//!    installed on.
//! 2. `deb` assembles it with settings, systemd unit, udev rules and guide, by `dpkg-deb`.
//! 3. `smoke` unpacks the package and runs its program, natively or in qemu's emulation of the
//!    other processor.
//! 4. `systemd-analyze` and `lintian` check the rest, if they are installed.
//!
//! A step whose tool is missing is reported as skipped; the package is made all the same.

mod deb;
mod smoke;

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail, ensure};
use clap::ValueEnum;

use crate::report::Report;
use crate::wasm::Profile;
use crate::{page, skips, tools};

/// What computer the package is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Target {
    /// Raspberry Pi 3 and later, with a 64-bit system
    Arm64,
    /// A PC
    Amd64,
}

impl Target {
    /// Debian's name for it, and Rust's name for the processor.
    fn names(self) -> [&'static str; 2] {
        match self {
            Self::Arm64 => ["arm64", "aarch64"],
            Self::Amd64 => ["amd64", "x86_64"],
        }
    }

    fn architecture(self) -> &'static str {
        self.names()[0]
    }

    fn processor(self) -> &'static str {
        self.names()[1]
    }

    /// Rust's name for the target.
    fn triple(self) -> String {
        format!("{}-unknown-linux-musl", self.processor())
    }

    fn is_this_machine(self) -> bool {
        std::env::consts::OS == "linux" && std::env::consts::ARCH == self.processor()
    }

    /// This computer.
    #[must_use]
    pub fn this_machine() -> Self {
        match std::env::consts::ARCH {
            "aarch64" => Self::Arm64,
            _ => Self::Amd64,
        }
    }

    /// The C compiler for the few lines of C and assembly in `ring`.
    fn compiler(self) -> Result<String> {
        let gcc = format!("{}-linux-gnu-gcc", self.processor());
        let mut compilers = [gcc, "clang".to_owned()].into_iter();
        compilers.find(|name| tools::is_in_path(name)).with_context(|| {
            format!(
                "a C compiler for {} is missing; install it by `sudo apt-get install gcc-{}-linux-gnu`, or clang",
                self.architecture(),
                self.processor().replace('_', "-"),
            )
        })
    }
}

/// What is not in every program.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, ValueEnum)]
pub enum Feature {
    /// Recordings in object storage
    Storage,
    /// Robots at a Zenoh router, also for tools of ROS 2
    Zenoh,
}

impl Feature {
    /// As Cargo calls it.
    fn name(self) -> &'static str {
        match self {
            Self::Storage => "storage",
            Self::Zenoh => "zenoh",
        }
    }
}

/// Maximum size of a package without features, bytes, for updating a robot over a slow link.
const MOST_BYTES: u64 = 5_700_000;

/// Builds the package for `target` and tries it out.
///
/// # Errors
/// If a tool that is indispensable is missing, or a step fails.
pub fn package(target: Target, features: &[Feature]) -> Result<()> {
    let mut features = features.to_vec();
    features.sort();
    features.dedup();
    page::build(Profile::Release)?;
    let program = build(target, &features, &tools::root().join("www/dist"))?;
    let package = deb::build(target, &features, &program)?;
    skips::begin()?;
    let mut report = Report::default();
    report.step("its size", || say_size(&features, &program, &package));
    report.step("the packaged program runs", || {
        smoke::test(target, &package)
    });
    report.step("the unit is one", verify_unit);
    report.step("the package is one", || lint(&package));
    report.finish_with(&skips::all()?, false)?;
    println!("{}", package.display());
    Ok(())
}

/// Compiles the bridge with the page of this folder in it.
fn build(target: Target, features: &[Feature], page: &Path) -> Result<PathBuf> {
    let triple = target.triple();
    tools::need_target(&triple)?;
    let suffix = triple.replace('-', "_");
    let mut cargo = tools::cargo();
    cargo
        .env("SLAMLAB_PAGE", page)
        .env(format!("CC_{suffix}"), target.compiler()?)
        // ring needs no C library for this, and a compiler for another system has no musl.
        .env(
            format!("CFLAGS_{suffix}"),
            "-ffreestanding -DRING_CORE_NOSTDLIBINC=1",
        )
        .args("build --profile packaged --package slamlab-bridge --bin slamlab-bridge".split(' '))
        .args(["--target", &triple, "--features", &names(features, ",")]);
    tools::run(&mut cargo)?;
    let program = tools::target_dir()
        .join(triple)
        .join("packaged/slamlab-bridge");
    if !program.is_file() {
        bail!("{} was not made", program.display());
    }
    Ok(program)
}

fn names(features: &[Feature], between: &str) -> String {
    let names = features.iter().map(|feature| feature.name());
    names.collect::<Vec<_>>().join(between)
}

fn say_size(features: &[Feature], program: &Path, package: &Path) -> Result<()> {
    let bytes = |file: &Path| std::fs::metadata(file).map(|known| known.len());
    let (program, package) = (bytes(program)?, bytes(package)?);
    eprintln!("  the program has {program} bytes, the package {package}");
    ensure!(
        !features.is_empty() || package <= MOST_BYTES,
        "a package without features may have {MOST_BYTES} bytes"
    );
    Ok(())
}

/// Lets systemd check the unit, with an existing program in it.
fn verify_unit() -> Result<()> {
    let Some(analyze) = tools::in_path("systemd-analyze") else {
        return skip("systemd-analyze", "systemd");
    };
    let unit = tools::root().join("bridge/deploy/slamlab-bridge.service");
    let text = std::fs::read_to_string(&unit)?;
    let folder = tools::target_dir().join("package/unit");
    std::fs::create_dir_all(&folder)?;
    let copy = folder.join("slamlab-bridge.service");
    let runnable = text
        .replace("/usr/bin/slamlab-bridge serve", "/bin/true serve")
        // The user is created when the package is installed.
        .replace("=slamlab\n", "=daemon\n");
    std::fs::write(&copy, runnable)?;
    let security = ["security", "--offline=yes", "--no-pager", "--threshold=25"];
    for words in [&["verify", "--man=no"][..], &security] {
        tools::run(Command::new(&analyze).args(words).arg(&copy))?;
    }
    Ok(())
}

/// What lintian complains of and is intended: one static file that runs anywhere, `--help` as the
/// manual, scripts without debhelper, and a project without a mail address.
const MEANT: [&str; 5] = [
    "statically-linked-binary",
    "no-manual-page",
    "maintainer-script-calls-systemctl",
    "bogus-mail-host",
    "bogus-mail-host-in-debian-changelog",
];

fn lint(package: &Path) -> Result<()> {
    let Some(lintian) = tools::in_path("lintian") else {
        return skip("lintian", "lintian");
    };
    let mut lintian = Command::new(lintian);
    // Without this it would refuse to run as root.
    lintian.args(["--allow-root", "--fail-on", "error", "--suppress-tags"]);
    lintian.arg(MEANT.join(","));
    tools::run(lintian.arg(package))
}

/// A step that cannot be done here does not count as failed.
fn skip(tool: &str, debian: &str) -> Result<()> {
    let why = format!("{tool} is missing; on Debian: sudo apt-get install {debian}");
    skips::note("a step of the package", &why)
}

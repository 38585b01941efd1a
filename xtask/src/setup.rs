//! What tests need beside Rust and Node: installed where that may be done, else named with the command to type.
//!
//! | machine | what happens |
//! |---|---|
//! | Debian or Ubuntu, as root (in CI also by a `sudo` that asks for nothing) | `apt-get` installs what is missing |
//! | any other | a browser that Playwright has brought is used; the rest is named with its command |

use std::path::Path;
use std::process::{Command, Stdio};

use anyhow::Result;

use crate::suites::Suite;
use crate::{firmware, tools};

/// A package of Debian's, which suites need it, and whether what they want of it is there.
struct Package {
    name: &'static str,
    suites: &'static [Suite],
    is_there: fn() -> bool,
}

const IN_A_BROWSER: &[Suite] = &[Suite::Wasm, Suite::Page];
/// The page is tried with the real firmware, too.
const WITH_FIRMWARE: &[Suite] = &[Suite::Page, Suite::Firmware];

const PACKAGES: [Package; 10] = [
    Package {
        name: "chromium",
        suites: IN_A_BROWSER,
        is_there: || tools::find_chrome().is_some(),
    },
    Package {
        name: "chromium-driver",
        suites: &[Suite::Wasm],
        is_there: || tools::find_chromedriver().is_some(),
    },
    Package {
        name: "gcc-avr",
        suites: WITH_FIRMWARE,
        is_there: || tools::in_path("avr-gcc").is_some(),
    },
    Package {
        name: "avr-libc",
        suites: WITH_FIRMWARE,
        is_there: firmware::has_avr_libc,
    },
    Package {
        name: "make",
        suites: WITH_FIRMWARE,
        is_there: || tools::in_path("make").is_some(),
    },
    Package {
        name: "pkg-config",
        suites: WITH_FIRMWARE,
        is_there: || tools::in_path("pkg-config").is_some(),
    },
    Package {
        name: "libelf-dev",
        suites: WITH_FIRMWARE,
        is_there: || firmware::has_library("libelf"),
    },
    Package {
        name: "zlib1g-dev",
        suites: WITH_FIRMWARE,
        is_there: || firmware::has_library("zlib"),
    },
    Package {
        name: "libzstd-dev",
        suites: WITH_FIRMWARE,
        is_there: || firmware::has_library("libzstd"),
    },
    Package {
        name: "libclang-dev",
        suites: WITH_FIRMWARE,
        is_there: firmware::has_libclang,
    },
];

/// The packages that these suites lack here.
#[must_use]
pub fn missing(suites: &[Suite]) -> Vec<&'static str> {
    let is_wanted = |package: &&Package| package.suites.iter().any(|s| suites.contains(s));
    PACKAGES
        .iter()
        .filter(is_wanted)
        // simavr is built on Linux only.
        .filter(|package| cfg!(target_os = "linux") || package.suites != WITH_FIRMWARE)
        .filter(|package| !(package.is_there)())
        .map(|package| package.name)
        .collect()
}

/// Installs what is missing, where that may be done; else says what to type, and suites that can do without it run all the same.
///
/// # Errors
/// If an installation fails.
pub fn install(missing: &[&str]) -> Result<()> {
    let (Some(mut update), Some(mut install)) = (apt_get(), apt_get()) else {
        eprintln!("missing: {}; {}", missing.join(", "), by_hand(missing));
        return Ok(());
    };
    tools::run(update.args(["update", "-qq"]))?;
    tools::run(
        install
            .args(["install", "-y", "-qq", "--no-install-recommends"])
            .args(missing),
    )
}

fn by_hand(missing: &[&str]) -> String {
    let browser = match missing.contains(&"chromium") {
        true => "; or, for the page's tests, `npx --prefix tests/page playwright install chromium`",
        false => "",
    };
    match cfg!(target_os = "macos") {
        true => format!("type `brew install --cask chromium chromedriver`{browser}"),
        false => format!(
            "on Debian or Ubuntu type `sudo apt-get install {}`{browser}",
            missing.join(" ")
        ),
    }
}

/// `apt-get`, with the right to install, where this is Debian or Ubuntu and there is one.
fn apt_get() -> Option<Command> {
    let program =
        tools::in_path("apt-get").filter(|_| Path::new("/etc/debian_version").exists())?;
    let mut command = if is_root() {
        Command::new(program)
    } else if tools::is_ci() && may_sudo() {
        let mut sudo = Command::new("sudo");
        sudo.args(["-n", "DEBIAN_FRONTEND=noninteractive"]);
        sudo.arg(program);
        sudo
    } else {
        return None;
    };
    command
        .env("DEBIAN_FRONTEND", "noninteractive")
        .stdin(Stdio::null());
    Some(command)
}

fn is_root() -> bool {
    let output = Command::new("id").arg("-u").output();
    output.is_ok_and(|output| output.stdout.trim_ascii() == b"0")
}

fn may_sudo() -> bool {
    let mut sudo = Command::new("sudo");
    sudo.args(["-n", "true"])
        .stdin(Stdio::null())
        .stderr(Stdio::null());
    sudo.status().is_ok_and(|status| status.success())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn native_tests_need_nothing_more() {
        assert_eq!(missing(&[Suite::Native]), Vec::<&str>::new());
    }

    #[test]
    fn what_is_missing_is_named_with_the_command_to_type() {
        if !cfg!(target_os = "macos") {
            let told = by_hand(&["chromium", "make"]);
            assert!(
                told.contains("sudo apt-get install chromium make"),
                "{told}"
            );
            assert!(told.contains("playwright install chromium"), "{told}");
        }
    }
}

//! What tests need besides Rust and Node: installed if that is permitted, otherwise listed with the
//! command to type.
//!
//! | machine | what happens |
//! |---|---|
//! | Debian or Ubuntu, as root (in CI also by a `sudo` that asks for nothing) | `apt-get` installs what is missing |
//! | any other | a browser that Playwright has installed is used; the rest is listed with its command |

use std::path::Path;
use std::process::{Command, Stdio};

use anyhow::Result;

use crate::suites::Suite;
use crate::{firmware, tools};

const IN_A_BROWSER: &[Suite] = &[Suite::Wasm, Suite::Page];
/// The page is tested with the real firmware, too.
const WITH_FIRMWARE: &[Suite] = &[Suite::Page, Suite::Firmware];

/// A package of Debian: its name, which suites need it, and whether what they need of it is there.
type Package = (&'static str, &'static [Suite], fn() -> bool);

const PACKAGES: [Package; 11] = [
    ("chromium", IN_A_BROWSER, || tools::find_chrome().is_some()),
    ("chromium-driver", &[Suite::Wasm], || {
        tools::find_chromedriver().is_some()
    }),
    // On other systems no browser reads the store that it writes.
    ("libnss3-tools", &[Suite::Page], || {
        !cfg!(target_os = "linux") || tools::is_in_path("certutil")
    }),
    ("gcc-avr", WITH_FIRMWARE, || tools::is_in_path("avr-gcc")),
    ("avr-libc", WITH_FIRMWARE, firmware::has_avr_libc),
    ("make", WITH_FIRMWARE, || tools::is_in_path("make")),
    ("pkg-config", WITH_FIRMWARE, || {
        tools::is_in_path("pkg-config")
    }),
    ("libelf-dev", WITH_FIRMWARE, || {
        firmware::has_library("libelf")
    }),
    ("zlib1g-dev", WITH_FIRMWARE, || {
        firmware::has_library("zlib")
    }),
    ("libzstd-dev", WITH_FIRMWARE, || {
        firmware::has_library("libzstd")
    }),
    ("libclang-dev", WITH_FIRMWARE, firmware::has_libclang),
];

/// The packages that these suites lack on this machine.
#[must_use]
pub fn missing(suites: &[Suite]) -> Vec<&'static str> {
    let all = PACKAGES.iter();
    all.filter(|(_, needed_by, is_there)| {
        // simavr is built on Linux only.
        (cfg!(target_os = "linux") || *needed_by != WITH_FIRMWARE)
            && needed_by.iter().any(|suite| suites.contains(suite))
            && !is_there()
    })
    .map(|(name, ..)| *name)
    .collect()
}

/// Installs what is missing, if that is permitted; otherwise prints what to type, and suites that
/// can do without it still run.
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

/// `apt-get`, with the right to install; none if this is not Debian or Ubuntu, or that right is
/// lacking.
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
            let text = by_hand(&["chromium", "make"]);
            assert!(
                text.contains("sudo apt-get install chromium make"),
                "{text}"
            );
            assert!(text.contains("playwright install chromium"), "{text}");
        }
    }
}

//! The `.deb`: files in their places, and the control information for `dpkg`.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{Context, Result};

use super::{Feature, Target, names};
use crate::tools;

/// Files of the repository that are installed: from, to.
const FILES: [(&str, &str); 5] = [
    ("deploy/bridge.toml", "etc/slamlab"),
    ("deploy/slamlab-bridge.service", "lib/systemd/system"),
    ("deploy/60-slamlab.rules", "lib/udev/rules.d"),
    ("deploy/debian/copyright", "usr/share/doc/slamlab-bridge"),
    ("GUIDE.md", "usr/share/doc/slamlab-bridge"),
];
const SCRIPTS: [&str; 3] = ["postinst", "prerm", "postrm"];

/// Makes the package in `target/package`.
pub(super) fn build(target: Target, features: &[Feature], program: &Path) -> Result<PathBuf> {
    let dpkg = tools::dpkg_deb()?;
    // Additional features are part of its version; packages with and without them can replace each
    // other.
    let version = match features {
        [] => env!("CARGO_PKG_VERSION").to_owned(),
        _ => concat!(env!("CARGO_PKG_VERSION"), "+").to_owned() + &names(features, "."),
    };
    let version = version.as_str();
    let folder = tools::target_dir().join("package");
    let name = format!("slamlab-bridge_{version}_{}", target.architecture());
    let tree = folder.join(&name);
    if tree.exists() {
        fs::remove_dir_all(&tree).with_context(|| format!("cannot empty {}", tree.display()))?;
    }
    put(program, &tree.join("usr/bin/slamlab-bridge"), 0o755)?;
    let bridge = tools::root().join("bridge");
    for (from, to) in FILES {
        let from = bridge.join(from);
        let name = from.file_name().unwrap_or_default();
        put(&from, &tree.join(to).join(name), 0o644)?;
    }
    changelog(&tree.join("usr/share/doc/slamlab-bridge"), version)?;
    let debian = bridge.join("deploy/debian");
    for script in SCRIPTS {
        put(
            &debian.join(script),
            &tree.join("DEBIAN").join(script),
            0o755,
        )?;
    }
    write(&tree.join("DEBIAN/conffiles"), "/etc/slamlab/bridge.toml\n")?;
    let control = fs::read_to_string(debian.join("control"))?
        .replace("@VERSION@", version)
        .replace("@ARCHITECTURE@", target.architecture())
        .replace("@KILOBYTES@", &size(&tree)?.div_ceil(1024).to_string());
    write(&tree.join("DEBIAN/control"), &control)?;
    let package = folder.join(format!("{name}.deb"));
    let mut dpkg = Command::new(dpkg);
    dpkg.args(["--root-owner-group", "-Zxz", "--build"])
        .arg(&tree)
        .arg(&package);
    tools::run(dpkg.stdout(Stdio::null()))?;
    fs::remove_dir_all(&tree)?;
    Ok(package)
}

/// Unpacks a package.
pub(super) fn unpack(package: &Path, to: &Path) -> Result<()> {
    let mut dpkg = Command::new(tools::dpkg_deb()?);
    tools::run(dpkg.arg("-x").arg(package).arg(to))
}

fn put(from: &Path, to: &Path, mode: u32) -> Result<()> {
    make_place(to)?;
    fs::copy(from, to).with_context(|| format!("cannot copy {}", from.display()))?;
    fs::set_permissions(to, fs::Permissions::from_mode(mode))?;
    Ok(())
}

fn write(to: &Path, text: &str) -> Result<()> {
    make_place(to)?;
    fs::write(to, text).with_context(|| format!("cannot write {}", to.display()))
}

/// Makes folders that everybody can read, whatever the umask of the person who packs.
fn make_place(file: &Path) -> Result<()> {
    let Some(folder) = file.parent() else {
        return Ok(());
    };
    fs::create_dir_all(folder)?;
    let package = tools::target_dir().join("package");
    for folder in folder.ancestors().take_while(|folder| *folder != package) {
        fs::set_permissions(folder, fs::Permissions::from_mode(0o755))?;
    }
    Ok(())
}

/// Debian requires one; the changes are listed in the repository.
fn changelog(folder: &Path, version: &str) -> Result<()> {
    let plain = folder.join("changelog");
    let text = format!(
        "slamlab-bridge ({version}) stable; urgency=low\n\n  * See CHANGELOG.md of slamlab.\n\n \
         -- The slamlab developers <slamlab@localhost.localdomain>  Sat, 21 Nov 2026 00:00:00 +0000\n"
    );
    write(&plain, &text)?;
    fs::set_permissions(&plain, fs::Permissions::from_mode(0o644))?;
    let mut gzip = Command::new("gzip");
    tools::run(gzip.args(["-9", "--no-name", "--force"]).arg(&plain))
}

/// Total size of all files, bytes.
fn size(folder: &Path) -> Result<u64> {
    let mut sum = 0;
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        sum += match entry.file_type()?.is_dir() {
            true => size(&entry.path())?,
            false => entry.metadata()?.len(),
        };
    }
    Ok(sum)
}

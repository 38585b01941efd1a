//! Runs the program of a package as a person would first meet it: does it serve its page, does the
//! doctor answer, and does it map, with how much memory?

use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail, ensure};

use super::{Target, deb};
use crate::tools;

/// An emulated processor on a loaded machine may be slow.
const PATIENCE: Duration = Duration::from_secs(120);
/// Time of mapping before its memory is measured.
const MAPPING: Duration = Duration::from_secs(20);

/// Unpacks the package and runs its program; reported as skipped if the other processor cannot be
/// emulated.
pub(super) fn test(target: Target, package: &Path) -> Result<()> {
    let emulator = format!("qemu-{}-static", target.processor());
    let emulator = match (target.is_this_machine(), tools::in_path(&emulator)) {
        (true, _) => None,
        (false, Some(found)) => Some(found),
        (false, None) => return super::skip(&emulator, "qemu-user-static"),
    };
    let folder = tools::target_dir().join("package/smoke");
    if folder.exists() {
        fs::remove_dir_all(&folder)?;
    }
    deb::unpack(package, &folder)?;
    let installed = Installed { folder, emulator };
    installed.settings_are_read()?;
    installed.doctor_names_a_port_that_is_not_there()?;
    installed.page_is_served()?;
    installed.robot_is_mapped()?;
    fs::remove_dir_all(&installed.folder)?;
    Ok(())
}

struct Installed {
    folder: PathBuf,
    emulator: Option<PathBuf>,
}

impl Installed {
    fn program(&self) -> Command {
        let program = self.folder.join("usr/bin/slamlab-bridge");
        let mut command = match &self.emulator {
            Some(emulator) => {
                let mut command = Command::new(emulator);
                command.arg(program);
                command
            }
            None => Command::new(program),
        };
        // Away from the repository, whose www/dist it must not serve.
        command.current_dir(&self.folder).stdin(Stdio::null());
        command
    }

    /// A bridge with a simulated robot, and its address.
    fn serving(&self, more: &str) -> Result<(Running, String)> {
        let words = format!("serve --port 0 --source sim:arena,lidar --token-file token {more}");
        let mut command = self.program();
        command
            .args(words.split_whitespace())
            .stdout(Stdio::piped());
        let mut bridge = Running(command.spawn().context("the program does not start")?);
        let address = bridge.address()?;
        Ok((bridge, address))
    }

    /// Whether it succeeds, and what it prints.
    fn said(&self, words: &[&str]) -> Result<(bool, String)> {
        let output = self.program().args(words).output()?;
        let all = [output.stdout, output.stderr].concat();
        Ok((
            output.status.success(),
            String::from_utf8_lossy(&all).into_owned(),
        ))
    }

    fn settings_are_read(&self) -> Result<()> {
        let (succeeds, text) = self.said(&["config", "--config", "etc/slamlab/bridge.toml"])?;
        let is_read = succeeds && text.contains("listen = \"0.0.0.0:8080\"");
        ensure!(is_read, "config says {text}");
        eprintln!("  config reads the installed settings");
        Ok(())
    }

    fn doctor_names_a_port_that_is_not_there(&self) -> Result<()> {
        const PROBLEM: &str = "PROBLEM /dev/slamlab-none is not there: plug the device in";
        let (succeeds, text) = self.said(&["doctor", "/dev/slamlab-none"])?;
        ensure!(!succeeds && text.contains(PROBLEM), "doctor says {text}");
        eprintln!("  doctor names a port that is not there");
        Ok(())
    }

    fn page_is_served(&self) -> Result<()> {
        let (bridge, address) = self.serving("")?;
        let dist = tools::root().join("www/dist");
        for (path, file, kind) in [
            ("", "index.html", "text/html"),
            (
                "slamlab_web_bg.wasm",
                "slamlab_web_bg.wasm",
                "application/wasm",
            ),
            (
                "slamlab_web_rest.wasm",
                "slamlab_web_rest.wasm",
                "application/wasm",
            ),
            ("worker.js", "worker.js", "text/javascript"),
            ("local_bridge.js", "local_bridge.js", "text/javascript"),
        ] {
            let (head, body) = get(&address, &format!("/{path}"))?;
            for part in [
                "http/1.1 200",
                &format!("content-type: {kind}"),
                "content-security-policy: default-src 'none'",
            ] {
                ensure!(head.contains(part), "{file}: expected {part} in {head}");
            }
            let is_same = body == fs::read(dist.join(file))?;
            ensure!(is_same, "/{path} is not the page's {file}");
        }
        let (_, about) = get(&address, "/bridge.json")?;
        let about = String::from_utf8_lossy(&about);
        ensure!(
            about.contains("sim:arena,lidar"),
            "bridge.json says {about}"
        );
        eprintln!(
            "  the page inside the program is served at http://{address}/, with a simulated robot behind it"
        );
        bridge.stop()
    }

    /// A standing robot sees the room around it. Under an emulator the memory includes the
    /// emulator's.
    fn robot_is_mapped(&self) -> Result<()> {
        let (bridge, address) = self.serving("--map house.slamlab")?;
        let begun = Instant::now();
        let image = loop {
            let (head, body) = get(&address, "/map.pgm")?;
            if head.contains("http/1.1 200") {
                break body;
            }
            ensure!(begun.elapsed() < PATIENCE, "nothing is mapped: {head}");
            thread::sleep(Duration::from_millis(100));
        };
        let seconds = begun.elapsed().as_secs_f64();
        thread::sleep(MAPPING);
        let memory = most_memory(bridge.0.id())?;
        bridge.stop()?;
        ensure!(image.starts_with(b"P5"), "/map.pgm is no image");
        let kept = fs::metadata(self.folder.join("house.slamlab"));
        let kept = kept.context("the map is not kept")?.len();
        ensure!(kept > 0, "the map that is kept is empty");
        eprintln!(
            "  it maps: the first map after {seconds:.1} s, kept at the end in {kept} bytes; {memory} kB of memory at most"
        );
        Ok(())
    }
}

/// Peak memory of a process, kB.
///
/// Source: proc_pid_status(5), `VmHWM`.
fn most_memory(id: u32) -> Result<u64> {
    let status = fs::read_to_string(format!("/proc/{id}/status"))?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let number = line.and_then(|rest| rest.split_whitespace().next());
    let number = number.context("the system does not tell what memory a process has")?;
    Ok(number.parse()?)
}

/// The program; it is ended when this is dropped.
struct Running(Child);

impl Running {
    fn address(&mut self) -> Result<String> {
        let out = self.0.stdout.take().context("no output")?;
        let mut line = String::new();
        BufReader::new(out).read_line(&mut line)?;
        let address = line
            .split("http://")
            .nth(1)
            .and_then(|rest| rest.split('/').next());
        address
            .map(str::to_owned)
            .with_context(|| format!("it does not say where it is, but `{line}`"))
    }

    fn stop(mut self) -> Result<()> {
        let id = self.0.id().to_string();
        tools::run(Command::new("kill").args(["-TERM", &id]))?;
        let status = self.0.wait()?;
        if !status.success() {
            bail!("it ended with {status} at SIGTERM");
        }
        Ok(())
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        // A program that has already ended cannot be killed.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Head (in small letters) and body of a response.
fn get(address: &str, path: &str) -> Result<(String, Vec<u8>)> {
    let mut stream = TcpStream::connect(address)?;
    stream.set_read_timeout(Some(PATIENCE))?;
    write!(
        stream,
        "GET {path} HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\n\r\n"
    )?;
    let mut bytes = vec![];
    stream.read_to_end(&mut bytes)?;
    let end = bytes.windows(4).position(|four| four == b"\r\n\r\n");
    let end = end.with_context(|| format!("{path}: no answer"))?;
    let body = bytes.split_off(end + 4);
    Ok((String::from_utf8_lossy(&bytes).to_lowercase(), body))
}

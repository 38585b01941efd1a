//! A bridge in a separate process, and what can be done to it from outside.

use std::net::SocketAddr;
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};
use std::process::Stdio;

use tokio::io::{AsyncBufReadExt, BufReader};
use tokio::process::{Child, Command};

use crate::torn::{self, Torn};

pub(crate) struct BridgeProcess {
    child: Child,
    pub(crate) address: SocketAddr,
    pub(crate) recording: PathBuf,
    /// File with the seconds by which its clock is off.
    step: PathBuf,
}

impl BridgeProcess {
    /// Starts it; token and clock offset are in `folder`. Writes beyond a limit fail, as on a full
    /// disk, without ending it. If there is a bucket, it records into `recordings` in `folder`
    /// instead of to `recording`, and stores from there also what others finished.
    pub(crate) async fn start(
        program: &str,
        source: &str,
        folder: &Path,
        recording: PathBuf,
        torn: Option<&Torn>,
    ) -> Self {
        let stored = torn.map(|torn| {
            let into = folder.join("recordings");
            std::fs::create_dir_all(&into).unwrap();
            (torn.settings(folder), torn::pieces(&into), into)
        });
        let step = folder.join("step");
        std::fs::write(&step, 0_i64.to_le_bytes()).unwrap();
        let mut command = Command::new("sh");
        command
            .args(["-c", "trap '' XFSZ; exec \"$@\"", "sh", program])
            .args(["serve", "--port", "0", "--page"])
            .arg(concat!(env!("CARGO_MANIFEST_DIR"), "/../bridge/tests/page"))
            .args(["--source", source, "--token-file"])
            .arg(folder.join("token"))
            .arg("--record")
            .arg(stored.as_ref().map_or(&recording, |(.., into)| into))
            .env("LD_PRELOAD", clock_step(folder).await)
            .env("SLAMLAB_CLOCK_STEP", &step)
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .kill_on_drop(true);
        if let Some((settings, ..)) = &stored {
            command.arg("--config").arg(settings);
        }
        let mut child = command.spawn().unwrap();
        let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
        let address = loop {
            let line = lines.next_line().await.unwrap();
            let line = line.expect("it tells its address");
            let rest = line.split_once("http://").map(|(_, rest)| rest);
            let address = rest.and_then(|rest| rest.split(['/', '#', ' ']).next()?.parse().ok());
            if let Some(address) = address {
                break address;
            }
        };
        tokio::spawn(async move { while let Ok(Some(_)) = lines.next_line().await {} });
        let recording = match stored {
            None => recording,
            // The one that was not there before.
            Some((_, before, into)) => {
                let mut now = torn::pieces(&into).into_iter();
                now.find(|piece| !before.contains(piece)).unwrap()
            }
        };
        Self {
            child,
            address,
            recording,
            step,
        }
    }

    /// SIGKILL.
    pub(crate) async fn kill(mut self) {
        self.child.kill().await.unwrap();
    }

    /// Its files can no longer grow.
    pub(crate) async fn fill_disk(&self) {
        let length = std::fs::metadata(&self.recording).unwrap().len();
        let status = Command::new("prlimit")
            .args(["--pid", &self.pid(), &format!("--fsize={}", length + 1)])
            .status()
            .await;
        assert!(status.unwrap().success());
    }

    /// Its clock jumps.
    pub(crate) fn step_clock(&self, seconds: i64) {
        let file = std::fs::File::options().write(true).open(&self.step);
        file.unwrap()
            .write_all_at(&seconds.to_le_bytes(), 0)
            .unwrap();
    }

    /// Its private memory, kB, without what it shares with files.
    pub(crate) fn anonymous_kb(&self) -> f64 {
        let status = std::fs::read_to_string(format!("/proc/{}/status", self.pid())).unwrap();
        let line = status
            .lines()
            .find_map(|line| line.strip_prefix("RssAnon:"));
        line.and_then(|rest| rest.split_whitespace().next()?.parse().ok())
            .unwrap()
    }

    /// Processor time that it has used so far, s; Linux counts in hundredths.
    pub(crate) fn processor_seconds(&self) -> f64 {
        let stat = std::fs::read_to_string(format!("/proc/{}/stat", self.pid())).unwrap();
        // After the name, which may hold anything, follow state and numbers; user and system time
        // are fields 14 and 15 (proc(5)).
        let fields = stat.rsplit_once(')').unwrap().1.split_whitespace();
        let ticks = fields
            .skip(11)
            .take(2)
            .map(|field| field.parse::<f64>().unwrap());
        ticks.sum::<f64>() / 100.0
    }

    fn pid(&self) -> String {
        self.child.id().expect("it runs").to_string()
    }
}

/// The library that shifts a program's clock, compiled once for each folder.
async fn clock_step(folder: &Path) -> PathBuf {
    let library = folder.join("clock_step.so");
    if !library.exists() {
        let status = Command::new("cc")
            .args(["-shared", "-fPIC", "-O1", "-o"])
            .arg(&library)
            .arg(concat!(
                env!("CARGO_MANIFEST_DIR"),
                "/examples/bridge_report/clock_step.c"
            ))
            .status()
            .await;
        assert!(status.unwrap().success(), "cc does not compile the library");
    }
    library
}

//! Programs that print `there` once they serve, and ports for them.

use std::ffi::OsStr;
use std::process::Stdio;
use std::time::Duration;

use tokio::io::{AsyncBufReadExt, BufReader};
use tokio::process::{Child, Command};
use tokio::time::timeout;

/// A timeout: whatever is awaited comes sooner or never.
pub(crate) const NEVER: Duration = Duration::from_secs(30);

/// A program, once it has said that it is there; it is ended when this is dropped.
pub(crate) async fn start(program: impl AsRef<OsStr>, words: &[impl AsRef<OsStr>]) -> Child {
    let mut child = Command::new(program)
        .args(words)
        .stdout(Stdio::piped())
        .stderr(Stdio::inherit())
        .kill_on_drop(true)
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
    let line = timeout(NEVER, lines.next_line()).await;
    assert_eq!(line.unwrap().unwrap().as_deref(), Some("there"));
    child
}

/// A port of this machine that was free a moment ago.
pub(crate) fn free_port() -> u16 {
    let listener = std::net::TcpListener::bind(("127.0.0.1", 0)).unwrap();
    listener.local_addr().unwrap().port()
}

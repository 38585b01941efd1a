//! The program itself: it says where it is, stops when asked, and fails with a sentence.
#![allow(missing_docs)] // a test binary has no public interface
#![allow(clippy::unwrap_used)] // helpers of tests, which clippy does not count as tests

use std::fs;
use std::io::{BufRead, BufReader};
use std::net::TcpListener;
use std::process::{Child, Command, Output, Stdio};

use tempfile::TempDir;

fn bridge(arguments: &[&str], page: &TempDir) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_slamlab-bridge"));
    command.args(arguments).arg("--page").arg(page.path());
    command
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    command.env("RUST_BACKTRACE", "1");
    command
}

fn page() -> TempDir {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("index.html"), "<title>slamlab</title>").unwrap();
    folder
}

fn fails(mut command: Command) -> String {
    let Output {
        status,
        stderr,
        stdout,
    } = command.output().unwrap();
    assert!(!status.success());
    assert!(stdout.is_empty(), "it must not claim to serve");
    let error = String::from_utf8(stderr).unwrap();
    assert_eq!(
        error.lines().count(),
        1,
        "one sentence, no backtrace: {error}"
    );
    error
}

#[test]
fn a_port_in_use_ends_it_with_a_sentence() {
    let taken = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = taken.local_addr().unwrap().port().to_string();
    let error = fails(bridge(&["--port", &port], &page()));
    assert!(
        error.contains(&format!("port {port} is already in use")),
        "{error}"
    );
}

#[test]
fn a_folder_without_a_page_ends_it_with_a_sentence() {
    let error = fails(bridge(&["--port", "0"], &TempDir::new().unwrap()));
    assert!(error.contains("index.html is missing"), "{error}");
}

#[cfg(unix)]
#[test]
fn it_prints_its_address_and_ends_well_when_terminated() {
    let page = page();
    let mut child = bridge(&["--port", "0"], &page).spawn().unwrap();
    let line = first_line(&mut child);
    let address = line
        .split("http://")
        .nth(1)
        .and_then(|rest| rest.split('/').next());
    let answers = address.is_some_and(|address| std::net::TcpStream::connect(address).is_ok());
    let id = child.id().to_string();
    assert!(
        Command::new("kill")
            .args(["-TERM", &id])
            .status()
            .unwrap()
            .success()
    );
    let status = child.wait().unwrap();
    assert!(answers, "{line}");
    assert!(status.success(), "{status}");
}

#[cfg(unix)]
fn first_line(child: &mut Child) -> String {
    let mut line = String::new();
    BufReader::new(child.stdout.as_mut().unwrap())
        .read_line(&mut line)
        .unwrap();
    line
}

//! The program itself: it prints its address, stops when asked, and fails with a sentence.
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
    terminate(&child);
    let status = child.wait().unwrap();
    assert!(answers, "{line}");
    assert!(status.success(), "{status}");
}

#[cfg(unix)]
/// As systemd does, or Ctrl+C on a container.
fn terminate(child: &Child) {
    let mut kill = Command::new("kill");
    let status = kill.args(["-TERM", &child.id().to_string()]).status();
    assert!(status.unwrap().success());
}

#[cfg(unix)]
fn first_line(child: &mut Child) -> String {
    let mut line = String::new();
    BufReader::new(child.stdout.as_mut().unwrap())
        .read_line(&mut line)
        .unwrap();
    line
}

#[cfg(not(has_page))]
#[test]
fn a_program_without_the_page_says_so_and_how_to_get_one() {
    let folder = TempDir::new().unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_slamlab-bridge"));
    command.args(["--port", "0"]).current_dir(folder.path());
    let error = fails(command);
    for words in [
        "there is no page in www/dist",
        "cargo xtask build",
        "cargo xtask package",
    ] {
        assert!(error.contains(words), "{error}");
    }
}

#[test]
fn config_prints_the_file_with_the_flags_above_it() {
    let folder = TempDir::new().unwrap();
    let file = folder.path().join("bridge.toml");
    fs::write(
        &file,
        "listen = \"0.0.0.0:81\"\nprivate = true\n[[source]]\nname = \"ld06:/dev/x\"\nmount = { x = 0.5 }\n",
    )
    .unwrap();
    let config = |flags: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_slamlab-bridge"));
        command
            .args(["config", "--config"])
            .arg(&file)
            .args(flags)
            .output()
            .unwrap()
    };
    let text = |output: Output| String::from_utf8(output.stdout).unwrap();
    let plain = text(config(&[]));
    for line in [
        "listen = \"0.0.0.0:81\"",
        "private = true",
        "mdns = true",
        "name = \"ld06:/dev/x\"",
        "x = 0.5",
    ] {
        assert!(plain.contains(line), "{line} is not in {plain}");
    }
    let flags = ["--port", "82", "--private=false", "--source", "sim:arena"];
    let above = text(config(&flags));
    for line in [
        "listen = \"0.0.0.0:82\"",
        "private = false",
        "name = \"sim:arena\"",
    ] {
        assert!(above.contains(line), "{line} is not in {above}");
    }
    assert!(!above.contains("ld06"), "{above}");
    fs::write(&file, "open = true\nlisten-on = 3\n").unwrap();
    let output = config(&[]);
    let error = String::from_utf8(output.stderr).unwrap();
    assert!(
        !output.status.success()
            && error.contains("line 2")
            && error.contains("unknown field `listen-on`"),
        "{error}"
    );
}

/// What a program reports to systemd.
#[cfg(target_os = "linux")]
struct Told {
    folder: TempDir,
    socket: std::os::unix::net::UnixDatagram,
}

#[cfg(target_os = "linux")]
impl Told {
    fn new() -> Self {
        let folder = TempDir::new().unwrap();
        let socket = std::os::unix::net::UnixDatagram::bind(folder.path().join("notify")).unwrap();
        socket
            .set_read_timeout(Some(std::time::Duration::from_secs(60)))
            .unwrap();
        Self { folder, socket }
    }

    fn by(&self, command: &mut Command) -> Child {
        let path = self.folder.path().join("notify");
        command.env("NOTIFY_SOCKET", path).spawn().unwrap()
    }

    fn hear(&self, word: &str) {
        let mut bytes = [0; 256];
        loop {
            let count = self.socket.recv(&mut bytes).unwrap();
            if String::from_utf8_lossy(&bytes[..count])
                .lines()
                .any(|line| line == word)
            {
                return;
            }
        }
    }

    /// Expects ready, alive and stopping, in this order.
    fn lives_and_ends(&self, mut child: Child) {
        self.hear("READY=1");
        self.hear("WATCHDOG=1");
        self.hear("WATCHDOG=1");
        terminate(&child);
        self.hear("STOPPING=1");
        assert!(child.wait().unwrap().success());
    }
}

#[cfg(target_os = "linux")]
#[test]
fn systemd_is_told_that_it_serves_lives_and_ends() {
    let (told, page) = (Told::new(), page());
    told.lives_and_ends(told.by(&mut bridge(&["--port", "0"], &page)));
}

/// A bridge that logs a warning at once, because it is open to the network.
#[cfg(target_os = "linux")]
fn talkative(page: &TempDir, token: &TempDir) -> Command {
    let listen = [
        "--listen",
        "0.0.0.0:0",
        "--mdns=false",
        "--source",
        "sim:arena",
    ];
    let mut command = bridge(&listen, page);
    command.arg("--token-file").arg(token.path().join("token"));
    command
}

#[cfg(target_os = "linux")]
#[test]
fn a_log_that_nobody_reads_keeps_the_robot_waiting_for_nothing() {
    use std::io::Write;

    let (told, page, token) = (Told::new(), page(), TempDir::new().unwrap());
    // Fill the pipe: the next write to it blocks for ever.
    let (_reader, mut full) = std::io::pipe().unwrap();
    full.write_all(&[b'.'; 65_536]).unwrap();
    told.lives_and_ends(told.by(talkative(&page, &token).stderr(full)));
}

#[cfg(target_os = "linux")]
#[test]
fn a_log_that_cannot_be_written_ends_nothing() {
    let (told, page, token) = (Told::new(), page(), TempDir::new().unwrap());
    let full = fs::File::options().write(true).open("/dev/full").unwrap();
    told.lives_and_ends(told.by(talkative(&page, &token).stderr(full)));
    let (reader, gone) = std::io::pipe().unwrap();
    drop(reader);
    told.lives_and_ends(told.by(talkative(&page, &token).stderr(gone)));
}

#[cfg(target_os = "linux")]
#[test]
fn an_answer_that_cannot_be_written_is_an_error_and_no_panic() {
    let mut command = Command::new(env!("CARGO_BIN_EXE_slamlab-bridge"));
    let full = fs::File::options().write(true).open("/dev/full").unwrap();
    let output = command.arg("config").stdout(full).output().unwrap();
    let error = String::from_utf8(output.stderr).unwrap();
    assert!(!output.status.success());
    assert!(error.contains("cannot write to stdout"), "{error}");
    let mut command = Command::new(env!("CARGO_BIN_EXE_slamlab-bridge"));
    let (reader, gone) = std::io::pipe().unwrap();
    drop(reader);
    let output = command.arg("config").stdout(gone).output().unwrap();
    assert!(output.status.success(), "its reader wants no more");
    assert!(output.stderr.is_empty());
}

/// Output of `slamlab-bridge token …` with this file of the owner's token.
fn token(arguments: &[&str], folder: &TempDir) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_slamlab-bridge"));
    let file = folder.path().join("token");
    command
        .arg("token")
        .args(arguments)
        .arg("--token-file")
        .arg(file);
    command.output().unwrap()
}

#[test]
fn rights_are_made_listed_and_taken_away_by_commands() {
    let folder = TempDir::new().unwrap();
    let says = |arguments: &[&str]| {
        let output = token(arguments, &folder);
        assert!(output.status.success(), "{output:?}");
        String::from_utf8(output.stdout).unwrap()
    };
    let refused = |arguments: &[&str]| {
        let output = token(arguments, &folder);
        assert!(!output.status.success(), "{output:?}");
        String::from_utf8(output.stderr).unwrap()
    };
    let owner = says(&[]);
    let made = says(&["add", "anna", "--role", "driver", "--qr"]);
    assert!(
        made.contains("anna is a driver") && made.contains('█'),
        "{made}"
    );
    let secret = made
        .split("#token=")
        .nth(1)
        .unwrap()
        .lines()
        .next()
        .unwrap();
    assert_eq!(secret.len(), 64);
    assert!(!owner.contains(secret));
    let list = says(&["list"]);
    assert!(list.contains("anna  driver  made 20"), "{list}");
    let file = folder.path().join("rights.toml");
    let text = fs::read_to_string(&file).unwrap();
    assert!(!text.contains(secret) && !list.contains(secret), "{text}");
    let again = refused(&["add", "anna", "--role", "owner"]);
    assert!(again.contains("of the name anna already"), "{again}");
    let king = refused(&["add", "bert", "--role", "king"]);
    assert!(
        king.contains("expected one of watcher, driver, owner"),
        "{king}"
    );
    let name = refused(&["add", "b t", "--role", "driver"]);
    assert!(name.contains("is no name"), "{name}");
    assert!(says(&["revoke", "anna"]).contains("anna is no driver any more"));
    let gone = refused(&["revoke", "anna"]);
    assert!(gone.contains("there are none"), "{gone}");
    let spoilt = format!("{text}role = 3\n");
    fs::write(&file, &spoilt).unwrap();
    for arguments in [
        &["list"][..],
        &["add", "c", "--role", "driver"],
        &["revoke", "anna"],
    ] {
        let error = refused(arguments);
        assert!(
            error.contains("rights.toml") && error.contains("line"),
            "{error}"
        );
    }
    assert_eq!(fs::read_to_string(&file).unwrap(), spoilt);
}

#[test]
fn a_bridge_does_not_begin_with_rights_that_it_cannot_read() {
    let folder = TempDir::new().unwrap();
    token(&["add", "anna", "--role", "driver"], &folder);
    let file = folder.path().join("rights.toml");
    let text = fs::read_to_string(&file).unwrap();
    fs::write(&file, text.replace("driver", "king")).unwrap();
    let path = folder.path().join("token");
    let arguments = [
        "--port",
        "0",
        "--source",
        "sim:arena",
        "--token-file",
        path.to_str().unwrap(),
    ];
    let error = fails(bridge(&arguments, &page()));
    assert!(
        error.contains("rights.toml") && error.contains("king"),
        "{error}"
    );
}

/// A bridge with a robot whose token is in the folder.
fn robot(folder: &TempDir, page: &TempDir, more: &[&str]) -> Command {
    let token = folder.path().join("token").display().to_string();
    let serve = ["--port", "0", "--token-file", &token];
    let source = ["--source", "sim:arena,lidar"];
    bridge(&[&serve[..], &source[..], more].concat(), page)
}

#[test]
fn a_start_that_is_refused_leaves_no_recording_and_no_audit() {
    let folder = TempDir::new().unwrap();
    let at = |name: &str| folder.path().join(name).display().to_string();
    let (file, audit) = (at("x.mcap"), at("audit"));
    let given = ["--record", &file, "--audit", &audit];
    let home = ["--map", "--on-link-loss", "home", "--failsafe-right", "ann"];
    let error = fails(robot(&folder, &page(), &[&given[..], &home[..]].concat()));
    assert!(error.contains("failsafe right ann"), "{error}");
    let made: Vec<_> = fs::read_dir(folder.path()).unwrap().collect();
    assert_eq!(made.len(), 1, "the token alone: {made:?}");
}

#[test]
fn two_robots_are_not_mixed() {
    let folder = TempDir::new().unwrap();
    let error = fails(robot(&folder, &page(), &["--source", "sim:office,lidar"]));
    assert!(
        error.contains("sim:arena,lidar and sim:office,lidar are two robots"),
        "{error}"
    );
}

#[cfg(unix)]
#[test]
fn a_folder_of_recordings_is_taken_by_one_bridge_at_a_time() {
    let folder = TempDir::new().unwrap();
    let at = |name: &str| format!("{}/", folder.path().join(name).display());
    let (drives, audit) = (at("drives"), at("audit"));
    let page = page();
    let recording = || robot(&folder, &page, &["--record", &drives]);
    let mut first = recording().spawn().unwrap();
    first_line(&mut first);
    let and_audit = ["--record", &drives, "--audit", &audit];
    let error = fails(robot(&folder, &page, &and_audit));
    terminate(&first);
    let ended = first.wait().unwrap().success();
    let expected = format!("folder {drives}: another bridge writes there");
    assert!(error.contains(&expected), "{error}");
    assert!(ended);
    let files = |folder: &str, ending: &str| {
        let all = fs::read_dir(folder).unwrap();
        all.filter(|entry| {
            let name = entry.as_ref().unwrap().file_name();
            name.to_str().unwrap().ends_with(ending)
        })
        .count()
    };
    assert_eq!(files(&drives, ".mcap"), 1);
    assert_eq!(files(&audit, ".jsonl"), 0, "nothing was begun");
    let mut again = recording().spawn().unwrap();
    first_line(&mut again);
    terminate(&again);
    assert!(again.wait().unwrap().success());
    assert_eq!(files(&drives, ".mcap"), 2);
}

#[cfg(unix)]
#[test]
fn recording_is_said_once_it_is_so() {
    let folder = TempDir::new().unwrap();
    let file = folder.path().join("a.mcap");
    fs::write(&file, "precious").unwrap();
    let record = || {
        let mut command = Command::new(env!("CARGO_BIN_EXE_slamlab-bridge"));
        command.args(["record", "--source", "sim:arena,lidar"]);
        command
            .arg(&file)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        command
    };
    let error = fails(record());
    assert!(error.contains("is already there"), "{error}");
    fs::remove_file(&file).unwrap();
    let mut recording = record().spawn().unwrap();
    let line = first_line(&mut recording);
    terminate(&recording);
    assert!(line.starts_with("recording to "), "{line}");
    assert!(recording.wait().unwrap().success() && file.exists());
}

#[cfg(unix)]
#[test]
fn a_map_is_kept_by_one_bridge_at_a_time() {
    let folder = TempDir::new().unwrap();
    let file = folder.path().join("a.slamlab").display().to_string();
    let page = page();
    let with_map = || robot(&folder, &page, &["--map", &file]);
    let mut first = with_map().spawn().unwrap();
    first_line(&mut first);
    let error = fails(with_map());
    terminate(&first);
    let ended = first.wait().unwrap().success();
    assert!(
        error.contains("another bridge keeps its map there"),
        "{error}"
    );
    assert!(ended);
    let mut again = with_map().spawn().unwrap();
    let line = first_line(&mut again);
    terminate(&again);
    again.wait().unwrap();
    assert!(line.contains("http://"), "it is free again: {line}");
}

#[cfg(unix)]
#[test]
fn a_port_that_is_not_there_is_logged_once() {
    let (folder, page) = (TempDir::new().unwrap(), page());
    let token = folder.path().join("token").display().to_string();
    let mut command = bridge(&["--port", "0", "--token-file", &token], &page);
    command.args(["--source", "rp6:/dev/nowhere"]);
    let mut child = command.spawn().unwrap();
    let line = BufReader::new(child.stderr.as_mut().unwrap())
        .lines()
        .map_while(Result::ok)
        .find(|line| line.contains("/dev/nowhere"));
    std::thread::sleep(std::time::Duration::from_secs(3));
    terminate(&child);
    let Output { stderr, .. } = child.wait_with_output().unwrap();
    let rest = String::from_utf8(stderr).unwrap();
    let line = line.unwrap();
    assert!(line.contains("WARN"), "no colours in a file: {line:?}");
    assert!(!rest.contains("/dev/nowhere"), "once: {rest}");
}

#[test]
fn config_refuses_what_serve_would_and_says_where_it_stands() {
    let folder = TempDir::new().unwrap();
    let file = folder.path().join("bridge.toml");
    for (text, place, words) in [
        ("record-piece-mib = 0", ", line 1", "record-piece-mib is 0"),
        (
            "open = false\nrecord-budget-mib = 9000",
            ", line 2",
            "record-budget-mib does nothing",
        ),
        (
            "open = false\n[map]\nfile = \"\"",
            ", line 3",
            "map file is empty",
        ),
        (
            "record = \"/x/\"\n[storage]\nurl = \"\"",
            ", line 3",
            "storage url \"\": it is empty",
        ),
        (
            "record = \"/x/\"\n[storage]\nurl = \"s3://me:hidden@drives/robot\"",
            ", line 3",
            "storage url holds a user or a password",
        ),
        #[cfg(feature = "storage")]
        (
            "record = \"/x/\"\n[storage]\nurl = \"file:///x\"",
            ", line 3",
            "recordings are made in /x/",
        ),
        #[cfg(feature = "storage")]
        (
            "record = \"/x/\"\n[storage]\nurl = \"s3://a\"\n[storage.options]\naws_endpoint = \"nonsense\"",
            ", line 5",
            "aws_endpoint: \"nonsense\" is no address",
        ),
        ("[map]\nset = { a = 1 }", "", "there is no setting"),
        (
            "[map]\nset = { \"grid.resolution\" = nan }",
            "",
            "Cell size is NaN",
        ),
        (
            "tls-cert = \"/nowhere\"\ntls-key = \"/nowhere\"",
            "",
            "/nowhere",
        ),
        (
            "[[source]]\nname = \"sim:arena\"\nmount = { x = 0.1 }",
            "",
            "mount",
        ),
    ] {
        fs::write(&file, text).unwrap();
        let mut command = Command::new(env!("CARGO_BIN_EXE_slamlab-bridge"));
        command.args(["config", "--config"]).arg(&file);
        let error = fails(command);
        assert!(error.contains(words), "{text}: {error}");
        let place = format!("bridge.toml{place}");
        assert!(place == "bridge.toml" || error.contains(&place), "{error}");
        assert!(!error.contains("hidden"), "{error}");
    }
}

#[test]
fn rights_stand_beside_a_file_that_holds_a_token_or_none_yet() {
    let folder = TempDir::new().unwrap();
    let said = |output: Output| String::from_utf8([output.stdout, output.stderr].concat()).unwrap();
    let none = said(token(&["list"], &folder));
    assert!(none.contains("no owner"), "{none}");
    fs::write(folder.path().join("token"), "root:x:0:0\n").unwrap();
    for arguments in [&["list"][..], &["add", "ann", "--role", "driver"]] {
        let said = said(token(arguments, &folder));
        assert!(said.contains("token"), "{said}");
        assert!(!folder.path().join("rights.toml").exists(), "{said}");
    }
}

//! The bridge over HTTP: files, their types, the headers that confine the page, and what is
//! refused.
#![cfg(not(target_family = "wasm"))] // opens sockets
#![allow(missing_docs)] // a test binary has no public interface
#![allow(clippy::unwrap_used)] // helpers of tests, which clippy does not count as tests

use std::fs;
use std::net::SocketAddr;
use std::path::PathBuf;

use slamlab_bridge::{Config, Page};
use tempfile::TempDir;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::sync::oneshot;

/// A bridge on a free port with a small page; it stops when this is dropped.
struct Bridge {
    address: SocketAddr,
    folder: TempDir,
    _stop: oneshot::Sender<()>,
}

impl Bridge {
    async fn start() -> Self {
        let folder = TempDir::new().unwrap();
        let page = folder.path().join("page");
        fs::create_dir(&page).unwrap();
        for (name, content) in [
            ("page/index.html", "<!doctype html><title>slamlab</title>"),
            ("page/main.js", "export {};"),
            ("page/main-Q3KX7ABC.js", "export {};"),
            ("page/style.css", "p {}"),
            ("page/icon.svg", "<svg/>"),
            ("page/world.json", "{}"),
            ("page/a.wasm", "\0asm"),
            ("page/a.wasm.br", "packed"),
            ("page/a.wasm.gz", "zipped"),
            ("secret.txt", "outside the page"),
        ] {
            fs::write(folder.path().join(name), content).unwrap();
        }
        let listener = slamlab_bridge::bind(([127, 0, 0, 1], 0).into())
            .await
            .unwrap();
        let address = listener.local_addr().unwrap();
        let (stop, stopped) = oneshot::channel::<()>();
        tokio::spawn(slamlab_bridge::run(listener, of_page(page), async {
            let _ = stopped.await;
        }));
        Self {
            address,
            folder,
            _stop: stop,
        }
    }

    /// Sends `request` unchanged, with a Host header and a closing one added, and reads the whole
    /// answer.
    async fn ask(&self, request: &str) -> Answer {
        self.raw(&format!(
            "{request}\r\nHost: {}\r\nConnection: close\r\n\r\n",
            self.address
        ))
        .await
    }

    async fn raw(&self, request: &str) -> Answer {
        let mut stream = TcpStream::connect(self.address).await.unwrap();
        stream.write_all(request.as_bytes()).await.unwrap();
        let mut bytes = Vec::new();
        stream.read_to_end(&mut bytes).await.unwrap();
        let text = String::from_utf8_lossy(&bytes).into_owned();
        let (head, body) = text.split_once("\r\n\r\n").unwrap_or((&text, ""));
        Answer {
            status: head
                .split(' ')
                .nth(1)
                .and_then(|code| code.parse().ok())
                .unwrap_or(0),
            head: head.to_ascii_lowercase(),
            body: body.to_owned(),
        }
    }
}

struct Answer {
    status: u16,
    head: String,
    body: String,
}

impl Answer {
    fn header(&self, name: &str) -> &str {
        let lines = self.head.lines().filter_map(|line| line.split_once(": "));
        lines
            .filter(|(found, _)| *found == name)
            .map(|(_, value)| value)
            .next()
            .unwrap_or("")
    }
}

/// Serves the page in this folder, without a robot.
fn of_page(folder: PathBuf) -> Config {
    Config {
        page: Some(Page::Folder(folder)),
        ..Config::default()
    }
}

#[tokio::test]
async fn each_kind_of_file_has_its_type() {
    let bridge = Bridge::start().await;
    for (path, kind) in [
        ("/", "text/html"),
        ("/index.html", "text/html"),
        ("/main.js", "text/javascript"),
        ("/style.css", "text/css"),
        ("/icon.svg", "image/svg+xml"),
        ("/world.json", "application/json"),
        ("/a.wasm", "application/wasm"),
    ] {
        let answer = bridge.ask(&format!("GET {path} HTTP/1.1")).await;
        assert_eq!(answer.status, 200, "{path}");
        assert!(
            answer.header("content-type").starts_with(kind),
            "{path}: {}",
            answer.head
        );
    }
}

#[tokio::test]
async fn every_answer_fences_the_page_in() {
    let bridge = Bridge::start().await;
    for path in ["/", "/main.js", "/missing", "/a.wasm"] {
        let answer = bridge.ask(&format!("GET {path} HTTP/1.1")).await;
        let policy = answer.header("content-security-policy");
        assert!(
            policy.starts_with("default-src 'none'"),
            "{path}: {}",
            answer.head
        );
        assert!(
            !policy.contains("unsafe-inline") && !policy.contains("'unsafe-eval'"),
            "{policy}"
        );
        for (name, value) in [
            ("x-content-type-options", "nosniff"),
            ("referrer-policy", "no-referrer"),
            ("cross-origin-opener-policy", "same-origin"),
            ("cross-origin-embedder-policy", "require-corp"),
            ("cross-origin-resource-policy", "same-origin"),
        ] {
            assert_eq!(answer.header(name), value, "{path}: {name}");
        }
        assert!(
            answer.header("permissions-policy").contains("camera=()"),
            "{path}"
        );
    }
}

#[tokio::test]
async fn compressed_forms_are_sent_to_those_who_take_them() {
    let bridge = Bridge::start().await;
    for (accepted, encoding, body) in [
        ("br, gzip", "br", "packed"),
        ("gzip", "gzip", "zipped"),
        ("identity", "", "\0asm"),
    ] {
        let answer = bridge
            .ask(&format!(
                "GET /a.wasm HTTP/1.1\r\nAccept-Encoding: {accepted}"
            ))
            .await;
        assert_eq!(answer.header("content-encoding"), encoding, "{accepted}");
        assert_eq!(
            answer.header("content-type"),
            "application/wasm",
            "{accepted}"
        );
        assert_eq!(answer.header("vary"), "accept-encoding", "{accepted}");
        assert_eq!(answer.body, body, "{accepted}");
    }
}

#[tokio::test]
async fn an_unchanged_file_costs_no_second_transfer() {
    let bridge = Bridge::start().await;
    let first = bridge.ask("GET /main.js HTTP/1.1").await;
    assert_eq!(first.header("cache-control"), "no-cache");
    let tag = first.header("etag");
    assert!(!tag.is_empty(), "{}", first.head);
    let second = bridge
        .ask(&format!("GET /main.js HTTP/1.1\r\nIf-None-Match: {tag}"))
        .await;
    assert_eq!((second.status, second.body.as_str()), (304, ""));
    let hashed = bridge.ask("GET /main-Q3KX7ABC.js HTTP/1.1").await;
    assert!(hashed.header("cache-control").contains("immutable"));
}

#[tokio::test]
async fn what_is_not_there_is_404_in_words_and_is_not_kept() {
    let bridge = Bridge::start().await;
    let answer = bridge.ask("GET /nothing.js HTTP/1.1").await;
    assert_eq!(answer.status, 404);
    assert_eq!(answer.body, "There is no /nothing.js in this page.\n");
    assert_eq!(answer.header("cache-control"), "no-store");
    assert!(answer.header("content-type").starts_with("text/plain"));
}

#[tokio::test]
async fn nothing_outside_the_page_can_be_reached() {
    let bridge = Bridge::start().await;
    assert!(bridge.folder.path().join("secret.txt").is_file());
    for path in [
        "/../secret.txt",
        "/%2e%2e/secret.txt",
        "/..%2fsecret.txt",
        "/%2e%2e%2fsecret.txt",
        "/a/../../secret.txt",
        "/..\\secret.txt",
        "//etc/passwd",
        "/%00",
        "/main.js%00.txt",
    ] {
        let answer = bridge.ask(&format!("GET {path} HTTP/1.1")).await;
        assert!(
            (400..500).contains(&answer.status),
            "{path}: {}",
            answer.head
        );
        assert!(!answer.body.contains("outside"), "{path}");
    }
}

#[tokio::test]
async fn a_foreign_host_is_refused() {
    let bridge = Bridge::start().await;
    for host in [
        "evil.example.com",
        "localhost.evil.com:8080",
        "127.0.0.1.evil.com",
        "",
    ] {
        let answer = bridge
            .raw(&format!(
                "GET / HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n"
            ))
            .await;
        assert_eq!(answer.status, 421, "{host}: {}", answer.head);
        assert!(!answer.body.contains("<title>"), "{host}");
    }
    for refused in [
        "GET / HTTP/1.1\r\nConnection: close\r\n\r\n",
        "GET http://evil.example.com/ HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n",
        "GET / HTTP/1.1\r\nHost: localhost\r\nHost: evil.example.com\r\nConnection: close\r\n\r\n",
    ] {
        let answer = bridge.raw(refused).await;
        assert!(
            (400..500).contains(&answer.status),
            "{refused}: {}",
            answer.head
        );
    }
    for host in ["localhost:1234", "robot.local", "[::1]:8080", "192.168.0.9"] {
        let answer = bridge
            .raw(&format!(
                "GET / HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n"
            ))
            .await;
        assert_eq!(answer.status, 200, "{host}: {}", answer.head);
    }
}

#[tokio::test]
async fn only_reading_is_allowed() {
    let bridge = Bridge::start().await;
    for method in ["POST", "PUT", "DELETE"] {
        let answer = bridge
            .ask(&format!("{method} / HTTP/1.1\r\nContent-Length: 0"))
            .await;
        assert_eq!(answer.status, 405, "{method}");
    }
    let head = bridge.ask("HEAD /main.js HTTP/1.1").await;
    assert_eq!((head.status, head.body.as_str()), (200, ""));
}

#[tokio::test]
async fn a_port_in_use_is_a_sentence_with_advice() {
    let bridge = Bridge::start().await;
    let error = slamlab_bridge::bind(bridge.address)
        .await
        .unwrap_err()
        .to_string();
    assert!(error.contains(&bridge.address.to_string()), "{error}");
    assert!(
        error.contains("already in use") && error.contains("--port"),
        "{error}"
    );
}

#[tokio::test]
async fn a_folder_without_a_page_is_a_sentence_with_advice() {
    let folder = TempDir::new().unwrap();
    let listener = slamlab_bridge::bind(([127, 0, 0, 1], 0).into())
        .await
        .unwrap();
    let result = slamlab_bridge::run(listener, of_page(folder.path().to_owned()), async {}).await;
    let error = result.unwrap_err().to_string();
    assert!(
        error.contains("index.html is missing") && error.contains("cargo xtask build"),
        "{error}"
    );
}

#[tokio::test]
async fn shutting_down_ends_the_server_even_with_an_idle_connection() {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("index.html"), "").unwrap();
    let listener = slamlab_bridge::bind(([127, 0, 0, 1], 0).into())
        .await
        .unwrap();
    let address = listener.local_addr().unwrap();
    let (stop, stopped) = oneshot::channel::<()>();
    let server = tokio::spawn(slamlab_bridge::run(
        listener,
        of_page(folder.path().to_owned()),
        async {
            let _ = stopped.await;
        },
    ));
    let _idle = TcpStream::connect(address).await.unwrap();
    stop.send(()).unwrap();
    server.await.unwrap().unwrap();
}

//! The bridge over TLS: page, WebSocket, and what is refused.
#![allow(missing_docs)] // a test binary has no public interface
#![allow(clippy::unwrap_used)] // helpers of tests, which clippy does not count as tests

use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;

use futures_util::StreamExt;
use slamlab_bridge::source::sim::SimSource;
use slamlab_bridge::tls::Identity;
use slamlab_bridge::{Config, Limits, Page, run};
use slamlab_core::wire::message::{Format, FromBridge, decode};
use tempfile::TempDir;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::sync::oneshot;
use tokio_rustls::TlsConnector;
use tokio_rustls::client::TlsStream;
use tokio_rustls::rustls::crypto::ring;
use tokio_rustls::rustls::pki_types::pem::PemObject;
use tokio_rustls::rustls::pki_types::{CertificateDer, ServerName};
use tokio_rustls::rustls::{ClientConfig, RootCertStore};
use tokio_tungstenite::tungstenite::client::IntoClientRequest;
use tokio_tungstenite::tungstenite::{self, Message};

/// A timeout long enough for any load of the machine.
const PATIENCE: Duration = Duration::from_secs(60);

struct Bridge {
    address: SocketAddr,
    folder: TempDir,
    _stop: oneshot::Sender<()>,
}

impl Bridge {
    async fn start(limits: Limits) -> Self {
        let folder = TempDir::new().unwrap();
        let page = folder.path().join("page");
        std::fs::create_dir(&page).unwrap();
        std::fs::write(page.join("index.html"), "<title>slamlab</title>").unwrap();
        let config = Config {
            page: Some(Page::Folder(page)),
            sources: vec![Box::new(SimSource::new("arena").unwrap())],
            tls: Some(Identity::load_or_make(folder.path()).unwrap()),
            limits,
            ..Config::default()
        };
        let listener = slamlab_bridge::bind(([127, 0, 0, 1], 0).into())
            .await
            .unwrap();
        let address = listener.local_addr().unwrap();
        let (stop, stopped) = oneshot::channel::<()>();
        tokio::spawn(run(listener, config, async {
            let _ = stopped.await;
        }));
        Self {
            address,
            folder,
            _stop: stop,
        }
    }

    /// A client that trusts this bridge's certificate and no other, and that checks the name in it.
    async fn connect(&self, name: &'static str) -> std::io::Result<TlsStream<TcpStream>> {
        let pem = std::fs::read(self.folder.path().join("tls-ca.pem")).unwrap();
        let mut roots = RootCertStore::empty();
        roots
            .add(CertificateDer::from_pem_slice(&pem).unwrap())
            .unwrap();
        let config = ClientConfig::builder_with_provider(Arc::new(ring::default_provider()))
            .with_safe_default_protocol_versions()
            .unwrap()
            .with_root_certificates(roots)
            .with_no_client_auth();
        let stream = TcpStream::connect(self.address).await?;
        let name = ServerName::try_from(name).unwrap();
        TlsConnector::from(Arc::new(config))
            .connect(name, stream)
            .await
    }

    fn request(&self, path: &str) -> String {
        let port = self.address.port();
        format!("GET {path} HTTP/1.1\r\nHost: localhost:{port}\r\nConnection: close\r\n\r\n")
    }
}

async fn ask(stream: &mut (impl AsyncReadExt + AsyncWriteExt + Unpin), request: &str) -> String {
    stream.write_all(request.as_bytes()).await.unwrap();
    let mut bytes = vec![];
    // The other end may close without TLS's own goodbye.
    let _ = stream.read_to_end(&mut bytes).await;
    String::from_utf8_lossy(&bytes).into_owned()
}

#[tokio::test]
async fn the_page_and_what_is_said_of_the_bridge_come_over_tls() {
    let bridge = Bridge::start(Limits::default()).await;
    for name in ["localhost", "127.0.0.1"] {
        let mut stream = bridge.connect(name).await.unwrap();
        let page = ask(&mut stream, &bridge.request("/")).await;
        assert!(
            page.starts_with("HTTP/1.1 200") && page.contains("<title>slamlab"),
            "{page}"
        );
        assert!(
            page.to_lowercase()
                .contains("content-security-policy: default-src 'none'"),
            "{page}"
        );
    }
    let mut stream = bridge.connect("localhost").await.unwrap();
    let about = ask(&mut stream, &bridge.request("/bridge.json")).await;
    assert!(
        about.contains("\"websocket\":\"/ws\"") && about.contains("sim:arena"),
        "{about}"
    );
    let other = bridge
        .connect("robot.example")
        .await
        .unwrap_err()
        .to_string();
    assert!(
        other.contains("certificate"),
        "the name is not in it: {other}"
    );
}

#[tokio::test]
async fn a_websocket_opens_from_the_page_that_came_over_tls_only() {
    let bridge = Bridge::start(Limits::default()).await;
    let host = format!("localhost:{}", bridge.address.port());
    let open = async |origin: String| {
        let mut request = format!("wss://{host}/ws").into_client_request().unwrap();
        request
            .headers_mut()
            .insert("Origin", origin.parse().unwrap());
        let stream = bridge.connect("localhost").await.unwrap();
        tokio_tungstenite::client_async(request, stream).await
    };
    let (mut socket, _) = open(format!("https://{host}")).await.unwrap();
    let first = tokio::time::timeout(PATIENCE, socket.next())
        .await
        .unwrap()
        .unwrap()
        .unwrap();
    let Message::Binary(bytes) = first else {
        panic!("{first:?}");
    };
    let (_, hello) = decode::<FromBridge>(&bytes, Format::Binary).unwrap();
    assert!(matches!(hello, FromBridge::Hello(_)), "{hello:?}");
    for foreign in [format!("http://{host}"), "https://evil.example".into()] {
        let refused = open(foreign.clone()).await.err();
        assert!(
            matches!(&refused, Some(tungstenite::Error::Http(answer)) if answer.status() == 403),
            "{foreign}: {refused:?}"
        );
    }
}

/// An independent implementation of RFC 5280 checks chain, names, extensions, and that the
/// authority cannot vouch for names outside its limits.
#[test]
fn openssl_takes_the_chain_for_a_server_of_these_names_and_for_nothing_else() {
    use std::process::Command;
    let folder = TempDir::new().unwrap();
    Identity::load_or_make(folder.path()).unwrap();
    let leaf = std::fs::read_to_string(folder.path().join("tls-leaf.toml")).unwrap();
    let leaf: toml::Table = leaf.parse().unwrap();
    let pem = folder.path().join("leaf.pem");
    std::fs::write(&pem, leaf["cert"].as_str().unwrap()).unwrap();
    let ca = folder.path().join("tls-ca.pem");
    let verify = |more: &[&str]| {
        let mut command = Command::new("openssl");
        let command = command.args(["verify", "-x509_strict", "-CAfile"]).arg(&ca);
        command.args(more).arg(&pem).output()
    };
    let output = verify(&["-purpose", "sslserver", "-verify_hostname", "localhost"]);
    let output = output.expect("openssl is installed");
    assert!(output.status.success(), "{output:?}");
    for (more, is_good) in [
        (
            &["-purpose", "sslserver", "-verify_ip", "127.0.0.1"][..],
            true,
        ),
        (
            &["-purpose", "sslserver", "-verify_hostname", "robot.example"],
            false,
        ),
        (&["-purpose", "sslclient"], false),
    ] {
        assert_eq!(verify(more).unwrap().status.success(), is_good, "{more:?}");
    }
    let text = |file: &std::path::Path| {
        let mut command = Command::new("openssl");
        let output = command
            .args(["x509", "-noout", "-text", "-in"])
            .arg(file)
            .output();
        String::from_utf8(output.unwrap().stdout).unwrap()
    };
    let [leaf, ca] = [text(&pem), text(&ca)];
    for part in [
        "TLS Web Server Authentication",
        "Digital Signature",
        "CA:FALSE",
        "DNS:localhost",
    ] {
        assert!(leaf.contains(part), "{part}: {leaf}");
    }
    for part in [
        "CA:TRUE, pathlen:0",
        "Certificate Sign",
        "Name Constraints",
        "DNS:local",
    ] {
        assert!(ca.contains(part), "{part}: {ca}");
    }
}

#[tokio::test]
async fn who_comes_in_the_clear_is_sent_to_the_right_address_and_told_nothing_else() {
    let bridge = Bridge::start(Limits::default()).await;
    let port = bridge.address.port();
    let mut stream = TcpStream::connect(bridge.address).await.unwrap();
    let answer = ask(&mut stream, &bridge.request("/bridge.json?a=1")).await;
    assert!(answer.starts_with("HTTP/1.1 308"), "{answer}");
    let location = format!("location: https://localhost:{port}/bridge.json?a=1\r\n");
    assert!(answer.to_lowercase().contains(&location), "{answer}");
    assert!(!answer.contains("sim:arena"), "{answer}");
    // Except for what a phone needs that does not trust the bridge yet.
    let mut stream = TcpStream::connect(bridge.address).await.unwrap();
    let page = ask(&mut stream, &bridge.request("/trust")).await;
    let fingerprint = Identity::load_or_make(bridge.folder.path()).unwrap();
    assert!(
        page.starts_with("HTTP/1.1 200") && page.contains(fingerprint.fingerprint()),
        "{page}"
    );
    let mut stream = TcpStream::connect(bridge.address).await.unwrap();
    let certificate = ask(&mut stream, &bridge.request("/slamlab-ca.crt")).await;
    assert!(
        certificate.contains("application/x-x509-ca-cert"),
        "{certificate}"
    );
    // Nobody is redirected to a foreign name.
    let mut stream = TcpStream::connect(bridge.address).await.unwrap();
    let request = "GET / HTTP/1.1\r\nHost: rebound.example\r\nConnection: close\r\n\r\n";
    let answer = ask(&mut stream, request).await;
    assert!(answer.starts_with("HTTP/1.1 421"), "{answer}");
}

#[tokio::test]
async fn a_handshake_that_dawdles_is_ended_and_garbage_is_survived() {
    let limits = Limits {
        header: Duration::from_millis(200),
        ..Limits::default()
    };
    let bridge = Bridge::start(limits).await;
    // Nothing at all; half a handshake; an invalid handshake.
    for bytes in [&b""[..], &[22, 3, 1, 2, 0, 1], &[22; 2000]] {
        let mut stream = TcpStream::connect(bridge.address).await.unwrap();
        stream.write_all(bytes).await.unwrap();
        let mut rest = vec![];
        let ended = tokio::time::timeout(PATIENCE, stream.read_to_end(&mut rest)).await;
        assert!(ended.is_ok(), "{} bytes kept it open", bytes.len());
    }
    let bridge = Bridge::start(Limits::default()).await;
    let mut stream = bridge.connect("localhost").await.unwrap();
    assert!(
        ask(&mut stream, &bridge.request("/healthz"))
            .await
            .contains("ok")
    );
}

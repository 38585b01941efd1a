//! The connection to the router: opening a session, and noticing that it is lost.
//!
//! Zenoh's own error says only that it could connect to no endpoint. So a connection of our own is
//! tried first, whose error says why: nobody there, an unknown certificate, or our own refused.

use std::fmt;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use ::zenoh::{Config, Session};
use serde_json::json;
use tokio::io::{AsyncRead, AsyncReadExt};
use tokio::net::TcpStream;
use tokio::time::timeout;
use tokio_rustls::TlsConnector;
use tokio_rustls::rustls::crypto::ring;
use tokio_rustls::rustls::pki_types::pem::PemObject;
use tokio_rustls::rustls::pki_types::{CertificateDer, PrivateKeyDer, ServerName};
use tokio_rustls::rustls::{ClientConfig, RootCertStore};

use super::{Endpoint, ZenohConfig, ZenohError};

/// A router that takes longer counts as not answering.
const LONGEST: Duration = Duration::from_secs(5);
/// Time within which a router refuses a certificate, if it does.
const REFUSAL: Duration = Duration::from_millis(300);
/// Time without a sign of life after which the router considers the bridge gone, ms.
const LEASE_MILLIS: u64 = 2000;
/// The system's send buffer for the link, bytes. It is small because data in it is older than what
/// waits here, and urgent messages cannot overtake it. Linux takes twice as much.
const SEND_BUFFER: u32 = 16 * 1024;
/// Zenoh's buffer for readings, bytes: one batch of this length.
const BATCH: u16 = 8 * 1024;

/// A router, and how to connect to it.
pub(super) struct Router {
    endpoint: Endpoint,
    tls: Option<TlsConnector>,
    config: Config,
}

/// Why there is no session.
#[derive(Debug, thiserror::Error)]
pub(super) enum OpenError {
    #[error("no router answers at {0}: {1}")]
    Absent(Endpoint, String),
    #[error("the router at {0} and this bridge do not trust each other's certificates: {1}")]
    Certificate(Endpoint, String),
    #[error("what answers at {0} is no Zenoh router: {1}")]
    Stranger(Endpoint, String),
}

impl Router {
    /// # Errors    [`ZenohError::File`]: a file does not hold a certificate or key.
    pub(super) fn new(zenoh: &ZenohConfig) -> Result<Self, ZenohError> {
        let endpoint = zenoh.router.clone();
        let tls = zenoh.ca.as_deref().map(|ca| connector(ca, zenoh));
        Ok(Self {
            endpoint,
            tls: tls.transpose()?,
            config: config(zenoh),
        })
    }

    pub(super) fn endpoint(&self) -> &Endpoint {
        &self.endpoint
    }

    /// # Errors    [`OpenError`], with the reason in words.
    pub(super) async fn open(&self) -> Result<Session, OpenError> {
        self.try_out().await?;
        let opening = ::zenoh::open(self.config.clone());
        match timeout(2 * LONGEST, async { opening.await }).await {
            Ok(Ok(session)) => Ok(session),
            Ok(Err(error)) => Err(OpenError::Stranger(
                self.endpoint.clone(),
                error.to_string(),
            )),
            Err(_) => Err(OpenError::Stranger(
                self.endpoint.clone(),
                "it never said hello".to_owned(),
            )),
        }
    }

    async fn try_out(&self) -> Result<(), OpenError> {
        let Endpoint { host, port, .. } = &self.endpoint;
        let absent = |why: String| OpenError::Absent(self.endpoint.clone(), why);
        let late = format!("nothing within {} s", LONGEST.as_secs());
        let connecting = timeout(LONGEST, TcpStream::connect((host.as_str(), *port)));
        let stream = connecting.await.map_err(|_| absent(late.clone()))?;
        let stream = stream.map_err(|error| absent(error.to_string()))?;
        let Some(tls) = &self.tls else {
            return Ok(());
        };
        let refused = |why: String| OpenError::Certificate(self.endpoint.clone(), why);
        let name =
            ServerName::try_from(host.clone()).map_err(|error| refused(error.to_string()))?;
        let shaking = timeout(LONGEST, tls.connect(name, stream)).await;
        let stream = shaking.map_err(|_| absent(late))?;
        let stream = stream.map_err(|error| refused(error.to_string()))?;
        // In TLS 1.3 a client learns only by reading that its own certificate was refused.
        refusal(stream)
            .await
            .map_or(Ok(()), |why| Err(refused(why)))
    }
}

async fn refusal(mut stream: impl AsyncRead + Unpin) -> Option<String> {
    match timeout(REFUSAL, stream.read_u8()).await {
        Ok(Err(error)) => Some(error.to_string()),
        Ok(Ok(_)) | Err(_) => None,
    }
}

/// Shown as a name in logs.
impl fmt::Debug for Router {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Router({})", self.endpoint)
    }
}

/// The addresses of a session's links; none if it has no router.
pub(super) async fn router_of(session: &Session) -> Option<String> {
    let mut routers = session.info().routers_zid().await;
    routers.next().map(|id| id.to_string())
}

fn config(zenoh: &ZenohConfig) -> Config {
    let mut config = Config::default();
    let path = |path: &Path| path.to_string_lossy().into_owned();
    let identity = zenoh.identity.as_ref();
    let values = [
        ("mode", json!("client")),
        ("connect/endpoints", json!([zenoh.router.to_string()])),
        ("connect/timeout_ms", json!(LONGEST.as_millis() as u64)),
        // The caches for late readers need timestamps to tell which message is older.
        ("timestamping/enabled", json!(true)),
        ("scouting/multicast/enabled", json!(false)),
        ("scouting/gossip/enabled", json!(false)),
        ("transport/link/tx/lease", json!(LEASE_MILLIS)),
        ("transport/link/tx/batch_size", json!(BATCH)),
        ("transport/link/tx/queue/size/data", json!(1)),
        ("transport/link/tcp/so_sndbuf", json!(SEND_BUFFER)),
        (
            "transport/link/tls",
            json!({
                "root_ca_certificate": zenoh.ca.as_deref().map(path),
                "enable_mtls": identity.is_some(),
                "connect_certificate": identity.map(|(cert, _)| path(cert)),
                "connect_private_key": identity.map(|(_, key)| path(key)),
                "so_sndbuf": SEND_BUFFER,
            }),
        ),
    ];
    for (key, value) in values {
        if let Err(error) = config.insert_json5(key, &value.to_string()) {
            tracing::error!("zenoh does not take {key}: {error}");
        }
    }
    config
}

fn connector(ca: &Path, zenoh: &ZenohConfig) -> Result<TlsConnector, ZenohError> {
    let mut roots = RootCertStore::empty();
    for root in certificates("ca", ca)? {
        let is_one = roots.add(root);
        is_one.map_err(|error| wrong("ca", ca, error.to_string()))?;
    }
    let config = ClientConfig::builder_with_provider(Arc::new(ring::default_provider()))
        .with_safe_default_protocol_versions()
        .map_err(|error| wrong("ca", ca, error.to_string()))?
        .with_root_certificates(roots);
    let config = match &zenoh.identity {
        None => config.with_no_client_auth(),
        Some((cert, key)) => {
            let secret = PrivateKeyDer::from_pem_slice(&read("key", key)?);
            let secret = secret.map_err(|error| {
                wrong(
                    "key",
                    key,
                    format!("expected a private key in PEM: {error}"),
                )
            })?;
            config
                .with_client_auth_cert(certificates("cert", cert)?, secret)
                .map_err(|error| wrong("cert", cert, error.to_string()))?
        }
    };
    Ok(TlsConnector::from(Arc::new(config)))
}

fn certificates(
    key: &'static str,
    path: &Path,
) -> Result<Vec<CertificateDer<'static>>, ZenohError> {
    let text = read(key, path)?;
    let all: Result<Vec<_>, _> = CertificateDer::pem_slice_iter(&text).collect();
    match all {
        Ok(all) if !all.is_empty() => Ok(all),
        Ok(_) => Err(wrong(key, path, "expected a certificate in PEM".to_owned())),
        Err(error) => {
            let why = format!("expected a certificate in PEM: {error}");
            Err(wrong(key, path, why))
        }
    }
}

fn read(key: &'static str, path: &Path) -> Result<Vec<u8>, ZenohError> {
    std::fs::read(path).map_err(|error| wrong(key, path, error.to_string()))
}

fn wrong(key: &'static str, path: &Path, why: String) -> ZenohError {
    let path = path.to_owned();
    ZenohError::File { key, path, why }
}

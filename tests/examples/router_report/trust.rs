//! A router that requires certificates: clients with the right one are let in, and it is reported
//! in words who does not trust whom; the robot is still served at its own address.

use std::path::{Path, PathBuf};

use rcgen::{BasicConstraints, CertificateParams, IsCa, Issuer, KeyPair};
use serde_json::{Value, json};

use crate::client::Client;
use crate::process::{Bridge, Router};
use crate::remote;
use crate::started::free_port;

/// A certificate authority in a folder of its own.
pub(crate) struct Authority {
    issuer: Issuer<'static, KeyPair>,
    pub(crate) cert: PathBuf,
}

impl Authority {
    pub(crate) fn make(folder: &Path, name: &str) -> Self {
        let mut params = CertificateParams::new(vec![]).unwrap();
        params.is_ca = IsCa::Ca(BasicConstraints::Unconstrained);
        let name = format!("{name} authority");
        params
            .distinguished_name
            .push(rcgen::DnType::CommonName, &name);
        let key = KeyPair::generate().unwrap();
        let cert = folder.join(format!("{name}.pem"));
        std::fs::write(&cert, params.self_signed(&key).unwrap().pem()).unwrap();
        let issuer = Issuer::new(params, key);
        Self { issuer, cert }
    }

    /// Certificate and key for this name.
    pub(crate) fn sign(&self, folder: &Path, name: &str) -> [PathBuf; 2] {
        let params = CertificateParams::new(vec!["localhost".to_owned()]).unwrap();
        let key = KeyPair::generate().unwrap();
        let cert = params.signed_by(&key, &self.issuer).unwrap();
        let paths = ["cert", "key"].map(|kind| folder.join(format!("{name}-{kind}.pem")));
        std::fs::write(&paths[0], cert.pem()).unwrap();
        std::fs::write(&paths[1], key.serialize_pem()).unwrap();
        paths
    }
}

pub(crate) async fn report() -> (bool, Value) {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let (ours, foreign) = (Authority::make(at, "our"), Authority::make(at, "foreign"));
    let router = ours.sign(at, "router");
    let (known, unknown) = (ours.sign(at, "known"), foreign.sign(at, "unknown"));
    let endpoint = format!("tls/localhost:{}", free_port());
    let tls = json!({
        "root_ca_certificate": ours.cert, "enable_mtls": true,
        "listen_certificate": router[0], "listen_private_key": router[1],
    });
    let router = Router::start(&endpoint, &json!({ "transport/link/tls": tls })).await;
    let tls = json!({
        "root_ca_certificate": ours.cert, "enable_mtls": true,
        "connect_certificate": known[0], "connect_private_key": known[1],
    });
    let session = remote::session(&endpoint, &json!({ "transport/link/tls": tls })).await;
    let text = |path: &Path| path.to_str().unwrap().to_owned();
    let bridge = async |name: &str, ca: &Authority, identity: Option<&[PathBuf; 2]>| {
        let mut flags = vec!["--zenoh", &endpoint, "--zenoh-name", name, "--zenoh-ca"];
        let ca = text(&ca.cert);
        flags.push(&ca);
        let files = identity.map(|[cert, key]| [text(cert), text(key)]);
        if let Some([cert, key]) = &files {
            flags.extend(["--zenoh-cert", cert, "--zenoh-key", key]);
        }
        Bridge::start(&flags).await
    };
    let right = bridge("right", &ours, Some(&known)).await;
    let is_in = remote::wait_for(&session, "right", 1).await.is_some();
    let mut refused = serde_json::Map::new();
    let mut holds = is_in;
    for (name, ca, identity, words) in [
        ("foreign-router", &foreign, Some(&known), "UnknownIssuer"),
        ("foreign-robot", &ours, Some(&unknown), "UnknownCA"),
        ("no-certificate", &ours, None, "CertificateRequired"),
    ] {
        let bridge = bridge(name, ca, identity).await;
        let words = words.to_owned();
        let is_said = bridge.says("do not trust each other's certificates").await
            && bridge.says(&words).await
            && bridge.said().contains(&endpoint);
        let is_out = remote::robots(&session, name).await.is_empty();
        let is_served = Client::connect(bridge.address, "").await.robot.is_some();
        bridge.kill().await;
        holds &= is_said && is_out && is_served;
        let figure = json!({ "said": is_said, "stays_out": is_out, "served_at_home": is_served });
        refused.insert(name.to_owned(), figure);
    }
    right.kill().await;
    router.kill().await;
    (
        holds,
        json!({ "right_certificate_is_let_in": is_in, "refused": refused }),
    )
}

//! TLS: for a network in which others could listen.
//!
//! In: a certificate and its key, or a folder in which the bridge keeps its own. Out: an
//! [`Identity`] to serve with.
//!
//! 1. No public authority certifies a robot in a local network. Its own certificate names this
//!    machine: `localhost`, `NAME.local`, and the addresses that it has at the time. The browser
//!    warns once; a person compares the fingerprint that the bridge prints.
//! 2. Key and certificate lie beside the token, the key readable by its owner only. Both stay until
//!    they are deleted.
//! 3. The provider is `ring`; TLS 1.2 and 1.3, HTTP/1.1.

use std::fs;
use std::net::IpAddr;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use rcgen::{CertificateParams, CertifiedKey, DistinguishedName, DnType, KeyPair};
use sha2::{Digest, Sha256};
use tokio_rustls::TlsAcceptor;
use tokio_rustls::rustls::crypto::ring;
use tokio_rustls::rustls::pki_types::pem::PemObject;
use tokio_rustls::rustls::pki_types::{CertificateDer, PrivateKeyDer, pem};
use tokio_rustls::rustls::{self, ServerConfig};

use crate::secret_file::{self, SecretFileError};

/// Names of the bridge's own files.
const OWN: [&str; 2] = ["tls-cert.pem", "tls-key.pem"];

/// A certificate with its key. It prints as its fingerprint.
#[derive(Clone)]
pub struct Identity {
    config: Arc<ServerConfig>,
    fingerprint: String,
}

/// Why TLS cannot be spoken.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TlsError {
    /// A file cannot be read or written, or others can read the key.
    #[error("TLS file {0}")]
    File(#[from] SecretFileError),
    /// A file does not hold what it should.
    #[error("TLS file {}: expected {expected} in PEM: {source}", path.display())]
    Pem {
        /// The file.
        path: PathBuf,
        /// What should stand there.
        expected: &'static str,
        /// What is wrong.
        source: pem::Error,
    },
    /// Certificate and key do not go together, or are of a kind that is unknown.
    #[error("TLS certificate {}: {source}", path.display())]
    Useless {
        /// The certificate's file.
        path: PathBuf,
        /// What is wrong.
        source: rustls::Error,
    },
    /// One half of the bridge's own pair is gone.
    #[error("{} is there and {} is not: delete the one, and both are made again", there.display(), missing.display())]
    Half {
        /// The file that is there.
        there: PathBuf,
        /// The other.
        missing: PathBuf,
    },
    /// No certificate could be made.
    #[error("no certificate can be made: {0}")]
    Make(#[from] rcgen::Error),
}

impl std::fmt::Debug for Identity {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Identity({})", self.fingerprint)
    }
}

impl Identity {
    /// Reads certificate chain and key.
    ///
    /// # Errors    [`TlsError`]: a file that cannot be read or used.
    pub fn load(cert: &Path, key: &Path) -> Result<Self, TlsError> {
        let secret = secret_file::read(key)?;
        let text = fs::read(cert).map_err(|source| SecretFileError::of(cert, source))?;
        let chain: Result<Vec<_>, _> = CertificateDer::pem_slice_iter(&text).collect();
        let chain = chain.and_then(|chain| match chain.is_empty() {
            true => Err(pem::Error::NoItemsFound),
            false => Ok(chain),
        });
        let chain = chain.map_err(|source| unreadable(cert, "a certificate", source))?;
        let secret = PrivateKeyDer::from_pem_slice(secret.as_bytes())
            .map_err(|source| unreadable(key, "a private key", source))?;
        let fingerprint = chain
            .first()
            .map_or_else(String::new, |first| fingerprint(first));
        let config = configure(chain, secret).map_err(|source| TlsError::Useless {
            path: cert.to_owned(),
            source,
        })?;
        Ok(Self {
            config: Arc::new(config),
            fingerprint,
        })
    }

    /// Reads the bridge's own pair in `folder`, or makes it.
    ///
    /// # Errors    [`TlsError`]: it cannot be read, made or used.
    pub fn load_or_make(folder: &Path) -> Result<Self, TlsError> {
        let [cert, key] = OWN.map(|name| folder.join(name));
        let half = |there, missing| Err(TlsError::Half { there, missing });
        match (cert.exists(), key.exists()) {
            (false, false) => make(&cert, &key)?,
            (true, false) => return half(cert, key),
            (false, true) => return half(key, cert),
            (true, true) => (),
        }
        Self::load(&cert, &key)
    }

    /// SHA-256 of the certificate, as browsers show it: `AB:01:…`.
    #[must_use]
    pub fn fingerprint(&self) -> &str {
        &self.fingerprint
    }

    pub(crate) fn acceptor(&self) -> TlsAcceptor {
        TlsAcceptor::from(Arc::clone(&self.config))
    }
}

fn configure(
    chain: Vec<CertificateDer<'static>>,
    key: PrivateKeyDer<'static>,
) -> Result<ServerConfig, rustls::Error> {
    let mut config = ServerConfig::builder_with_provider(Arc::new(ring::default_provider()))
        .with_safe_default_protocol_versions()?
        .with_no_client_auth()
        .with_single_cert(chain, key)?;
    config.alpn_protocols = vec![b"http/1.1".to_vec()];
    Ok(config)
}

fn make(cert: &Path, key: &Path) -> Result<(), TlsError> {
    let CertifiedKey {
        cert: made,
        signing_key,
    } = certify(&names())?;
    // The key last: without it the certificate is not taken for a pair.
    for (path, text) in [(cert, made.pem()), (key, signing_key.serialize_pem())] {
        secret_file::write(path, text.trim_end())?;
    }
    Ok(())
}

fn certify(names: &[String]) -> Result<CertifiedKey<KeyPair>, rcgen::Error> {
    let mut params = CertificateParams::new(names)?;
    let mut subject = DistinguishedName::new();
    subject.push(DnType::CommonName, "slamlab bridge");
    params.distinguished_name = subject;
    // A Pi has no clock of its own: a certificate that begins today may begin in its future.
    params.not_before = rcgen::date_time_ymd(2024, 1, 1);
    params.not_after = rcgen::date_time_ymd(2049, 12, 31);
    let signing_key = KeyPair::generate()?;
    let cert = params.self_signed(&signing_key)?;
    Ok(CertifiedKey { cert, signing_key })
}

/// All that a browser on the same network may call this machine by.
fn names() -> Vec<String> {
    let mut names = vec!["localhost".to_owned()];
    names.extend(crate::address::host_name().map(|name| format!("{name}.local")));
    let loopback = [
        IpAddr::from([127, 0, 0, 1]),
        IpAddr::from([0, 0, 0, 0, 0, 0, 0, 1]),
    ];
    let others = crate::address::of_this_machine();
    names.extend(loopback.into_iter().chain(others).map(|ip| ip.to_string()));
    names
}

fn fingerprint(cert: &CertificateDer<'_>) -> String {
    let bytes = Sha256::digest(cert);
    let pairs: Vec<_> = bytes.iter().map(|byte| format!("{byte:02X}")).collect();
    pairs.join(":")
}

fn unreadable(path: &Path, expected: &'static str, source: pem::Error) -> TlsError {
    TlsError::Pem {
        path: path.to_owned(),
        expected,
        source,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_own_pair_is_made_once_and_its_key_is_private() {
        let folder = tempfile::TempDir::new().unwrap();
        let place = folder.path().join("deep");
        let made = Identity::load_or_make(&place).unwrap();
        let read = Identity::load_or_make(&place).unwrap();
        assert_eq!(made.fingerprint(), read.fingerprint());
        assert_eq!(made.fingerprint().len(), 32 * 3 - 1);
        let key = place.join(OWN[1]);
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            assert_eq!(
                fs::metadata(&key).unwrap().permissions().mode() & 0o777,
                0o600
            );
            fs::set_permissions(&key, fs::Permissions::from_mode(0o640)).unwrap();
            let error = Identity::load_or_make(&place).unwrap_err().to_string();
            assert!(error.contains("mode 640"), "{error}");
        }
        fs::remove_file(&key).unwrap();
        let error = Identity::load_or_make(&place).unwrap_err();
        assert!(matches!(error, TlsError::Half { .. }), "{error}");
    }

    #[test]
    fn files_that_do_not_go_together_are_refused() {
        let folder = tempfile::TempDir::new().unwrap();
        let [one, other] = ["one", "other"].map(|name| folder.path().join(name));
        Identity::load_or_make(&one).unwrap();
        Identity::load_or_make(&other).unwrap();
        let (cert, key) = (one.join(OWN[0]), other.join(OWN[1]));
        let error = Identity::load(&cert, &key).unwrap_err();
        assert!(matches!(error, TlsError::Useless { .. }), "{error}");
        let error = Identity::load(&key, &key).unwrap_err().to_string();
        assert!(error.contains("expected a certificate"), "{error}");
        let error = Identity::load(&cert, &folder.path().join("none"))
            .unwrap_err()
            .to_string();
        assert!(error.contains("none"), "{error}");
    }
}

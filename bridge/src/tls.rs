//! TLS: for networks in which others could eavesdrop.
//!
//! In: a certificate and its key, or a folder in which the bridge keeps its own. Out: an
//! [`Identity`] for the server.
//!
//! 1. No public authority certifies a robot in a local network. So the bridge has one of its own
//!    (`authority`), made once; a phone that installs it trusts the bridge permanently (`/trust`,
//!    see [`crate::trust`]). Other browsers show a warning, and the person compares the
//!    fingerprint.
//! 2. The authority signs a short-lived certificate (`leaf`) that names this machine: `localhost`,
//!    `NAME.local`, and its present addresses. It is renewed while the bridge runs
//!    ([`Identity::renew`]).
//! 3. All files are beside the token; keys are readable by their owner only.
//! 4. A certificate made by somebody else is read again when its files change (`files`).
//! 5. The provider is `ring`; TLS 1.2 and 1.3, HTTP/1.1.

mod authority;
mod files;
mod leaf;
mod names;
mod validity;

use std::path::{Path, PathBuf};
use std::sync::{Arc, PoisonError, RwLock};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use sha2::{Digest, Sha256};
use tokio_rustls::TlsAcceptor;
use tokio_rustls::rustls::crypto::ring;
use tokio_rustls::rustls::pki_types::pem::PemObject;
use tokio_rustls::rustls::pki_types::{CertificateDer, PrivateKeyDer, pem};
use tokio_rustls::rustls::server::{ClientHello, ResolvesServerCert};
use tokio_rustls::rustls::sign::CertifiedKey;
use tokio_rustls::rustls::{self, ServerConfig};

use crate::secret_file::SecretFileError;
use authority::Authority;
use files::Files;
use leaf::Leaf;
pub use names::UNNAMED;

/// A certificate with its key. It prints as its fingerprint.
#[derive(Clone)]
pub struct Identity {
    config: Arc<ServerConfig>,
    shown: Arc<Shown>,
    fingerprint: String,
    origin: Origin,
}

/// The certificate shown to clients; replaced when it is renewed.
#[derive(Debug)]
struct Shown(RwLock<Arc<CertifiedKey>>);

/// Where this certificate and the next ones come from.
#[derive(Clone)]
enum Origin {
    Own(Own),
    Files(Arc<Files>),
}

/// The bridge's own authority, and its folder.
#[derive(Clone)]
struct Own {
    folder: PathBuf,
    authority: Arc<Authority>,
}

/// Why TLS cannot be used.
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
        /// What should be in it.
        expected: &'static str,
        /// What is wrong.
        source: pem::Error,
    },
    /// Certificate and key do not match, or are of an unknown kind.
    #[error("TLS certificate {}: {source}", path.display())]
    Useless {
        /// The certificate's file.
        path: PathBuf,
        /// What is wrong.
        source: rustls::Error,
    },
    /// One file of the bridge's own pair is missing.
    #[error("{} is there and {} is not: delete the one, and both are made again", there.display(), missing.display())]
    Half {
        /// The file that exists.
        there: PathBuf,
        /// The missing one.
        missing: PathBuf,
    },
    /// The certificate beside the bridge's own key belongs to another key.
    #[error("{} is not the certificate of {}: put the right one back, or delete both, and both are made again", cert.display(), key.display())]
    Foreign {
        /// The file of the certificate.
        cert: PathBuf,
        /// The file of the key.
        key: PathBuf,
    },
    /// The key cannot sign.
    #[error("TLS file {}: expected a private key in PEM: {source}", path.display())]
    Key {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        source: rcgen::Error,
    },
    /// The file for the certificate that the bridge made holds something else.
    #[error("TLS file {}: {said}; delete it, and it is made again", path.display())]
    Leaf {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        said: String,
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
        let (files, certified) = Files::open(cert, key, time_of_day())?;
        let fingerprint = (certified.cert.first()).map_or_else(String::new, fingerprint);
        let origin = Origin::Files(Arc::new(files));
        Self::new(certified, fingerprint, origin).map_err(|source| TlsError::Useless {
            path: cert.to_owned(),
            source,
        })
    }

    /// Reads the bridge's own authority in `folder`, or makes it, and a certificate signed by it.
    ///
    /// # Errors    [`TlsError`]: it cannot be read, made or used.
    pub fn load_or_make(folder: &Path) -> Result<Self, TlsError> {
        let authority = Arc::new(Authority::load_or_make(folder)?);
        let (leaf, _) = Leaf::load_or_make(folder, &authority, &names::all(), time_of_day())?;
        let certified = of_leaf(folder, &leaf)?;
        let fingerprint = authority.fingerprint();
        let origin = Origin::Own(Own {
            folder: folder.to_owned(),
            authority,
        });
        Self::new(certified, fingerprint, origin).map_err(|source| TlsError::Useless {
            path: folder.join(leaf::FILE),
            source,
        })
    }

    fn new(
        certified: CertifiedKey,
        fingerprint: String,
        origin: Origin,
    ) -> Result<Self, rustls::Error> {
        let shown = Arc::new(Shown(RwLock::new(Arc::new(certified))));
        let provider = Arc::new(ring::default_provider());
        let mut config = ServerConfig::builder_with_provider(provider)
            .with_safe_default_protocol_versions()?
            .with_no_client_auth()
            .with_cert_resolver(Arc::clone(&shown) as Arc<dyn ResolvesServerCert>);
        config.alpn_protocols = vec![b"http/1.1".to_vec()];
        Ok(Self {
            config: Arc::new(config),
            shown,
            fingerprint,
            origin,
        })
    }

    /// Shows a new certificate from now on, if the bridge's own one ends soon or no longer names
    /// the machine's addresses, or if the files of somebody else's have changed. Returns whether it
    /// does.
    ///
    /// # Errors    [`TlsError`]: none can be made; then the old one is still shown.
    pub fn renew(&self) -> Result<bool, TlsError> {
        self.renew_for(&names::all(), time_of_day())
    }

    fn renew_for(&self, names: &[String], now: Duration) -> Result<bool, TlsError> {
        let certified = match &self.origin {
            Origin::Files(files) => files.renewed(now),
            Origin::Own(Own { folder, authority }) => {
                let (leaf, is_new) = Leaf::load_or_make(folder, authority, names, now)?;
                is_new.then(|| of_leaf(folder, &leaf)).transpose()?
            }
        };
        let is_new = certified.is_some();
        if let Some(certified) = certified.map(Arc::new) {
            *self.shown.0.write().unwrap_or_else(PoisonError::into_inner) = certified;
        }
        Ok(is_new)
    }

    /// SHA-256 of what a person should trust, as browsers show it, `AB:01:…`: of the bridge's own
    /// authority, else of the certificate that was read at the start.
    #[must_use]
    pub fn fingerprint(&self) -> &str {
        &self.fingerprint
    }

    /// The certificate of the bridge's own authority, DER; none if somebody else made the
    /// certificate.
    #[must_use]
    pub fn authority(&self) -> Option<&[u8]> {
        match &self.origin {
            Origin::Own(own) => Some(own.authority.der.as_ref()),
            Origin::Files(_) => None,
        }
    }

    pub(crate) fn acceptor(&self) -> TlsAcceptor {
        TlsAcceptor::from(Arc::clone(&self.config))
    }
}

impl ResolvesServerCert for Shown {
    fn resolve(&self, _: ClientHello<'_>) -> Option<Arc<CertifiedKey>> {
        let shown = self.0.read().unwrap_or_else(PoisonError::into_inner);
        Some(Arc::clone(&shown))
    }
}

fn certify(
    chain: Vec<CertificateDer<'static>>,
    key: PrivateKeyDer<'static>,
) -> Result<CertifiedKey, rustls::Error> {
    let certified = CertifiedKey::from_der(chain, key, &ring::default_provider())?;
    certified.keys_match().map(|()| certified)
}

fn of_leaf(folder: &Path, leaf: &Leaf) -> Result<CertifiedKey, TlsError> {
    let path = folder.join(leaf::FILE);
    let cert = CertificateDer::from_pem_slice(leaf.cert.as_bytes())
        .map_err(|source| unreadable(&path, "a certificate", source))?;
    let key = PrivateKeyDer::from_pem_slice(leaf.key.as_bytes())
        .map_err(|source| unreadable(&path, "a private key", source))?;
    certify(vec![cert], key).map_err(|source| TlsError::Useless { path, source })
}

/// Time since 1970; a clock before that was never set.
fn time_of_day() -> Duration {
    SystemTime::now()
        .duration_since(UNIX_EPOCH)
        .unwrap_or_default()
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
    use std::fs;

    use super::*;
    use crate::secret_file;

    const DAY: Duration = Duration::from_secs(24 * 60 * 60);

    #[test]
    fn the_own_authority_is_made_once_and_its_key_is_private() {
        let folder = tempfile::TempDir::new().unwrap();
        let place = folder.path().join("deep");
        let made = Identity::load_or_make(&place).unwrap();
        let read = Identity::load_or_make(&place).unwrap();
        assert_eq!(made.fingerprint(), read.fingerprint());
        assert_eq!(made.fingerprint().len(), 32 * 3 - 1);
        assert!(shown(&made) == shown(&read), "a restart changes nothing");
        let key = place.join(authority::FILES[1]);
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            for secret in [&key, &place.join(leaf::FILE)] {
                let mode = fs::metadata(secret).unwrap().permissions().mode();
                assert_eq!(mode & 0o777, 0o600);
            }
            fs::set_permissions(&key, fs::Permissions::from_mode(0o640)).unwrap();
            let error = Identity::load_or_make(&place).unwrap_err().to_string();
            assert!(error.contains("mode 640"), "{error}");
        }
        fs::remove_file(&key).unwrap();
        let error = Identity::load_or_make(&place).unwrap_err();
        assert!(matches!(error, TlsError::Half { .. }), "{error}");
    }

    fn shown(identity: &Identity) -> Vec<u8> {
        identity.shown.0.read().unwrap().cert[0].to_vec()
    }

    #[test]
    fn a_certificate_is_made_anew_before_its_end_and_for_other_names() {
        let folder = tempfile::TempDir::new().unwrap();
        let identity = Identity::load_or_make(folder.path()).unwrap();
        let (names, now) = (names::all(), time_of_day());
        let renewed = |names: &[String], now| identity.renew_for(names, now).unwrap();
        assert!(!renewed(&names, now + 59 * DAY));
        assert!(renewed(&names, now + 61 * DAY));
        assert!(!renewed(&names, now + 61 * DAY));
        // The clock was set back: the certificate is not valid yet.
        assert!(renewed(&names, now));
        let mut others = names.clone();
        others.push("192.168.99.7".into());
        let before = shown(&identity);
        assert!(identity.renew_for(&others, now).unwrap());
        assert!(shown(&identity) != before);
    }

    #[test]
    fn a_leaf_that_is_none_is_named_and_files_of_others_are_not_renewed() {
        let folder = tempfile::TempDir::new().unwrap();
        Identity::load_or_make(folder.path()).unwrap();
        let path = folder.path().join(leaf::FILE);
        for text in ["", "begins = 1", "cert = 7"] {
            secret_file::write(&path, text).unwrap();
            let error = Identity::load_or_make(folder.path())
                .unwrap_err()
                .to_string();
            assert!(
                error.contains("tls-leaf.toml") && error.contains("delete it"),
                "{error}"
            );
        }
        let [cert, key] = authority::FILES.map(|name| folder.path().join(name));
        let theirs = Identity::load(&cert, &key).unwrap();
        assert!(!theirs.renew().unwrap() && theirs.authority().is_none());
    }

    /// Regression: phones were told to trust an authority that had signed nothing that the bridge
    /// shows.
    #[test]
    fn an_authority_that_signs_nothing_here_is_not_offered() {
        let folder = tempfile::TempDir::new().unwrap();
        let [own, other] = ["own", "other"].map(|name| folder.path().join(name));
        Identity::load_or_make(&own).unwrap();
        Identity::load_or_make(&other).unwrap();
        let [cert, _] = authority::FILES;
        fs::copy(other.join(cert), own.join(cert)).unwrap();
        let error = Identity::load_or_make(&own).unwrap_err();
        assert!(matches!(error, TlsError::Foreign { .. }), "{error}");
        assert!(error.to_string().contains("delete both"), "{error}");
    }

    #[test]
    fn files_that_do_not_go_together_are_refused() {
        let folder = tempfile::TempDir::new().unwrap();
        let [one, other] = ["one", "other"].map(|name| folder.path().join(name));
        Identity::load_or_make(&one).unwrap();
        Identity::load_or_make(&other).unwrap();
        let (cert, key) = (
            one.join(authority::FILES[0]),
            other.join(authority::FILES[1]),
        );
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

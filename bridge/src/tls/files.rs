//! A certificate that somebody else makes and renews: by hand, or by a program like certbot.
//!
//! In: its two files. Out: the certificate to show, at the start and again whenever the files have
//! changed; and in the log what its owner should know.
//!
//! 1. The files are read each time, and parsed only if their content differs. File times would not
//!    do, because copying may preserve them.
//! 2. If the new certificate cannot be used, the previous one is still shown, and this is logged
//!    once: of the two files one is always written first.
//! 3. A certificate that ends within [`SOON`], or has ended, is logged at the start and once a day.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use sha2::{Digest, Sha256};
use tokio_rustls::rustls::pki_types::pem::PemObject;
use tokio_rustls::rustls::pki_types::{CertificateDer, PrivateKeyDer, pem};
use tokio_rustls::rustls::sign::CertifiedKey;

use super::{TlsError, certify, unreadable, validity};
use crate::secret_file::{self, SecretFileError};

const DAY: Duration = Duration::from_secs(24 * 60 * 60);
/// How long before its end its owner is told.
const SOON: Duration = Duration::from_secs(7 * 24 * 60 * 60);

/// The two files.
pub(super) struct Files {
    cert: PathBuf,
    key: PathBuf,
    known: Mutex<Known>,
}

struct Known {
    /// Hash of the files' last content, used or not.
    mark: [u8; 32],
    /// End of the certificate that is shown; none if it cannot be read.
    ends: Option<Duration>,
    /// When its owner was last told of that.
    told: Option<Duration>,
}

/// What the files hold.
struct Texts {
    cert: Result<Vec<u8>, SecretFileError>,
    key: Result<String, SecretFileError>,
}

impl Files {
    /// Reads the files for the first time.
    ///
    /// # Errors    [`TlsError`]: they cannot be read or used.
    pub(super) fn open(
        cert: &Path,
        key: &Path,
        now: Duration,
    ) -> Result<(Self, CertifiedKey), TlsError> {
        let texts = Texts::read(cert, key);
        let mark = texts.mark();
        let certified = texts.certified(cert, key)?;
        let known = Known {
            mark,
            ends: end_of(&certified),
            told: None,
        };
        let files = Self {
            cert: cert.to_owned(),
            key: key.to_owned(),
            known: Mutex::new(known),
        };
        files.tell(now);
        Ok((files, certified))
    }

    /// The certificate to show from now on, if the files have changed and can be used.
    pub(super) fn renewed(&self, now: Duration) -> Option<CertifiedKey> {
        let renewed = self.changed();
        self.tell(now);
        renewed
    }

    fn changed(&self) -> Option<CertifiedKey> {
        let texts = Texts::read(&self.cert, &self.key);
        let mark = texts.mark();
        let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        if known.mark == mark {
            return None;
        }
        known.mark = mark;
        match texts.certified(&self.cert, &self.key) {
            Ok(certified) => {
                known.ends = end_of(&certified);
                known.told = None;
                Some(certified)
            }
            Err(error) => {
                tracing::warn!(
                    "the certificate's files have changed and cannot be used, so that the one before is shown on: {error}"
                );
                None
            }
        }
    }

    /// Logs that the certificate ends soon, or has ended.
    fn tell(&self, now: Duration) {
        if let Some(words) = self.warning(now) {
            tracing::warn!("the certificate {} {words}", self.cert.display());
        }
    }

    /// The warning about its end that is due now; none if the end is far away, or was logged today.
    fn warning(&self, now: Duration) -> Option<String> {
        let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        let ends = known.ends.filter(|ends| *ends < now + SOON)?;
        if known.told.is_some_and(|told| now < told + DAY) {
            return None;
        }
        known.told = Some(now);
        Some(match ends.checked_sub(now).map(|left| left.as_secs()) {
            None | Some(0) => "has expired: browsers refuse it until it is replaced".to_owned(),
            Some(left) => format!(
                "expires in {:.1} days: browsers refuse it from then on until it is replaced",
                left as f64 / DAY.as_secs_f64()
            ),
        })
    }
}

impl Texts {
    fn read(cert: &Path, key: &Path) -> Self {
        Self {
            cert: fs::read(cert).map_err(|source| SecretFileError::of(cert, source)),
            key: secret_file::read(key),
        }
    }

    /// Hash of the content; for a file that cannot be read, of its error.
    fn mark(&self) -> [u8; 32] {
        let cert = match &self.cert {
            Ok(bytes) => Sha256::digest(bytes),
            Err(error) => Sha256::digest(error.to_string()),
        };
        let key = match &self.key {
            Ok(text) => Sha256::digest(text),
            Err(error) => Sha256::digest(error.to_string()),
        };
        Sha256::digest([cert, key].concat()).into()
    }

    fn certified(self, cert: &Path, key: &Path) -> Result<CertifiedKey, TlsError> {
        let secret = self.key?;
        let chain: Result<Vec<_>, _> = CertificateDer::pem_slice_iter(&self.cert?).collect();
        let chain = chain.and_then(|chain| match chain.is_empty() {
            true => Err(pem::Error::NoItemsFound),
            false => Ok(chain),
        });
        let chain = chain.map_err(|source| unreadable(cert, "a certificate", source))?;
        let secret = PrivateKeyDer::from_pem_slice(secret.as_bytes())
            .map_err(|source| unreadable(key, "a private key", source))?;
        certify(chain, secret).map_err(|source| TlsError::Useless {
            path: cert.to_owned(),
            source,
        })
    }
}

fn end_of(certified: &CertifiedKey) -> Option<Duration> {
    certified.cert.first().and_then(|cert| validity::ends(cert))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Writes a certificate that ends in `year`, and its key.
    fn write([cert, key]: [&Path; 2], year: i32) {
        let mut params = rcgen::CertificateParams::new(["robot.example".to_owned()]).unwrap();
        params.not_after = rcgen::date_time_ymd(year, 1, 1);
        let pair = rcgen::KeyPair::generate().unwrap();
        fs::write(cert, params.self_signed(&pair).unwrap().pem()).unwrap();
        secret_file::write(key, pair.serialize_pem().trim_end()).unwrap();
    }

    fn at(year: i32, month: u8, day: u8) -> Duration {
        let seconds = rcgen::date_time_ymd(year, month, day).unix_timestamp();
        Duration::from_secs(seconds as u64)
    }

    /// Regression: after certbot had renewed the certificate, the bridge still showed the old one
    /// until it had expired.
    #[test]
    fn files_that_have_changed_are_shown_and_broken_ones_are_not() {
        let folder = tempfile::TempDir::new().unwrap();
        let [cert, key] = ["cert.pem", "key.pem"].map(|name| folder.path().join(name));
        let both = [cert.as_path(), key.as_path()];
        write(both, 2030);
        let now = at(2026, 1, 1);
        let (files, first) = Files::open(&cert, &key, now).unwrap();
        assert!(files.renewed(now).is_none(), "nothing has changed");
        write(both, 2031);
        let second = files.renewed(now).unwrap();
        assert!(second.cert != first.cert);
        // Half of the next pair: the key is still the previous one.
        let old = fs::read(&key).unwrap();
        write(both, 2032);
        let new = fs::read_to_string(&key).unwrap();
        secret_file::write(&key, std::str::from_utf8(&old).unwrap().trim_end()).unwrap();
        assert!(files.renewed(now).is_none());
        fs::remove_file(&key).unwrap();
        assert!(files.renewed(now).is_none());
        secret_file::write(&key, new.trim_end()).unwrap();
        assert!(files.renewed(now).is_some());
    }

    #[test]
    fn that_it_ends_is_said_a_week_before_and_once_a_day() {
        let folder = tempfile::TempDir::new().unwrap();
        let [cert, key] = ["cert.pem", "key.pem"].map(|name| folder.path().join(name));
        write([&cert, &key], 2030);
        let (files, _) = Files::open(&cert, &key, at(2029, 6, 1)).unwrap();
        let said = |now| files.warning(now).unwrap_or_default();
        assert_eq!(said(at(2029, 12, 24)), "");
        assert!(said(at(2029, 12, 27)).starts_with("expires in 5.0 days"));
        assert_eq!(said(at(2029, 12, 27) + DAY / 2), "");
        assert!(said(at(2029, 12, 28)).starts_with("expires in 4.0 days"));
        assert!(said(at(2030, 1, 1)).starts_with("has expired"));
        assert!(said(at(2031, 1, 1)).starts_with("has expired"));
        // It is logged at the start, too.
        let (files, _) = Files::open(&cert, &key, at(2031, 1, 1)).unwrap();
        assert!(files.warning(at(2031, 1, 1)).is_none(), "it was said");
    }
}

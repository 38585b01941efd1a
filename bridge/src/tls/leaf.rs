//! The certificate that the bridge shows: signed by its authority, for this machine's present names
//! and addresses, and short-lived.
//!
//! It is kept in one file with its key, so that a restart changes nothing: a browser that accepted
//! it without the authority does not ask again while it is valid. It is made anew when it ends
//! within [`RENEW`], when the machine's names have changed, when another authority signed it, or
//! when by the machine's clock it is not valid yet.

use std::path::Path;
use std::time::Duration;

use rcgen::{
    CertificateParams, DistinguishedName, DnType, ExtendedKeyUsagePurpose, IsCa, KeyPair,
    KeyUsagePurpose,
};
use serde::{Deserialize, Serialize};

use super::TlsError;
use super::authority::Authority;
use crate::secret_file;

/// Its file, beside the token.
pub(super) const FILE: &str = "tls-leaf.toml";
const DAY: Duration = Duration::from_secs(24 * 60 * 60);
/// How long it is valid; phones accept 825 days at most.
const LASTS: Duration = Duration::from_secs(90 * 24 * 60 * 60);
/// How long before its end it is made anew.
const RENEW: Duration = Duration::from_secs(30 * 24 * 60 * 60);

/// A certificate with its key. Times are seconds since 1970.
#[derive(Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Leaf {
    begins: u64,
    ends: u64,
    names: Vec<String>,
    /// Fingerprint of the authority that signed it.
    authority: String,
    pub(super) cert: String,
    pub(super) key: String,
}

impl Leaf {
    /// Reads it from `folder` if it is still good for these names, or makes it anew; returns
    /// whether it was made.
    pub(super) fn load_or_make(
        folder: &Path,
        authority: &Authority,
        names: &[String],
        now: Duration,
    ) -> Result<(Self, bool), TlsError> {
        let path = folder.join(FILE);
        match secret_file::read(&path) {
            Ok(text) => {
                let leaf: Self = toml::from_str(&text).map_err(|error| TlsError::Leaf {
                    path: path.clone(),
                    said: error.message().to_owned(),
                })?;
                if leaf.is_good(authority, names, now) {
                    return Ok((leaf, false));
                }
            }
            Err(error) if error.is_not_found() => (),
            Err(error) => return Err(error.into()),
        }
        let leaf = Self::make(authority, names, now)?;
        let text = toml::to_string(&leaf).map_err(|error| TlsError::Leaf {
            path: path.clone(),
            said: error.to_string(),
        })?;
        secret_file::write(&path, text.trim_end())?;
        Ok((leaf, true))
    }

    pub(super) fn is_good(&self, authority: &Authority, names: &[String], now: Duration) -> bool {
        let (begins, ends) = (
            Duration::from_secs(self.begins),
            Duration::from_secs(self.ends),
        );
        begins <= now
            && now + RENEW < ends
            && self.names == names
            && self.authority == authority.fingerprint()
    }

    fn make(authority: &Authority, names: &[String], now: Duration) -> Result<Self, TlsError> {
        let mut params = CertificateParams::new(names)?;
        let mut subject = DistinguishedName::new();
        subject.push(DnType::CommonName, "slamlab bridge");
        params.distinguished_name = subject;
        params.is_ca = IsCa::ExplicitNoCa;
        params.key_usages = vec![KeyUsagePurpose::DigitalSignature];
        params.extended_key_usages = vec![ExtendedKeyUsagePurpose::ServerAuth];
        params.use_authority_key_identifier_extension = true;
        // It begins a day early, because a phone's clock may be behind.
        let (begins, ends) = (now.saturating_sub(DAY), now + LASTS);
        params.not_before = time::OffsetDateTime::UNIX_EPOCH + begins;
        params.not_after = time::OffsetDateTime::UNIX_EPOCH + ends;
        let key = KeyPair::generate()?;
        let cert = params.signed_by(&key, &authority.issuer)?;
        Ok(Self {
            begins: begins.as_secs(),
            ends: ends.as_secs(),
            names: names.to_vec(),
            authority: authority.fingerprint(),
            cert: cert.pem(),
            key: key.serialize_pem(),
        })
    }
}

//! The bridge's own authority: made once, installed once on each phone, and valid only for bridges
//! in local networks.
//!
//! Its certificate limits the names for which it may vouch: `localhost`, `.local`, and addresses
//! that are not routed on the internet. Whoever steals its key from the robot cannot impersonate a
//! bank with it.
//!
//! Source: RFC 5280 §4.2; RFC 6762 for `.local`, RFC 1918, 3927, 4193 and 4291 for the addresses.

use std::net::IpAddr;
use std::path::Path;

use rcgen::{
    BasicConstraints, CertificateParams, CidrSubnet, DistinguishedName, DnType, GeneralSubtree,
    IsCa, Issuer, KeyPair, KeyUsagePurpose, NameConstraints, PublicKeyData,
};
use sha2::{Digest, Sha256};
use tokio_rustls::rustls::pki_types::pem::PemObject;
use tokio_rustls::rustls::pki_types::{CertificateDer, PrivateKeyDer};

use super::{TlsError, certify, fingerprint, unreadable};
use crate::secret_file::{self, SecretFileError};

/// Certificate and key, beside the token.
pub(super) const FILES: [&str; 2] = ["tls-ca.pem", "tls-ca-key.pem"];

/// Networks that are local only: address and length of the prefix.
const LOCAL: [(&str, u8); 8] = [
    ("127.0.0.0", 8),
    ("10.0.0.0", 8),
    ("172.16.0.0", 12),
    ("192.168.0.0", 16),
    ("169.254.0.0", 16),
    ("::1", 128),
    ("fc00::", 7),
    ("fe80::", 10),
];

/// An authority with its key, ready to sign.
pub(super) struct Authority {
    pub(super) der: CertificateDer<'static>,
    pub(super) issuer: Issuer<'static, KeyPair>,
}

impl Authority {
    /// Reads it from `folder`, or makes it.
    pub(super) fn load_or_make(folder: &Path) -> Result<Self, TlsError> {
        let [cert, key] = FILES.map(|name| folder.join(name));
        let half = |there, missing| Err(TlsError::Half { there, missing });
        match (cert.exists(), key.exists()) {
            (false, false) => make(&cert, &key)?,
            (true, false) => return half(cert, key),
            (false, true) => return half(key, cert),
            (true, true) => (),
        }
        let secret = secret_file::read(&key)?;
        let pair = KeyPair::from_pem(&secret).map_err(|source| TlsError::Key {
            path: key.clone(),
            source,
        })?;
        let pem =
            std::fs::read_to_string(&cert).map_err(|source| SecretFileError::of(&cert, source))?;
        let der = CertificateDer::from_pem_slice(pem.as_bytes())
            .map_err(|source| unreadable(&cert, "a certificate", source))?;
        // Otherwise phones would be asked to trust an authority that signs nothing here.
        let own = PrivateKeyDer::try_from(pair.serialize_der()).ok();
        let belongs = own.is_some_and(|own| certify(vec![der.clone()], own).is_ok());
        if !belongs {
            return Err(TlsError::Foreign { cert, key });
        }
        let issuer = Issuer::new(params(&pair), pair);
        Ok(Self { der, issuer })
    }

    pub(super) fn fingerprint(&self) -> String {
        fingerprint(&self.der)
    }
}

/// Whether the authority may vouch for the name.
pub(super) fn may_name(name: &str) -> bool {
    match name.parse::<IpAddr>() {
        Ok(ip) => LOCAL.iter().any(|(network, bits)| {
            let network = network.parse::<IpAddr>();
            network.is_ok_and(|network| is_within(ip, network, *bits))
        }),
        Err(_) => name == "localhost" || name.ends_with(".local"),
    }
}

fn is_within(ip: IpAddr, network: IpAddr, bits: u8) -> bool {
    let head = |ip: u128, length: u32| ip >> (length - u32::from(bits));
    match (ip, network) {
        (IpAddr::V4(ip), IpAddr::V4(network)) => {
            head(ip.to_bits().into(), 32) == head(network.to_bits().into(), 32)
        }
        (IpAddr::V6(ip), IpAddr::V6(network)) => {
            head(ip.to_bits(), 128) == head(network.to_bits(), 128)
        }
        _ => false,
    }
}

fn make(cert: &Path, key: &Path) -> Result<(), TlsError> {
    let pair = KeyPair::generate()?;
    let made = params(&pair).self_signed(&pair)?;
    // The key last: a certificate alone does not count as a pair.
    for (path, text) in [(cert, made.pem()), (key, pair.serialize_pem())] {
        secret_file::write(path, text.trim_end())?;
    }
    Ok(())
}

/// The same parameters for the same key, so that a certificate read from its file need not be
/// parsed.
fn params(pair: &KeyPair) -> CertificateParams {
    let mut params = CertificateParams::default();
    let of_key: String = Sha256::digest(pair.der_bytes())[..4]
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect();
    let mut subject = DistinguishedName::new();
    subject.push(DnType::CommonName, format!("slamlab robot {of_key}"));
    params.distinguished_name = subject;
    params.is_ca = IsCa::Ca(BasicConstraints::Constrained(0));
    params.key_usages = vec![KeyUsagePurpose::KeyCertSign, KeyUsagePurpose::CrlSign];
    params.name_constraints = Some(NameConstraints {
        permitted_subtrees: permitted(),
        excluded_subtrees: vec![],
    });
    // A Raspberry Pi has no battery-backed clock: what begins today may begin in its future.
    params.not_before = rcgen::date_time_ymd(2024, 1, 1);
    params.not_after = rcgen::date_time_ymd(2049, 12, 31);
    params
}

fn permitted() -> Vec<GeneralSubtree> {
    let names = ["localhost", "local"].map(|name| GeneralSubtree::DnsName(name.to_owned()));
    let networks = LOCAL.iter().filter_map(|(network, bits)| {
        let network = network.parse::<IpAddr>().ok()?;
        Some(GeneralSubtree::IpAddress(CidrSubnet::from_addr_prefix(
            network, *bits,
        )))
    });
    names.into_iter().chain(networks).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_vouches_for_local_names_only() {
        for name in [
            "localhost",
            "robot.local",
            "127.0.0.1",
            "10.9.8.7",
            "172.31.0.1",
            "192.168.1.7",
            "169.254.3.4",
            "::1",
            "fd00::7",
            "fe80::1",
        ] {
            assert!(may_name(name), "{name}");
        }
        for name in [
            "robot.example",
            "notlocal",
            "8.8.8.8",
            "172.32.0.1",
            "192.169.0.1",
            "2001:db8::1",
            "::2",
        ] {
            assert!(!may_name(name), "{name}");
        }
        assert_eq!(permitted().len(), 2 + LOCAL.len());
    }
}

//! How a phone learns to trust the bridge: a page that explains it, and the authority's
//! certificate.
//!
//! Both are also served without TLS, because a phone that does not trust the bridge yet cannot read
//! them otherwise. Nothing in them is secret; but an attacker in between could hand out another
//! certificate. So the page says what to compare it with: the fingerprint on the robot's own
//! screen, which is also in the QR code.

use axum::Router;
use axum::http::header;
use axum::response::IntoResponse;
use axum::routing::get;

use crate::tls::Identity;

/// Path of the page.
pub const PAGE: &str = "/trust";
const CERTIFICATE: &str = "/slamlab-ca.crt";
const STYLE: &str = "/trust.css";

const HTML: &str = include_str!("trust/trust.html");
const CSS: &str = include_str!("trust/trust.css");

/// The address that a phone opens first, without TLS, with the fingerprint of what it should trust.
#[must_use]
pub fn address(url: &str, fingerprint: &str) -> String {
    let url = url.trim_end_matches('/').replacen("https://", "http://", 1);
    format!("{url}{PAGE}#sha256={fingerprint}")
}

/// The routes; none if the certificate is not the bridge's own.
pub(crate) fn routes(identity: Option<&Identity>) -> Router {
    let Some((identity, der)) =
        identity.and_then(|identity| Some((identity, identity.authority()?)))
    else {
        return Router::new();
    };
    let html = HTML.replace("{fingerprint}", identity.fingerprint());
    let der = der.to_vec();
    let typed = |kind: &'static str| [(header::CONTENT_TYPE, kind)];
    Router::new()
        .route(
            PAGE,
            get(async move || (typed("text/html; charset=utf-8"), html.clone()).into_response()),
        )
        .route(
            STYLE,
            get(async move || (typed("text/css"), CSS).into_response()),
        )
        .route(
            CERTIFICATE,
            get(async move || (typed("application/x-x509-ca-cert"), der.clone()).into_response()),
        )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_names_what_it_serves() {
        for served in [CERTIFICATE, STYLE, "{fingerprint}"] {
            assert!(HTML.contains(served), "{served}");
        }
        assert_eq!(
            address("https://192.168.1.7:8080/", "AB:01"),
            "http://192.168.1.7:8080/trust#sha256=AB:01"
        );
    }
}

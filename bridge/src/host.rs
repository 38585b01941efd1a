//! Which names a browser may call this server by.
//!
//! A foreign page can point its own domain name at this machine's address (DNS rebinding) and would
//! then count as the same origin. Its requests carry its own name in `Host`, so only names that no
//! foreign server can own are served: IP literals, `localhost`, and `.local` names, which are
//! resolved on the local network alone (RFC 6762).

use std::net::{Ipv4Addr, Ipv6Addr};

/// Whether `authority`, a `Host` header such as `127.0.0.1:8080`, `[::1]` or `robot.local`, is one
/// of ours.
///
/// # Example
/// ```
/// use slamlab_bridge::host::is_ours;
/// assert!(is_ours("192.168.1.7:8080"));
/// assert!(!is_ours("rebound.example.com:8080"));
/// ```
#[must_use]
pub fn is_ours(authority: &str) -> bool {
    let Some(host) = without_port(authority) else {
        return false;
    };
    if let Some(ipv6) = host
        .strip_prefix('[')
        .and_then(|rest| rest.strip_suffix(']'))
    {
        return ipv6.parse::<Ipv6Addr>().is_ok();
    }
    let name = host.strip_suffix('.').unwrap_or(host).to_ascii_lowercase();
    name.parse::<Ipv4Addr>().is_ok() || name == "localhost" || is_mdns_name(&name)
}

/// Whether a page of this `Origin` may connect to a server that was called by this `Host`: the page
/// that the server itself sent, or one that was allowed by name. Without an origin it is no
/// browser, and no page can have made it connect. A server that speaks TLS sent no page by `http`;
/// one that does not may stand behind another that does.
#[must_use]
pub fn is_allowed_origin(
    origin: Option<&str>,
    host: Option<&str>,
    is_tls: bool,
    allowed: &[String],
) -> bool {
    let Some(origin) = origin else {
        return true;
    };
    let plain = origin.strip_prefix("http://").filter(|_| !is_tls);
    let own = plain.or(origin.strip_prefix("https://"));
    own.is_some() && own == host || allowed.iter().any(|allowed| allowed == origin)
}

/// The authority without `:port`; nothing if what follows the colon is not a port.
fn without_port(authority: &str) -> Option<&str> {
    match authority.rsplit_once(':') {
        Some((_, rest)) if rest.ends_with(']') => Some(authority),
        Some((host, port)) => port.parse::<u16>().ok().map(|_| host),
        None => Some(authority),
    }
}

fn is_mdns_name(name: &str) -> bool {
    name.strip_suffix(".local").is_some_and(|label| {
        !label.is_empty()
            && label
                .bytes()
                .all(|b| b.is_ascii_alphanumeric() || b == b'-' || b == b'.')
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn literals_localhost_and_mdns_names_are_ours() {
        for host in [
            "127.0.0.1",
            "127.0.0.1:8080",
            "10.0.0.3:1",
            "[::1]",
            "[fe80::1]:8080",
            "localhost",
            "LOCALHOST:8080",
            "localhost.",
            "raspberrypi.local:8080",
            "a-b.c.local",
        ] {
            assert!(is_ours(host), "{host}");
        }
    }

    #[test]
    fn only_the_own_page_and_those_named_may_connect() {
        let allowed = ["https://lab.example".to_owned()];
        let check = |origin, host, expect| {
            assert_eq!(
                is_allowed_origin(origin, host, false, &allowed),
                expect,
                "{origin:?} {host:?}"
            );
        };
        let host = Some("robot.local:8080");
        check(None, host, true);
        check(Some("http://robot.local:8080"), host, true);
        check(Some("https://lab.example"), host, true);
        for foreign in [
            "",
            "null",
            "http://robot.local",
            "http://robot.local:8081",
            "http://robot.local:8080.evil.com",
            "ftp://robot.local:8080",
            "robot.local:8080",
            "https://lab.example.evil.com",
            "http://lab.example",
        ] {
            check(Some(foreign), host, false);
        }
        check(Some("http://robot.local:8080"), None, false);
        check(Some("https://robot.local:8080"), host, true);
    }

    #[test]
    fn a_bridge_that_speaks_tls_sent_no_page_by_http() {
        let is_allowed = |origin| is_allowed_origin(Some(origin), Some("robot.local"), true, &[]);
        assert!(is_allowed("https://robot.local"));
        assert!(!is_allowed("http://robot.local"));
    }

    #[test]
    fn every_other_name_is_foreign() {
        for host in [
            "",
            ":8080",
            "example.com",
            "localhost.example.com",
            "127.0.0.1.example.com",
            "evil.localhost.org:80",
            ".local",
            "x@y.local",
            "local",
            "::1",
            "[::1",
            "[evil]",
            "localhost:99999",
            "localhost:80:80",
            "1.2.3",
            "0x7f000001",
        ] {
            assert!(!is_ours(host), "{host}");
        }
    }
}

//! Which names a browser may call this server by.
//!
//! A foreign page can point its own domain name at this machine's address (DNS rebinding) and would
//! then count as the same origin. Its requests carry that name in `Host`. So the bridge serves only
//! names that no foreign server can own: IP literals, `localhost`, and `.local` names, which are
//! resolved on the local network only (RFC 6762). Names that belong to the robot's owner, of a
//! reverse proxy or in a VPN, are allowed one by one.

use std::net::{Ipv4Addr, Ipv6Addr};

/// The port that a browser leaves out of an `http` origin.
const HTTP_PORT: &str = ":80";
const HTTPS_PORT: &str = ":443";

/// Whether `authority`, a `Host` header such as `127.0.0.1:8080`, `[::1]` or `robot.local`, names
/// this bridge, or was `allowed` by name. Any port will do.
///
/// # Example
/// ```
/// use slamlab_bridge::host::is_ours;
/// let allowed = ["robot.example.com".to_owned()];
/// assert!(is_ours("192.168.1.7:8080", &allowed));
/// assert!(is_ours("robot.example.com", &allowed));
/// assert!(!is_ours("rebound.example.com:8080", &allowed));
/// ```
#[must_use]
pub fn is_ours(authority: &str, allowed: &[String]) -> bool {
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
    name.parse::<Ipv4Addr>().is_ok()
        || name == "localhost"
        || is_mdns_name(&name)
        || allowed.contains(&name)
}

/// Whether a page of this `Origin` may connect to a server that was addressed by this `Host`: the
/// page must come from the server itself, or be allowed by name. A request without an origin does
/// not come from a browser, so no page can have made it. A server that speaks TLS never sent a page
/// by `http`; one that does not may be behind a proxy that does. Upper and lower case count the
/// same, and so do the scheme's default port and no port: a browser leaves that port out of
/// `Origin`, but other clients write `Host` as it was typed.
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
    let plain = origin.strip_prefix("http://").map(|own| (own, HTTP_PORT));
    let secure = origin.strip_prefix("https://").map(|own| (own, HTTPS_PORT));
    let own = plain.filter(|_| !is_tls).or(secure);
    own.zip(host)
        .is_some_and(|((own, port), host)| is_same(own, host, port))
        || allowed.iter().any(|allowed| allowed == origin)
}

/// Whether two authorities are the same, given the scheme's default port.
fn is_same(one: &str, other: &str, port: &str) -> bool {
    let [one, other] = [one, other].map(|name| name.strip_suffix(port).unwrap_or(name));
    !one.is_empty() && one.eq_ignore_ascii_case(other)
}

/// Checks that a browser can write this as an `Origin`; any other text would never match a request.
///
/// # Errors    What is wrong with it.
///
/// # Source    RFC 6454 §6.2: scheme and host in lower case, the port only if it is not the
/// scheme's default, nothing after it.
pub fn check_origin(origin: &str) -> Result<(), &'static str> {
    match origin {
        "*" => return Err("every page of the world may not drive a robot"),
        "null" => return Err("any page without an origin would be let in"),
        _ => (),
    }
    let Some((scheme, authority)) = origin.split_once("://") else {
        return Err("the scheme is missing");
    };
    let is_scheme = |b: u8| b.is_ascii_lowercase() || b.is_ascii_digit() || b"+-.".contains(&b);
    if scheme.is_empty() || !scheme.bytes().all(is_scheme) {
        return Err("the scheme is none, or not in lower case");
    }
    if authority.ends_with('/') && !authority.trim_end_matches('/').contains('/') {
        return Err("it ends with a slash");
    }
    if authority.contains(['/', '?', '#', '@']) {
        return Err("it holds more than scheme, host and port");
    }
    let is_plain = |c: char| c.is_ascii_graphic() && !c.is_ascii_uppercase();
    if !authority.chars().all(is_plain) {
        return Err("the host is not in lower case, or not in ASCII");
    }
    if authority.contains('*') {
        return Err("a host cannot be left open");
    }
    let host = without_port(authority).ok_or("the port is no number up to 65535")?;
    if host.is_empty() {
        return Err("the host is missing");
    }
    let port = authority.get(host.len()..).unwrap_or_default();
    match (scheme, port) {
        ("http", HTTP_PORT) | ("https", HTTPS_PORT) => {
            Err("browsers leave the scheme's own port out")
        }
        _ => Ok(()),
    }
}

/// Checks that this can be allowed as a host name: browsers ask for nothing else.
///
/// # Errors    What is wrong with it.
///
/// # Source    RFC 1123 §2.1: labels of letters, digits and hyphens.
pub fn check_host(host: &str) -> Result<(), &'static str> {
    if host.contains("://") {
        return Err("a scheme is not part of it");
    }
    if host.contains('*') {
        return Err("a name cannot be left open");
    }
    if host.contains(['/', '?', '#', '@']) {
        return Err("it holds more than a name");
    }
    if host.parse::<Ipv4Addr>().is_ok() || host.trim_matches(['[', ']']).parse::<Ipv6Addr>().is_ok()
    {
        return Err("the bridge answers to addresses anyway");
    }
    if host.contains(':') {
        return Err("a port is not part of it: any is taken");
    }
    if host.ends_with('.') {
        return Err("it ends with a dot");
    }
    let is_plain = |b: u8| b.is_ascii_lowercase() || b.is_ascii_digit() || b == b'-';
    let is_label = |label: &str| {
        (1..=63).contains(&label.len())
            && label.bytes().all(is_plain)
            && !label.starts_with('-')
            && !label.ends_with('-')
    };
    match host.len() <= 253 && host.split('.').all(is_label) {
        true => Ok(()),
        false => {
            Err("a name has labels of lower-case letters, digits and hyphens, with dots between")
        }
    }
}

/// The authority without `:port`; none if what follows the colon is not a port.
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
            assert!(is_ours(host, &[]), "{host}");
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

    /// Regression: a script that wrote the name in upper case got the page, but no connection to
    /// the robot.
    #[test]
    fn letters_in_both_cases_and_the_schemes_own_port_name_the_same() {
        let check = |origin, host, expect| {
            let is_allowed = is_allowed_origin(Some(origin), Some(host), false, &[]);
            assert_eq!(is_allowed, expect, "{origin} {host}");
        };
        check("http://robot.local:8080", "ROBOT.Local:8080", true);
        check("http://robot.local", "robot.local:80", true);
        check("https://robot.local", "ROBOT.LOCAL:443", true);
        check("https://[fd00::7]", "[FD00::7]:443", true);
        // The default port of the other scheme is an ordinary port.
        check("https://robot.local", "robot.local:80", false);
        check("http://robot.local", "robot.local:443", false);
        check("http://robot.local:8080", "robot.local:80", false);
        check("http://", ":80", false);
    }

    #[test]
    fn an_origin_that_no_browser_writes_is_none() {
        for good in [
            "https://lab.example",
            "http://192.168.1.7:3000",
            "http://[::1]:3000",
            "vscode-webview://1a2b",
            "http://lab.example:443",
        ] {
            assert_eq!(check_origin(good), Ok(()), "{good}");
        }
        for bad in [
            "",
            "*",
            "null",
            "lab.example",
            "https://",
            "https://lab.example/",
            "https://lab.example//",
            "https://lab.example/page",
            "https://lab.example?x",
            "https://user@lab.example",
            "https://Lab.example",
            "HTTPS://lab.example",
            "https://*.lab.example",
            "https://lab.example:443",
            "http://lab.example:80",
            "https://lab.example:https",
            "https://lab.example:99999",
            "https://lab.example ",
            "https://läb.example",
            "://lab.example",
        ] {
            assert!(check_origin(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn a_bridge_that_speaks_tls_sent_no_page_by_http() {
        let is_allowed = |origin| is_allowed_origin(Some(origin), Some("robot.local"), true, &[]);
        assert!(is_allowed("https://robot.local"));
        assert!(!is_allowed("http://robot.local"));
    }

    #[test]
    fn every_other_name_is_foreign() {
        let allowed = ["robot.example".to_owned()];
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
            "robot.example.evil.com",
            "evil.robot.example",
            "robot.exampl",
            "robot.example:x",
        ] {
            assert!(!is_ours(host, &allowed), "{host}");
        }
    }

    #[test]
    fn a_name_that_was_allowed_is_ours_at_any_port() {
        let allowed = [
            "robot.example".to_owned(),
            "robot.tail1234.ts.net".to_owned(),
        ];
        for host in [
            "robot.example",
            "robot.example:443",
            "ROBOT.example",
            "robot.example.",
            "robot.tail1234.ts.net:8080",
        ] {
            assert!(is_ours(host, &allowed), "{host}");
            assert!(!is_ours(host, &[]), "{host}");
        }
    }

    #[test]
    fn a_host_that_no_browser_asks_for_is_none() {
        for good in [
            "robot.example",
            "robot",
            "r2-d2.lab.example",
            "xn--rbot-5qa.example",
        ] {
            assert_eq!(check_host(good), Ok(()), "{good}");
        }
        for bad in [
            "",
            "*",
            "*.example",
            "https://robot.example",
            "robot.example/",
            "robot.example:8080",
            "user@robot.example",
            "Robot.example",
            "robot.example.",
            "robot..example",
            "-robot.example",
            "röbot.example",
            "robot example",
            "192.168.1.7",
            "[::1]",
            "::1",
            &"a".repeat(64),
        ] {
            assert!(check_host(bad).is_err(), "{bad}");
        }
    }
}

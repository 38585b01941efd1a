//! What this machine is called by others on its network.

use std::net::{IpAddr, SocketAddr};

/// The machine's name without a domain; none where it is no name that `.local` could follow.
#[must_use]
pub fn host_name() -> Option<String> {
    let name = gethostname::gethostname().into_string().ok()?;
    let name = name.split('.').next()?.to_ascii_lowercase();
    let is_label = !name.is_empty() && name.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'-');
    (is_label && name != "localhost").then_some(name)
}

/// The machine's own addresses, but for those that count on this machine only. None where the
/// system does not tell.
#[must_use]
pub fn of_this_machine() -> Vec<IpAddr> {
    let is_ours = |ip: &IpAddr| match ip {
        IpAddr::V4(ip) => !ip.is_loopback() && !ip.is_link_local(),
        // An address with a scope does not stand in a URL that browsers take.
        IpAddr::V6(ip) => !ip.is_loopback() && !ip.is_unicast_link_local(),
    };
    let all = if_addrs::get_if_addrs().unwrap_or_default();
    let mut ours: Vec<_> = all
        .iter()
        .map(if_addrs::Interface::ip)
        .filter(is_ours)
        .collect();
    ours.sort();
    ours.dedup();
    ours
}

/// The page's addresses, for one to be typed: on this machine first, then as others on the network
/// reach it.
///
/// # Example
/// ```
/// let urls = slamlab_bridge::address::urls("127.0.0.1:8080".parse().unwrap(), false);
/// assert_eq!(urls, ["http://127.0.0.1:8080/"]);
/// ```
#[must_use]
pub fn urls(listening: SocketAddr, is_tls: bool) -> Vec<String> {
    let scheme = if is_tls { "https" } else { "http" };
    if !listening.ip().is_unspecified() {
        return vec![format!("{scheme}://{listening}/")];
    }
    let port = listening.port();
    let names = host_name().map(|name| format!("{name}.local"));
    let numbers = of_this_machine().into_iter().filter(|ip| ip.is_ipv4());
    [Some("localhost".to_owned()), names]
        .into_iter()
        .flatten()
        .chain(numbers.map(|ip| ip.to_string()))
        .map(|host| format!("{scheme}://{host}:{port}/"))
        .collect()
}

/// What anybody in the network can do with a bridge that listens there, and how to close that; none
/// where nobody else reaches it, or nothing is open.
#[must_use]
pub fn exposure(listening: SocketAddr, is_tls: bool, is_private: bool) -> Option<&'static str> {
    if listening.ip().is_loopback() {
        return None;
    }
    match (is_private, is_tls) {
        (true, true) => None,
        (false, false) => Some(
            "open to the network: whoever reaches it may watch and stop the robot (--private wants the token for that \
             too), and whoever listens there can read along and change what is sent (--tls prevents it)",
        ),
        (false, true) => Some(
            "open to the network: whoever reaches it may watch and stop the robot (--private wants the token for that \
             too)",
        ),
        (true, false) => Some(
            "in the clear on the network: whoever listens there can read along and change what is sent (--tls prevents \
             it)",
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_open_is_said_with_how_to_close_it() {
        let everywhere = "0.0.0.0:80".parse().unwrap();
        let said = |tls, private| exposure(everywhere, tls, private).unwrap_or_default();
        for (tls, private) in [(false, false), (false, true), (true, false), (true, true)] {
            let said = said(tls, private);
            assert_eq!(said.contains("--tls"), !tls, "{said}");
            assert_eq!(said.contains("--private"), !private, "{said}");
            assert_eq!(said.contains("stop the robot"), !private, "{said}");
        }
        for here in ["127.0.0.1:80", "[::1]:80"] {
            assert_eq!(exposure(here.parse().unwrap(), false, false), None);
        }
    }

    #[test]
    fn a_bridge_that_listens_everywhere_is_named_here_first() {
        let urls = urls("0.0.0.0:81".parse().unwrap(), true);
        assert_eq!(urls[0], "https://localhost:81/");
        assert!(
            urls.iter()
                .all(|url| url.starts_with("https://") && url.ends_with(":81/"))
        );
        // Whatever is named would be let in.
        for url in &urls {
            let host = url.trim_start_matches("https://").trim_end_matches('/');
            assert!(crate::host::is_ours(host, &[]), "{host}");
        }
    }
}

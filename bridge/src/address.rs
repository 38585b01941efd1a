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

#[cfg(test)]
mod tests {
    use super::*;

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
            assert!(crate::host::is_ours(host), "{host}");
        }
    }
}

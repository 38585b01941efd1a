//! The addresses and names by which others on the network reach this machine.

use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr};

use tokio::net::UdpSocket;

/// The machine's name without its domain; none if it is not valid in front of `.local`.
#[must_use]
pub fn host_name() -> Option<String> {
    let name = gethostname::gethostname().into_string().ok()?;
    let name = name.split('.').next()?.to_ascii_lowercase();
    let is_label = !name.is_empty() && name.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'-');
    (is_label && name != "localhost").then_some(name)
}

/// The machine's own addresses, except those valid only on this machine. Empty if the system does
/// not list them.
#[must_use]
pub fn of_this_machine() -> Vec<IpAddr> {
    let is_ours = |ip: &IpAddr| match ip {
        IpAddr::V4(ip) => !ip.is_loopback() && !ip.is_link_local(),
        // Browsers accept no URL with a scoped (link-local) address.
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

/// The page's addresses, for a person to type: first the one for this machine, then those for
/// others on the network.
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

/// The one of the page's addresses that a phone is likeliest to reach: this machine's address on
/// its default route, because a phone is seldom in the network of a virtual machine or a container;
/// else the first numeric address, which needs no multicast DNS; else the last.
#[must_use]
pub fn for_a_phone(urls: &[String]) -> Option<&String> {
    phones_choice(urls, towards_all_others())
}

fn phones_choice(urls: &[String], own: Option<IpAddr>) -> Option<&String> {
    let in_figures = |url: &&String| host_in(url).parse::<IpAddr>().ok();
    let is_own = |url: &&String| own.is_some() && in_figures(url) == own;
    let first = || urls.iter().find(|url| in_figures(url).is_some());
    urls.iter().find(is_own).or_else(first).or(urls.last())
}

/// The host in one of these addresses, without brackets.
pub(crate) fn host_in(url: &str) -> &str {
    let authority = url.split("://").nth(1).unwrap_or(url);
    let authority = authority.split('/').next().unwrap_or_default();
    let host = match authority.rsplit_once(':') {
        Some((_, rest)) if rest.ends_with(']') => authority,
        Some((host, _)) => host,
        None => authority,
    };
    host.trim_matches(['[', ']'])
}

/// The machine's own address on the default route. Nothing is sent: connecting a UDP socket only
/// selects the address it would send from.
fn towards_all_others() -> Option<IpAddr> {
    // Addresses for documentation (RFC 5737): nobody has them, so the default route counts.
    const ANYBODY: ([u8; 4], u16) = ([203, 0, 113, 1], 9);
    let socket = std::net::UdpSocket::bind((Ipv4Addr::UNSPECIFIED, 0)).ok()?;
    socket.connect(SocketAddr::from(ANYBODY)).ok()?;
    Some(socket.local_addr().ok()?.ip())
}

/// The page's address for clients that come through `host`. If this machine is in several networks,
/// it is the address in the network through which it reaches `host`. None if no address of the
/// machine is known.
pub async fn url_towards(listening: SocketAddr, is_tls: bool, host: (&str, u16)) -> Option<String> {
    if listening.ip().is_unspecified()
        && let Some(ours) = source_towards(host).await
        // A host on this machine says nothing about its networks.
        && !ours.is_loopback()
        && (ours.is_ipv4() || listening.is_ipv6())
    {
        return urls(SocketAddr::new(ours, listening.port()), is_tls).pop();
    }
    // Others reach it by the last address: if there are several, the first works on this machine
    // only.
    urls(listening, is_tls).pop()
}

/// The address that the system would send from. Nothing is sent.
async fn source_towards(host: (&str, u16)) -> Option<IpAddr> {
    for address in tokio::net::lookup_host(host).await.ok()? {
        let any: IpAddr = match address {
            SocketAddr::V4(_) => Ipv4Addr::UNSPECIFIED.into(),
            SocketAddr::V6(_) => Ipv6Addr::UNSPECIFIED.into(),
        };
        if let Ok(socket) = UdpSocket::bind((any, 0)).await
            && socket.connect(address).await.is_ok()
            && let Ok(ours) = socket.local_addr()
        {
            return Some(ours.ip());
        }
    }
    None
}

/// What anybody in the network can do with a bridge that listens there, and how to prevent it; none
/// if nobody else can reach it, or nothing is open.
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

/// What anybody who reaches the robot's router can do, and how to prevent it. The bridge cannot
/// know whom the router lets in.
#[must_use]
pub fn exposure_at_router(is_tls: bool) -> &'static str {
    match is_tls {
        true => {
            "open at the router: whoever it lets in may watch and stop the robot; let it ask for certificates of its clients"
        }
        false => {
            "open at the router: whoever reaches it may watch and stop the robot, and whoever listens on the way can read \
             along (a router at tls/ that asks for certificates of its clients prevents both)"
        }
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

    /// Regression: the highest address was chosen. On a machine that had run a container, this was
    /// the container's network bridge, which no phone reaches.
    #[test]
    fn a_phone_gets_the_address_on_the_default_route() {
        let all = ["localhost", "robot.local", "10.0.0.5", "172.17.0.1"];
        let urls = all.map(|host| format!("https://{host}:8080/"));
        let chosen = |count: usize, own: Option<&str>| {
            let own = own.map(|own| own.parse().unwrap());
            phones_choice(&urls[..count], own).map(|url| host_in(url))
        };
        assert_eq!(chosen(4, Some("10.0.0.5")), Some("10.0.0.5"));
        assert_eq!(chosen(4, Some("172.17.0.1")), Some("172.17.0.1"));
        assert_eq!(chosen(4, Some("192.0.2.2")), Some("10.0.0.5"));
        assert_eq!(chosen(4, None), Some("10.0.0.5"));
        assert_eq!(chosen(2, Some("192.0.2.2")), Some("robot.local"));
        assert_eq!(chosen(0, None), None);
        let here = towards_all_others();
        assert!(here.is_none_or(|ip| ip.is_loopback() || of_this_machine().contains(&ip)));
    }

    #[test]
    fn the_host_of_an_address_stands_alone() {
        for (url, host) in [
            ("https://[fd00::7]:8080/", "fd00::7"),
            ("http://10.0.0.5:80/", "10.0.0.5"),
            ("https://robot.local/", "robot.local"),
            ("https://[::1]/", "::1"),
        ] {
            assert_eq!(host_in(url), host);
        }
    }

    #[tokio::test]
    async fn who_is_in_a_network_gets_the_address_in_that_network() {
        let everywhere: SocketAddr = "0.0.0.0:8080".parse().unwrap();
        // Addresses for documentation (RFC 5737): nobody has them, so the default route counts.
        let theirs = url_towards(everywhere, false, ("192.0.2.1", 7447)).await;
        let all = urls(everywhere, false);
        assert!(
            theirs.is_none_or(|url| all.contains(&url)),
            "one of {all:?}"
        );
        for own in of_this_machine().into_iter().filter(IpAddr::is_ipv4) {
            let url = url_towards(everywhere, true, (&own.to_string(), 7447)).await;
            assert_eq!(url.unwrap(), format!("https://{own}:8080/"));
        }
    }

    #[tokio::test]
    async fn of_a_host_on_this_machine_and_of_none_it_is_the_last_name() {
        let everywhere: SocketAddr = "0.0.0.0:8080".parse().unwrap();
        let last = urls(everywhere, false).pop();
        for host in ["127.0.0.1", "no-such-host.invalid"] {
            assert_eq!(
                url_towards(everywhere, false, (host, 7447)).await,
                last,
                "{host}"
            );
        }
        let here: SocketAddr = "127.0.0.1:8080".parse().unwrap();
        let url = url_towards(here, false, ("192.0.2.1", 7447)).await;
        assert_eq!(url.unwrap(), "http://127.0.0.1:8080/");
    }
}

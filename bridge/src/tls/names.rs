//! The names of this machine in the bridge's own certificate, and which addresses of the page a
//! browser would refuse because they are not in it.

use std::net::IpAddr;

use super::{Identity, authority};

/// Said in place of an address if [`Identity::named`] leaves none.
pub const UNNAMED: &str = "there is no address that the bridge's own certificate could name: its authority vouches for \
    localhost, .local names and private addresses only; listen on all addresses (0.0.0.0), or give the bridge a \
    certificate for its name (--tls-cert, --tls-key)";

/// All names of this machine that a browser on the same network may use and for which the authority
/// may vouch.
pub(super) fn all() -> Vec<String> {
    let mut names = vec!["localhost".to_owned()];
    names.extend(crate::address::host_name().map(|name| format!("{name}.local")));
    let loopback = [
        IpAddr::from([127, 0, 0, 1]),
        IpAddr::from([0, 0, 0, 0, 0, 0, 0, 1]),
    ];
    let others = crate::address::of_this_machine();
    names.extend(loopback.into_iter().chain(others).map(|ip| ip.to_string()));
    names.retain(|name| authority::may_name(name));
    names
}

impl Identity {
    /// Those of the page's addresses that the certificate names. If somebody else made the
    /// certificate, all of them: they know what it is for.
    #[must_use]
    pub fn named(&self, urls: Vec<String>) -> Vec<String> {
        match self.authority() {
            Some(_) => among(&all(), urls),
            None => urls,
        }
    }

    /// Those of the names that the bridge should answer to that its own certificate lacks; none if
    /// somebody else made the certificate.
    #[must_use]
    pub fn lacking<'a>(&self, hosts: &'a [String]) -> Vec<&'a str> {
        let names = match self.authority() {
            Some(_) => all(),
            None => return vec![],
        };
        let is_lacking = |host: &&str| !names.iter().any(|name| name == host);
        hosts
            .iter()
            .map(String::as_str)
            .filter(is_lacking)
            .collect()
    }
}

fn among(names: &[String], mut urls: Vec<String>) -> Vec<String> {
    urls.retain(|url| {
        names
            .iter()
            .any(|name| name == crate::address::host_in(url))
    });
    urls
}

#[cfg(test)]
mod tests {
    use super::*;

    fn owned(names: &[&str]) -> Vec<String> {
        names.iter().map(|name| (*name).to_owned()).collect()
    }

    /// Regression: the bridge sent people to a public address, for which its authority cannot
    /// vouch.
    #[test]
    fn only_addresses_that_the_own_certificate_names_are_left() {
        let urls = owned(&[
            "https://localhost:8080/",
            "https://robot.local:8080/",
            "https://192.0.2.2:8080/",
            "https://192.168.1.7:8080/",
            "https://[fd00::7]:8080/",
        ]);
        let names = owned(&["localhost", "robot.local", "192.168.1.7", "fd00::7"]);
        let mut left = urls.clone();
        left.remove(2);
        assert_eq!(among(&names, urls), left);
        assert!(among(&names, owned(&["https://192.0.2.2:443/"])).is_empty());
    }

    #[test]
    fn a_name_of_a_proxy_is_lacking_in_the_own_certificate_and_in_no_other() {
        let folder = tempfile::TempDir::new().unwrap();
        let own = Identity::load_or_make(folder.path()).unwrap();
        let hosts = owned(&["localhost", "robot.example.com"]);
        assert_eq!(own.lacking(&hosts), ["robot.example.com"]);
        let public = owned(&["https://192.0.2.2:8080/"]);
        assert!(own.named(public.clone()).is_empty());
        let [cert, key] = authority::FILES.map(|name| folder.path().join(name));
        let theirs = Identity::load(&cert, &key).unwrap();
        assert!(theirs.lacking(&hosts).is_empty());
        assert_eq!(theirs.named(public.clone()), public);
    }
}

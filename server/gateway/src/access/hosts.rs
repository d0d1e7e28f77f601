//! The names under which the server may be reached. A page of another site can make a browser believe that its own name belongs to this computer (DNS rebinding). The
//! request then carries that name as its host, and is refused.

use super::is_loopback;
use std::net::IpAddr;

/// Names of this computer, and those that were allowed on the command line.
#[derive(Clone, Debug)]
pub(crate) struct HostList {
    names: Vec<String>,
}

impl HostList {
    /// `allowed` besides the names of this computer.
    pub(crate) fn new(allowed: &[String]) -> Self {
        let own = rustix::system::uname().nodename().to_string_lossy().to_ascii_lowercase();
        let short = own.split('.').next().unwrap_or_default().to_owned();
        let multicast = format!("{short}.local");
        let allowed = allowed.iter().map(|name| name.trim_end_matches('.').to_ascii_lowercase());
        let mut names = vec!["localhost".to_owned(), own, short, multicast];
        names.extend(allowed);
        names.retain(|name| !name.is_empty());
        Self { names }
    }

    /// Whether a request for this host may be answered that came to `local`, an address of this computer. Ports differ where one is forwarded, and do not count.
    pub(crate) fn allows(&self, host: &str, local: IpAddr) -> bool {
        let name = without_port(host).trim_end_matches('.');
        let literal = name.strip_prefix('[').and_then(|name| name.strip_suffix(']')).unwrap_or(name);
        if let Ok(address) = literal.parse::<IpAddr>() {
            let (address, local) = (address.to_canonical(), local.to_canonical());
            // Whoever is on this computer may use any of its names for itself.
            return address == local
                || is_loopback(address) && is_loopback(local)
                || self.names_contain(literal);
        }
        self.names_contain(name)
    }

    /// The addresses by which a client may know this computer that has reached `local`.
    pub(crate) fn addresses(&self, local: IpAddr) -> Vec<String> {
        let further = self.names.iter().filter(|name| name.parse::<IpAddr>().is_ok());
        std::iter::once(&local.to_canonical().to_string()).chain(further).cloned().collect()
    }

    fn names_contain(&self, name: &str) -> bool {
        self.names.iter().any(|allowed| allowed.eq_ignore_ascii_case(name))
    }
}

/// A host without its port.
fn without_port(host: &str) -> &str {
    match host.rsplit_once(':') {
        Some((name, port)) if port.bytes().all(|byte| byte.is_ascii_digit()) && !name.ends_with(':') => {
            // An IPv6 address without brackets has colons too, but is no valid host.
            if name.starts_with('[') || !name.contains(':') { name } else { host }
        }
        _ => host,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_other_sites_are_refused() {
        let hosts = HostList::new(&["Robot7.plant.example.".to_owned(), "192.0.2.9".to_owned()]);
        let local: IpAddr = "10.0.0.5".parse().expect("an address");
        let loopback: IpAddr = "127.0.0.1".parse().expect("an address");
        for host in [
            "localhost",
            "LOCALHOST:8080",
            "robot7.plant.example:443",
            "10.0.0.5",
            "10.0.0.5:8080",
            "192.0.2.9",
        ] {
            assert!(hosts.allows(host, local), "{host}");
        }
        let own = rustix::system::uname().nodename().to_string_lossy().into_owned();
        assert!(hosts.allows(&own, local));
        assert!(hosts.allows("127.0.0.1:1", loopback) && hosts.allows("[::1]:1", loopback));
        let strange = [
            "evil.example",
            "localhost.evil.example",
            "10.0.0.6",
            "127.0.0.1",
            "",
            ":80",
            "robot7",
            "[::1]",
            "robot7.plant.example@evil.example",
            "evil.example:80:80",
            "localhost:80x",
        ];
        for host in strange {
            assert!(!hosts.allows(host, local), "{host}");
        }
    }
}

//! The names of this machine.

use std::net::IpAddr;

#[derive(Debug)]
pub(crate) struct Hosts {
    names: Vec<String>,
}

impl Hosts {
    pub(crate) fn new(names: Vec<String>) -> Self {
        Self { names: names.iter().map(|name| bare(name)).collect() }
    }

    /// Whether the name is one of this machine, for a connection to `local`. The port does not
    /// count: a tunnel may have another.
    pub(crate) fn allows(&self, host: &str, local: Option<IpAddr>) -> bool {
        let host = bare(host);
        let is_loopback = local.is_some_and(|local| local.to_canonical().is_loopback());
        let is_local = match host.parse::<IpAddr>() {
            Ok(ip) if ip.is_loopback() => is_loopback,
            Ok(ip) => local.is_some_and(|local| local.to_canonical() == ip.to_canonical()),
            Err(_) => host == "localhost" && is_loopback,
        };
        is_local || self.names.contains(&host)
    }
}

/// A host without its port and the brackets of an IPv6 address, in lower case.
fn bare(host: &str) -> String {
    let host = host.trim();
    let name = match host.strip_prefix('[').and_then(|rest| rest.split_once(']')) {
        Some((address, _)) => address,
        // an address of IPv6 has colons of its own
        None if host.matches(':').count() > 1 => host,
        None => host.split(':').next().unwrap_or(host),
    };
    name.trim_end_matches('.').to_ascii_lowercase()
}

//! The port a user named, also after it was pulled out and plugged in under another name.

use std::{
    fs,
    path::{Path, PathBuf},
};

use crate::{ports::PortEntry, ports::UsbAdapter};

/// A port by all that is known to lead to it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct PortAddress {
    /// As the user gave it.
    given: String,
    stable_name: Option<PathBuf>,
    usb: Option<UsbAdapter>,
}

impl PortAddress {
    pub(crate) fn new(given: &str) -> Self {
        Self { given: given.into(), stable_name: None, usb: None }
    }

    /// As the user gave it.
    pub(crate) fn given(&self) -> &str {
        &self.given
    }

    /// Remembers what the port that was just opened is.
    pub(crate) fn learn(&mut self, opened: &str, ports: &[PortEntry]) {
        let Some(port) = find(ports, opened) else { return };
        self.stable_name = port.stable_name.clone();
        self.usb = port.usb.clone();
    }

    /// The names to try, the surest first: another adapter may have taken the name of one that was
    /// pulled out.
    pub(crate) fn candidates(&self, ports: &[PortEntry]) -> Vec<String> {
        let stable = self.stable_name.as_ref().map(|name| name.to_string_lossy().into_owned());
        let known =
            stable.into_iter().chain([self.given.clone()]).filter(|name| !self.belongs_to_another_port(name, ports));
        let same_adapter = ports.iter().filter(|port| self.is_same_adapter(port)).map(|port| port.name.clone());
        let mut names: Vec<String> = Vec::new();
        for name in known.chain(same_adapter) {
            if !names.contains(&name) {
                names.push(name);
            }
        }
        names
    }

    /// Whether the name that the user gave leads to another adapter now.
    pub(crate) fn is_taken(&self, ports: &[PortEntry]) -> bool {
        self.belongs_to_another_port(&self.given, ports)
    }

    /// By the serial number of the adapter: without one, two of a kind look the same.
    fn is_same_adapter(&self, port: &PortEntry) -> bool {
        self.usb.as_ref().is_some_and(|usb| usb.serial_number.is_some()) && port.usb == self.usb
    }

    /// Of a port that is not on USB nothing is known that could differ.
    fn belongs_to_another_port(&self, name: &str, ports: &[PortEntry]) -> bool {
        self.usb.is_some() && find(ports, name).is_some_and(|port| port.usb != self.usb)
    }
}

fn find<'a>(ports: &'a [PortEntry], name: &str) -> Option<&'a PortEntry> {
    // the user may have given a symlink
    let device = fs::canonicalize(name).unwrap_or_else(|_| name.into());
    ports.iter().find(|port| Path::new(&port.name) == device)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn port(name: &str, serial_number: Option<&str>) -> PortEntry {
        let usb = UsbAdapter {
            vendor_id: 0x0403,
            product_id: 0x6001,
            serial_number: serial_number.map(Into::into),
            manufacturer: None,
            product: None,
        };
        let stable_name = serial_number.map(|number| format!("/dev/serial/by-id/usb-{number}").into());
        PortEntry { name: name.into(), stable_name, usb: Some(usb), likely: true }
    }

    #[test]
    fn an_adapter_is_followed_to_another_name() {
        let mut address = PortAddress::new("ttyX0");
        assert_eq!(address.candidates(&[]), ["ttyX0"]);
        address.learn("ttyX0", &[port("ttyX0", Some("A1")), port("ttyX1", Some("B2"))]);
        assert_eq!(address.candidates(&[]), ["/dev/serial/by-id/usb-A1", "ttyX0"]);
        let moved = [port("ttyX0", Some("B2")), port("ttyX5", Some("A1"))];
        assert_eq!(address.candidates(&moved), ["/dev/serial/by-id/usb-A1", "ttyX5"], "the old name is another's");
        assert!(address.is_taken(&moved) && !address.is_taken(&moved[1..]));
    }

    #[test]
    fn adapters_without_a_number_are_not_guessed() {
        let mut address = PortAddress::new("ttyX0");
        address.learn("ttyX0", &[port("ttyX0", None)]);
        assert_eq!(address.candidates(&[port("ttyX1", None)]), ["ttyX0"]);
    }

    #[test]
    fn a_port_that_is_not_on_usb_keeps_its_name() {
        let mut address = PortAddress::new("/dev/pts/7");
        address.learn("/dev/pts/7", &[port("ttyX0", Some("A1"))]);
        assert_eq!(address.candidates(&[port("ttyX0", Some("A1"))]), ["/dev/pts/7"]);
    }
}
